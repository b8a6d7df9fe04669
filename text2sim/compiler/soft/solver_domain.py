"""Domains of the solvers: the space that deformable bodies can reach."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from math import dist, hypot, prod, sqrt
from pathlib import Path

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import NOWHERE, Bounds, apart, around, grown, middle, moved, sides, swept, union
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.rotation import Z_AXIS, Vec, quat_rotate, vector_unit
from text2sim.compiler.soft.solvers import is_soft, touches_soft
from text2sim.compiler.soft.travel import MAX_FOLLOWED_DISTANCE, Travel
from text2sim.compiler.trees.link_trees import tree_extents
from text2sim.spec_schema.models.bodies import HingeMount
from text2sim.spec_schema.models.scene import Scene
from text2sim.spec_schema.models.shapes import Stream
from text2sim.spec_schema.models.soft_bodies import FLOWING

FLUID_SPREAD = 1.5
"""How far a liquid spreads on the floor, over the height that it falls from."""
CREEPING, CURRENT = 100.0, 0.894
"""Reynolds number of its fall below which a liquid creeps instead of splashing, and the factor of the radius of its
current, see `_current`."""
SPARE = 1.5
"""Factor on that radius: what is poured heaps up first, and runs down what stands there."""
RUNOUT_FLAT, RUNOUT_TALL, RUNOUT_IMPACT = 1.24, 1.6, 0.25
"""How far a column of sand runs out when released: over its height if that is less than 1.7 radii, over the root of
height times radius if more (Lube et al. 2004, J. Fluid Mech. 508); and over the height of its fall."""
MAX_RESTING_GAP = 0.01
"""Largest gap [m] between a solid and what lies on it."""
MIN_UPRIGHT_COSINE = 1.0 - 1e-6
"""Cosine of the angle between a floor's normal and the vertical."""


@dataclass(frozen=True)
class Surroundings:
    """What stands around deformable bodies, and touches them, and what else decides where they get."""

    scene: Scene
    """Gravity and duration."""
    travel: Travel
    """How far bodies are moved."""
    folder: Path
    """The case's folder."""
    solids: tuple[Bounds, ...]
    """Bounds [m] of statics and bodies of links, in the world, with the space through which motors move them."""
    floors: tuple[float, ...]
    """Heights [m] of horizontal planes."""
    moved: tuple[tuple[Bounds, Bounds], ...]
    """Solids that motors or prescribed motions move: bounds [m] at the start, and displacements."""
    tilting: tuple[tuple[Bounds, Bounds], ...]
    """Solids on hinges: bounds [m] at the start, and of where what they lift gets when it slides off."""


def extents_of(copy: Copy, folder: Path) -> Bounds:
    """Return the bounds [m] of a copy at the start, in the world.

    Raises:
        AssetError: if one of its files cannot be used.
    """
    if copy.shape is None:
        low, high = tree_extents(copy.model, copy.quat, folder)
    else:
        low, high = extents(copy.shape, copy.quat, folder)
    return moved((low, high), copy.pos)


def floor_height(copy: Copy) -> float | None:
    """Return the height [m] of a horizontal plane; None for everything else."""
    if copy.shape is None or copy.shape.kind != "plane":
        return None
    return copy.pos[2] if quat_rotate(copy.quat, Z_AXIS)[2] > MIN_UPRIGHT_COSINE else None


def find_surroundings(placed: dict[str, list[Copy]], scene: Scene, travel: Travel, folder: Path) -> Surroundings:
    """Return what stands around deformable bodies, without what they do not touch.

    Args:
        placed: Copies by static and body.
        scene: The section.
        travel: How far bodies are moved.
        folder: The case's folder.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    solids, floors, carried, tilting = [], [], [], []
    for copies in placed.values():
        for copy in copies:
            if is_soft(copy.model) or not touches_soft(copy.model):
                continue
            if copy.shape is not None and copy.shape.kind == "plane":
                height = floor_height(copy)
                floors += [height] if height is not None else []
                continue
            box = extents_of(copy, folder)
            if isinstance(mount := getattr(copy.model, "mount", None), HingeMount):
                tilting.append((box, _slid(box, quat_rotate(copy.quat, vector_unit(mount.axis)))))
            if copy.name in travel.spins:
                box = _turned_about(copy.pos, box)
            displacements = travel.motors.get(copy.name, NOWHERE)
            solids.append(swept(box, displacements))
            if displacements != NOWHERE:
                carried.append((box, displacements))
    return Surroundings(scene, travel, folder, tuple(solids), tuple(floors), tuple(carried), tuple(tilting))


def domain_box(copies: list[Copy], surroundings: Surroundings, margin: float, volume: float) -> Bounds:
    """Return a box [m] that deformable bodies stay in.

    If it would have too many cells, it leaves less room for bouncing, rolling and spreading.

    Args:
        copies: The bodies.
        surroundings: What stands around them.
        margin: Free space on every side [m], also below a floor.
        volume: Volume that it should not exceed [m3].

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    scene, travel = surroundings.scene, surroundings.travel
    boxes = [extents_of(copy, surroundings.folder) for copy in copies]
    own = [swept(box, travel.holds.get(copy.name, NOWHERE)) for copy, box in zip(copies, boxes, strict=True)]
    falls = [
        _fall(*box, surroundings, hanging=_hanging(copy, box, travel))[2]
        for copy, box in zip(copies, boxes, strict=True)
    ]
    reach = max(_sideways_reach(c, box, fall, scene) for c, box, fall in zip(copies, boxes, falls, strict=True))
    length = max(max(sides(box)) for box in boxes)
    for part in (1.0, 0.5, 0.25):
        box = _domain_box(copies, own, surroundings, margin, length, part * reach)
        if prod(sides(box)) <= volume:
            break
    return box


def path_bounds(copy: Copy, surroundings: Surroundings) -> Bounds:
    """Return the box [m] of where a body gets when it is held, thrown, pushed and carried, and falls.

    Args:
        copy: The body.
        surroundings: What stands around it.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    travel = surroundings.travel
    box = swept(extents_of(copy, surroundings.folder), travel.holds.get(copy.name, NOWHERE))
    x, y, z = _fall(*box, surroundings, math.inf)
    center = middle(box)
    below = [
        b[2]
        for a, b in surroundings.solids
        if all(a[k] < center[k] < b[k] for k in (0, 1)) and b[2] <= box[0][2] + MAX_RESTING_GAP
    ]
    z = max(z, min(max(below, default=-MAX_FOLLOWED_DISTANCE) - box[0][2], 0.0)) if z < 0.0 else z
    z = max(z, -_hanging(copy, box, travel))
    return _flown(copy, box, (x, y, z), surroundings, math.inf)


def _flown(
    copy: Copy, box: Bounds, fall: Vec, surroundings: Surroundings, farthest: float = MAX_FOLLOWED_DISTANCE
) -> Bounds:
    scene, travel = surroundings.scene, surroundings.travel
    floors = [floor for floor in surroundings.floors if floor <= box[0][2] + MAX_RESTING_GAP]
    if copy.name in travel.spins:
        box = _turned_about(middle(box), box)
    box = swept(box, _box(travel.flights.get(copy.name)))
    box = swept(box, _box(_thrown(travel.starts.get(copy.name), fall, scene, farthest)))
    fallen = swept(box, _box(fall))
    for start, displacements in surroundings.moved:
        if not apart(grown(swept(start, displacements), MAX_RESTING_GAP), fallen):
            fallen = around([*fallen, *_reach_of_mover(copy.model.kind, fallen, start, displacements)])
    if copy.model.kind in FLOWING:
        for solid, slid in surroundings.tilting:
            if not apart(grown(solid, MAX_RESTING_GAP), fallen):
                fallen = around([*fallen, *slid])
    (x, y, z), high = fallen
    return (x, y, max([z, *floors])), high


def _turned_about(pivot: Vec, box: Bounds) -> Bounds:
    """Return where a solid gets when it turns about a point, in any direction."""
    radius = max(dist(pivot, corner) for corner in product(*zip(*box, strict=True)))
    return grown((pivot, pivot), radius)


def _slid(box: Bounds, axis: Vec) -> Bounds:
    """Return where what lies on a solid gets when that turns about an axis: off it, and on by half of its length."""
    half = max(sides(box)) / 2
    on = tuple(half * sqrt(max(0.0, 1 - part * part)) for part in axis)
    low, high = box
    return (low[0] - on[0], low[1] - on[1], low[2]), (high[0] + on[0], high[1] + on[1], high[2] + on[2])


def _reach_of_mover(kind: str, box: Bounds, start: Bounds, displacements: Bounds) -> Bounds:
    """Return where a moving solid takes what lies on it or in its way."""
    taken = swept(box, displacements)
    if start[1][2] <= box[0][2] + MAX_RESTING_GAP:
        return taken  # it carries it
    # What it pushes is in front of it: a whole body, or only a heap of what flows.
    size = 0.0 if kind in FLOWING else max(sides(box))
    front = grown(swept(start, displacements), size)
    return _componentwise(max, taken[0], front[0]), _componentwise(min, taken[1], front[1])


def _thrown(velocity: Vec | None, fall: Vec, scene: Scene, farthest: float) -> Vec | None:
    """Return how far [m] a start velocity takes a body: through the air, and then until friction stops it."""
    size = hypot(*scene.gravity)
    if velocity is None:
        return None
    x, y, z = velocity
    if size == 0.0:
        return _limit_length((x * scene.duration, y * scene.duration, z * scene.duration), farthest)
    if z > 0.0 > scene.gravity[2]:
        up = min(z * z / (2 * size), z * scene.duration)
        time = z / size + sqrt(2 * (abs(fall[2]) + up) / size)
    else:
        up, time = 0.0, sqrt(2 * hypot(*fall) / size)
    # With a friction of 0.5 it then slides for v^2 / g.
    time = min(time + hypot(x, y) / size, scene.duration)
    return _limit_length((x * time, y * time, up if scene.gravity[2] < 0.0 else z * time), farthest)


def _limit_length(displacement: Vec, farthest: float) -> Vec:
    part = min(1.0, farthest / max(hypot(*displacement), 1e-12))
    return displacement[0] * part, displacement[1] * part, displacement[2] * part


def _sideways_reach(copy: Copy, box: Bounds, fall: float, scene: Scene) -> float:
    """Return how far [m] a falling body gets sideways: it swings out, bounces, rolls or runs."""
    kind = copy.model.kind
    x, y, tall = sides(box)
    if isinstance(copy.shape, Stream):  # what it makes is as wide as all of it as a cube
        x = y = tall = max(tall, copy.shape.volume ** (1 / 3))
    if kind == "liquid":
        spread = FLUID_SPREAD * (tall + abs(fall))
        gravity, viscosity = hypot(*scene.gravity), copy.model.material.viscosity / copy.model.material.density
        if gravity == 0.0 or sqrt(2 * gravity * (tall + abs(fall))) * tall > CREEPING * viscosity:
            return spread
        return min(spread, SPARE * _current(x * y * tall, viscosity, gravity, scene.duration))
    if kind in ("granular", "snow"):
        radius = max(x, y) / 2
        runout = RUNOUT_FLAT * tall if tall < 1.7 * radius else RUNOUT_TALL * sqrt(tall * radius)
        return runout + RUNOUT_IMPACT * abs(fall)
    # A cloth swings out to half its length.
    return max(x, y, tall) / 2 + 0.5 * (tall + abs(fall))


def _current(volume: float, viscosity: float, gravity: float, time: float) -> float:
    """Return the radius [m] that a volume [m3] of a viscous liquid has spread to on a floor after a time [s].

    Huppert (1982), "The propagation of two-dimensional and axisymmetric viscous gravity currents over a rigid
    horizontal surface", J. Fluid Mech. 121: R = 0.894 (g V^3 / (3 nu))^(1/8) t^(1/8), with the kinematic viscosity nu
    [m2/s].
    """
    return CURRENT * (gravity * volume**3 / (3 * viscosity) * time) ** 0.125


def _domain_box(
    copies: list[Copy], own: list[Bounds], surroundings: Surroundings, margin: float, length: float, reach: float
) -> Bounds:
    whole = union(own)
    hanging = max(_hanging(copy, box, surroundings.travel) for copy, box in zip(copies, own, strict=True))
    fall = _fall(*whole, surroundings, hanging=hanging)
    flown = [_flown(c, box, fall, surroundings) for c, box in zip(copies, own, strict=True)]
    low, high = union(flown)
    box = (low[0] - reach, low[1] - reach, low[2]), (high[0] + reach, high[1] + reach, high[2])
    box = union([box, *_nearby(box, surroundings, reach, margin)])
    floors = [floor for floor in surroundings.floors if floor <= whole[0][2] + margin]
    low, high = box
    # A cloth may hang lower than anything that stands elsewhere.
    hanging = [box[1][2] - max(sides(box)) for copy, box in zip(copies, own, strict=True) if copy.model.kind == "cloth"]
    bottom = max([low[2], *floors]) if floors else min([low[2], *hanging])
    top = high[2] + length / 2 + 0.25 * abs(fall[2])
    return (low[0] - margin, low[1] - margin, bottom - margin), (high[0] + margin, high[1] + margin, top + margin)


def _hanging(copy: Copy, box: Bounds, travel: Travel) -> float:
    """Return how far [m] a body that is held can hang below its place; infinite for one that is not."""
    return dist(*box) if copy.name in travel.hanging else math.inf


def _fall(
    low: Vec,
    high: Vec,
    surroundings: Surroundings,
    farthest: float = MAX_FOLLOWED_DISTANCE,
    hanging: float = math.inf,
) -> Vec:
    """Return how far [m] gravity takes bodies: to the floor, to what stands lowest, or as far as they are followed.

    None of them gets lower than by `hanging`.
    """
    scene = surroundings.scene
    size = sum(g * g for g in scene.gravity) ** 0.5
    if size == 0.0:
        return (0.0, 0.0, 0.0)
    free = min(0.5 * size * scene.duration**2, farthest)
    x, y, z = (free * g / size for g in scene.gravity)
    if z < 0.0:
        floors = [floor for floor in surroundings.floors if floor < high[2]]
        below = [a[2] for a, _ in surroundings.solids if a[2] < low[2]]
        if floors or below:
            # All the way to a floor, even if the time is too short to get there.
            z = min((max(floors) if floors else min(below)) - low[2], 0.0)
    return (x, y, max(z, -hanging))


def _nearby(box: Bounds, surroundings: Surroundings, reach: float, margin: float) -> list[Bounds]:
    """Return what stands in a box, or nearer to it than the margin, clipped at `reach` around it.

    Otherwise the margin might end just behind the wall of a tank, and stop the water before it.
    """
    far = grown(box, reach)
    return [
        (_componentwise(max, a, far[0]), _componentwise(min, b, far[1]))
        for a, b in surroundings.solids
        if all(a[k] < box[1][k] + margin and b[k] > box[0][k] - margin for k in range(3))
    ]


def _box(displacement: Vec | None) -> Bounds:
    """Return the box around a displacement and its start."""
    return around([(0.0, 0.0, 0.0), displacement or (0.0, 0.0, 0.0)])


def _componentwise(choose: Callable[[float, float], float], a: Vec, b: Vec) -> Vec:
    return (choose(a[0], b[0]), choose(a[1], b[1]), choose(a[2], b[2]))
