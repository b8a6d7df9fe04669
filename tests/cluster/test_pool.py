"""The local pool: distribution of tasks, retries, stops."""

import threading
import time
from pathlib import Path

import psutil
import pytest

from text2sim.cluster.estimate import in_words, measured_needs
from text2sim.cluster.pool import run_local
from text2sim.cluster.task import Needs, Task
from text2sim.recording.record import RunRecord
from text2sim.runtime.stop import Stop

pytestmark = pytest.mark.usefixtures("open_workers")


def task(name: str, folder: Path, **arguments: object) -> Task:
    return Task(f"open_worker:{name}", arguments, output=folder)


def test_a_task_writes_where_it_should_and_two_workers_share_the_work(tmp_path):
    marks = [task("write", tmp_path, text="one"), task("write", tmp_path, text="one"), task("refuse", tmp_path)]
    done = {id(one.task): one for one in run_local(marks, 2, Stop(), warm=False)}
    assert (tmp_path / "said.txt").read_text() == "one"
    assert {done[id(mark)].error for mark in marks} == {"", "there is no ball"}
    assert all(psutil.pid_exists(done[id(mark)].result["pid"]) is False for mark in marks[:2])


def test_a_lost_worker_is_replaced_and_only_its_task_is_done_again(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    tasks = [
        task("die", tmp_path / "a", times=2),
        task("die", tmp_path / "b", times=9),
        task("write", tmp_path, text=""),
    ]
    done = {id(one.task): one for one in run_local(tasks, 1, Stop(), warm=False)}
    assert (done[id(tasks[0])].tries, done[id(tasks[0])].result) == (3, {"deaths": 2})
    assert done[id(tasks[1])].error == "its worker died 3 times (exit code -9)"
    assert done[id(tasks[2])].tries == 1


def test_a_request_to_stop_ends_running_tasks_and_begins_no_others(tmp_path):
    stop, tasks = Stop(), [task("wait", tmp_path, mark=f"pid{n}") for n in range(3)]

    def ask() -> None:
        while len(list(tmp_path.glob("pid*"))) < 2:
            time.sleep(0.05)
        stop.request()

    threading.Thread(target=ask).start()
    done = list(run_local(tasks, 2, stop, warm=False))
    assert sorted(one.stopped for one in done) == [False, False, True]
    pids = [int(path.read_text()) for path in tmp_path.glob("pid*")]
    assert len(pids) == 2
    assert not any(psutil.pid_exists(pid) for pid in pids)


def test_tasks_wait_for_memory(tmp_path):
    """Two that need more than half of the machine do not run together."""
    much = Needs(memory=psutil.virtual_memory().total * 6 // 10)
    tasks = [Task("open_worker:write", {"text": ""}, needs=much, output=tmp_path) for _ in range(3)]
    workers = {one.worker for one in run_local(tasks, 2, Stop(), warm=False)}
    assert workers == {"worker 1"}


def test_only_functions_of_ours_are_called(tmp_path, monkeypatch):
    monkeypatch.undo()  # with the worker as it is
    (done,) = run_local([Task("os:getpid")], 1, Stop(), warm=False)
    assert "os is not a module of text2sim" in done.error


def test_an_estimate_is_the_mean_of_measured_runs(tmp_path):
    for number, seconds in enumerate((30.0, 90.0)):
        (tmp_path / f"fall-{number}").mkdir()
        record = RunRecord("fall", "finished", {}, timings={"simulate": seconds}, peak_memory=10**9)
        record.write(tmp_path / f"fall-{number}")
    needs = measured_needs(tmp_path)["fall"]
    assert (needs.seconds, needs.memory) == (60.0, 1_700_000_000)
    words = in_words([Task("", needs=needs)] * 3 + [Task("")], 2)
    # 4 tasks of 60 s on 2 workers are 120 s; 240 s of a core are 1/15 h, at 0.05 USD an hour
    assert "about 2 min, 0.067 core hours, 0.0033 USD" in words
    assert "assumed for 1 unmeasured" in words
