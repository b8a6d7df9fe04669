"""Still cameras that frame what spreads or gathers: they come closer while that is all in a smaller picture.

A camera that shows bodies whole over a long shot stands as far away as their widest moment needs: cups on a turntable
are specks from the start because they lie around it at the end. Such a camera stands close while it can, and travels
along its line of sight once, over a few seconds.
"""

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.legibility.film import Watcher, spread_numbers
from text2sim.spec_schema.changes.operation import Operation
from text2sim.templates.cadence import MAIN, Frame, frames, reels
from text2sim.templates.cameras import View, framed, project
from text2sim.templates.viewpoints import along

Array = NDArray[Any]

CLOSER, CLOSEST = 1.25, 2.5
"""Factors on the size of bodies in the picture: less is not worth a motion, and more would lose their surroundings."""
WORTHWHILE = 0.12
"""Least gain: the fraction of all pictures that become closer, times the factor less 1."""
MOMENTS = 48
"""Number of pictures in which bodies are sampled."""
TRAVEL, DOUBLING = 0.5, 1.2
"""Duration of the motion [s of film], and what each doubling of the distance adds to it."""
REMAINS = 1.0
"""Time [s of film] for which the camera stands still at least, before and after."""
KEYS = 8
"""Number of intervals between keys of the motion."""
SEEN = 1.0 + 1e-6
"""Largest coordinates in the picture of what is whole in it."""
FIXED = re.compile(
    r"\b(?:static|fixed|locked|still|stationary|steady|unmoving|motionless)(?:[ -]\w+){0,2}[ -]"
    r"(?:camera|shot|view|frame)\b"
    r"|\btripod\b|\bcamera\b[^.;]{0,30}\b(?:not move|n't move|does not|doesn't|stays|still|fixed|static)\b",
    re.IGNORECASE,
)
"""Words of a request by which the camera stands still."""


def reframed(watcher: Watcher, name: str, written: Mapping[str, Any]) -> list[Operation]:
    """Return the operation that makes a still camera with a `frame` come closer; none if that is not worthwhile.

    Args:
        watcher: Measures the recorded run.
        name: Name of the camera.
        written: The camera as its author wrote it.
    """
    film, last = watcher.recording.film, watcher.recording.last
    camera, shown = film["cameras"][name], [one for one in frames(film, reels(film)[MAIN], last) if one.camera == name]
    times = [frame.t for frame in shown]
    if camera["kind"] != "still" or "direction" not in camera.get("frame", {}) or times != sorted(times):
        return []
    picked = spread_numbers(len(shown), MOMENTS)
    whole = watcher.cameras.view(name, shown[0].t)
    clouds = [_seen(watcher, camera["frame"], whole, shown[k].t) for k in picked]
    best = _best(watcher, camera, whole, clouds, np.array(picked), shown)
    if best is None:
        return []
    times, positions, targets = best
    for k, cloud in zip(picked, clouds, strict=True):
        pos, target = (np.array(along(times, points.tolist(), shown[k].t)) for points in (positions, targets))
        if len(cloud) and not _inside(whole._replace(pos=pos, look_at=target), cloud, _aspect(watcher)):
            return []
    kept = {key: written[key] for key in ("up", "fov_deg", "lens_mm", "f_stop", "focus") if key in written}
    value = {
        "kind": "keyframed",
        "times": [round(t, 4) for t in times],
        "positions": [[round(float(c), 4) for c in pos] for pos in positions],
        "look_at": [[round(float(c), 4) for c in target] for target in targets],
    }
    return [{"op": "replace", "path": f"/render/cameras/{name}", "value": value | kept}]


def _best(
    watcher: Watcher, camera: dict[str, Any], whole: View, clouds: list[Array], picked: Array, shown: list[Frame]
) -> tuple[list[float], Array, Array] | None:
    """Return times, positions and targets of the most worthwhile motion; None if none is.

    Args:
        watcher: Measures the recorded run.
        camera: The camera of the film.
        whole: Its view.
        clouds: What each sampled picture has to show, shape (n, 3) each.
        picked: Numbers of these pictures.
        shown: All pictures of the camera.
    """
    fps, aspect = float(watcher.recording.film["fps"]), _aspect(watcher)
    far = float(np.linalg.norm(whole.look_at - whole.pos))
    found, most, many = None, WORTHWHILE, len(shown)
    for k in range(1, len(clouds)):
        for outwards in (True, False):
            part = np.concatenate(clouds[:k] if outwards else clouds[k:])
            if not len(part):
                continue
            near = framed(camera, part, aspect)
            factor = far / float(np.linalg.norm(np.subtract(near["look_at"], near["pos"])))
            if factor < CLOSER:
                continue
            shift = min(1.0, (1 - 1 / CLOSEST) / (1 - 1 / factor))  # part of the way if that is too close
            factor = min(factor, CLOSEST)
            takes = math.ceil((TRAVEL + DOUBLING * math.log2(factor)) * fps)
            # Before the first picture that needs the wide view, or after the last one.
            first, last = (picked[k] - 1 - takes, picked[k] - 1) if outwards else (picked[k], picked[k] + takes)
            close, wide = (first, many - last) if outwards else (many - last, first)
            if close < REMAINS * fps or wide < REMAINS * fps or not shown[first].t < shown[last].t:
                continue
            if (gain := close / many * (factor - 1)) > most:
                away = np.array([whole.pos, whole.look_at])
                closer = away + shift * (np.array([near["pos"], near["look_at"]]) - away)
                moving = (shown[first].t, shown[last].t)
                found, most = (moving, closer, away) if outwards else (moving, away, closer), gain
    if found is None:
        return None
    return _motion((shown[0].t, shown[-1].t), *found)


def _motion(
    whole: tuple[float, float], moving: tuple[float, float], start: Array, goal: Array
) -> tuple[list[float], Array, Array]:
    """Return times, positions and targets of a camera at rest, then with an even change of size, and at rest again.

    Args:
        whole: First and last time of the camera [s].
        moving: Times between which it moves [s].
        start: Its position and target before [m], shape (2, 3).
        goal: Its position and target afterwards [m], shape (2, 3).
    """
    (first, last), (begin, end) = whole, moving
    ratio = np.linalg.norm(goal[0] - goal[1]) / np.linalg.norm(start[0] - start[1])
    u = np.linspace(0.0, 1.0, KEYS + 1)
    part = (ratio ** (u * u * (3 - 2 * u)) - 1) / (ratio - 1)
    times, parts = (begin + (end - begin) * u).tolist(), part.tolist()
    if first < begin - 1e-3:
        early = min(0.05, (begin - first) / 2)
        times, parts = [first, begin - early, *times], [0.0, 0.0, *parts]
    if last > end + 1e-3:
        late = min(0.05, (last - end) / 2)
        times, parts = [*times, end + late, last], [*parts, 1.0, 1.0]
    poses = start + np.array(parts)[:, None, None] * (goal - start)
    return times, poses[:, 0], poses[:, 1]


def _seen(watcher: Watcher, frame: Mapping[str, Any], whole: View, t: float) -> Array:
    """Return the points that a camera has to show at a time [s]: what is framed, and bodies that it shows whole."""
    states, aspect = watcher.recording.states, _aspect(watcher)
    points = np.asarray(states.bounds(frame["bodies"], t), float)
    points = points[np.isfinite(points).all(axis=1)]
    if frame["within"] is not None:
        low, high = frame["within"]
        points = points[((points >= low) & (points <= high)).all(axis=1)]
    clouds = [points]
    for body in watcher.moving:
        own = np.asarray(states.bounds([body], t), float)
        own = own[np.isfinite(own).all(axis=1)]
        if len(own) and _inside(whole, own, aspect):
            clouds.append(own)
    return np.concatenate(clouds)


def _aspect(watcher: Watcher) -> float:
    wide, tall = watcher.recording.film["resolution"]
    return float(wide / tall)


def _inside(view: View, points: Array, aspect: float) -> bool:
    right, up, depth = project(view, points, aspect).T
    return bool((depth > 0).all() and max(np.abs(right).max(), np.abs(up).max()) <= SEEN)
