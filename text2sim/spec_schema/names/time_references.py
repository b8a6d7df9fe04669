"""Checks that the times of a case fit together, and ask for no more than anybody can wait for."""

from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.text.document import Path

MAX_STEPS = 10_000_000
"""Time steps of a run: at a millisecond each, three hours."""
MAX_RECORDED = 1_000_000
"""Recorded frames of a run."""


def check_time(cast: NameTable) -> None:
    """Check the time step and the rate of recording."""
    scene = cast.loaded.case.scene
    duration, rate = scene.duration, cast.loaded.case.record_rate
    if scene.dt > duration:
        message = f"the time step is longer than the whole run ({duration:g} s)"
        cast.report(("scene", "dt"), message, "time-step")
    _check_amount(cast, ("scene", "dt"), "time steps", duration / scene.dt, MAX_STEPS)
    recorded = duration * min(rate, 1 / scene.dt)
    _check_amount(cast, ("scene", "record", "rate"), "recorded frames", recorded, MAX_RECORDED)
    if duration * rate < 1:
        message = f"only the start would be recorded: a run of {duration:g} s needs at least {1 / duration:g}"
        cast.report(("scene", "record", "rate"), message, "rate")


def _check_amount(cast: NameTable, where: Path, noun: str, amount: float, most: int) -> None:
    if amount > most:
        cast.report(where, f"makes {amount:.3g} {noun}; at most {most:,} are possible", "too-many", key=True)
