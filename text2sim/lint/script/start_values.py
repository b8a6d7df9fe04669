"""Values of measures at the start, by their definitions (`evidence/measures.py`), if the case determines them."""

from collections.abc import Callable, Sequence
from math import dist, hypot, inf, sqrt
from statistics import pstdev
from typing import Any

from text2sim.compiler.action_rows import StartVelocity
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec, vector_dot, vector_unit
from text2sim.lint.facts import Facts
from text2sim.lint.script.targets import StartTarget, Targets
from text2sim.spec_schema.models.space import BoxRegion, SphereRegion

COLUMN = {"x": 0, "y": 1, "z": 2}
ROUNDING = 1e-4
"""Relative error of values at the start, because the engine uses single precision."""
MAX_DISTANCES = 10_000
"""Largest number of pairs of bodies whose distance is computed."""


def start_of(facts: Facts, measure: Any, targets: Sequence[StartTarget]) -> float | None:
    """Return the value of a measure in the first frame, before `change_from` is applied; None if it is not known.

    Args:
        facts: The case.
        measure: The measure.
        targets: Its targets.
    """
    if measure.kind in UNDEFORMED:
        return UNDEFORMED[measure.kind]
    if measure.kind == "volume" and measure.relative:
        return 1.0
    if not targets or any(target.driven or not target.known for target in targets):
        return None
    if measure.kind in _COLLECTIVE:
        return _COLLECTIVE[measure.kind](facts, measure, targets)
    if measure.kind not in _PER_TARGET:
        return None
    values = [_PER_TARGET[measure.kind](facts, measure, target) for target in targets]
    numbers = [value for value in values if value is not None]
    return _reduced(measure, numbers) if len(numbers) == len(values) else None


def value_at_rest(facts: Facts, measure: Any, targets: Sequence[StartTarget]) -> float | None:
    """Return the value of a measure while nothing moves; None if it is not known.

    Args:
        facts: The case.
        measure: The measure.
        targets: Its targets.
    """
    if not targets or any(not target.known for target in targets):
        return None
    value = measure.at_rest
    if value is None:
        return start_of(facts, measure, targets)
    of_each = measure.change_from is None and measure.so_far != "range" and "above" in type(measure).model_fields
    return _reduced(measure, [value] * len(targets)) if of_each else value


def _reduced(measure: Any, values: list[float]) -> float | None:
    if measure.stat == "count":
        above = -inf if measure.above is None else measure.above
        below = inf if measure.below is None else measure.below
        if any(min(abs(v - above), abs(v - below)) <= ROUNDING * max(1.0, abs(v)) for v in values):
            return None
        return float(sum(above < value < below for value in values))
    if measure.stat == "range":
        return max(values) - min(values)
    if measure.stat == "std":
        return pstdev(values)
    if measure.stat in ("sum", "mean"):
        return sum(values) / (len(values) if measure.stat == "mean" else 1)
    if measure.stat is None and len(values) > 1:
        return None
    return min(values) if measure.stat == "min" else max(values)


class _Rows(dict[str, list[StartVelocity]]):
    """Initial velocities by copy."""

    def __init__(self, facts: Facts) -> None:
        for row in facts.rows.velocities:
            self.setdefault(row.entity, []).append(row)


def _start_velocity(facts: Facts, copy: Copy) -> StartVelocity | None:
    """Return how a copy starts to move; None if that is not known: it has several start velocities, or of joints."""
    rows = facts.once(_Rows).get(copy.name, [])
    if len(rows) > 1 or copy.name in facts.lowering.joint_velocities:
        return None
    return rows[0] if rows else StartVelocity(copy.name, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0, "")


def velocity_at_start(facts: Facts, target: StartTarget) -> Vec | None:
    """Return the velocity of the centre of mass [m/s]; None if it is not known."""
    start, tree = _start_velocity(facts, target.copy), facts.tree(target.copy)
    several = tree is not None and len(tree.links()) > 1
    return None if start is None or (several and any(start.angular)) else start.linear


def spin_at_start(facts: Facts, target: StartTarget) -> float | None:
    """Return the angular speed [rad/s]; None if it is not known."""
    start = _start_velocity(facts, target.copy)
    return None if start is None else hypot(*start.angular)


def _angular_velocity(facts: Facts, measure: Any, target: StartTarget) -> float | None:
    start = _start_velocity(facts, target.copy)
    if start is None or (any(start.angular) and measure.frame != "world"):
        return None
    return start.angular[COLUMN[measure.axis]]


def _component(facts: Facts, measure: Any, target: StartTarget) -> float | None:
    velocity = velocity_at_start(facts, target)
    return None if velocity is None else velocity[COLUMN[measure.axis]]


def _speed(facts: Facts, measure: Any, target: StartTarget) -> float | None:
    velocity = velocity_at_start(facts, target)
    return None if velocity is None else hypot(*velocity)


def _extent(facts: Facts, measure: Any, targets: Sequence[StartTarget]) -> float | None:
    boxes = [facts.box(target.copy) if target.link is None else None for target in targets]
    known = [box for box in boxes if box is not None]
    if len(known) < len(boxes) or measure.region is not None or measure.frame is not None:
        return None
    column = COLUMN[measure.axis]
    low, high = min(box[0][column] for box in known), max(box[1][column] for box in known)
    return {"min": low, "max": high, "range": high - low}[measure.stat]


def _distance(facts: Facts, measure: Any, targets: Sequence[StartTarget]) -> float | None:
    pairs = facts.once(Targets).pairs(measure.between, MAX_DISTANCES) or ()
    return min((dist(a.origin, b.origin) for a, b in pairs), default=None)


def _count_in(facts: Facts, measure: Any, targets: Sequence[StartTarget]) -> float | None:
    depths = [depth_inside(measure.region, target.origin) for target in targets]
    return None if any(abs(depth) < 1e-5 for depth in depths) else float(sum(depth > 0 for depth in depths))


def _momentum(facts: Facts, measure: Any, targets: Sequence[StartTarget]) -> float | None:
    total = 0.0
    for target in targets:
        velocity, mass = velocity_at_start(facts, target), facts.masses.get(target.copy.name)
        if velocity is None or mass is None or target.link is not None:
            return None
        total += mass * velocity[COLUMN[measure.axis]]
    return total


def _energy(facts: Facts, measure: Any, targets: Sequence[StartTarget]) -> float | None:
    moved = any(velocity_at_start(facts, t) != (0.0, 0.0, 0.0) or spin_at_start(facts, t) != 0.0 for t in targets)
    return None if moved or measure.part != "kinetic" else 0.0


_PER_TARGET: dict[str, Callable[[Facts, Any, StartTarget], float | None]] = {
    "position": lambda facts, measure, target: target.origin[COLUMN[measure.axis]],
    "velocity": _component,
    "speed": _speed,
    "angular_speed": lambda facts, measure, target: spin_at_start(facts, target),
    "angular_velocity": _angular_velocity,
    "turns": lambda facts, measure, target: 0.0,
    "bend": lambda facts, measure, target: 0.0,
    "displacement": lambda facts, measure, target: 0.0,
    "tilt": lambda facts, measure, target: 0.0,
}
_COLLECTIVE: dict[str, Callable[[Facts, Any, Sequence[StartTarget]], float | None]] = {
    "extent": _extent,
    "distance": _distance,
    "count_in": _count_in,
    "momentum": _momentum,
    "energy": _energy,
}
UNDEFORMED = {"stretch": 1.0, "strain": 0.0}
"""Values of measures of deformation at the start."""


def depth_inside(region: Any, point: Vec) -> float:
    """Return how deep [m] a point is inside a region, negative outside; as in `recording.geometry.depth_inside`."""
    if isinstance(region, SphereRegion):
        return region.radius - dist(region.center, point)
    if isinstance(region, BoxRegion) or not hasattr(region, "axis"):
        sides = zip(region.min, point, region.max, strict=True)
        return min(min(p - low, high - p) for low, p, high in sides)
    axis = vector_unit(region.axis)
    offset = [p - c for p, c in zip(point, region.center, strict=True)]
    along = vector_dot(offset, axis)
    radial = sqrt(max(0.0, sum(o * o for o in offset) - along * along))
    return min(region.radius - radial, region.height / 2 - abs(along))
