"""Derives from the recording how a case is filmed that leaves this open.

`AUTO` in `render.py` tells what the author left open:

    times       waiting is cut, the decisive moment is slowed down, and the film ends on the final state
    camera      the camera stands where moving bodies are least hidden, move across the picture and stand out; it tracks
                bodies where that brings it nearer
    turn_lights the studio lamps turn with the camera

All decisions follow from the states alone, so the preview and the path-traced film show the same.
"""

import math
from collections import Counter
from typing import Any

import numpy as np

if __package__:
    from .cameras import framed  # noqa: TID252
    from .pacing import shots_of  # noqa: TID252
    from .standpoints import best_camera, typical, view_of  # noqa: TID252
else:  # in a program, where it lies beside this module
    from cameras import framed
    from pacing import shots_of
    from standpoints import best_camera, typical, view_of

MOMENTS = 160
"""Number of moments of the recording at which motion is sampled."""
NEARER = 0.75
"""The camera tracks its subjects if that brings it to this fraction of its distance from them, or nearer, for a quarter
of the film at least."""
ACTIVE = 0.03
"""Distance [picture heights] that a body moves within `WINDOW` to count as moving at the time."""
WINDOW, CALM = 0.7, 0.9
"""Time [s of film]: how far before and after a moment its motion has to be in the picture, and over which the path of a
tracking camera is smoothed."""
STEP = 0.2
"""Time between two keyframes of a tracking camera [s of film]."""
WHOLE, PAST = 0.5, 0.33
"""Time at both ends for which a tracking camera shows all that moves [s of film]; in the end without what came to rest
in this first part of the film."""
CONTEXT = 0.25
"""How much of what stands beside it a tracking camera shows on each side, in sizes of what moves. What is nearer than
this, and not larger than what moves, is shown whole."""
VESSEL = 5.0
"""A static around what moves is shown whole up to this many sizes of what moves: a glass is seen with its rim."""
NEAREST = 0.3
"""Smallest distance of a tracking camera, as a fraction of the distance at which everything is in the picture."""


def directed(film: dict, states: Any) -> dict:
    """Return a film in which everything is decided.

    Args:
        film: Constants of `render.py`, see `cadence.film_of`.
        states: Recorded states, see `playback.States`.
    """
    auto = film.get("auto")
    if not auto or not hasattr(states, "tracks") or not film["cameras"]:
        return film
    if auto.get("bare"):
        states = _Bare(states, auto["bare"])
    name, camera = next(iter(film["cameras"].items()))
    moving, last = auto["moving"], float(states.time[-1])
    times = np.linspace(film["start"], max(min(film["end"], last), film["start"]), MOMENTS)
    made = film | {"auto": None}
    if not moving or times[-1] <= times[0]:
        return made
    tracks = np.nan_to_num(np.array([states.tracks(moving, float(t)) for t in times]))
    if not tracks.shape[1]:
        return made
    if auto["camera"]:
        camera = best_camera(film, camera, states, times, tracks)
        if auto["turn_lights"]:
            made["lights"] = _turned_lights(film["lights"], film["cameras"][name], camera)
    size = _size(camera, tracks)
    if auto["times"]:
        made["shots"] = shots_of(times, tracks, size, name)
        made["overlay"] = film["overlay"] | {"pace": True}
    if auto["camera"]:
        made["cameras"] = {name: _along(camera, made | {"auto": auto}, states)}
    return made


class _Bare:
    """Recorded states in which some bodies are as large as the parts that touch: without far larger decor.

    Args:
        states: See `playback.States`.
        parts: Names of these parts by name of the body.
    """

    def __init__(self, states: Any, parts: dict[str, list[str]]):
        self._states, self._parts = states, parts

    def __getattr__(self, name: str) -> Any:
        return getattr(self._states, name)

    def bounds(self, bodies: list[str], t: float) -> np.ndarray:
        return self._states.bounds(self._bare(bodies), t)

    def tracks(self, bodies: list[str], t: float) -> np.ndarray:
        return self._states.tracks(self._bare(bodies), t)

    def _bare(self, bodies: list[str]) -> list[str]:
        return [part for name in bodies for part in self._parts.get(name, [name])]


def _size(camera: dict, tracks: np.ndarray) -> float:
    """Length that fills the height of the picture [m]."""
    if "pos" in camera and "look_at" in camera:
        away = float(np.linalg.norm(np.subtract(camera["look_at"], camera["pos"])))
        return max(2 * away * math.tan(math.radians(camera["fov"]) / 2), 1e-6)
    return max(float(np.linalg.norm(np.ptp(tracks.reshape(-1, 3), axis=0))), 1e-6)


def _along(camera: dict, film: dict, states: Any) -> dict:
    """Return the camera, or one that tracks the subjects if that brings it nearer."""
    frame, still = camera["frame"], {key: value for key, value in camera.items() if key != "frame"}
    aspect, view = film["resolution"][0] / film["resolution"][1], view_of(camera)
    shots = film["shots"] or [{"from": film["start"], "to": film["end"], "speed": film["speed"]}]
    shown, times = _film_times(shots)
    full = float(np.linalg.norm(view.pos - view.look_at))
    height = 2 * full * math.tan(math.radians(view.fov) / 2)
    moving = film["auto"]["moving"]
    copies = Counter(name.split("[")[0] for name in states.boxes(moving).names)
    standing = [states.bounds([name], float(times[0])) for name in film["auto"]["statics"]]
    active, clouds, beside = _active(moving, states, shown, times, ACTIVE * height), [], []
    for names, t, at in zip(active, times, shown, strict=True):
        cloud = _shown(states, names, float(t), frame["within"], springs=True)
        if at >= WHOLE:
            cloud = typical(cloud, sum(copies[name] for name in names))
        clouds.append(cloud if len(cloud) else _shown(states, moving, float(t), frame["within"]))
        waiting = [_shown(states, [name], float(t), frame["within"]) for name in moving if name not in names]
        beside.append([cloud for cloud in [*standing, *waiting] if len(cloud)])
    if not all(map(len, clouds)):  # there is nothing to track
        return still
    direction, kept, middles = (view.pos - view.look_at) / full, [], []
    for t, others in zip(shown, beside, strict=True):
        near = np.concatenate([cloud for cloud, other in zip(clouds, shown, strict=True) if abs(other - t) <= WINDOW])
        points = np.concatenate([near, *(_beside(near, cloud) for cloud in others)])
        near_by = framed(camera | {"frame": frame | {"margin": 0.1}}, points, aspect)
        away = max(float(np.linalg.norm(np.subtract(near_by["pos"], near_by["look_at"]))), NEAREST * full)
        kept.append([*near_by["look_at"], away])
        middles.append(np.median(near, axis=0))
    gaps = (shown[:, None] - shown[None]) / (CALM / 2)
    weights = np.exp(-(gaps**2) / 2)
    calm = weights @ np.array(kept) / weights.sum(axis=1, keepdims=True)
    places = calm[:, :3] + calm[:, 3:] * direction
    before, after = (np.linalg.norm(place - np.array(middles), axis=1) for place in (view.pos, places))
    if np.quantile(after / before, 0.25) > NEARER:
        return still
    look_at, positions = ([tuple(round(float(c), 4) for c in row) for row in rows] for rows in (calm[:, :3], places))
    rest = {key: value for key, value in still.items() if key not in ("pos", "look_at", "kind")}
    return rest | {
        "kind": "keyframed",
        "times": [round(float(t), 5) for t in times],
        "positions": positions,
        "look_at": look_at,
    }


def _active(names: list[str], states: Any, shown: np.ndarray, times: np.ndarray, far: float) -> list[list[str]]:
    """Return the bodies to show at each time: those that move or moved last; first all, and in the end nearly all.

    Args:
        names: Bodies that ever move.
        states: Recorded states.
        shown: Times of the film [s], shape (n,).
        times: Simulated times shown then [s], shape (n,).
        far: Distance [m] that a body moves within `WINDOW` to count.
    """
    found: list[list[str]] = [[] for _ in times]
    for name in names:
        track = np.nan_to_num(np.array([states.tracks([name], float(t)) for t in times]))
        for k, t in enumerate(shown):
            near = track[np.abs(shown - t) <= WINDOW]
            if track.shape[1] and np.linalg.norm(np.ptp(near, axis=0), axis=1).max() > far:
                found[k].append(name)
    late = {name for row, t in zip(found, shown, strict=True) if t > PAST * shown[-1] for name in row}
    early = {name for row in found for name in row} - late
    ending, last = [name for name in names if name not in early], names
    for k, t in enumerate(shown):
        last = found[k] or last
        found[k] = names if t < WHOLE else ending if t > shown[-1] - WHOLE else last
    return found


def _film_times(shots: list[dict]) -> tuple[np.ndarray, np.ndarray]:
    """Times of the film [s], at most STEP apart, and the simulated times [s] shown then, shape (n,) each."""
    shown, times, begin = [0.0], [shots[0]["from"]], 0.0
    for shot in shots:
        long = (shot["to"] - shot["from"]) / shot["speed"]
        parts = np.linspace(0, 1, max(math.ceil(long / STEP), 2) + 1)[1:]
        shown += [begin + part * long for part in parts]
        times += [shot["from"] + part * (shot["to"] - shot["from"]) for part in parts]
        begin += long
    return np.array(shown), np.array(times)


def _shown(states: Any, names: list[str], t: float, space: Any, *, springs: bool = False) -> np.ndarray:
    """Points of bodies (n, 3) at a time [s] that are in a space, see `standpoints.within`; there may be none.

    With `springs`, also where springs are fastened: what something hangs from belongs in the picture.
    """
    cloud = states.bounds(names, t)
    if springs:
        cloud = np.concatenate([cloud, states.spring_ends(t).reshape(-1, 3)])
    cloud = cloud[np.isfinite(cloud).all(axis=1)]
    low, high = space
    return cloud[((cloud >= low) & (cloud <= high)).all(axis=1)]


def _beside(cloud: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Points of a body to be shown with what moves, as context: all of it, the nearer part, or none if far away."""
    low, high, first, last = cloud.min(axis=0), cloud.max(axis=0), other.min(axis=0), other.max(axis=0)
    room, size, middle = float((high - low).max()), float((last - first).max()), (low + high) / 2
    around = ((first <= middle) & (middle <= last)).all() and high[2] <= last[2]
    apart = np.maximum(first - high, low - last).max()
    if (around and size <= VESSEL * room) or (apart < CONTEXT * room and size <= room):
        return other
    return np.clip(other, low - CONTEXT * room, high + CONTEXT * room) if apart < room / 2 else np.zeros((0, 3))


def _turned_lights(lights: dict, before: dict, after: dict) -> dict:
    """Return the lights of a studio, turned about z as far as the camera was."""

    def azimuth(camera: dict) -> float:
        x, y, _ = np.subtract(camera["look_at"], camera["pos"])
        return math.atan2(y, x)

    turn = azimuth(after) - azimuth(before)
    c, s = math.cos(turn), math.sin(turn)

    def turned(light: dict) -> dict:
        if "direction" not in light:
            return light
        x, y, z = light["direction"]
        return light | {"direction": (round(c * x - s * y, 4), round(s * x + c * y, 4), z)}

    return {name: turned(light) for name, light in lights.items()}
