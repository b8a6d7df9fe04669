"""How many copies a `repeat` makes."""

import math

from text2sim.spec_schema.models.repeat import Grid, Repeat, RunningBond


def count_copies(repeat: Repeat | None) -> int:
    """Number of copies; 1 without `repeat`. Half ends give every second row of a bond one box more."""
    if repeat is None:
        return 1
    if isinstance(repeat, Grid):
        return math.prod(repeat.counts)
    if isinstance(repeat, RunningBond):
        return repeat.rows * repeat.columns + (repeat.rows // 2 if repeat.ends == "half" else 0)
    return repeat.count
