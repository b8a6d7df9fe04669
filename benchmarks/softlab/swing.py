"""What an undamped body swings about, and how fast."""

import numpy as np

from benchmarks.softlab.lab import Array


def period_and_mean(time: Array, value: Array, about: float) -> tuple[float, float]:
    """Return the period of an oscillation [s], and its mean over whole periods.

    Args:
        time: Evenly spaced times [s], shape (F,).
        value: What swings, from one end of its way at time 0, shape (F,).
        about: A guess of the period [s], right within a third.
    """
    first = _turn(time, value, about / 2, about, +1)
    back = _turn(time, value, first + about / 2, about, -1)
    second = _turn(time, value, back + about / 2, about, +1)
    end = min(second, float(time[-1]))
    inside = (time >= first) & (time <= end)
    ends = np.interp([first, end], time, value)
    t = np.concatenate([[first], time[inside], [end]])
    v = np.concatenate([ends[:1], value[inside], ends[1:]])
    return second - first, float(np.trapezoid(v, t) / (end - first))


def _turn(time: Array, value: Array, near: float, period: float, sign: int) -> float:
    """Return when the value turns back, within a third of a period from `near`, between the samples."""
    window = np.flatnonzero(np.abs(time - near) < period / 3)
    k = int(window[np.argmax(sign * value[window])])
    k = min(max(k, 1), len(time) - 2)
    a, b, c = value[k - 1 : k + 2]
    bend = a - 2 * b + c
    return float(time[k] + (0.0 if bend == 0 else 0.5 * (a - c) / bend) * (time[1] - time[0]))
