"""Positions, targets and lenses of the cameras of a film.

A camera is a dictionary from `render.py`. All have `kind`, `up`, and the vertical field of view `fov` [deg].

    still       pos, look_at
    follow      body, link, smooth [s], and pos or offset [m]; with an offset also aside [m], from the body to the point
                it looks at
    mounted     body, link, and in its frame pos, look_at and up
    orbit       look_at, radius, height [m], start, turn [rad]
    dolly       pos, to, look_at
    keyframed   times [s], positions [m], look_at: a point, or one for each time

`f_stop` gives it a thin lens, focused on `focus`, or on the point it looks at. This module does without numpy, so that
checks of a case need not import it.
"""

import math
from typing import Any

Vec = tuple[float, float, float]

HALF_SENSOR = 0.012
"""Half the height [m] of a picture on 35 mm film (36 mm x 24 mm), to which f-stops and focal lengths refer."""
MEAN_OF = 9
"""Number of moments over which the position of a followed body is averaged."""


def place(camera: dict, t: float, part: float, states: Any) -> tuple[Vec, Vec, Vec]:
    """Return the position of a camera, the point it looks at [m], and the direction that is up in its picture.

    Args:
        camera: The camera.
        t: Simulated time [s].
        part: Progress of a camera that moves over its take, 0 to 1.
        states: Has `position(body, t, link)`, three numbers [m], and for a mounted camera `pose(body, t, link)`, the
            position and the orientation (w, x, y, z).

    Raises:
        ValueError: If the camera is of an unknown kind.
    """
    if camera["kind"] == "mounted":
        pos, quat = states.pose(camera["body"], t, camera["link"])
        eye, look_at, up = (_turned(quat, camera[key]) for key in ("pos", "look_at", "up"))
        return _sum(pos, eye), _sum(pos, look_at), up
    return *_line_of_sight(camera, t, part, states), camera["up"]


def _line_of_sight(camera: dict, t: float, part: float, states: Any) -> tuple[Vec, Vec]:
    kind = camera["kind"]
    if kind == "still":
        return camera["pos"], camera["look_at"]
    if kind == "follow":
        body = followed(camera, t, states)
        if "offset" not in camera:
            return camera["pos"], body
        return _sum(body, camera["offset"]), _sum(body, camera.get("aside", (0.0, 0.0, 0.0)))
    if kind == "orbit":
        angle = camera["start"] + camera["turn"] * part
        arm = (camera["radius"] * math.cos(angle), camera["radius"] * math.sin(angle), camera["height"])
        return _sum(camera["look_at"], arm), camera["look_at"]
    if kind == "dolly":
        x, y, z = (a + (b - a) * part for a, b in zip(camera["pos"], camera["to"], strict=True))
        return (x, y, z), camera["look_at"]
    if kind == "keyframed":
        look_at, times = camera["look_at"], camera["times"]
        if isinstance(look_at, list):
            look_at = along(times, look_at, t)
        return along(times, camera["positions"], t), look_at
    raise ValueError(f"no camera is of kind {kind}")


def followed(camera: dict, t: float, states: Any) -> Vec:
    """Return the position of a followed body [m], averaged over a short time so that the picture is calm.

    Args:
        camera: The camera.
        t: Simulated time [s].
        states: See `place`.
    """
    # The mean is about `t` even at the start, before which nothing is recorded: else the camera would first have to
    # catch up with a body that moves from the beginning.
    span = min(camera["smooth"], 2 * t)
    times = [t + span * (i / (MEAN_OF - 1) - 0.5) for i in range(MEAN_OF)]
    spots = [states.position(camera["body"], moment, camera["link"]) for moment in times]
    x, y, z = (sum(float(spot[k]) for spot in spots) / MEAN_OF for k in range(3))
    return x, y, z


def along(times: list[float], points: list[Vec], t: float) -> Vec:
    """Return the position [m] on a Catmull-Rom spline through points; its speed is zero at both ends.

    Args:
        times: Time of each point [s], increasing.
        points: The points [m].
        t: Time [s]; clamped to the range of `times`.
    """
    last = len(times) - 1
    t = min(max(t, times[0]), times[-1])
    k = next((k for k in range(last) if t <= times[k + 1]), last - 1)
    long = times[k + 1] - times[k]
    u = (t - times[k]) / long

    def speed(i: int, axis: int) -> float:
        if i in (0, last):
            return 0.0
        return (points[i + 1][axis] - points[i - 1][axis]) / (times[i + 1] - times[i - 1])

    # Written so that it stands exactly still between equal points.
    x, y, z = (
        points[k][axis]
        + u**2 * (3 - 2 * u) * (points[k + 1][axis] - points[k][axis])
        + u * (1 - u) ** 2 * long * speed(k, axis)
        + u**2 * (u - 1) * long * speed(k + 1, axis)
        for axis in range(3)
    )
    return (x, y, z)


def basis(pos: Any, look_at: Any, up: Any) -> tuple[Vec, Vec, Vec]:
    """Return the unit vectors right, up and ahead of a camera.

    Args:
        pos: Position of the camera [m].
        look_at: The point in the middle of the picture [m].
        up: Direction that is up in the picture; need not be perpendicular or of unit length.
    """
    ahead = _unit(tuple(float(b) - float(a) for a, b in zip(pos, look_at, strict=True))) or (0.0, 1.0, 0.0)
    right = _cross(ahead, _unit(up) or (0.0, 0.0, 1.0))
    if math.hypot(*right) < 1e-3:  # straight up or down: +y is up in the picture
        right = _cross(ahead, (0.0, 1.0, 0.0))
    right = _unit(right) or (1.0, 0.0, 0.0)
    return right, _cross(right, ahead), ahead


def aperture_radius(fov: float, f_stop: float) -> float:
    """Return the radius of the lens [m]: focal length / (2 f_stop), for 35 mm film; `fov` is in degrees."""
    return HALF_SENSOR / math.tan(math.radians(fov) / 2) / (2 * f_stop)


def clip(camera: dict) -> tuple[float, float]:
    """Return the near and far clipping distance for a rasteriser [m]."""
    if "offset" in camera:
        away = math.hypot(*camera["offset"])
    elif camera["kind"] == "orbit":
        away = camera["radius"]
    elif camera["kind"] == "keyframed":
        look_at = camera["look_at"]
        looks = look_at if isinstance(look_at, list) else [look_at] * len(camera["positions"])
        away = min(math.dist(pos, at) for pos, at in zip(camera["positions"], looks, strict=True))
    else:
        away = math.dist(camera["pos"], camera["look_at"]) if "look_at" in camera else 3.0
    return round(max(away / 50, 0.005), 4), round(max(away * 20, 60.0), 1)


def _sum(a: Any, b: Any) -> Vec:
    return (float(a[0]) + b[0], float(a[1]) + b[1], float(a[2]) + b[2])


def _turned(quat: Any, vector: Vec) -> Vec:
    """Return a vector rotated by a unit quaternion (w, x, y, z)."""
    w, x, y, z = (float(c) for c in quat)
    twist = _cross((2 * x, 2 * y, 2 * z), vector)
    a, b, c = _cross((x, y, z), twist)
    return (vector[0] + w * twist[0] + a, vector[1] + w * twist[1] + b, vector[2] + w * twist[2] + c)


def _cross(a: Vec, b: Vec) -> Vec:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _unit(vector: Any) -> Vec | None:
    """Return the vector with length 1; None if it is too short."""
    x, y, z = (float(c) for c in vector)
    long = math.hypot(x, y, z)
    return (x / long, y / long, z / long) if long > 1e-9 else None
