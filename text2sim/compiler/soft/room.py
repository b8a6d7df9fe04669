"""Where deformable bodies can come to: the space that their solvers must cover."""

from dataclasses import dataclass
from pathlib import Path

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.geometry import Bounds
from text2sim.compiler.shapes.rotation import Vec, quat_rotate
from text2sim.compiler.soft.solvers import is_soft
from text2sim.compiler.trees.anatomy import tree_extents
from text2sim.spec_schema.models.scene import Scene

LONGEST_FALL = 2.0
"""How far [m] a body is followed that falls onto nothing."""
FLUID_SPREAD = 1.5
"""How far what does not hold together spreads on the floor, as a part of the height from which it comes."""
UPRIGHT = 1.0 - 1e-6
"""Cosine of the angle between a floor's normal and the vertical."""


@dataclass(frozen=True)
class Surroundings:
    """What stands around deformable bodies."""

    solids: tuple[Bounds, ...]
    """Bounds [m] of statics and bodies of links, in the world."""
    floors: tuple[float, ...]
    """Heights [m] of horizontal planes."""


def extents_of(copy: Copy, folder: Path) -> Bounds:
    """Bounds [m] of a copy at the start, in the world.

    Raises:
        AssetError: if one of its files cannot be used.
    """
    if copy.shape is None:
        low, high = tree_extents(copy.model, copy.quat, folder)
    else:
        low, high = geometry.extents(copy.shape, copy.quat, folder)
    return _moved(low, copy.pos), _moved(high, copy.pos)


def floor_height(copy: Copy) -> float | None:
    """Height [m] of a horizontal plane; None for everything else."""
    if copy.shape is None or copy.shape.kind != "plane":
        return None
    return copy.pos[2] if quat_rotate(copy.quat, (0.0, 0.0, 1.0))[2] > UPRIGHT else None


def surroundings(placed: dict[str, list[Copy]], folder: Path) -> Surroundings:
    """Return what stands around deformable bodies.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    solids, floors = [], []
    for copies in placed.values():
        for copy in copies:
            if is_soft(copy.model):
                continue
            if copy.shape is not None and copy.shape.kind == "plane":
                height = floor_height(copy)
                floors += [height] if height is not None else []
            else:
                solids.append(extents_of(copy, folder))
    return Surroundings(tuple(solids), tuple(floors))


def room(
    copies: list[Copy],
    around: Surroundings,
    scene: Scene,
    speeds: dict[str, Vec],
    folder: Path,
    margin: float,
) -> Bounds:
    """Return a box [m] that deformable bodies stay in.

    Args:
        copies: The bodies.
        around: What else there is.
        scene: Gravity and duration.
        speeds: Initial velocity [m/s] by copy.
        folder: The case's folder.
        margin: Kept free on every side [m]; below a floor, too.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    own = [extents_of(copy, folder) for copy in copies]
    low, high = _union(own)
    fall = _fall(low, high, around, scene)
    # What falls bounces, rolls and spreads; a cloth swings out to half its length.
    length = max(max(b - a for a, b in zip(*one, strict=True)) for one in own)
    flows = any(copy.model.kind in ("granular", "liquid", "snow") for copy in copies)
    tall = high[2] - low[2] + max(fall[2], -fall[2])
    reach = length / 2 + (FLUID_SPREAD if flows else 0.5) * tall
    gravity = sum(g * g for g in scene.gravity) ** 0.5
    sweep = [_sweep(speeds[c.name], gravity, scene.duration) for c in copies if c.name in speeds] or [(0.0,) * 3]
    least = [low[k] - reach * (k < 2) + min(0.0, fall[k], *(s[k] for s in sweep)) for k in range(3)]
    most = [high[k] + reach * (k < 2) + max(0.0, fall[k], *(s[k] for s in sweep)) for k in range(3)]
    most[2] += length / 2 + 0.25 * abs(fall[2])
    box = (least[0], least[1], least[2]), (most[0], most[1], most[2])
    box = _with_neighbours(box, around, reach)
    lowest = [max(box[0][2], max(floors))] if (floors := [f for f in around.floors if f <= low[2] + margin]) else []
    bottom = lowest[0] if lowest else box[0][2]
    (x, y, _), (a, b, top) = box
    return (x - margin, y - margin, bottom - margin), (a + margin, b + margin, top + margin)


def _fall(low: Vec, high: Vec, around: Surroundings, scene: Scene) -> Vec:
    """Way [m] that gravity takes bodies: to the floor, or to what stands below, or as far as they are followed."""
    size = sum(g * g for g in scene.gravity) ** 0.5
    if size == 0.0:
        return (0.0, 0.0, 0.0)
    free = min(0.5 * size * scene.duration**2, LONGEST_FALL)
    x, y, z = (free * g / size for g in scene.gravity)
    if z < 0.0:
        floors = [f for f in around.floors if f < high[2]]
        below = [a[2] for a, _ in around.solids if a[2] < low[2]]
        ground = max(floors) if floors else min(below, default=low[2] + z)
        z = max(min(ground - low[2], 0.0), -1e9 if floors or below else z)
    return (x, y, z)


def _sweep(velocity: Vec, gravity: float, duration: float) -> Vec:
    """How far [m] something comes at a speed: until gravity and friction have stopped it, or time is up."""
    speed = sum(v * v for v in velocity) ** 0.5
    time = min(duration, 2 * speed / gravity) if gravity else min(duration, 1.0)
    return (velocity[0] * time, velocity[1] * time, velocity[2] * time)


def _with_neighbours(box: Bounds, around: Surroundings, reach: float) -> Bounds:
    """The box and all solids near it, of which no more counts than lies within `reach`."""
    far = _grown(box, reach)
    near = [
        (_pick(max, a, far[0]), _pick(min, b, far[1]))
        for a, b in around.solids
        if all(a[k] < box[1][k] and b[k] > box[0][k] for k in range(3))
    ]
    return _union([box, *near])


def _grown(box: Bounds, by: float) -> Bounds:
    low, high = box
    return _moved(low, (-by, -by, -by)), _moved(high, (by, by, by))


def _union(boxes: list[Bounds]) -> Bounds:
    low, high = boxes[0]
    for a, b in boxes[1:]:
        low, high = _pick(min, low, a), _pick(max, high, b)
    return low, high


def _pick(choose: object, a: Vec, b: Vec) -> Vec:
    x, y, z = (choose(p, q) for p, q in zip(a, b, strict=True))  # type: ignore[operator]
    return (x, y, z)


def _moved(point: Vec, by: Vec) -> Vec:
    return (point[0] + by[0], point[1] + by[1], point[2] + by[2])
