"""Motion of bodies as the pictures of a film show it, from recorded states."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.recording.film_record import FilmRecord
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras, View, project

Array = NDArray[Any]

SLACK, FARTHEST = 0.02, 1.0
"""Displacement [heights of the picture] that does not make a picture look different, and largest one in x or y from one
picture to the next that counts."""


def visible_motion(recording: FilmRecord, frames: Sequence[Frame]) -> Array:
    """Return how far bodies have moved in the pictures, up to each picture [heights of the picture], shape (n,).

    From one picture to the next of the same camera, a point x that is inside one of them moves by the shorter of

        p'(x') - p(x)  and  p(x') - p(x)

    where p and p' project into both pictures. So it has to move in the picture and in space: a truck which a camera
    follows rests as much as a wall past which it travels. These vectors sum to s; what |s| exceeds `SLACK` by counts,
    and is taken off s: what flutters or trembles comes back. A body moves by the mean over its points, and the sum over
    bodies accumulates. Points are the centres of the meshes of links (a wheel that spins in place rests), and up to
    `TRACKED` points of what deforms. Cuts, held pictures and replays show nothing new.

    Args:
        recording: The recorded run.
        frames: The pictures.
    """
    states, cameras = recording.states, Cameras(recording.film, recording.states)
    aspect = recording.film["resolution"][0] / recording.film["resolution"][1]
    drawn = {part.body: None for part in [*recording.parts, *recording.soft] if part.look.drawn}
    soft = [part.body for part in recording.soft if part.body in drawn]
    boxes = states.boxes([body for body in drawn if body not in recording.statics and body not in soft])
    counts = {name: boxes.names.count(name) for name in boxes.names}
    weights = np.array([1 / counts[name] for name in boxes.names])
    if soft and frames:
        sizes = [len(states.tracks([body], frames[0].t)) for body in soft]
        weights = np.concatenate([weights, *(np.full(size, 1 / size) for size in sizes if size)])

    def shown(frame: Frame) -> tuple[View, Array]:
        tracked = [states.tracks([body], frame.t) for body in soft]
        return cameras.view(frame.camera, frame.t, frame.part), np.concatenate(
            [states.placed(boxes, frame.t)[0], *tracked]
        )

    moved, way = np.zeros(len(frames)), np.zeros((len(weights), 2))
    before = shown(frames[0]) if frames else None
    for k, (one, other) in enumerate(zip(frames, frames[1:], strict=False), 1):
        after = shown(other)
        if before is not None and one.camera == other.camera and other.t > one.t and not other.again:
            way += _displacement(before, after, aspect)
            far = np.hypot(*way.T)
            moved[k] = float(weights @ np.maximum(far - SLACK, 0.0))
            way *= (SLACK / np.maximum(far, SLACK))[:, None]
        before = after
    return moved.cumsum()


def _displacement(before: tuple[View, Array], after: tuple[View, Array], aspect: float) -> Array:
    """Displacement of points from one picture to the next [heights of the picture], shape (n, 2)."""
    (view, points), (next_view, next_points) = before, after
    start, filmed, stood = (
        project(*row, aspect) for row in ((view, points), (next_view, next_points), (view, next_points))
    )
    ahead = (start[:, 2] > 0) & (filmed[:, 2] > 0) & (stood[:, 2] > 0)
    inside = ahead & ((np.abs(start[:, :2]).max(axis=1) <= 1) | (np.abs(filmed[:, :2]).max(axis=1) <= 1))
    one, other = ((end - start)[:, :2] * (aspect / 2, 0.5) for end in (filmed, stood))
    shorter = np.where((np.hypot(*one.T) < np.hypot(*other.T))[:, None], one, other)
    return np.where(inside[:, None], np.clip(shorter, -FARTHEST, FARTHEST), 0.0)
