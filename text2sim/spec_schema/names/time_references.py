"""Checks of the time step, the rate of recording, and the number of steps."""

from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.text.document import Path

MAX_STEPS = 10_000_000
"""Most time steps of a run: at a millisecond each, three hours."""
MAX_RECORDED = 1_000_000
"""Most recorded frames of a run."""


def check_time(table: NameTable) -> None:
    """Check the time step and the rate of recording."""
    scene = table.loaded.case.scene
    duration, rate = scene.duration, table.loaded.case.record_rate
    if scene.dt > duration:
        message = f"the time step is longer than the whole run ({duration:g} s)"
        table.report(("scene", "dt"), message, "time-step")
    _check_amount(table, ("scene", "dt"), "time steps", duration / scene.dt, MAX_STEPS)
    recorded = duration * min(rate, 1 / scene.dt)
    _check_amount(table, ("scene", "record", "rate"), "recorded frames", recorded, MAX_RECORDED)
    if duration * rate < 1:
        message = f"records only the start: a run of {duration:g} s needs at least {1 / duration:g}"
        table.report(("scene", "record", "rate"), message, "rate")


def _check_amount(table: NameTable, where: Path, noun: str, amount: float, most: int) -> None:
    if amount > most:
        table.report(where, f"gives {amount:.3g} {noun}; at most {most:,} are possible", "too-many", key=True)
