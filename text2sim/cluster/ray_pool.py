"""Tasks on a Ray cluster, whose inputs and outputs go through a shared store."""

import logging
import os
import tempfile
from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import monotonic
from typing import Any

from text2sim.cluster.store import SKIPPED, Store, Tree, digest_of
from text2sim.cluster.task import MAX_TRIES, STOPPED, Done, Task, key_of
from text2sim.cluster.worker import Worker
from text2sim.harness.folder import staging
from text2sim.harness.sources import package_code
from text2sim.runtime.stop import Stop
from text2sim.spec_schema.errors import MachineError

POLL_INTERVAL = 0.5
TASKS_PER_CORE = 4
"""Tasks per core of the cluster that are submitted to Ray at a time: enough that Ray never waits for us."""
TASKS_FOLDER = "text2sim-tasks"
"""Folder for inputs and outputs of tasks, below the nodes' temporary folder."""

_worker: list[Worker] = []
"""The worker of this process of Ray, kept so that its engine stays warm between tasks."""


def run_ray(tasks: Sequence[Task], address: str, url: str, stop: Stop, *, warm: bool = True) -> Iterator[Done]:
    """Run tasks on a Ray cluster, and yield the result of each as soon as it is known.

    Results in the store are reused. A task whose worker or node is lost is tried again, `MAX_TRIES` times in total. At
    a request to stop, running tasks are killed. All nodes need the same version of text2sim.

    Args:
        tasks: The tasks.
        address: Address of the cluster, for `ray.init`.
        url: URL of the store, which all nodes must reach.
        stop: Requests to stop.
        warm: Whether workers keep an engine warm.

    Raises:
        MachineError: if there is no Ray, or no cluster.
    """
    store, code, cores = Store(url), package_code(), connect(address)
    import ray
    import ray.exceptions as failures

    with stop.gently():
        remote = ray.remote(_on_node)
        waiting, tries, trees = deque(range(len(tasks))), [0] * len(tasks), dict[Path, Tree]()
        running: dict[Any, tuple[int, str, float]] = {}
        try:
            while waiting or running:
                while waiting and len(running) < TASKS_PER_CORE * cores and not stop.count:
                    number = waiting.popleft()
                    task = tasks[number]
                    order = task.order({name: _tree(store, path, trees) for name, path in task.inputs.items()}, None)
                    key = key_of({**order, "inputs": {n: digest_of(tree) for n, tree in order["inputs"].items()}}, code)
                    known = None if tries[number] or task.arguments.get("force") else store.kept(key)
                    if known and not known[0].get("again"):
                        yield _fetched(store, task, known, 0, 0.0, "")
                        continue
                    tries[number] += 1
                    needs = {"num_cpus": task.needs.cores, "memory": task.needs.memory, "num_gpus": task.needs.gpu}
                    remote_task = remote.options(**needs, max_retries=0, name=task.label or task.function)
                    running[remote_task.remote(order, key, url, code, warm)] = number, key, monotonic()
                if stop.count:
                    numbers = [*(number for number, _, _ in running.values()), *waiting]
                    yield from (Done(tasks[number], None, STOPPED, tries[number]) for number in numbers)
                    return
                # All ready results at once: waiting for single ones would scan all running tasks for each.
                ready, _ = (
                    ray.wait(list(running), num_returns=len(running), timeout=POLL_INTERVAL) if running else ([], [])
                )
                for ref in ready:
                    number, key, since = running.pop(ref)
                    task, seconds = tasks[number], monotonic() - since
                    try:
                        answer: dict[str, Any] = ray.get(ref)
                    except failures.RayTaskError as error:
                        answer = {"error": str(error.cause or error).splitlines()[-1]}
                    except failures.RayError as error:  # its worker or its node died
                        if tries[number] < MAX_TRIES:
                            waiting.appendleft(number)
                            continue
                        answer = {"error": f"its worker died {MAX_TRIES} times ({type(error).__name__})"}
                    if "error" not in answer and (kept := store.kept(key)):
                        yield _fetched(store, task, kept, tries[number], seconds, answer["worker"])
                    else:
                        words = str(answer.get("error", f"its result is not in {url}"))
                        yield Done(task, None, words, tries[number], seconds, machine=bool(answer.get("machine")))
        finally:
            for ref in running:
                ray.cancel(ref, force=True)


def connect(address: str) -> int:
    """Connect this process to a Ray cluster, and return the number of its cores.

    Raises:
        MachineError: if there is no Ray, or no cluster.
    """
    try:
        import ray
    except ImportError as error:
        raise MachineError("Ray is not installed here: pip install 'text2sim[ray]'") from error
    try:
        if not ray.is_initialized():
            ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
    except (ConnectionError, ValueError, RuntimeError, OSError) as error:
        raise MachineError(f"there is no Ray cluster at {address}: {str(error).splitlines()[0]}") from error
    return max(1, int(ray.cluster_resources().get("CPU", 1)))


def _tree(store: Store, path: Path, trees: dict[Path, Tree]) -> Tree:
    if path not in trees:
        trees[path] = store.put_tree(path, skip=frozenset({"render"}) if (path / "run.json").is_file() else SKIPPED)
    return trees[path]


def _fetched(
    store: Store, task: Task, kept: tuple[dict[str, Any], Tree], tries: int, seconds: float, worker: str
) -> Done:
    if task.output is not None:
        store.get_tree(kept[1], task.output)
    return Done(task, kept[0], "", tries, seconds, worker)


def _on_node(order: dict[str, Any], key: str, url: str, code: str, warm: bool) -> dict[str, Any]:
    """Run a task in a process of Ray: fetch its inputs, store its results."""
    import ray

    if code != package_code():
        return {"error": "this node has another version of text2sim; install the same everywhere", "machine": True}
    store, home = Store(url), Path(tempfile.gettempdir()) / TASKS_FOLDER
    if not _worker:
        folder = home / f".staging-{os.getpid()}-engine"
        folder.mkdir(parents=True, exist_ok=True)
        _worker.append(Worker(folder, warm=warm))
    with staging(home) as folder:
        inputs = {name: folder / "inputs" / name for name in order["inputs"]}
        for name, tree in order["inputs"].items():
            store.get_tree(tree, inputs[name])
        output = folder / "output"
        output.mkdir()
        answer = _worker[0].perform({**order, "inputs": inputs, "output": output})
        if "result" in answer:
            store.keep(key, answer.pop("result"), store.put_tree(output))
    return {**answer, "worker": ray.get_runtime_context().get_node_id()[:8]}
