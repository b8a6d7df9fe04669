"""Cameras that move by keyframes, and draw back while a body that moves would leave the picture.

An author who sets keyframes cannot see that a lid which is lifted, or a ball which bounces, leaves the picture at the
top. Such a camera stands further away, and higher, as long as that shows the body whole, and returns to its place.
"""

import math
from collections.abc import Iterator
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.legibility.film import Watcher, spread_numbers
from text2sim.legibility.sight import Sight
from text2sim.recording.film_record import FilmRecord
from text2sim.spec_schema.changes.operation import Operation
from text2sim.templates.cadence import MAIN, Frame, frames, reels
from text2sim.templates.cameras import View, project
from text2sim.templates.viewpoints import basis

Array = NDArray[Any]

EDGE = 0.05
"""Distance [half heights or widths of the picture] that is left to its edge."""
WHOLE, GLIMPSED = 0.999, 0.25
"""Fractions of a thing's points in the picture from which it is whole, and from which a moving body belongs there."""
KEYS = 13
"""Number of pictures of a camera that are measured; each that changes becomes a key."""
NOTICED = 0.1
"""Fraction of a camera's pictures in which a body has to be cut."""
AWAY, ASIDE = 1.6, 0.6
"""Largest factor on the distance of a camera, and largest shift [half widths or heights] of its target."""
SEEN = 0.5
"""Fraction of its pixels, scaled by the distance, that a body keeps at least: nothing comes before the camera."""
RETURN = 3
"""Number of keys over which it draws back before, and returns afterwards."""
STEPS = 2
"""Number of corrections: a camera that stands elsewhere has another perspective."""

Extent = tuple[Array, Array]
"""Lowest and highest coordinates in the picture, each of shape (2,); the picture reaches from -1 to 1."""


def withdrawn(watcher: Watcher, name: str) -> list[Operation]:
    """Return the operations that make a keyframed camera draw back where it cuts off what moves; none if it need not.

    Args:
        watcher: Measures the recorded run.
        name: Name of the camera.
    """
    shown = {round(frame.t, 4): frame for frame in pictures_by_camera(watcher.recording, KEYS)[name]}
    pictures = [shown[t] for t in sorted(shown)]
    first = [watcher.cameras.view(name, frame.t, frame.part) for frame in pictures]
    before = sights_of(watcher, pictures, first)
    inside = np.array([sight.inside for sight in before])
    cut = watcher.moves & (inside >= GLIMPSED) & (inside < WHOLE)
    cut &= cut.sum(axis=0) >= max(1, NOTICED * len(pictures))
    # What is whole stays so, unless it is a ground that only seems so.
    kept = cut | ((inside >= WHOLE) & (np.array([s.seen / s.size for s in before]) > 0))
    views, moved = list(first), np.zeros(len(first), bool)
    for _ in range(STEPS):
        views, moved = _drawn_back(watcher, pictures, first, views, cut, kept)
        if not moved.any():
            return []
    after = sights_of(watcher, pictures, views)
    for k in np.flatnonzero(moved & cut.any(axis=1)):
        grown = np.linalg.norm(views[k].pos - views[k].look_at) / np.linalg.norm(first[k].pos - first[k].look_at)
        seen = kept[k] & (before[k].seen > 0)
        if (after[k].inside[kept[k]] < WHOLE).any() or (
            after[k].seen[seen] * grown**2 < SEEN * before[k].seen[seen]
        ).any():
            return []
    views = _eased(first, views, moved)
    path = f"/render/cameras/{name}"
    rows = {
        "times": [round(frame.t, 5) for frame in pictures],
        "positions": [[round(float(c), 4) for c in view.pos] for view in views],
        "look_at": [[round(float(c), 4) for c in view.look_at] for view in views],
    }
    return [{"op": "add", "path": f"{path}/{field}", "value": value} for field, value in rows.items()]


def _drawn_back(
    watcher: Watcher, pictures: list[Frame], first: list[View], views: list[View], cut: Array, kept: Array
) -> tuple[list[View], Array]:
    """Return views that show all that is kept, and which of them differ from the first ones.

    Args:
        watcher: Measures the recorded run.
        pictures: Pictures of the camera, by time.
        first: Views of the camera.
        views: Views so far.
        cut: What is cut in each of the first views and should not be, shape (pictures, things).
        kept: What each picture should show whole, shape (pictures, things).
    """
    found, moved = [], np.zeros(len(first), bool)
    for k, (frame, old, view) in enumerate(zip(pictures, first, views, strict=True)):
        near = slice(max(k - 1, 0), k + 2)  # it draws back one key earlier, and comes back one later
        extents = dict(extents_of(watcher, frame.t, view))
        window = [extents[j] for j in np.flatnonzero(kept[k]).tolist() if j in extents]
        if not cut[near].any() or not window:
            found.append(view)
            continue
        tall, wide = math.tan(math.radians(view.fov) / 2), watcher.size[0] / watcher.size[1]
        away = float(np.linalg.norm(view.look_at - view.pos))
        least = float(np.linalg.norm(old.look_at - old.pos)) / away
        middle, wider = centred(union(window), turned=True, least=least)
        right, up, _ = (np.array(axis) for axis in basis(view.pos, view.look_at, view.up))
        target = view.look_at + away * tall * (middle[0] * wide * right + middle[1] * up)
        pos = target + wider * (view.pos - view.look_at)
        shift = np.linalg.norm(target - old.look_at) * least / (away * tall)
        if wider > AWAY * least or shift > ASIDE * max(wide, 1.0):
            found.append(old)  # it does not fit
            continue
        found.append(view._replace(pos=pos, look_at=target))
        moved[k] = bool(np.abs(pos - old.pos).max() > 1e-3)
    return found, moved


def _eased(first: list[View], views: list[View], moved: Array) -> list[View]:
    """Return views that come gradually from the first views to those that moved, and go back to them."""
    found, moving = list(views), np.flatnonzero(moved)
    for k in np.flatnonzero(~moved).tolist():
        near = int(moving[np.abs(moving - k).argmin()])
        weight = max(1 - abs(near - k) / (RETURN + 1), 0.0)
        pos, look_at = (getattr(views[near], at) - getattr(first[near], at) for at in ("pos", "look_at"))
        found[k] = first[k]._replace(pos=first[k].pos + weight * pos, look_at=first[k].look_at + weight * look_at)
    return found


def pictures_by_camera(recording: FilmRecord, many: int) -> dict[str, list[Frame]]:
    """Return some pictures of the main film for each of its cameras."""
    found: dict[str, list[Frame]] = {}
    for camera, group in groupby(
        frames(recording.film, reels(recording.film)[MAIN], recording.last), lambda f: f.camera
    ):
        found.setdefault(camera, []).extend(group)
    return {name: [shown[k] for k in spread_numbers(len(shown), many)] for name, shown in found.items()}


def sights_of(watcher: Watcher, shown: list[Frame], views: list[View]) -> list[Sight]:
    """Return what is visible in pictures with these views.

    Args:
        watcher: Measures the recorded run.
        shown: The pictures.
        views: View of each.
    """
    return [watcher.recorded.sight(frame.t, view, watcher.size) for frame, view in zip(shown, views, strict=True)]


def extents_of(watcher: Watcher, t: float, view: View) -> Iterator[tuple[int, Extent]]:
    """Yield the extent in a picture of every thing that is entirely in front of the camera.

    Args:
        watcher: Measures the recorded run.
        t: Simulated time [s].
        view: View of the camera.
    """
    things = watcher.recorded.things(t)
    wide, tall = watcher.size
    places = project(view, things.triangles, wide / tall).reshape(-1, 3, 3)
    for k in np.unique(things.owner).tolist():
        own = places[things.owner == k].reshape(-1, 3)
        if (own[:, 2] > 0).all():
            yield k, (own[:, :2].min(axis=0), own[:, :2].max(axis=0))


def union(extents: list[Extent]) -> Extent:
    """Return the extent of all extents together."""
    low, high = (np.stack(side) for side in zip(*extents, strict=True))
    return low.min(axis=0), high.max(axis=0)


def centred(window: Extent, *, turned: bool, least: float = 1.0) -> tuple[Array, float]:
    """Return where the centre of the picture should be, and the factor on its width and height.

    Args:
        window: What should be in the picture.
        turned: Whether its centre can move.
        least: Smallest factor.
    """
    low, high = window[0] - EDGE, window[1] + EDGE
    if not turned:
        return np.zeros(2), max(least, float(np.abs([low, high]).max()))
    wider = max(least, float((high - low).max() / 2))
    # The nearest centre from which both sides are in the picture.
    return np.clip(np.zeros(2), high - wider, low + wider), wider
