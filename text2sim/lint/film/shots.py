"""The cameras of a case, as numbers: what falls into their pictures."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from text2sim.compiler.shapes.rotation import Vec, vector_cross, vector_unit
from text2sim.compiler.trees.tree import tree_links
from text2sim.lint.facts import Facts

Offset = Callable[[str, float], Vec]
"""Displacement [m] of a copy from its start at a time [s], as far as it is known."""


def _still(name: str, t: float) -> Vec:
    return (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Shot:
    """A camera at a moment."""

    name: str
    pos: Vec
    target: Vec
    right: Vec
    up: Vec
    ahead: Vec
    tall: float
    """Tangent of half the vertical field of view."""
    wide: float
    """The same across."""

    def place(self, point: Vec) -> tuple[float, float, float]:
        """Return a point in the picture (-1 to 1 across and up; beyond is outside) and its depth [m]."""
        away = (point[0] - self.pos[0], point[1] - self.pos[1], point[2] - self.pos[2])
        depth = _dot(away, self.ahead)
        if depth <= 1e-6:
            return math.inf, math.inf, depth
        return _dot(away, self.right) / (depth * self.wide), _dot(away, self.up) / (depth * self.tall), depth

    def shows(self, point: Vec, radius: float = 0.0) -> bool:
        """Whether a ball about a point is in the picture, be it with its edge."""
        x, y, depth = self.place(point)
        if depth <= 1e-6:
            return False
        # The ball touches the plane through the camera and an edge of the picture.
        room = radius / depth
        across, tall = 1 + room * math.hypot(1, self.wide) / self.wide, 1 + room * math.hypot(1, self.tall) / self.tall
        return abs(x) <= across and abs(y) <= tall

    def share(self, balls: Iterable[tuple[Vec, float]]) -> float:
        """Return a bound of the part of the picture that balls fill."""
        total = 0.0
        for center, radius in balls:
            depth = self.place(center)[2]
            if depth > radius:
                total += math.pi * radius**2 / (depth**2 - radius**2) / (4 * self.tall * self.wide)
            elif depth > -radius:
                return 1.0
        return min(total, 1.0)

    def needed(self, point: Vec) -> float | None:
        """Return the vertical field of view [deg] that would hold a point, if it is ahead of the camera."""
        x, y, depth = self.place(point)
        if depth <= 1e-6:
            return None
        return 2 * math.degrees(math.atan(max(abs(x), abs(y)) * self.tall))


def shots(facts: Facts, t: float, offset: Offset = _still) -> list[Shot]:
    """Return all cameras at a time [s] of the simulation."""
    return [shot(facts, camera, t, offset) for camera in facts.plan.render["cameras"]]


def shot(facts: Facts, camera: dict[str, Any], t: float, offset: Offset = _still) -> Shot:
    """Return a camera of the plan at a time [s]; what `offset` does not know of is where it starts."""
    render = facts.plan.render
    span = render["end"] - render["start"]
    part = min(max((t - render["start"]) / span, 0.0), 1.0) if span > 0 else 0.0
    if camera["kind"] == "follow":
        target = _plus(_body(facts, camera["body"], camera["link"]), offset(camera["body"], t))
        pos = camera["pos"] if camera.get("offset") is None else _plus(target, camera["offset"])
    else:
        target = camera["look_at"]
        if camera["kind"] == "orbit":
            angle = camera["start"] + camera["turn"] * part
            arm = (camera["radius"] * math.cos(angle), camera["radius"] * math.sin(angle), camera["height"])
            pos = _plus(target, arm)
        elif camera["kind"] == "dolly":
            x, y, z = (a + (b - a) * part for a, b in zip(camera["pos"], camera["to"], strict=True))
            pos = (x, y, z)
        else:
            pos = camera["pos"]
    away = (target[0] - pos[0], target[1] - pos[1], target[2] - pos[2])
    ahead = vector_unit(away) if math.hypot(*away) > 1e-9 else (0.0, 1.0, 0.0)
    right = vector_cross(ahead, vector_unit(camera["up"]))
    if math.hypot(*right) < 1e-3:  # straight up or down: +y is up in the picture
        right = vector_cross(ahead, (0.0, 1.0, 0.0))
    right = vector_unit(right)
    tall = math.tan(math.radians(camera["fov"]) / 2)
    wide = tall * render["resolution"][0] / render["resolution"][1]
    return Shot(camera["name"], pos, target, right, vector_cross(right, ahead), ahead, tall, wide)


def _body(facts: Facts, name: str, link: str | None) -> Vec:
    """Position [m] of a copy's link at the start; of its first if none is named."""
    copy = facts.copies[name]
    tree = facts.tree(copy)
    if tree is None or not tree.roots:
        return copy.pos
    standing = {one.link.name: one.pos for one in tree_links(tree, copy.pos, copy.quat)}
    return standing.get(link if link is not None else tree.roots[0].name, copy.pos)


def _plus(a: Vec, b: Vec) -> Vec:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
