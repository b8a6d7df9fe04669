"""Pool of worker processes on this machine."""

import queue
import tempfile
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from text2sim.cluster.task import MAX_TRIES, STOPPED, Done, Task
from text2sim.runtime.child import default_memory
from text2sim.runtime.dialogue import Child
from text2sim.runtime.outcome import read_end
from text2sim.runtime.stop import Stop

POLL_INTERVAL = 0.2
MODULE = "text2sim.cluster.worker"
SHUTDOWN_TIME = 15.0
"""Time [s] that workers have to end."""


class _Member:
    """A worker of the pool, and its current task."""

    def __init__(self, number: int, folder: Path, inbox: "queue.Queue[Any]", *, warm: bool) -> None:
        self.name = f"worker {number + 1}"
        self._start = lambda: Child(
            self.name, MODULE, [str(home), *["warm"] * warm], self.log, inbox, whole_environment=True
        )
        home = folder / f"worker_{number + 1}"
        home.mkdir(parents=True, exist_ok=True)
        self.log: Path = home / "worker.log"
        self.child: Child = self._start()
        self.job: tuple[int, float] | None = None
        """Number of its task, and when it began [s]."""

    def restart(self) -> None:
        self.child = self._start()

    def begin(self, number: int, task: Task) -> None:
        self.job = number, monotonic()
        inputs = {name: str(path.absolute()) for name, path in task.inputs.items()}
        output = None if task.output is None else str(task.output.absolute())
        self.child.send(order=number, **task.order(inputs, output))


def run_local(tasks: Sequence[Task], workers: int, stop: Stop, *, warm: bool = True) -> Iterator[Done]:
    """Run tasks, and yield the result of each as soon as it is known.

    A worker that dies is replaced, and its task is tried again, `MAX_TRIES` times in total. At the first request to
    stop, running tasks are asked to stop and no others begin; at the second they are killed. Workers always end with
    this process. A task waits until the memory needs of running tasks leave enough for it, unless it is the only one.

    Args:
        tasks: The tasks, in order.
        workers: Number of tasks at a time.
        stop: Requests to stop.
        warm: Whether each worker keeps an engine warm.
    """
    inbox: queue.Queue[Any] = queue.Queue()
    waiting, tries, ended = deque(range(len(tasks))), [0] * len(tasks), 0
    with tempfile.TemporaryDirectory(prefix="text2sim-pool-") as folder, stop.gently():
        count = min(workers, len(tasks))
        members = [_Member(number, Path(folder), inbox, warm=warm) for number in range(count)]
        asked = 0
        try:
            while ended < len(tasks):
                if stop.count:
                    for number in waiting:
                        yield Done(tasks[number], None, STOPPED, tries[number])
                    ended += len(waiting)
                    waiting.clear()
                if stop.count > asked:
                    asked = stop.count
                    for member in members:
                        member.child.send(cancel=0) if asked == 1 else member.child.kill()
                for member in members:
                    if member.job is None and waiting and _has_room(tasks, members, tasks[waiting[0]]):
                        number = waiting.popleft()
                        tries[number] += 1
                        member.begin(number, tasks[number])
                with suppress(queue.Empty):
                    news = inbox.get(timeout=POLL_INTERVAL)
                    member = next((member for member in members if member.child is news.child), None)
                    if member is None:
                        continue
                    done = _handle_message(member, news.data, tasks, tries)
                    if "died" in news.data and ended < len(tasks) and not stop.count:
                        member.restart()
                    if isinstance(done, Done):
                        ended += 1
                        yield done
                    elif done is not None:
                        waiting.appendleft(done)
        finally:
            for member in members:
                member.child.send(cancel=0)
                member.child.end()
            until = monotonic() + SHUTDOWN_TIME
            while monotonic() < until and stop.count < 2 and not all(member.child.has_ended for member in members):
                sleep(POLL_INTERVAL)
            for member in members:
                member.child.kill()


def _handle_message(
    member: _Member, data: dict[str, Any], tasks: Sequence[Task], tries: list[int]
) -> Done | int | None:
    """The result of a worker's task, or the number of a task to retry; None if the message is about neither."""
    if member.job is None or not (data.get("order") == member.job[0] or "died" in data):
        return None
    (number, since), member.job = member.job, None
    seconds = monotonic() - since
    if "died" not in data:
        machine = bool(data.get("machine"))
        return Done(
            tasks[number], data.get("result"), data.get("error", ""), tries[number], seconds, member.name, machine
        )
    if tries[number] < MAX_TRIES:
        return number
    last = read_end(member.log).strip().rpartition("\n")[2].strip()
    words = f"its worker died {MAX_TRIES} times (exit code {data['died']}){last and f': {last[:300]}'}"
    return Done(tasks[number], None, words, tries[number], seconds, member.name)


def _has_room(tasks: Sequence[Task], members: Sequence[_Member], task: Task) -> bool:
    running = [tasks[member.job[0]].needs.memory for member in members if member.job is not None]
    return not running or sum(running) + task.needs.memory <= default_memory()
