"""Tracks of the film's cameras: their poses over simulated time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from text2sim.recording.film_record import FilmRecord
from text2sim.templates.cadence import frames, reels
from text2sim.templates.cameras import Cameras, View, basis

Array = NDArray[np.floating]

MAX_CAMERA_POSES = 400
"""Largest number of poses of a camera."""


@dataclass(frozen=True)
class Track:
    """A camera over time; a single pose if it never moves."""

    times: Array
    """Simulated times [s], increasing, shape (n,)."""
    views: list[View]

    def poses(self) -> tuple[Array, Array]:
        """Return positions [m], shape (n, 3), and orientations (w, x, y, z), shape (n, 4).

        The camera looks along -z, with +y up.
        """
        turns = np.array([facing(view.pos, view.look_at, view.up) for view in self.views])
        for before, after in zip(turns, turns[1:], strict=False):
            if before @ after < 0:
                after *= -1
        return np.array([view.pos for view in self.views]), turns


def camera_tracks(recording: FilmRecord) -> dict[str, Track]:
    """Return the cameras of a recording's films by name, each over the time of its shots.

    If a time is shown twice, as in a slow-motion replay, its first occurrence is used.
    """
    film, cameras = recording.film, Cameras(recording.film, recording.states)
    seen: dict[str, dict[float, float]] = {}
    for reel in reels(film).values():
        for frame in frames(film, reel, recording.last):
            seen.setdefault(frame.camera, {}).setdefault(round(frame.t, 9), frame.part)
    tracks = {}
    for name, parts in seen.items():
        times = sorted(parts)
        chosen = np.unique(np.linspace(0, len(times) - 1, min(len(times), MAX_CAMERA_POSES)).round().astype(int))
        times = [times[k] for k in chosen]
        views = [cameras.view(name, t, parts[t]) for t in times]
        rows = np.array([[*view.pos, *view.look_at, *view.up, view.focus] for view in views])
        kept = slice(None) if (rows != rows[0]).any() else slice(1)
        tracks[name] = Track(np.array(times[kept]), views[kept])
    return tracks


def facing(pos: Array, target: Array, up: Array | tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Array:
    """Return the orientation (w, x, y, z) whose -z axis points from one point to another.

    Args:
        pos: The first point, shape (3,) [m].
        target: The second point, shape (3,) [m].
        up: Up direction, shape (3,).
    """
    from scipy.spatial.transform import Rotation

    right, upwards, ahead = (np.asarray(axis) for axis in basis(pos, target, up))
    x, y, z, w = Rotation.from_matrix(np.stack([right, upwards, -ahead], axis=1)).as_quat()
    return np.array([w, x, y, z])
