"""Frames in which nothing moves visibly: each is replaced by an earlier frame that looks the same.

Bodies at rest still move by micrometres, so no two frames have the same digest. Without this, the second before
an event and the rest at the end would cost as much as the event. A part of what is saved is spent on more samples of
the frame that stays, which is looked at longest.
"""

from collections.abc import Iterable
from math import radians, tan

import numpy as np
from numpy.typing import NDArray

from text2sim.recording.film_record import FilmRecord
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras, View

Array = NDArray[np.floating]

VISIBLE = 0.2
"""Smallest motion that is drawn [pixels]."""
CAMERA_RESTS = 1e-5
"""Largest motion of a resting camera, as a fraction of its distance to the point that it looks at."""

EXACT = (4, 8, 16, 36, 64)
"""Samples per pixel that the sampler distributes evenly."""
SPENT, MOST = 0.5, 8
"""Fraction of the time saved by a held frame that is spent on its samples, and the largest factor on them."""


def held_samples(samples: int, pictures: int) -> int:
    """Return the samples per pixel of a frame that stands for a number of pictures."""
    most = samples * min(SPENT * pictures, MOST)
    return max([samples, *(exact for exact in EXACT if exact <= most)])


def drawn_frames(frames: Iterable[Frame], recording: FilmRecord, cameras: Cameras, height: int) -> dict[Frame, Frame]:
    """Return the frame that is drawn in place of each frame: itself, or an earlier one that looks the same.

    Each frame is compared with the one that is drawn for it, so slow motion does not add up.

    Args:
        frames: Frames of a film, in order.
        recording: The recording of the run.
        cameras: Its cameras.
        height: Height of the picture [pixels].
    """
    drawn: dict[Frame, Frame] = {}
    last, last_views, last_points = None, [], np.zeros(0)
    for frame in frames:
        times = (frame.open, frame.close)
        views = [cameras.view(frame.camera, t, frame.part + (t - frame.t) * frame.pace) for t in times]
        if last is None or frame.camera != last.camera or not _rests(last_views, views):
            last, last_views, last_points = frame, views, np.zeros(0)
        else:
            last_points = last_points if len(last_points) else _points(recording, last)
            points = _points(recording, frame)
            if _motion(last_points, points, views[0], height) > VISIBLE:
                last, last_views, last_points = frame, views, points
        drawn[frame] = last
    return drawn


def _rests(before: list[View], now: list[View]) -> bool:
    """Return whether a camera does not move between two frames."""
    for a, b in zip(before, now, strict=True):
        near = CAMERA_RESTS * float(np.linalg.norm(a.look_at - a.pos))
        if not all(np.allclose(x, y, rtol=0.0, atol=near) for x, y in zip(a, b, strict=True)):
            return False
    return True


def _points(recording: FilmRecord, frame: Frame) -> Array:
    """Return points of all that moves, when the shutter opens and when it closes, shape (2, n, 3) [m]."""
    states = recording.states
    moving = [body for body in recording.bodies if body not in recording.statics]
    found = []
    for t in (frame.open, frame.close):
        points = [states.poses(t)[0], states.tracks(moving, t)]  # poses know of removed bodies
        if states.soft is not None:
            points += [states.soft.at(name, states.around(t)) for name in ("soft_points", "soft_surface")]
        found.append(np.concatenate(points))
    return np.nan_to_num(np.array(found))


def _motion(before: Array, now: Array, view: View, height: int) -> float:
    """Return the largest motion of a point in the picture [pixels]."""
    away = np.maximum(np.linalg.norm(before - view.pos, axis=-1), 1e-6)
    pixels = height / (2 * tan(radians(view.fov) / 2))
    return pixels * float((np.linalg.norm(now - before, axis=-1) / away).max(initial=0.0))
