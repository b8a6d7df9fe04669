"""Playback speed of a film for which the author gave none: waiting is cut, and the decisive moment is slowed down."""

import numpy as np

STILL = 0.02
"""Speed [picture heights / s] below which bodies count as at rest."""
WAIT = 0.8
"""Longest rest that is shown [s of film], at the end and in between."""
LEAD = 0.5
"""Time before the first motion [s of film]."""
SHORT, LONG = 3.0, 30.0
"""Length of a film [s] below which all of it is slowed down, and above which it is sped up."""
ROUND = 0.7
"""Speed above which a slowed film runs at speed 1 instead: nobody would see the difference."""
SUDDEN = 5.0
"""A moment is decisive if velocities change there this many times as much as at quiet times."""
FAST = 0.7
"""Besides, bodies must move faster there than this [picture heights / s of film]."""
BEFORE, AFTER = 0.5, 1.5
"""Time before and after the decisive moment that is shown in slow motion [s of film]."""
SLOWEST = 0.1
ALIKE = 0.6
"""The first change of at least this share of the largest is the decisive moment."""
MOST, TAIL, QUICK = 0.85, 2.5, 4.0
"""Once this share of all motion is over, the rest is sped up to this length [s of film], by at most this factor: bodies
that swing or roll to rest."""


def shots_of(times: np.ndarray, tracks: np.ndarray, size: float, camera: str) -> list[dict]:
    """Return shots that cut waiting and slow the decisive moment down.

    Args:
        times: Moments [s], shape (T,).
        tracks: Points of all moving bodies at these moments [m], shape (T, n, 3).
        size: Length that fills the height of the picture [m].
        camera: Name of the camera of the shots.
    """
    step = float(times[1] - times[0])
    moves = np.linalg.norm(np.diff(tracks, axis=0), axis=2).max(axis=1) / size / step > STILL
    if not moves.any():
        return [_shot(camera, times[0], times[-1], 1.0, 0.0)]
    first, last = (int(k) for k in np.flatnonzero(moves)[[0, -1]])
    # Bodies that creep are below the speed, but not at rest until they are near their final place.
    while last < len(times) - 2 and np.linalg.norm(tracks[-1] - tracks[last + 1], axis=1).max() > STILL * size:
        last += 1
    begin, end = times[first], times[last + 1]
    pace = float(np.clip((end - begin) / SHORT, SLOWEST, 1.0)) if end - begin < SHORT else 1.0
    pace = 1.0 if pace > ROUND else pace
    pace = max(pace, (end - begin) / LONG)
    marks = [(max(begin - LEAD * pace, times[0]), pace)]
    slow = _decisive(times, tracks, size, pace)
    waits = _waits(times, moves, first, last, pace)
    changes = [*waits, *([slow] if slow else [])]
    stop = min(end + WAIT * pace, times[-1])
    moved = np.cumsum(np.linalg.norm(np.diff(tracks, axis=0), axis=2).mean(axis=1))
    over = max(float(times[int(np.searchsorted(moved, MOST * moved[-1])) + 1]), slow[1] if slow else times[0])
    if (stop - over) / pace > TAIL:
        changes.append((over, stop, min((stop - over) / TAIL, QUICK * pace)))
    for t0, t1, speed in sorted(changes):
        t0 = max(t0, marks[-1][0])
        if t1 > t0:
            marks += [(t0, speed), (t1, pace)]
    marks = [(t, speed) for t, speed in marks if t < stop - 1e-6] or marks[:1]
    ends = [t for t, _ in marks[1:]] + [stop]
    kept = [(t0, t1, speed) for (t0, speed), t1 in zip(marks, ends, strict=True) if t1 - t0 > 1e-6]
    held = max(WAIT - (stop - end) / kept[-1][2], 0.0)
    return [_shot(camera, t0, t1, speed, held if k == len(kept) - 1 else 0.0) for k, (t0, t1, speed) in enumerate(kept)]


def _shot(camera: str, start: float, end: float, speed: float, hold: float) -> dict:
    return {
        "name": "", "camera": camera, "from": round(float(start), 4), "to": round(float(end), 4),
        "speed": float(f"{speed:.2g}"), "hold": round(float(hold), 2),
    }  # fmt: skip


def _decisive(times: np.ndarray, tracks: np.ndarray, size: float, pace: float) -> tuple[float, float, float] | None:
    """Return the span [s] of the decisive moment, and its playback speed; None if there is no such moment."""
    step = float(times[1] - times[0])
    speeds = np.diff(tracks, axis=0) / size / step
    jumps = np.linalg.norm(np.diff(speeds, axis=0), axis=2).mean(axis=1)
    if jumps.max() < SUDDEN * max(float(np.percentile(jumps, 25)), 1e-9):
        return None
    k = int(np.flatnonzero(jumps >= ALIKE * jumps.max())[0]) + 1
    near = speeds[max(k - 3, 0) : k + 4]
    fastest = float(np.percentile(np.linalg.norm(near, axis=2).max(axis=0), 98))
    if fastest * pace < FAST:
        return None
    speed = max(FAST / 2 / fastest, SLOWEST, pace / 5)
    return float(times[k] - BEFORE * speed), float(times[k] + AFTER * speed), speed


def _waits(
    times: np.ndarray, moves: np.ndarray, first: int, last: int, pace: float
) -> list[tuple[float, float, float]]:
    """Return spans [s] of rest that are too long to be shown in full, and their playback speeds."""
    found, k = [], first
    while k <= last:
        end = k
        while end <= last and not moves[end]:
            end += 1
        long = times[end] - times[k] - 0.6 * WAIT * pace
        if long > 0.6 * WAIT * pace:
            margin = 0.3 * WAIT * pace
            found.append((float(times[k] + margin), float(times[end] - margin), float(long / (0.4 * WAIT))))
        k = max(end, k + 1)
    return found
