"""Corrections of a film that was written without sight of its pictures: cameras that cut things off, an end at rest.

An author who writes `from`, `look_at` and `fov_deg` cannot see that a crate's corner ends up below the picture. Here
the recording is projected into the pictures of each camera. What is mostly in the picture, and cut in most of
them, is fitted in if the field of view grows by a fifth at most; whatever was whole stays whole. And the last shot ends
soon after nothing moves any more, and the first begins shortly before anything does, unless the film is as long as the
request says.
"""

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.legibility.film import Watcher
from text2sim.legibility.sight import Sight
from text2sim.recording.film_record import FilmRecord
from text2sim.rendering.reframing import FIXED, reframed
from text2sim.rendering.withdrawing import (
    EDGE,
    WHOLE,
    Extent,
    centred,
    extents_of,
    pictures_by_camera,
    sights_of,
    union,
    withdrawn,
)
from text2sim.spec_schema.changes.operation import Operation
from text2sim.templates.cadence import Frame, frames
from text2sim.templates.cameras import Cameras, View
from text2sim.templates.viewpoints import basis

Array = NDArray[Any]

PICTURES = 7
"""Number of pictures of each camera that are measured."""
TURNED, WIDENED = ("still", "dolly"), ("still", "dolly", "follow")
"""Kinds of cameras whose target can be moved, and whose field of view can be changed."""
WIDEST, FARTHEST = 1.2, 0.15
"""Largest factor by which a picture becomes wider, and largest distance [half widths or heights] by which its centre
moves: what needs more is left cut."""
MOSTLY = 0.5
"""Fraction of a thing's points in the picture from which it belongs there."""
LEAST_SHARE = 0.003
"""Share of the picture from which it matters that a thing is cut."""
STILL, CALM, WORTHWHILE = 0.02, 0.8, 0.3
"""Displacement [half heights of the picture] below which nothing moves, and time [s of film] for which the final state
is shown after that, besides a `hold`; a smaller gain [s of film] than the last number changes nothing."""
SETTLED, ENDS = 0.99, 40
"""Fraction of a body's points that has to be at rest, and number of pictures of the last shot that are compared with
its end."""
SHORTEST = 1.5
"""Shortest length [s of film] to which the last shot is cut."""
SECONDS = re.compile(
    r"\b(\d+(?:\.\d+)?|two|three|four|five|six|seven|eight|nine|ten|twelve|fifteen|twenty)[ -]*s(?:ec(?:ond)?s?)?\b",
    re.IGNORECASE,
)
"""Times that a request names."""
NUMBERS: dict[str, float] = {
    "two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "seven": 7, "eight": 8, "nine": 9, "ten": 10, "twelve": 12,
    "fifteen": 15, "twenty": 20,
}  # fmt: skip
AS_LONG = 0.12
"""Largest difference of a film's length from a time that the request names, as a part of it, for it to be meant."""
UNTIMED = ("still", "follow", "mounted", "keyframed")
"""Kinds of cameras that do not move faster in a shorter shot."""
WIDEST_FOV = 140.0
"""Largest field of view of the language [deg]."""
STEPS = 3
"""Number of corrections: turning a camera changes the perspective slightly."""


def composed(recording: FilmRecord, written: Mapping[str, Any], request: str = "") -> list[Operation]:
    """Return a JSON Patch of a case's `render` with which its main film cuts off less, and ends when all is at rest.

    Cameras with `frame` show their bodies whole; they only come closer while they can.

    Args:
        recording: The recorded run, with the film of the case.
        written: The section `render` of the case as its author wrote it.
        request: What was asked for. It may say that the camera stands still, and how long the film is.
    """
    cameras: Mapping[str, Any] = written.get("cameras") or {}
    patch: list[Operation] = []
    if not cameras:
        return patch
    watcher = Watcher(recording)
    stands = FIXED.search(request) is not None
    for name, shown in pictures_by_camera(recording, PICTURES).items():
        camera = recording.film["cameras"][name]
        if camera["kind"] == "keyframed" and name in cameras:
            patch += withdrawn(watcher, name)
        if name in cameras and not stands:
            patch += reframed(watcher, name, cameras[name])
        if camera["kind"] not in WIDENED or "frame" in camera or name not in cameras:
            continue
        if (fitted := _fitted(watcher, name, shown)) is not None:
            patch += _operations(f"/render/cameras/{name}", cameras[name], camera, fitted)
    return [*patch, *_trimmed(watcher, written.get("shots") or {}, request)]


def _as_long_as_asked(recording: FilmRecord, request: str) -> bool:
    """Return whether the film is as long as one of the times [s] that the request names."""
    film = recording.film
    length = len(frames(film, film["shots"], recording.last)) / film["fps"]
    asked = [NUMBERS.get(word.lower()) or float(word) for word in SECONDS.findall(request)]
    return any(abs(length - seconds) <= AS_LONG * seconds for seconds in asked)


def _trimmed(watcher: Watcher, shots: Mapping[str, Any], request: str) -> Iterator[Operation]:
    """Yield the operations that leave out most of the rest at the start of the first and the end of the last shot."""
    recording, film = watcher.recording, watcher.recording.film
    if not shots or len(shots) != len(film["shots"]) or _as_long_as_asked(recording, request):
        return
    start = film["shots"][0]
    if film["cameras"][start["camera"]]["kind"] in UNTIMED:
        moved = _rest(watcher, start, at_end=False)
        latest = min(start["to"], recording.last) - SHORTEST * start["speed"]
        begin = round(min(moved - CALM * start["speed"], latest), 3)
        # What rests through the whole shot is what the shot shows.
        if moved < min(start["to"], recording.last) and begin > start["from"] + WORTHWHILE * start["speed"]:
            yield {"op": "add", "path": f"/render/shots/{next(iter(shots))}/from", "value": begin}
    name, shot = list(shots)[-1], film["shots"][-1]
    if film["cameras"][shot["camera"]]["kind"] not in UNTIMED:
        return
    last, rest = min(shot["to"], recording.last), _rest(watcher, shot, at_end=True)
    end = round(max(rest + CALM * shot["speed"], shot["from"] + SHORTEST * shot["speed"]), 3)
    if shot["from"] < end < last - WORTHWHILE * shot["speed"]:
        yield {"op": "add", "path": f"/render/shots/{name}/to", "value": end}


def _rest(watcher: Watcher, shot: Mapping[str, Any], *, at_end: bool) -> float:
    """Return the time [s] from which all bodies of a shot are where they end, or until which where they start."""
    film, last = watcher.recording.film, min(shot["to"], watcher.recording.last)
    pictures = [one for one in frames(film, [dict(shot)], watcher.recording.last) if one.t <= last]
    pictures = pictures[:: max(1, len(pictures) // ENDS)]
    rest = last if at_end else shot["from"]
    view = watcher.cameras.view(shot["camera"], rest, float(at_end))
    height = float(np.linalg.norm(view.look_at - view.pos)) * _slope(view.fov)
    resting = _places(watcher, rest)
    for picture in reversed(pictures) if at_end else pictures:
        now = _places(watcher, picture.t)
        away = [np.linalg.norm(there - resting[k], axis=1) for k, there in now.items()]
        if any(np.quantile(far, SETTLED) > STILL * height for far in away):
            return rest
        rest = picture.t
    return rest if at_end else last


def _places(watcher: Watcher, t: float) -> dict[int, Array]:
    """Return where the corners of each body are at a time [s], shape (n, 3) [m]; at 0 if they are gone."""
    corners, piece, visible = watcher.recorded.surfaces(t)
    things, found = watcher.recorded.thing_of_piece[piece], np.where(visible[:, None, None], corners, 0.0)
    return {k: found[things == k].reshape(-1, 3) for k in np.flatnonzero(watcher.moves).tolist() if (things == k).any()}


def _fitted(watcher: Watcher, name: str, shown: list[Frame]) -> dict[str, Any] | None:
    """Return a camera of a film that cuts off less; None if it would remain as it is."""
    first = camera = watcher.recording.film["cameras"][name]
    turned = camera["kind"] in TURNED
    views = _views(watcher, name, camera, shown)
    extents = [dict(extents_of(watcher, frame.t, view)) for frame, view in zip(shown, views, strict=True)]
    before = sights_of(watcher, shown, views)
    if (things := _kept(watcher, before, extents, turned=turned)) is None:
        return None
    for _ in range(STEPS):
        window = union([one[k] for one in extents for k in things if k in one])
        middle, wider = centred(window, turned=turned, least=_narrowing(first, camera))
        camera = _turned(camera, views[0], middle, wider, watcher.size)
        views = _views(watcher, name, camera, shown)
        extents = [dict(extents_of(watcher, frame.t, view)) for frame, view in zip(shown, views, strict=True)]
    after = sights_of(watcher, shown, views)
    whole = all((a.inside[k] >= WHOLE) or not b.inside[k] for a, b in zip(after, before, strict=True) for k in things)
    return camera if camera != first and whole and 1 / _narrowing(first, camera) <= WIDEST + EDGE else None


def _views(watcher: Watcher, name: str, camera: dict[str, Any], shown: list[Frame]) -> list[View]:
    """Return the views of pictures with another camera of this name."""
    film = watcher.recording.film
    cameras = Cameras(film | {"cameras": film["cameras"] | {name: camera}}, watcher.recording.states)
    return [cameras.view(name, frame.t, frame.part) for frame in shown]


def _kept(watcher: Watcher, sights: list[Sight], extents: list[dict[int, Extent]], *, turned: bool) -> list[int] | None:
    """Return what the pictures should show whole; None if nothing is cut, or nothing of it fits."""
    inside = np.array([sight.inside for sight in sights])
    share = np.array([sight.seen / sight.size for sight in sights])
    within = inside > 0
    whole = ((inside >= WHOLE) | ~within).all(axis=0) & within.any(axis=0)
    cut = (inside >= MOSTLY) & (inside < WHOLE) & (share >= LEAST_SHARE)
    often = 2 * cut.sum(axis=0) >= np.maximum(within.sum(axis=0), 1)
    kept = np.flatnonzero(whole).tolist()
    moving = set(watcher.moving)
    order = sorted(
        np.flatnonzero(often).tolist(), key=lambda k: (watcher.recorded.names[k] not in moving, -share[:, k].max())
    )
    gained = False
    for k in order:
        rows = [[one[j] for j in [*kept, k] if j in one] for one in extents]
        if not all(k in one for one, present in zip(extents, within[:, k], strict=True) if present):
            continue  # partly behind the camera
        window = union([extent for row in rows for extent in row])
        middle, wider = centred(window, turned=turned)
        if wider <= WIDEST and np.abs(middle).max() <= FARTHEST:
            kept.append(k)
            gained = True
    return kept if gained else None


def _narrowing(first: dict[str, Any], camera: dict[str, Any]) -> float:
    """The factor with which a widened camera has its first field of view again."""
    return float(_slope(first["fov"]) / _slope(camera["fov"]))


def _slope(fov: float) -> float:
    return math.tan(math.radians(fov) / 2)


def _turned(camera: dict[str, Any], view: View, middle: Array, wider: float, size: tuple[int, int]) -> dict[str, Any]:
    """Return a camera with another centre of the picture and another field of view."""
    tall = _slope(view.fov)
    widened = camera | {"fov": min(round(math.degrees(2 * math.atan(tall * wider)), 2), WIDEST_FOV)}
    if np.abs(middle).max() < 1e-3:
        return widened
    right, up, ahead = (np.array(axis) for axis in basis(view.pos, view.look_at, view.up))
    direction = ahead + middle[0] * tall * size[0] / size[1] * right + middle[1] * tall * up
    away = float(np.linalg.norm(view.look_at - view.pos))
    target = view.pos + away * direction / np.linalg.norm(direction)
    return widened | {"look_at": tuple(round(float(c), 4) for c in target)}


def _operations(
    path: str, written: Mapping[str, Any], before: dict[str, Any], after: dict[str, Any]
) -> Iterator[Operation]:
    if after["fov"] != before["fov"]:
        if "lens_mm" in written:
            yield {"op": "remove", "path": f"{path}/lens_mm"}
        yield {"op": "add", "path": f"{path}/fov_deg", "value": round(after["fov"], 1)}
    if after.get("look_at") != before.get("look_at"):
        yield {"op": "add", "path": f"{path}/look_at", "value": [round(c, 3) for c in after["look_at"]]}
