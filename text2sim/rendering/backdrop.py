"""What stands around the scene: a seamless studio wall, or ground without an end.

As in a studio the wall stands only where a camera looks. The open sides let light out and in, which makes a picture
cheaper: in a closed room no path of light ends before its longest length.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from text2sim.rendering.meshes import Mesh, joined, revolved

Array = NDArray[np.floating]

WALL = 0.9
"""Height of a cyclorama's wall above its curve, in radii."""
NEAR = 0.5
"""Where the curve of the wall begins, in radii: on its open side the floor goes on, under lamps and cameras."""
CLEARANCE = 1.15
"""The same where a camera stands on a side to which another looks, in its distances."""
FILLET = 0.35
"""Radius of the curve between floor and wall, in radii."""
STEPS = 40
SIDES = 192
BEHIND = np.radians(75.0)
"""How far to both sides of where a camera looks the wall goes."""
HAZY = {"ground": 0.8, "horizon": 1.2}
"""Distance from the camera at which ground without an end is lost in haze, in radii of the stage."""
LOST = 1.5
"""Where ground without an end ends all the same, in distances of haze: less than a hundredth of it would be seen."""
WHOLE = 0.999
"""Alpha of a pixel that sees something everywhere."""
SUNK = 1e-4
"""How far the floor lies below the level on which things stand [m], so that both are not in one place."""


def backdrop_mesh(backdrop: dict[str, Any], eyes: Iterable[Array]) -> Mesh | None:
    """Return the mesh of a backdrop; None if there is none.

    Args:
        backdrop: As the film section has it resolved.
        eyes: Where cameras stand, now and then [m].
    """
    kind, eyes = backdrop["kind"], list(eyes)
    if kind == "none" or backdrop["level"] is None:
        return None
    bounded = kind == "cyclorama"
    if bounded:
        radius = max(float(backdrop["radius"]), _farthest(backdrop, eyes) * CLEARANCE / NEAR)
    else:
        off = [np.hypot(*np.subtract(eye, backdrop["center"])[:2]) for eye in eyes]
        radius = LOST * HAZY[kind] * float(backdrop["radius"]) + max(off, default=0.0)
    rings = radius * np.geomspace(0.05, 1.0, STEPS)
    made = _turned(np.column_stack([np.append(0.0, rings), np.zeros(STEPS + 1)]), np.tile([0.0, 1.0], (STEPS + 1, 1)))
    if bounded:
        bend, near = FILLET * radius, NEAR * radius
        turn = np.linspace(0, np.pi / 2, STEPS)
        curve = np.stack([near + bend * np.sin(turn), bend - bend * np.cos(turn)], axis=1)
        slopes = np.stack([-np.sin(turn), np.cos(turn)], axis=1)
        top = [(near + bend, WALL * radius + bend)]
        wall = _turned(np.concatenate([curve, top]), np.concatenate([slopes, slopes[-1:]]))
        made = joined([made, _open(wall, backdrop, eyes)])
    x, y = backdrop["center"][:2]
    return Mesh(made.vertices + (x, y, backdrop["level"] - SUNK), made.faces, made.normals)


def clearness(backdrop: dict[str, Any], depth: Array, alpha: Array) -> Array:
    """Return how much of what is seen comes through the haze, 0 to 1: ground fades before it ends in a hard line.

    Args:
        backdrop: As the film section has it resolved.
        depth: Distance from the camera [m], 0 where there is nothing, shape (h, w).
        alpha: 1 where there is something, shape (h, w).
    """
    far = HAZY.get(backdrop["kind"], 0.0) * float(backdrop["radius"])
    if not far:
        return np.ones_like(depth)
    # At the edge of the ground a pixel sees it in some samples only: it is as far away as what is beside it.
    away = np.where(alpha < WHOLE, maximum_filter(depth, size=3), depth)
    return np.exp(-((away / far) ** 4))


def _turned(profile: Array, slopes: Array) -> Mesh:
    made = revolved(profile, slopes, sides=SIDES)
    # The room is inside, so its faces look the other way round.
    return Mesh(made.vertices, made.faces[:, ::-1], made.normals)


def _farthest(backdrop: dict[str, Any], eyes: Sequence[Array]) -> float:
    """Return the distance [m] of the farthest camera that has a wall behind it, since another looks there."""
    away = np.array([np.asarray(eye, float)[:2] for eye in eyes]).reshape(-1, 2) - backdrop["center"][:2]
    angle = np.arctan2(away[:, 1], away[:, 0])
    behind = _between(angle[:, None], angle[None] + np.pi) < BEHIND
    return float(np.hypot(*away[behind.any(axis=1)].T).max(initial=0.0))


def _between(a: Array, b: Array) -> Array:
    """Return the angle [rad] between two directions, 0 to pi."""
    return np.abs((a - b + np.pi) % (2 * np.pi) - np.pi)


def _open(wall: Mesh, backdrop: dict[str, Any], eyes: Iterable[Array]) -> Mesh:
    """Return the part of a wall that cameras see behind the scene."""
    middle = wall.vertices[wall.faces].mean(axis=1)
    angle = np.arctan2(middle[:, 1], middle[:, 0])
    kept = np.zeros(len(angle), bool)
    for eye in eyes:
        x, y = np.subtract(backdrop["center"][:2], np.asarray(eye)[:2])
        if np.hypot(x, y) < 1e-6:  # straight from above
            kept[:] = True
        else:
            kept |= _between(angle, np.arctan2(y, x)) < BEHIND
    return Mesh(wall.vertices, wall.faces[kept], wall.normals)
