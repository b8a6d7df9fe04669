"""The cameras of a film, given the recorded states; `viewpoints.py` describes a camera.

A still, orbiting or following camera may have `frame`: the bodies to keep in the picture, the box `within` which they
count, and a margin. Its pose was then derived from the start of the scene, and is corrected by the recorded states.
"""

import math
from typing import Any, NamedTuple

import numpy as np

if __package__:
    from .viewpoints import aperture_radius, basis, followed, place  # noqa: TID252
else:  # in a program, where it lies beside this module
    from viewpoints import aperture_radius, basis, followed, place

SAMPLES = 60
"""Number of moments of the recording at which the framing is checked, beside those at which bodies are outermost."""
TURNS = 12
"""Number of positions of an orbiting camera at which the framing is checked."""


class View(NamedTuple):
    """Pose and lens of a camera at one moment."""

    pos: np.ndarray
    """Position [m], shape (3,)."""
    look_at: np.ndarray
    """Point in the middle of the picture [m], shape (3,)."""
    up: np.ndarray
    """Direction that is up in the picture, shape (3,)."""
    fov: float
    """Vertical field of view [deg]."""
    focus: float
    """Distance of the focal plane along the axis [m]."""
    aperture: float
    """Radius of the lens [m]; 0 if everything is sharp."""


class Cameras:
    """The cameras of a film.

    Args:
        film: Constants of `render.py`, see `cadence.film_of`.
        states: Has `position` and `pose`, see `viewpoints.place`. If it also has `bounds(bodies, t)`, the outermost
            points of bodies, shape (n, 3) [m], and the recorded times `time` [s], cameras with a `frame` are fitted to
            them.
    """

    def __init__(self, film: dict, states: Any):
        self._film, self._states = film, states
        self._aspect = film["resolution"][0] / film["resolution"][1]
        self._cameras = dict(film["cameras"])
        self._framed: set[str] = set()

    def view(self, name: str, t: float, part: float = 0.0) -> View:
        """Return the view of a camera.

        Args:
            name: Name of the camera.
            t: Simulated time [s].
            part: Progress of a camera that moves over its take, 0 to 1.
        """
        camera = self._camera(name)
        pos, look_at, up = (np.asarray(vector, float) for vector in place(camera, t, part, self._states))
        ahead = look_at - pos
        distance = float(np.linalg.norm(ahead))
        focus = distance
        if camera.get("focus") is not None:
            point = self._point(camera["focus"], t)
            focus = max(float((point - pos) @ ahead) / distance, 1e-3) if distance else distance
        aperture = aperture_radius(camera["fov"], camera["f_stop"]) if camera.get("f_stop") else 0.0
        return View(pos, look_at, up, float(camera["fov"]), focus, aperture)

    def _camera(self, name: str) -> dict:
        camera = self._cameras[name]
        if name not in self._framed and "frame" in camera and hasattr(self._states, "bounds"):
            points = self._shown(name, camera["frame"])
            if len(points):
                self._cameras[name] = camera = framed(camera, points, self._aspect)
            self._framed.add(name)
        return camera

    def _point(self, focus: Any, t: float) -> np.ndarray:
        if isinstance(focus, dict):
            return np.asarray(self._states.position(focus["body"], t, focus["link"]), float)
        return np.asarray(focus, float)

    def _shown(self, name: str, frame: dict) -> np.ndarray:
        """Points that a camera has to show in its shots [m], shape (n, 3); relative to the body that it follows."""
        shots = [shot for shot in self._film["shots"] if shot["camera"] == name]
        spans = [(shot["from"], shot["to"]) for shot in shots] or [(self._film["start"], self._film["end"])]
        time = np.asarray(self._states.time)
        inside = time[np.any([(time >= first) & (time <= last) for first, last in spans], axis=0)]
        times = (
            inside[np.unique(np.linspace(0, len(inside) - 1, SAMPLES).round().astype(int))]
            if len(inside)
            else time[-1:]
        )
        if len(inside) > SAMPLES and hasattr(self._states, "extremes"):
            times = np.union1d(times, self._states.extremes(frame["bodies"], inside))
        clouds = [np.asarray(self._states.bounds(frame["bodies"], float(t)), float) for t in times]
        points = np.concatenate([np.zeros((0, 3)), *clouds])
        known = np.isfinite(points).all(axis=1)
        if frame["within"] is not None:
            low, high = frame["within"]
            near = known & ((points >= low) & (points <= high)).all(axis=1)
            known = near if near.any() else known
        if (camera := self._cameras[name])["kind"] == "follow":
            origins = [followed(camera, float(t), self._states) for t in times]
            points = points - np.repeat(np.reshape(origins, (-1, 3)), [len(cloud) for cloud in clouds], axis=0)
        return points[known]


def project(view: View, points: Any, aspect: float) -> np.ndarray:
    """Return the coordinates of points in the picture, shape (n, 3): right and up, -1 to 1 inside, and depth [m].

    Args:
        view: The camera.
        points: Points in the world [m], shape (n, 3).
        aspect: Width of the picture over its height.
    """
    local = (np.asarray(points, float).reshape(-1, 3) - view.pos) @ np.stack(basis(view.pos, view.look_at, view.up)).T
    tan_half_fov = math.tan(math.radians(view.fov) / 2)
    right, up, depth = local.T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.column_stack([right / (depth * tan_half_fov * aspect), up / (depth * tan_half_fov), depth])


def framed(camera: dict, points: np.ndarray, aspect: float) -> dict:
    """Return a camera that shows all points, with a margin at the edges of the picture.

    A still camera with a `direction` moves as near as possible; without one it keeps its place and changes its field of
    view. An orbiting camera gets the smallest radius if `fit` is set; otherwise it only gets a new centre, and the
    margin is ignored. A following camera gets its place relative to the body that it follows.

    Args:
        camera: Camera with a `frame`.
        points: Points to show [m], shape (n, 3), relative to the followed body if there is one.
        aspect: Width of the picture over its height.
    """
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    if camera["kind"] == "orbit":
        return _framed_orbit(camera, points, middle, aspect)
    if camera["kind"] == "follow":
        still = _framed_by_distance(camera, points, middle, aspect)
        return camera | {"offset": still["pos"], "aside": still["look_at"]}
    if "direction" in camera["frame"]:
        return _framed_by_distance(camera, points, middle, aspect)
    return _framed_by_fov(camera, points, middle, aspect)


def _usable(camera: dict) -> float:
    """Share of the picture between its margins, in each direction."""
    return 1 - 2 * camera["frame"]["margin"]


def _tan_usable(camera: dict) -> float:
    """Tangent of half the field of view between the margins."""
    return math.tan(math.radians(camera["fov"]) / 2) * _usable(camera)


def _framed_orbit(camera: dict, points: np.ndarray, middle: np.ndarray, aspect: float) -> dict:
    if not camera["frame"]["fit"]:
        return camera | {"look_at": middle}
    slope = camera["height"] / camera["radius"]
    angles = camera["start"] + camera["turn"] * np.linspace(0, 1, TURNS)
    directions = [np.array((math.cos(angle), math.sin(angle), slope)) for angle in angles]
    tan_half_fov, local = _tan_usable(camera), points - middle
    fitting = [
        _fitting_distance(local, direction, camera["up"], tan_half_fov, aspect, turn_only=True)[0]
        for direction in directions
    ]
    radius = max(fitting) / math.hypot(1.0, slope)
    return camera | {"look_at": middle, "radius": radius, "height": slope * radius}


def _framed_by_distance(camera: dict, points: np.ndarray, middle: np.ndarray, aspect: float) -> dict:
    direction = np.asarray(camera["frame"]["direction"], float)
    distance, aside = _fitting_distance(points - middle, direction, camera["up"], _tan_usable(camera), aspect)
    toward = direction / np.linalg.norm(direction)
    return camera | {"pos": middle + aside + distance * toward, "look_at": middle + aside}


def _framed_by_fov(camera: dict, points: np.ndarray, middle: np.ndarray, aspect: float) -> dict:
    pos = np.asarray(camera["pos"], float)
    local = (points - pos) @ np.stack(basis(pos, middle, camera["up"])).T
    ahead = local[local[:, 2] > 1e-6]
    if len(ahead) < len(local):
        return camera | {"look_at": middle}  # some points are behind the camera
    # Turn the camera so that the middle of the points is in the middle of the picture.
    seen = ahead[:, :2] / ahead[:, 2:]
    shift = (seen.min(axis=0) + seen.max(axis=0)) / 2
    right, up, forward = np.array(basis(pos, middle, camera["up"]))
    look_at = pos + np.linalg.norm(middle - pos) * (forward + shift[0] * right + shift[1] * up)
    local = (points - pos) @ np.stack(basis(pos, look_at, camera["up"])).T
    seen = np.abs(local[:, :2] / np.maximum(local[:, 2:], 1e-9)).max(axis=0)
    fov = 2 * math.degrees(math.atan(max(seen[1], seen[0] / aspect) / _usable(camera)))
    return camera | {"look_at": look_at, "fov": float(np.clip(fov, 2.0, 120.0))}


def framed_balls(camera: dict, balls: list[tuple[Any, float]], aspect: float) -> dict:
    """Return a camera that shows all balls; see `framed`.

    Args:
        camera: The camera.
        balls: Centre [m], shape (3,), and radius [m] of each.
        aspect: Width of the picture over its height.
    """
    directions = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z], float)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return framed(
        camera, np.concatenate([np.asarray(center) + radius * directions for center, radius in balls]), aspect
    )


def _fitting_distance(
    points: np.ndarray, direction: np.ndarray, up: Any, tan_half_fov: float, aspect: float, *, turn_only: bool = False
) -> tuple[float, np.ndarray]:
    """Smallest distance [m] along `direction` that shows all points, and the sideways shift it needs [m].

    The picture's four edges are planes. Each plane is moved to its outermost point, and the camera stands where
    opposite planes meet. With `turn_only` the camera stays on the axis.
    """
    direction = direction / np.linalg.norm(direction)
    right, above, _ = np.array(basis(direction, (0.0, 0.0, 0.0), up))
    depth = points @ direction  # towards the camera
    needed, aside = [], np.zeros(3)
    for axis, slope in ((right, tan_half_fov * aspect), (above, tan_half_fov)):
        across = points @ axis
        high, low = (across + slope * depth).max(), (across - slope * depth).min()
        if turn_only:
            needed.append(max(high, -low) / slope)
        else:
            needed.append((high - low) / (2 * slope))
            aside = aside + axis * (high + low) / 2
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    return max(*needed, float(depth.max()) + 0.05 * size, 1e-2), aside
