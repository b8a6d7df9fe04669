"""Estimates of time, memory and cost of tasks, from earlier runs."""

from collections.abc import Sequence
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING

from text2sim.cluster.task import Needs, Task
from text2sim.recording.record import RunRecord
from text2sim.runtime.progress import rough_duration

if TYPE_CHECKING:
    from text2sim.spec_schema.loaded import LoadedCase

CORE_HOUR = 0.05
"""Price [USD] of an hour of a core with 4 GB of memory; list prices of large clouds are 0.04 to 0.05."""
GPU_HOUR = 3.0
"""Price [USD] of an hour of a data centre GPU (2 to 4)."""
MEMORY_MARGIN = 1.2
"""Requested memory over the measured peak."""
WORKER_MEMORY = 500_000_000
"""Memory [bytes] that a worker needs besides the engine, for evidence and report."""


def measured_needs(runs: Path) -> dict[str, Needs]:
    """Return the needs of the runs in a folder by case: largest memory, mean time."""
    found: dict[str, list[RunRecord]] = {}
    for path in runs.glob("*/run.json"):
        if (record := RunRecord.read(path.parent)) is not None and record.peak_memory:
            found.setdefault(record.case, []).append(record)
    return {
        case: Needs(
            memory=int(MEMORY_MARGIN * max(r.peak_memory for r in records)) + WORKER_MEMORY,
            gpu=float(any(r.key.get("device") == "cuda" for r in records)),
            seconds=fmean(sum(r.timings.values()) for r in records),
        )
        for case, records in found.items()
    }


def needs_of(loaded: "LoadedCase", known: dict[str, Needs], *, gpu: bool) -> Needs:
    """Return the needs of the simulation of a case, measured or by default.

    Args:
        loaded: The case.
        known: Measured needs by name of the case.
        gpu: Whether the user requested a GPU.
    """
    from text2sim.runtime.machine_check import needs_cuda

    seen = known.get(loaded.case.name, Needs())
    return Needs(seen.cores, seen.memory, float(gpu or needs_cuda(loaded)), seen.seconds)


def in_words(tasks: Sequence[Task], workers: int) -> str:
    """Return an estimate of time and cost of tasks for a number of workers, in words."""
    known = [task.needs.seconds for task in tasks if task.needs.seconds is not None]
    text = f"{len(tasks)} tasks, {workers} at once, up to {max(task.needs.memory for task in tasks) / 1e9:.1f} GB each"
    if not known:
        return f"{text}; time unknown, because none was measured before"
    mean = fmean(known)
    times = [mean if task.needs.seconds is None else task.needs.seconds for task in tasks]
    cores = sum(time * task.needs.cores for time, task in zip(times, tasks, strict=True)) / 3600
    gpus = sum(time * task.needs.gpu for time, task in zip(times, tasks, strict=True)) / 3600
    price = cores * CORE_HOUR + gpus * GPU_HOUR
    wall = max(sum(times) / workers, max(times))
    some = "" if len(known) == len(tasks) else f"; the mean is assumed for {len(tasks) - len(known)} unmeasured ones"
    gpu = f" and {gpus:.2g} GPU hours" if gpus else ""
    return f"{text}: about {rough_duration(wall)}, {cores:.2g} core hours{gpu}, {price:.2g} USD if rented{some}"
