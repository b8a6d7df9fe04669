"""Convex shapes with flat faces: polyhedra and rocks."""

from functools import cached_property
from math import cos, hypot, pi, sin, sqrt
from random import Random
from typing import Annotated, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Integer, Model, Size3, Vec3

FLATTEST = 1e-4
"""Smallest thickness of a polyhedron, as a fraction of its largest extent."""


def _cross(u: list[float], v: list[float]) -> tuple[float, float, float]:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


class Polyhedron(Model):
    """The convex hull of points, with flat faces: a wedge, a prism, a pyramid."""

    kind: Literal["polyhedron"]
    points: Annotated[list[Vec3], Field(min_length=4, max_length=64)]
    """Corners [m] in the body's frame, 4 to 64, in any order; points inside the hull of the others are ignored."""

    @model_validator(mode="after")
    def _solid(self) -> "Polyhedron":
        a = self.points[0]
        away = [[c - o for c, o in zip(point, a, strict=True)] for point in self.points]
        u = max(away, key=lambda v: hypot(*v))
        normal = max((_cross(u, v) for v in away), key=lambda n: hypot(*n))
        size, area = hypot(*u), hypot(*normal)
        if size > 1e6:
            raise ValueError(f"a point is {size:g} m from the first; at most 1000 km is possible")
        heights = [sum(n * c for n, c in zip(normal, v, strict=True)) / area for v in away] if area > 0 else [0.0]
        thin = max(heights) - min(heights)
        if thin < max(1e-6, FLATTEST * size):
            raise ValueError(f"its points lie in one plane or line, within {thin:.2g} m: they enclose no volume")
        return self


ROCK_CORNERS = 22
"""Number of points whose convex hull is a rock; some of them lie inside it."""
ROCK_DEPTH = 0.35
"""Largest depth of these points below an ellipsoid, as a fraction of its radius."""
THINNEST_ROCK = 0.05
"""Smallest extent of a rock, as a fraction of its largest."""


class Rock(Model):
    """An angular stone.

    It is the hull of points near an ellipsoid, and usually fills 0.3 to 0.55 of its bounding box. With `seed: ${i}`
    each copy has a shape of its own.
    """

    kind: Literal["rock"]
    size: Size3
    """Full lengths [m] along x, y, z, exactly."""
    seed: Annotated[Integer, Field(ge=0, le=1_000_000)] = 0
    """Same seed, same stone."""

    @model_validator(mode="after")
    def _no_flake(self) -> "Rock":
        if min(self.size) < THINNEST_ROCK * max(self.size):
            thinnest = f"{THINNEST_ROCK * max(self.size):g} m"
            raise ValueError(f"the sides of a rock of {max(self.size):g} m are at least {thinnest}; use a polyhedron")
        return self

    @cached_property
    def points(self) -> list[Vec3]:
        """Points [m] whose convex hull it is: a Fibonacci sphere with jitter, scaled to the size."""
        dice = Random(self.seed)
        turn = pi * (3 - sqrt(5))  # the golden angle spreads points evenly over a sphere
        corners = []
        for k in range(ROCK_CORNERS):
            z = 1 - (2 * k + 1 + dice.uniform(-0.8, 0.8)) / ROCK_CORNERS
            angle, r = k * turn + dice.uniform(-0.5, 0.5), 1 - ROCK_DEPTH * dice.random()
            flat = sqrt(1 - z * z)
            corners.append((r * flat * cos(angle), r * flat * sin(angle), r * z))
        sides = [(min(axis), max(axis)) for axis in zip(*corners, strict=True)]
        return [
            tuple(
                length * ((c - low) / (high - low) - 0.5)
                for c, (low, high), length in zip(corner, sides, self.size, strict=True)
            )  # type: ignore[misc]
            for corner in corners
        ]


Faceted = Polyhedron | Rock
"""Convex shapes with flat faces, given by `points`."""
