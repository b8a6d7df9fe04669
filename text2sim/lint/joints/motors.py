"""Motors with their loads and drives, for the rules about them.

The force of a motor in the engine (from `forward_dynamics.py`, and measured) is

    F = clamp(kp (target - q) + kv (target' - q'), -max_force, max_force)

where `kp` is the stiffness and `kv` the damping (kp = 0 for a velocity drive). Gravity is not compensated. The damping
of a position or velocity drive is integrated implicitly: it is added to the mass matrix as `h kv`, where `h` is the
substep, even if the force is limited. So a motor at its limit accelerates its load by at most F / (I + h kv). A motor
without a drive gives no force.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, sqrt

from text2sim.lint.facts import Facts, once_per_case
from text2sim.lint.joints.drives import Span, spans_of
from text2sim.lint.joints.linkage import Linkage
from text2sim.lint.joints.loaded_joint import LoadedJoint
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.spec_schema.text.document import Path

MAX_COPIES = 200
"""Most copies of a driven joint that are checked."""


@dataclass(frozen=True)
class Powered:
    """A driven joint whose load is known, its motor and its drives."""

    mechanics: Mechanics
    joint: LoadedJoint
    spans: tuple[Span, ...]
    stiffness: float
    damping: float
    limit: float
    """Largest force; infinite without a limit."""
    linkage: Linkage | None = None
    """What it moves, if it is closed by loops of its own."""

    @property
    def label(self) -> str:
        """The selector of the joint."""
        return self.mechanics.label(self.joint)

    @property
    def alone(self) -> bool:
        """Whether nothing else holds the load of the joint."""
        return not (self.joint.closed or self.joint.floating)

    @property
    def loaded(self) -> bool:
        """Whether the load of the joint is known: nothing else holds it, or only the loops of its linkage do."""
        return self.alone or self.linkage is not None

    def where(self, key: str) -> Path:
        """Return the path of a value of the motor, or of the motor if the case does not give the value."""
        places = (("actuator", key), ("actuator",), ())
        paths = (self.mechanics.where(self.joint, *place) for place in places)
        return self.mechanics.facts.first_path(*paths, ("bodies", self.joint.copy.body))

    def tolerances(self, kind: str) -> list[float]:
        """Return the tolerances of expectations on measures of that kind of the joint."""
        facts, found = self.mechanics.facts, []
        names = {self.label, self.label.replace(self.joint.copy.name, self.joint.copy.body, 1)}
        for expect in facts.case.actions.expect.values():
            measure = facts.case.actions.measures.get(expect.measure or "")
            if expect.tolerance is not None and measure is not None and measure.kind == kind:
                found += [expect.tolerance] if names & {*measure.subjects} else []
        return found

    def load(self, q: float) -> float:
        """Return the torque [N m] or force [N] of gravity and of the joint's spring at a position; of a linkage, too.

        0 where a linkage cannot get, or is free to move otherwise.
        """
        if self.linkage is not None:
            return self.linkage.load(q) or 0.0
        return self.joint.gravity(q) - self.joint.spec.spring * q

    def critical(self, stiffness: float) -> float:
        """Return the critical damping of a servo of that stiffness."""
        return 2 * sqrt(stiffness * self.joint.inertia)


@once_per_case
def powered(facts: Facts) -> list[Powered]:
    """Return every driven joint whose load is known; for copies with the same drives, the first.

    Of more than `MAX_COPIES` with different targets, an even sample is returned.
    """
    groups: dict[int, list[Powered]] = {}
    for motor in _all_powered(facts):
        groups.setdefault(id(motor.joint), []).append(motor)
    found = []
    for group in groups.values():
        step = max(1, -(-len(group) // MAX_COPIES))
        found += [*group[:-1:step], group[-1]]
    return found


def _all_powered(facts: Facts) -> Iterator[Powered]:
    mechanics, seen = facts.once(Mechanics), set()
    for (entity, name), spans in spans_of(facts).items():
        joint = mechanics.joint(facts.copies[entity], name)
        key = (id(joint), tuple((span.control, id(span.schedule)) for span in spans))
        if joint is None or joint.inertia <= 0.0 or key in seen:
            continue
        seen.add(key)
        motor = joint.motor
        stiffness, damping, limit = (motor.stiffness, motor.damping, motor.max_force) if motor else (0.0, 0.0, None)
        held = {other for (copy, other) in spans_of(facts) if copy == entity and other != name}
        linkage = mechanics.linkage(joint, held) if joint.closed else None
        yield Powered(mechanics, joint, tuple(spans), stiffness, damping, inf if limit is None else limit, linkage)
