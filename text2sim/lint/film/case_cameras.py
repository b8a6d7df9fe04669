"""Cameras of a case at a moment: positions, fields of view, and what their pictures show."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from text2sim.compiler.shapes.rotation import (
    Quaternion,
    Vec,
    quat_conjugate,
    quat_rotate,
    vector_dot,
    vector_minus,
    vector_plus,
)
from text2sim.compiler.trees.tree import link_frame
from text2sim.lint.facts import Facts, once_per_case
from text2sim.templates.cadence import Frame, frames, reels
from text2sim.templates.viewpoints import basis, place

Offset = Callable[[str, float], Vec]
"""Displacement [m] of a copy from its start at a time [s], as far as known."""


@dataclass(frozen=True)
class CameraView:
    """A camera at a moment."""

    name: str
    pos: Vec
    """Position [m]."""
    target: Vec
    """Point that it looks at [m]."""
    right: Vec
    """Unit vector, as are `up` and `ahead`."""
    up: Vec
    ahead: Vec
    tan_half_height: float
    """Tangent of half the vertical field of view."""
    tan_half_width: float
    """Tangent of half the horizontal field of view."""

    def project(self, point: Vec) -> tuple[float, float, float]:
        """Return a point in the picture (-1 to 1 across and up if inside) and its depth [m]."""
        away = vector_minus(point, self.pos)
        depth = vector_dot(away, self.ahead)
        if depth <= 1e-6:
            return math.inf, math.inf, depth
        return (
            vector_dot(away, self.right) / (depth * self.tan_half_width),
            vector_dot(away, self.up) / (depth * self.tan_half_height),
            depth,
        )

    def shows(self, point: Vec, radius: float = 0.0) -> bool:
        """Return whether a ball around a point may be partly in the picture; False is certain."""
        away = vector_minus(point, self.pos)
        depth = vector_dot(away, self.ahead)
        if depth <= 1e-6 - radius:
            return False
        # The ball is at most a radius beyond the planes through the camera and the edges of the picture.
        return all(
            abs(vector_dot(away, side)) <= depth * slope + radius * math.hypot(1, slope)
            for side, slope in ((self.right, self.tan_half_width), (self.up, self.tan_half_height))
        )

    def share(self, balls: Iterable[tuple[Vec, float]]) -> float:
        """Return an upper bound on the share of the picture that balls fill."""
        total = 0.0
        for center, radius in balls:
            away = vector_minus(center, self.pos)
            depth = vector_dot(away, self.ahead)
            if depth > radius:
                # The area of the ellipse in which the cone around the ball meets the plane at depth 1.
                long = math.sqrt((vector_dot(away, away) - radius**2) / (depth**2 - radius**2))
                picture_area = 4 * self.tan_half_height * self.tan_half_width
                total += long * math.pi * radius**2 / (depth**2 - radius**2) / picture_area
            elif depth > -radius:
                return 1.0
        return min(total, 1.0)

    def fov_to_show(self, point: Vec) -> float | None:
        """Return the vertical field of view [deg] that shows a point; None if it is behind the camera."""
        x, y, depth = self.project(point)
        if depth <= 1e-6:
            return None
        return 2 * math.degrees(math.atan(max(abs(x), abs(y)) * self.tan_half_height))


def views_at(facts: Facts, t: float, offset: Offset | None = None) -> list[CameraView]:
    """Return all cameras at a time [s] of the simulation.

    Args:
        facts: The case.
        t: Time of the simulation [s].
        offset: Displacements of copies; none if left out.
    """
    return [view_at(facts, name, t, offset) for name in facts.plan.render["cameras"]]


@once_per_case
def pictures_taken(facts: Facts) -> dict[str, list[Frame]]:
    """Return the pictures that each camera of the author takes, in the order of the film."""
    render = facts.plan.render
    found: dict[str, list[Frame]] = {name: [] for name in facts.case.render.cameras}
    for reel in reels(render).values() if found else ():
        for frame in frames(render, reel, facts.case.scene.duration):
            found[frame.camera].append(frame)
    return found


def spread_evenly(pictures: list[Frame], max_pictures: int) -> list[Frame]:
    """Return at most `max_pictures` pictures, spread evenly from the first to the last."""
    last = len(pictures) - 1
    if last < max_pictures:
        return pictures
    return [pictures[round(k * last / max(max_pictures - 1, 1))] for k in range(max_pictures)]


def films_at(facts: Facts, name: str, t: float) -> bool:
    """Return whether a camera takes pictures around a time [s].

    Args:
        facts: The case.
        name: Name of the camera.
        t: Time of the simulation [s].
    """
    step = facts.plan.render["speed"] / facts.plan.render["fps"]
    times = [frame.t for frame in pictures_taken(facts)[name]]
    return bool(times) and min(times) - step <= t <= max(times) + step


def view_at(facts: Facts, name: str, t: float, offset: Offset | None = None, part: float | None = None) -> CameraView:
    """Return a camera of the plan at a time [s].

    Args:
        facts: The case.
        name: Name of the camera.
        t: Simulated time [s].
        offset: Displacements of copies; none if left out.
        part: Progress of a moving camera, 0 to 1; that in a film without shots if left out.
    """
    render = facts.plan.render
    camera = render["cameras"][name]
    span = render["end"] - render["start"]
    plain = min(max((t - render["start"]) / span, 0.0), 1.0) if span > 0 else 0.0
    pos, target, upwards = place(camera, t, plain if part is None else part, _Known(facts, t, offset))
    right, up, ahead = basis(pos, target, upwards)
    tan_half_height = math.tan(math.radians(camera["fov"]) / 2)
    tan_half_width = tan_half_height * render["resolution"][0] / render["resolution"][1]
    return CameraView(name, pos, target, right, up, ahead, tan_half_height, tan_half_width)


def point_for(facts: Facts, name: str, point: Vec) -> tuple[Vec, str]:
    """Return a point of the world as a camera's `look_at` has it [m], and words for the frame that is not the world.

    Args:
        facts: The case.
        name: Name of the camera.
        point: The point at the start [m].
    """
    camera = facts.plan.render["cameras"][name]
    if camera["kind"] != "mounted":
        return point, ""
    pos, quat = _Known(facts, 0.0, None).pose(camera["body"], 0.0, camera["link"])
    return quat_rotate(quat_conjugate(quat), vector_minus(point, pos)), " in the frame of what carries it"


class _Known:
    """Predicted positions at a moment, in the form that cameras need; orientations are those at the start."""

    def __init__(self, facts: Facts, t: float, offset: Offset | None) -> None:
        self._facts, self._t, self._offset = facts, t, offset

    def position(self, body: str, t: float, link: str | None) -> Vec:
        """Return the position [m] of a copy's link, or of its root; `t` is close enough to the moment not to matter."""
        return self.pose(body, t, link)[0]

    def pose(self, body: str, t: float, link: str | None) -> tuple[Vec, Quaternion]:
        """Return the position [m] of a copy's link, or of its root, and its orientation at the start."""
        copy = self._facts.copies[body]
        pos, quat = link_frame(self._facts.tree(copy), link, copy.pos, copy.quat)
        return (pos if self._offset is None else vector_plus(pos, self._offset(body, self._t))), quat
