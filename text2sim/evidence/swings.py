"""Motion back and forth: turning points of a measure, and the period and decrement of its swings."""

import numpy as np

from text2sim.recording.states import Array

MIN_REVERSALS = 3
"""Fewest turning points with two swings between them, of which one follows the other."""


def turning_points(values: Array, swing: float) -> list[int]:
    """Return the frames at which values turn back after a change of at least `swing`, and change by it again.

    The start and the end of the values are no turning points.

    Args:
        values: A measure over time, shape (F,).
        swing: Smallest change that counts, in the unit of the measure.
    """
    turns: list[int] = []
    highest = lowest = rising = 0  # `rising` is 0 until the first change
    heights = values.tolist()
    for frame, value in enumerate(heights):
        highest = frame if value > heights[highest] else highest
        lowest = frame if value < heights[lowest] else lowest
        if rising >= 0 and heights[highest] - value >= swing:
            turns += [highest] if rising else []
            rising, lowest = -1, frame
        elif rising <= 0 and value - heights[lowest] >= swing:
            turns += [lowest] if rising else []
            rising, highest = 1, frame
    return turns


def judge_swings(stat: str, time: Array, values: Array, swing: float) -> tuple[float, str]:
    """Return a statistic of swings and what was found, in words; NaN with too few turning points.

    With turning points (t_k, x_k), k = 1 … n, and swings s_k = |x_k+1 - x_k|, `reversals` is n, `period` the mean of
    t_k+2 - t_k [s], and `decrement` that of 2 ln(s_k / s_k+1): the logarithmic decrement of a damped sine.

    Args:
        stat: One of `SWINGS`.
        time: Of the values [s], shape (F,).
        values: The measure, shape (F,).
        swing: Smallest change that counts, in its unit.
    """
    if not np.isfinite(values).all():
        return np.nan, "it has no value at some time"
    turns = turning_points(values, swing)
    found = f"it turned back {len(turns)} times"
    if stat == "reversals":
        return float(len(turns)), found
    if len(turns) < MIN_REVERSALS:
        return np.nan, f"{found}, and a {stat} needs {MIN_REVERSALS}"
    if stat == "period":
        value = float((time[turns[2:]] - time[turns[:-2]]).mean())
        return value, f"period was {value:.4g} s; {found}"
    value = float(2.0 * np.log(np.abs(np.diff(values[turns]))[[0, -1]]).dot([1, -1]) / (len(turns) - 2))
    return value, f"decrement was {value:.4g}; {found}"
