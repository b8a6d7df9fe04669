"""Statics that no picture shows, such as a wall behind the camera: they are not drawn, nor are their shadows.

An author who turns the camera leaves the backdrop where it was. A shadow without a cause looks like a mistake.
"""

import numpy as np

from text2sim.recording.film_record import FilmRecord
from text2sim.templates.cadence import frames, reels
from text2sim.templates.cameras import Cameras, View, project

EYES = 60
"""Number of moments of the films at which cameras are sampled."""
ROWS = 24
"""Number of points along each edge of a bounding box that are looked for in the pictures."""
BEYOND = 1.1
"""Half width and height of what is looked at, in those of the picture."""


def views_of(recording: FilmRecord) -> list[View]:
    """Return the views of the cameras over the films, and those of each camera over the whole time."""
    film, last = recording.film, recording.last
    cameras = Cameras(film, recording.states)
    pictures = [frame for reel in reels(film).values() for frame in frames(film, reel, last)]
    chosen = pictures[:: max(1, len(pictures) // EYES)]
    moments = [(frame.camera, frame.t, frame.part) for frame in chosen]
    parts = np.linspace(0.0, 1.0, EYES // 4)
    moments += [(name, film["start"] + p * (film["end"] - film["start"]), p) for name in film["cameras"] for p in parts]
    return [cameras.view(*moment) for moment in moments]


def offstage(recording: FilmRecord, views: list[View]) -> frozenset[str]:
    """Return the names of the statics that are outside all pictures.

    With lights of its own, a case may mean their shadows: nothing is offstage.

    Args:
        recording: The recording of the run.
        views: Views of its cameras.
    """
    if recording.film["backdrop"].get("own_lights"):
        return frozenset()
    wide, tall = recording.film["resolution"]
    first = float(recording.states.time[0])
    found = set()
    for body in recording.statics:
        corners = np.asarray(recording.states.bounds([body], first), float)
        if len(corners) and np.isfinite(corners).all():
            points = _box(corners)
            if not any(_sees(view, points, wide / tall) for view in views):
                found.add(body)
    return frozenset(found)


def _box(corners: np.ndarray) -> np.ndarray:
    """Return points on the faces of the bounding box of points, shape (n, 3) [m]."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    grid = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, ROWS)] * 2), axis=-1).reshape(-1, 2)
    faces = [np.insert(grid, axis, side, axis=1) for axis in range(3) for side in (0.0, 1.0)]
    return low + np.concatenate(faces) * (high - low)


def _sees(view: View, points: np.ndarray, aspect: float) -> bool:
    right, up, depth = project(view, points, aspect).T
    return bool(((depth > 0) & (np.abs(right) < BEYOND) & (np.abs(up) < BEYOND)).any())
