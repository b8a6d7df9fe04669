"""Motors, and what they are asked to do: what the rules about them share.

What the engine does with a motor (read in its `forward_dynamics.py`, and measured): its force is

    F = clamp(kp (target - q) + kv (target' - q'), -max_force, max_force)

with `kp` the stiffness and `kv` the damping (kp = 0 for a velocity drive). Gravity is not compensated. The damping of a
position or velocity drive is taken implicitly: it goes into the mass matrix as `h kv`, `h` being the substep, whether
or not the force is limited. So a motor at its limit accelerates its load by no more than F / (I + h kv). A motor that
nobody drives gives no force at all.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import ceil, floor, inf, log10, sqrt

from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import Span, spans_of
from text2sim.lint.joints.mechanics import Mechanics, mechanics_of
from text2sim.lint.joints.swing import Swing
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.text.document import Path

SOME = 200
"""As many copies of a driven joint are looked at."""


@dataclass(frozen=True)
class Powered:
    """A driven joint whose load is known, its motor and its drives."""

    mechanics: Mechanics
    swing: Swing
    spans: tuple[Span, ...]
    stiffness: float
    damping: float
    limit: float
    """Largest force; infinite if there is no limit."""

    @property
    def label(self) -> str:
        """How the case would name the joint."""
        return self.mechanics.label(self.swing)

    @property
    def alone(self) -> bool:
        """Whether nothing else carries or holds what the joint carries."""
        return not (self.swing.closed or self.swing.floating)

    def where(self, key: str) -> Path:
        """Return the path of a value of the motor, or of the motor where the case does not say the value."""
        for way in (("actuator", key), ("actuator",), ()):
            path = self.mechanics.where(self.swing, *way)
            if self.mechanics.facts.raw(path) is not None:
                return path
        return ("bodies", self.swing.copy.body)

    def tolerances(self, kind: str) -> list[float]:
        """Return the tolerances with which expectations look at measures of that kind of the joint."""
        facts, found = self.mechanics.facts, []
        names = {self.label, self.label.replace(self.swing.copy.name, self.swing.copy.body, 1)}
        for expect in facts.case.actions.expect.values():
            measure = facts.case.actions.measures.get(expect.measure or "")
            if expect.tolerance is not None and measure is not None and measure.kind == kind:
                found += [expect.tolerance] if getattr(measure, "of", None) in names else []
        return found

    def load(self, q: float) -> float:
        """Return the torque [N m] or force [N] of gravity and of the joint's own spring at a position."""
        return self.swing.gravity(q) - self.swing.joint.spring * q

    def critical(self, stiffness: float) -> float:
        """Return the damping with which a servo of that stiffness comes to rest soonest."""
        return 2 * sqrt(stiffness * self.swing.inertia)


def powered(facts: Facts) -> list[Powered]:
    """Return every driven joint whose load is known; of copies that are driven alike, the first.

    Of many copies with targets of their own, some are enough: those at the ends, and between.
    """
    return facts.own(_powered)


def _powered(facts: Facts) -> list[Powered]:
    groups: dict[int, list[Powered]] = {}
    for motor in _every(facts):
        groups.setdefault(id(motor.swing), []).append(motor)
    found = []
    for group in groups.values():
        steps = max(1, -(-len(group) // SOME))
        found += [*group[:-1:steps], group[-1]]
    return found


def _every(facts: Facts) -> Iterator[Powered]:
    mechanics, seen = mechanics_of(facts), set()
    for (entity, name), spans in spans_of(facts).items():
        swing = mechanics.swing(facts.copies[entity], name)
        key = (id(swing), tuple((span.control, id(span.schedule)) for span in spans))
        if swing is None or swing.inertia <= 0.0 or key in seen:
            continue
        seen.add(key)
        motor = swing.motor
        stiffness, damping, limit = (motor.stiffness, motor.damping, motor.max_force) if motor else (0.0, 0.0, None)
        yield Powered(mechanics, swing, tuple(spans), stiffness, damping, inf if limit is None else limit)


def one_each(problems: Iterable[Problem]) -> Iterator[Problem]:
    """Yield one finding for each place of the case, and say for how many copies it holds."""
    places: dict[tuple[str, str], list[Problem]] = {}
    for problem in problems:
        places.setdefault((problem.rule, problem.path), []).append(problem)
    for first, *more in places.values():
        note = f" (and in the same way {len(more)} more)" if more else ""
        yield replace(first, message=first.message + note)


def amount(value: float, unit: str) -> str:
    """Return a value with three digits and its unit; no exponent where a person would write none."""
    text = f"{float(f'{value:.3g}'):.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"
    return f"{text} {unit}".rstrip()


def at_least(value: float) -> str:
    """Return a value that is no smaller, with two digits."""
    if value <= 0.0:
        return "0"
    digit = 10.0 ** (floor(log10(value)) - 1)
    return f"{ceil(value / digit * (1 - 1e-9)) * digit:g}"
