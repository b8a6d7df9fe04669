"""Tasks on a real Ray cluster of three nodes on this machine, with a worker and a node killed in mid-run."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil
import pytest
from open_node import on_node

from text2sim.cluster import ray_pool
from text2sim.cluster.ray_pool import run_ray
from text2sim.cluster.task import Needs, Task
from text2sim.runtime.stop import Stop

ray = pytest.importorskip("ray")
pytestmark = pytest.mark.slow
SMALL = Needs(memory=100_000_000)
CASE = """\
text2sim: 2
name: drop
scene: {duration: 2.0, dt: 0.001, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 30]}}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  expect: {falls: {measure: height, at: end, below: 20}}
"""


def patiently(start: Callable[[], Any]) -> Any:
    """Try it three times: Ray gives its processes no more than 30 s to start, which a busy machine may not do."""
    for _ in range(2):
        with suppress(Exception):
            return start()
    return start()


@pytest.fixture(scope="module")
def cluster() -> Iterator[object]:
    """A head and two more nodes, a core each."""
    from ray.cluster_utils import Cluster

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
        node = {"num_cpus": 1, "memory": 4_000_000_000, "object_store_memory": 80_000_000}
        made = patiently(lambda: Cluster(initialize_head=True, head_node_args={**node, "include_dashboard": False}))
        made.nodes_for_tests = [patiently(lambda: made.add_node(**node)) for _ in range(2)]
        yield made
        ray.shutdown()
        made.shutdown()


@pytest.fixture
def begin(cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list]:
    monkeypatch.setattr(ray_pool, "_on_node", on_node)

    def run(tasks: list[Task], stop: Stop | None = None) -> list:
        return list(run_ray(tasks, cluster.address, str(tmp_path / "store"), stop or Stop(), warm=False))

    return run


def count(path: Path) -> int:
    return path.read_text().count("\n") if path.exists() else 0


def test_a_killed_worker_costs_its_task_and_no_other(begin, tmp_path):
    log = tmp_path / "log"
    tasks = [
        Task(
            "open_worker:note", {"log": str(log), "word": f"w{n}", "wait": n == 3}, needs=SMALL, output=tmp_path / "out"
        )
        for n in range(6)
    ]

    def kill() -> None:
        while not (words := [line.split() for line in log.read_text().splitlines()] if log.exists() else []) or not (
            pids := [int(pid) for word, pid in words if word == "w3"]
        ):
            time.sleep(0.1)
        Path(f"{log}.go").touch()  # the second time it does not wait
        os.kill(pids[0], signal.SIGKILL)

    threading.Thread(target=kill).start()
    done = begin(tasks)
    assert [one.error for one in done] == [""] * 6
    assert {one.task.arguments["word"]: one.tries for one in done} == {f"w{n}": 1 + (n == 3) for n in range(6)}
    assert len({one.worker for one in done}) > 1  # more than one node
    assert {path.name for path in (tmp_path / "out").iterdir()} == {f"w{n}" for n in range(6)}
    assert count(log) == 7
    again = begin(tasks)  # all of it is in the store
    assert [one.tries for one in again] == [0] * 6
    assert count(log) == 7


def test_a_lost_node_costs_only_its_tasks(begin, cluster, tmp_path):
    log = tmp_path / "log"

    def lose() -> None:
        while count(log) < 3:
            time.sleep(0.1)
        cluster.remove_node(cluster.nodes_for_tests.pop(), allow_graceful=False)
        while all(psutil.pid_exists(int(line.split()[1])) for line in log.read_text().splitlines()):
            time.sleep(0.1)
        Path(f"{log}.go").touch()

    threading.Thread(target=lose).start()
    done = begin(
        [Task("open_worker:note", {"log": str(log), "word": f"w{n}", "wait": True}, needs=SMALL) for n in range(3)]
    )
    assert [one.error for one in done] == [""] * 3
    assert sorted(one.tries for one in done) == [1, 1, 2]


def test_a_request_to_stop_leaves_no_processes(begin, tmp_path):
    stop, log = Stop(), tmp_path / "log"

    def ask() -> None:
        while count(log) < 2:
            time.sleep(0.1)
        stop.request()

    threading.Thread(target=ask).start()
    tasks = [Task("open_worker:note", {"log": str(log), "word": f"w{n}", "wait": True}, needs=SMALL) for n in range(4)]
    done = begin(tasks, stop)
    assert [one.stopped for one in done] == [True] * 4
    pids = [int(line.split()[1]) for line in log.read_text().splitlines()]
    until = time.monotonic() + 10
    while any(psutil.pid_exists(pid) for pid in pids) and time.monotonic() < until:
        time.sleep(0.1)
    assert not any(psutil.pid_exists(pid) for pid in pids)


def test_errors_of_the_user_come_back_as_messages(begin, tmp_path):
    (one,) = begin([Task("open_worker:refuse", needs=SMALL)])
    assert one.error == "there is no ball"


def drops(folder: Path, duration: float) -> list[Task]:
    """Four runs of a ball that falls, with other seeds."""
    case = folder / "drop"
    case.mkdir()
    (case / "case.yaml").write_text(CASE)
    return [
        Task(
            "text2sim.cluster.work:simulate",
            {
                "variants": [],
                "sets": [f"scene.seed={n}", f"scene.duration={duration}"],
                "point": None,
                "lint": [],
                "film": False,
            },
            label=f"drop{n}",
            needs=SMALL,
            inputs={"case": case},
            output=folder / "runs",
        )
        for n in range(4)
    ]


def at_work() -> list[psutil.Process]:
    """Ray's processes that have an engine, which writes its states below the task's folder."""
    found = []
    for process in psutil.process_iter(["cmdline"]):
        with suppress(psutil.Error):
            if " ".join(process.info["cmdline"] or ()).startswith("ray::drop") and process.children(recursive=True):
                found.append(process)
    return found


@pytest.mark.usefixtures("engine")
@pytest.mark.timeout(1500)
def test_a_worker_killed_while_it_simulates_costs_that_run_alone(cluster, tmp_path):
    """Four real runs on two or three nodes with warm engines; once one is done, another is killed in mid-run."""
    store, tasks = tmp_path / "store", drops(tmp_path, 2.0)
    killed: list[str] = []

    def kill() -> None:
        while not killed:
            for process in at_work()[:1] if [*store.glob("trees/*.json")] else ():
                title = " ".join(process.cmdline())
                process.kill()
                killed.append(title)
            time.sleep(0.05)

    threading.Thread(target=kill, daemon=True).start()

    def run() -> list[Any]:
        return list(run_ray(tasks, cluster.address, str(store), Stop()))

    done = run()
    assert [one.error for one in done] == [""] * 4
    assert killed
    tries = {one.task.label: one.tries for one in done}
    (victim,) = [label for label in tries if f"ray::{label}" in killed[0]]
    assert tries == {f"drop{n}": 1 + (f"drop{n}" == victim) for n in range(4)}
    for one in done:
        assert one.result["passed"]
        folder = tmp_path / "runs" / one.result["folder"]
        assert {"run.json", "report.html", "evidence.json", "case.yaml"} <= {path.name for path in folder.iterdir()}
    assert len({one.result["folder"] for one in done}) == 4
    assert [one.tries for one in run()] == [0] * 4, "all of it is in the store"


@pytest.mark.usefixtures("engine")
@pytest.mark.timeout(1500)
def test_a_request_to_stop_ends_the_engines_too(cluster, tmp_path):
    """Runs of many minutes; once two engines simulate, somebody asks to stop."""
    stop, engines = Stop(), []

    def ask() -> None:
        while len(at_work()) < 2:
            time.sleep(0.1)
        engines.extend(child for process in at_work() for child in process.children(recursive=True))
        stop.request()

    threading.Thread(target=ask, daemon=True).start()
    done = list(run_ray(drops(tmp_path, 600.0), cluster.address, str(tmp_path / "store"), stop))
    assert [one.stopped for one in done] == [True] * 4
    assert len(engines) >= 2
    _, alive = psutil.wait_procs(engines, timeout=15)
    assert not alive
    assert not at_work()
