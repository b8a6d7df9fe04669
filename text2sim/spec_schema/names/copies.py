"""Counts of the copies that a `repeat` makes."""

import math
from typing import Any

from text2sim.spec_schema.models.repeat import Glyphs, Grid, Repeat, RunningBond
from text2sim.spec_schema.models.shapes import Text

UNKNOWN = 1000
"""Copies of an unread sketch: the largest number of pieces."""


def count_copies(repeat: Repeat | None, shape: Any = None) -> int:
    """Return the number of copies; 1 without `repeat`. Half ends give every second row of a bond one box more.

    Args:
        repeat: The pattern.
        shape: The repeated shape; a text has a copy for each letter.
    """
    if repeat is None:
        return 1
    if isinstance(repeat, Glyphs):
        return sum(not sign.isspace() for sign in shape.text) if isinstance(shape, Text) else UNKNOWN
    if isinstance(repeat, Grid):
        return math.prod(repeat.counts)
    if isinstance(repeat, RunningBond):
        return repeat.rows * repeat.columns + (repeat.rows // 2 if repeat.ends == "half" else 0)
    return repeat.count
