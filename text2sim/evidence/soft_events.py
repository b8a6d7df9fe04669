"""Touches of deformable bodies. The engine does not report them: they are derived from distances of recorded points.

Two bodies touch while their gap is at most the distance that their solvers keep. They separate once it is half as
large again; the hysteresis keeps bodies at rest from flickering. Times are interpolated between frames.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget
from text2sim.evidence.soft_measures import gap
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array

PBD_TOLERANCE = 0.6
"""Largest gap of touching pbd particles, in their spacings: they rest at 0.5, and a fifth more still counts."""
MPM_CELL = 1 / 0.64
"""Largest gap of touching mpm particles, in their spacings: one cell of the grid."""
MESH_TOLERANCE, MESH_TOLERANCE_SHARE = 0.002, 0.05
"""Largest gap of touching vertices of fem and ipc: [m], or as a fraction of their edges, whichever is larger."""
RELEASE_FACTOR = 1.5
"""Gap at which a touch is over, in tolerances."""


def tolerance(body: RecordedDeformable) -> float:
    """Return the gap [m] up to which a body touches a rigid one; for two deformable bodies, both add up."""
    if body.solver == "pbd":
        return PBD_TOLERANCE * body.spacing
    if body.solver == "mpm":
        return MPM_CELL * body.spacing
    return max(MESH_TOLERANCE, MESH_TOLERANCE_SHARE * body.spacing)


def soft_episodes(
    recording: RecordedCase, first: Sequence[RecordedTarget], second: Sequence[RecordedTarget]
) -> list[dict[str, Any]]:
    """Return the touches of pairs of targets, at least one deformable, as occurrences without name and kind.

    Each has `gap`, the smallest of the touch [m], `penetration`, the largest depth of a point in a solid [m], and
    `pos`, the place where it began [m]. A pair named by both sides is listed once.

    Args:
        recording: The recording.
        first: Targets on one side.
        second: Targets on the other side.
    """
    rows, done = [], set()
    for one in first:
        for other in second:
            pair = frozenset(((one.links, one.soft), (other.links, other.soft)))
            if len(pair) == 2 and pair not in done:
                done.add(pair)
                rows += _episodes(recording, one, other)
    return rows


def _episodes(recording: RecordedCase, one: RecordedTarget, other: RecordedTarget) -> list[dict[str, Any]]:
    own, theirs = (one, other) if one.soft is not None else (other, one)
    body, second = recording.deformable(own), recording.deformable(theirs)
    assert body is not None
    near = tolerance(body) + (tolerance(second) if second is not None else 0.0)
    found = gap(recording, body, [theirs], 2 * RELEASE_FACTOR * near)
    time, rows = recording.states.time, []
    for begin, end in spans(found.value, near, RELEASE_FACTOR * near):
        last = len(time) - 1
        inside = slice(begin, end + 1)
        smallest = float(np.min(found.value[inside]))
        rows.append(
            {
                "time": passage(time, found.value, begin - 1, near) if begin else float(time[0]),
                "end": passage(time, found.value, end, RELEASE_FACTOR * near) if end < last else float(time[-1]),
                "ongoing": end == last,
                "between": [one.label, other.label],
                "pos": found.pos[begin].tolist(),
                "gap": smallest,
                "penetration": max(0.0, -smallest),
            }
        )
    return rows


def spans(value: Array, near: float, apart: float) -> list[tuple[int, int]]:
    """Return (first, last) of the runs of frames that begin when a value is `near` and end before it is `apart`.

    Args:
        value: One for each frame, shape (F,).
        near: A run begins at this value or below.
        apart: It ends at this value or above.
    """
    rows, begin = [], None
    for frame, now in enumerate(value.tolist()):
        if begin is None and now <= near:
            begin = frame
        elif begin is not None and not now < apart:
            rows.append((begin, frame - 1))
            begin = None
    return rows if begin is None else [*rows, (begin, len(value) - 1)]


def passage(time: Array, value: Array, frame: int, level: float) -> float:
    """Return the time [s] at which a value crosses a level between a frame and the next, linearly interpolated.

    Args:
        time: Of the frames [s], shape (F,).
        value: One for each frame, shape (F,).
        frame: The frame before the crossing.
        level: What is crossed.
    """
    a, b = float(value[frame]), float(value[frame + 1])
    part = (level - a) / (b - a) if np.isfinite(a) and np.isfinite(b) and a != b else 1.0
    return float(time[frame] + min(max(part, 0.0), 1.0) * (time[frame + 1] - time[frame]))
