"""Bounds on measures, by their definitions (`evidence/measures.py`), and their values at the start.

Bounds come from definitions (a speed is not negative, a tilt is at most 180 degrees, at most n of n copies count), from
limits that the engine enforces (a motor's largest force, `scene.max_speed`, at which a run stops), and from the reach
of held bodies. Ranges of joints are soft and get a margin of a tenth.
"""

from dataclasses import dataclass, replace
from math import dist, inf
from typing import Any

from text2sim.compiler.shapes.boxes import sides
from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import spans_of
from text2sim.lint.joints.loaded_joint import LoadedJoint
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.motion.reach import LinkReach
from text2sim.lint.script.start_values import COLUMN, ROUNDING, start_of
from text2sim.lint.script.targets import StartTarget, Targets
from text2sim.spec_schema.models import measures
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.placed import Deformable
from text2sim.spec_schema.names.measure_references import CONTACT_KINDS, PAIRS
from text2sim.spec_schema.names.selectors import quoted

JOINT_MEASURES = ("joint_position", "joint_velocity", "joint_force")
ROUND_SHORTFALL = 0.02
"""Share of its size by which the engine's mesh of a round shape may be smaller."""

Bounds = tuple[float, float, str]
"""Lowest and highest value, and why."""
UNBOUNDED: Bounds = (-inf, inf, "")
A_SHARE: Bounds = (0.0, 1.0, "a share is 0 to 1")
BOUNDS_OF_KIND: dict[str, Bounds] = {
    "tilt": (0.0, 180.0, "a tilt is 0 to 180 deg"),
    "share_in": A_SHARE,
    "largest_piece": A_SHARE,
    "leaked": A_SHARE,
    "submerged": A_SHARE,
    "stretch": (1e-6, inf, "it is a ratio of lengths, and 1 is unstretched"),
}


@dataclass(frozen=True)
class Values:
    """Possible values of a measure before the run."""

    low: float = -inf
    high: float = inf
    """Lowest and highest possible value."""
    why: str = ""
    """Reason for the bounds."""
    start: float | None = None
    """Value at the start; None if it is not known."""
    error: float = 0.0
    """Error of that value."""
    frozen: str = ""
    """Why it never changes; empty if it may."""
    unit: str = ""


class _Known(dict[str, Values]):
    def __init__(self, facts: Facts) -> None:
        self.facts = facts

    def __missing__(self, name: str) -> Values:
        measure = self.facts.case.actions.measures[name]
        values = _changes(_values(self.facts, measure), measure.change_from)
        if measure.so_far == "range":
            values = replace(values, low=0.0, high=values.high - values.low, start=0.0)
        self[name] = values
        return self[name]


def _changes(values: Values, since: str | float | None) -> Values:
    """Return the values of the change of a measure since the start or a time, from the values of the measure."""
    if since is None:
        return values
    if values.frozen:
        return replace(values, low=0.0, high=0.0, start=0.0)
    if since == "start" and values.start is not None:
        return replace(values, low=values.low - values.start, high=values.high - values.start, start=0.0)
    width = values.high - values.low
    return replace(values, low=-width, high=width, start=0.0 if since in ("start", 0.0) else None)


def values_of(facts: Facts, name: str) -> Values:
    """Return the possible values of a measure of the case."""
    return facts.once(_Known)[name]


def subjects(facts: Facts, measure: Any) -> list[StartTarget]:
    """Return the targets of a measure."""
    found = facts.once(Targets)
    if measure.kind in PAIRS:
        return [t for name in measure.measures for t in subjects(facts, facts.case.actions.measures[name])]
    if isinstance(measure, measures.Threaded | measures.Submerged):
        return found.select([*measure.subjects, *listed(measure.by)])
    if isinstance(measure, measures.Distance):
        return [target for selector in measure.between for target in found.select(selector)]
    if isinstance(measure, measures.SpringForce):
        spring: Any = facts.case.actions.controls[measure.spring]
        return found.select([spring.body, spring.to])
    if measure.of is None:
        return [target for name in facts.case.bodies for target in found.select(name) if not target.driven]
    return found.select(measure.of)


def _of_two(facts: Facts, pair: Any) -> Values:
    """Return the values of a difference, from those of its measures; of a ratio, only that at the start."""
    a, b = (values_of(facts, name) for name in pair.measures)
    if pair.kind == "difference":
        start = a.start - b.start if a.start is not None and b.start is not None else None
        named = zip(pair.measures, (a.why, b.why), strict=True)
        parts = (f"`{name}` ({why})" if why else f"`{name}`" for name, why in named)
        why = f"it follows from the bounds of {' and '.join(parts)}"
        return Values(a.low - b.high, a.high - b.low, why, start, a.error + b.error, unit=a.unit)
    if a.start is None or b.start is None or abs(b.start) <= b.error:
        return Values()
    start = a.start / b.start
    return Values(start=start, error=(a.error + abs(start) * b.error) / abs(b.start))


def _values(facts: Facts, measure: Any) -> Values:
    if measure.kind in PAIRS:
        return _of_two(facts, measure)
    targets = subjects(facts, measure)
    if not targets:
        return Values()
    if measure.kind in JOINT_MEASURES:
        return _of_joints(facts, measure, targets)
    stat = None if measure.kind == "extent" else getattr(measure, "stat", None)
    low, high, why = _reduced(facts, measure, targets, stat)
    start = start_of(facts, measure, targets)
    frozen = _frozen(measure, targets)
    if frozen and start is not None:
        low, high, why = start, start, frozen
    error = ROUNDING * max(1.0, abs(start or 0.0))
    if measure.kind == "extent":
        boxes = (facts.box(target.copy) for target in targets)
        error += ROUND_SHORTFALL * max((max(sides(box)) for box in boxes if box is not None), default=0.0)
    return Values(low, high, why, start, error, frozen, measure.value_unit)


def _reduced(facts: Facts, measure: Any, targets: list[StartTarget], stat: str | None) -> Bounds:
    low, high, why = _of_one(facts, measure, targets)
    if stat == "count":
        return 0.0, float(len(targets)), _number_in_words(measure, targets)
    if stat == "range":
        return 0.0, high - low, "a range is not negative"
    if stat == "std":
        return 0.0, (high - low) / 2, "a standard deviation is not negative, and at most half of the range"
    if stat == "sum":
        return low * len(targets), high * len(targets), why
    return low, high, why


def _number_in_words(measure: Any, targets: list[StartTarget]) -> str:
    verb = "selects" if len(measure.subjects) == 1 else "select"
    return f"{quoted(measure.subjects)} {verb} {len(targets)}"


def _of_one(facts: Facts, measure: Any, targets: list[StartTarget]) -> Bounds:
    kind, fastest = measure.kind, facts.plan.max_speed
    if kind == "velocity":
        return -fastest, fastest, f"the run stops at scene.max_speed ({fastest:g} m/s)"
    if kind == "speed":
        return 0.0, fastest, f"a speed is not negative, and the run stops at scene.max_speed ({fastest:g} m/s)"
    if kind in BOUNDS_OF_KIND:
        return BOUNDS_OF_KIND[kind]
    if kind == "threaded":
        targets = facts.once(Targets).select(measure.of)
    if kind in ("count_in", "threaded"):
        return 0.0, float(len(targets)), _number_in_words(measure, targets)
    if kind == "pieces":
        tearing = sum(isinstance(target.copy.model, Deformable) for target in targets)
        # Bonds may join all rigid ones.
        least = tearing + (len(targets) > tearing)
        return float(least), inf if tearing else float(len(targets)), f"there are {len(targets)} bodies"
    if kind == "contact_count" and measure.by is not None:
        pairs = len(targets) * len(facts.once(Targets).select(measure.by))
        return 0.0, float(pairs), f"there are {pairs} pairs"
    moving_frame = getattr(measure, "frame", None) is not None
    if kind == "position" or (kind == "displacement" and measure.axis is not None and not moving_frame):
        return _coordinate_bounds(facts, measure, targets)
    if kind == "displacement" and not moving_frame:
        return _distance_bounds(facts, targets)
    kinetic, width = kind == "energy" and measure.part == "kinetic", kind == "extent" and measure.stat == "range"
    size = kind == "contact_force" and measure.axis is None
    positive = measure.traits.never_negative or kinetic or width or size
    return (0.0, inf, "it is not negative") if positive else UNBOUNDED


def _coordinate_bounds(facts: Facts, measure: Any, targets: list[StartTarget]) -> Bounds:
    """Return the bounds on a coordinate or its change, from the reach of a body."""
    reach, column = facts.once(LinkReach), COLUMN[measure.axis]
    low, high = inf, -inf
    for target in targets:
        ball = reach.origin(target.copy, target.link) if target.known else None
        if ball is None:
            return UNBOUNDED
        since = target.origin[column] if measure.kind == "displacement" else 0.0
        low, high = min(low, ball[0][column] - ball[1] - since), max(high, ball[0][column] + ball[1] - since)
    return low, high, "its joints or its mount let it move no farther"


def _distance_bounds(facts: Facts, targets: list[StartTarget]) -> Bounds:
    reach, high = facts.once(LinkReach), 0.0
    for target in targets:
        ball = reach.origin(target.copy, target.link) if target.known else None
        if ball is None:
            return 0.0, inf, "it is not negative"
        high = max(high, dist(ball[0], target.origin) + ball[1])
    return 0.0, high, "it is not negative, and its joints or its mount let it move no farther"


def _frozen(measure: Any, targets: list[StartTarget]) -> str:
    """Return why a measure never changes; empty if it may."""
    if measure.kind in CONTACT_KINDS or any(target.driven for target in targets):
        return ""
    if measure.kind in ("extent", "displacement") and measure.frame is not None:
        return ""
    if any(target.frame_moves if measure.traits.of_root else target.moves for target in targets):
        return ""
    first = targets[0]
    if first.moves:
        return f"the frame of `{first.label}` is that of its root link, which is fixed; name one of its links"
    return f"`{first.label}` never moves"


# --- joints --------------------------------------------------------------------------------------------------------


def _of_joints(facts: Facts, measure: Any, targets: list[StartTarget]) -> Values:
    mechanics = facts.once(Mechanics)
    found = [mechanics.joint(target.copy, target.link or target.copy.body) for target in targets]
    joints = [joint for joint in found if joint is not None]
    if len(joints) < len(found) or measure.stat in ("count", "sum", "std", "range"):
        return Values()
    unit, force = joints[0].units
    ranges = [joint.spec.range for joint in joints]
    locked = all(limits is not None and limits[0] == limits[1] for limits in ranges)
    frozen = "its range does not let it move" if locked else ""
    if measure.kind == "joint_force":
        return _of_motor(facts, targets, joints, force)
    if measure.kind == "joint_velocity":
        speeds = {joint.spec.velocity for joint in joints}
        return Values(start=speeds.pop() if len(speeds) == 1 else None, error=ROUNDING, frozen=frozen, unit=f"{unit}/s")
    starts = {joint.start for joint in joints}
    start = starts.pop() if len(starts) == 1 else None
    low, high, why = UNBOUNDED
    if (limits := [limits for limits in ranges if limits is not None]) and len(limits) == len(ranges):
        least, most = min(a for a, _ in limits), max(b for _, b in limits)
        slack = 0.1 * (most - least) + 0.005
        low, high, why = least - slack, most + slack, f"its range is {least:.4g} to {most:.4g} {unit}"
    return Values(low, high, why, start, ROUNDING, frozen, unit)


def _of_motor(facts: Facts, targets: list[StartTarget], joints: list[LoadedJoint], unit: str) -> Values:
    driven = spans_of(facts)
    file = any(getattr(target.copy.model, "file", None) is not None for target in targets)
    if not file and not any((t.copy.name, t.link or t.copy.body) in driven for t in targets):
        why = "no control drives this joint, so its motor gives no force"
        return Values(0.0, 0.0, why, 0.0, ROUNDING, why, unit)
    limits = [joint.motor.max_force if joint.motor is not None else None for joint in joints]
    most = max((limit for limit in limits if limit is not None), default=inf)
    if any(limit is None for limit in limits):
        return Values(unit=unit)
    return Values(-most * (1 + ROUNDING), most * (1 + ROUNDING), f"its motor gives at most {most:g} {unit}", unit=unit)
