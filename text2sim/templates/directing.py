"""The film of a case that does not say how it is filmed, made of what was recorded.

`render.py` then has `AUTO`, which says what nobody has decided, and this module decides it:

    times       waiting is left out, the decisive moment is slowed down, and the film ends on the final state
    camera      stands where the least hides what moves, motion goes across the picture, and subjects stand out; it goes
                along where they are small compared with their way
    turn_lights studio lamps stand around the camera, wherever that is

Everything follows from the states alone, so that the preview and the path-traced film are the same film.
"""

import math
from typing import Any

import numpy as np

if __package__:
    from .cameras import framed, project  # noqa: TID252
    from .pacing import shots_of  # noqa: TID252
    from .standpoints import best_camera, view_of, within  # noqa: TID252
else:  # in a program, where it lies beside this module
    from cameras import framed, project
    from pacing import shots_of
    from standpoints import best_camera, view_of, within

MOMENTS = 160
"""Moments of the recording at which is asked what moves."""
SMALL = 0.4
"""Part of the picture's width or height, below which subjects are so small that the camera has to go along."""
WINDOW, CALM = 0.7, 0.9
"""Time [s of film] about a moment whose motion is in the picture then, and over which a camera's way is smoothed."""
STEP = 0.2
"""Time [s of film] between two places of a camera that goes along."""
NEAREST = 0.3
"""Smallest distance of a camera that goes along, as a part of that from which all would be seen."""


def directed(film: dict, states: Any) -> dict:
    """Return a film with all decided.

    Args:
        film: What `render.py` says, see `cadence.film_of`.
        states: The recorded ones, see `playback.States`.
    """
    auto = film.get("auto")
    if not auto or not hasattr(states, "tracks") or not film["cameras"]:
        return film
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


def _size(camera: dict, tracks: np.ndarray) -> float:
    """What fills the height of the picture [m]."""
    if "pos" in camera and "look_at" in camera:
        away = float(np.linalg.norm(np.subtract(camera["look_at"], camera["pos"])))
        return max(2 * away * math.tan(math.radians(camera["fov"]) / 2), 1e-6)
    return max(float(np.linalg.norm(np.ptp(tracks.reshape(-1, 3), axis=0))), 1e-6)


def _along(camera: dict, film: dict, states: Any) -> dict:
    """Return the camera, or one that goes along where subjects are small compared with their way."""
    frame, still = camera["frame"], {key: value for key, value in camera.items() if key != "frame"}
    aspect, view = film["resolution"][0] / film["resolution"][1], view_of(camera)
    shots = film["shots"] or [{"from": film["start"], "to": film["end"], "speed": film["speed"]}]
    shown, times = _film_times(shots)
    clouds = [states.bounds(film["auto"]["moving"], float(t)) for t in times]
    clouds = [within(cloud[np.isfinite(cloud).all(axis=1)], frame["within"]) for cloud in clouds]
    if not all(map(len, clouds)):  # nothing is left to go along with
        return still
    spans = [np.ptp(np.clip(project(view, cloud, aspect)[:, :2], -1, 1), axis=0).max() / 2 for cloud in clouds]
    if np.median(spans) >= SMALL:
        return still
    full = float(np.linalg.norm(view.pos - view.look_at))
    standing = [states.bounds([name], float(times[0])) for name in film["auto"]["statics"]]
    way, kept = (view.pos - view.look_at) / full, []
    for t in shown:
        near = [cloud for cloud, other in zip(clouds, shown, strict=True) if abs(other - t) <= WINDOW]
        cloud = np.concatenate(near)
        around = [cloud, *(_beside(cloud, static) for static in standing)]
        near_by = framed(camera | {"frame": frame | {"margin": 0.1}}, np.concatenate(around), aspect)
        away = max(float(np.linalg.norm(np.subtract(near_by["pos"], near_by["look_at"]))), NEAREST * full)
        kept.append([*near_by["look_at"], away])
    gaps = (shown[:, None] - shown[None]) / (CALM / 2)
    weights = np.exp(-(gaps**2) / 2)
    calm = weights @ np.array(kept) / weights.sum(axis=1, keepdims=True)
    look_at = [tuple(round(float(c), 4) for c in row[:3]) for row in calm]
    positions = [tuple(round(float(c), 4) for c in row[:3] + row[3] * way) for row in calm]
    rest = {key: value for key, value in still.items() if key not in ("pos", "look_at", "kind")}
    return rest | {
        "kind": "keyframed",
        "times": [round(float(t), 5) for t in times],
        "positions": positions,
        "look_at": look_at,
    }


def _film_times(shots: list[dict]) -> tuple[np.ndarray, np.ndarray]:
    """Times of the film [s], STEP apart or less, and the simulated ones [s] that it shows then, shape (n,)."""
    shown, times, begin = [0.0], [shots[0]["from"]], 0.0
    for shot in shots:
        long = (shot["to"] - shot["from"]) / shot["speed"]
        parts = np.linspace(0, 1, max(math.ceil(long / STEP), 2) + 1)[1:]
        shown += [begin + part * long for part in parts]
        times += [shot["from"] + part * (shot["to"] - shot["from"]) for part in parts]
        begin += long
    return np.array(shown), np.array(times)


def _beside(cloud: np.ndarray, static: np.ndarray) -> np.ndarray:
    """Points of what stands where things move, as far as it is near: without it their motion means nothing."""
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    room = float((high - low).max())
    apart = np.maximum(static.min(axis=0) - high, low - static.max(axis=0)).max() if len(static) else np.inf
    return np.clip(static, low - room, high + room) if apart < room / 2 else np.zeros((0, 3))


def _turned_lights(lights: dict, before: dict, after: dict) -> dict:
    """Return the lights of a studio, which stand around the camera, turned with it."""

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
