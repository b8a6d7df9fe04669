"""Simulations per hour in the local pool: with and without warm engines, one worker and two."""

import argparse
import resource
import tempfile
from pathlib import Path
from time import monotonic

from rich.console import Console
from rich.table import Table

from text2sim.cluster.run import Placement, run_tasks
from text2sim.cluster.task import Task
from text2sim.runtime.stop import Stop

ROOT = Path(__file__).resolve().parent.parent


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", type=Path, default=ROOT / "benchmarks/scenes/ten_boxes.yaml", help="its file")
    parser.add_argument("--items", type=int, default=6, help="simulations per worker")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    options = parser.parse_args()
    heads = ["first item [s]", "a further one of a worker [s]", "an hour, with start", "later", "processor [s an item]"]
    table = Table("workers", "engine", *heads)
    for workers in options.workers:
        for warm in (False, True):
            table.add_row(str(workers), "warm" if warm else "anew", *measure(options, workers, warm))
    Console().print(table)


def measure(options: argparse.Namespace, workers: int, warm: bool) -> list[str]:
    """Return the figures of one row."""
    count = options.items * workers
    with tempfile.TemporaryDirectory() as folder, Stop() as stop:
        tasks = []
        for number in range(count):  # another seed is another run
            case = {"file": options.case.name, "variants": [], "sets": [f"scene.seed={number + 1}"], "point": None}
            inputs, output = {"case": options.case.parent}, Path(folder)
            arguments = {**case, "lint": [], "film": False}
            tasks.append(Task("text2sim.cluster.work:simulate", arguments, inputs=inputs, output=output))
        begun, before, took = monotonic(), _children(), dict[str, list[float]]()
        first = last = 0.0
        for done in run_tasks(tasks, Placement(workers=workers, warm=warm), stop):
            assert done.result is not None, done.error
            last = monotonic() - begun
            first = first or last
            took.setdefault(done.worker, []).append(done.seconds)
    work = (_children() - before) / count
    further = [seconds for row in took.values() for seconds in row[1:]]  # the first of a worker starts its engine
    later = sum(further) / len(further)
    rates = count / last * 3600, workers / later * 3600
    return [f"{first:.1f}", f"{later:.1f}", *(f"{rate:.0f}" for rate in rates), f"{work:.1f}"]


def _children() -> float:
    """Time of processors [s] that ended child processes took."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
