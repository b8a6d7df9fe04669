"""Expectations for which the scene has not enough energy.

Where nothing but start velocities and gravity moves the bodies, their energy only gets less:

    E = sum (m v^2 / 2 + m g (z - ground) + spin)

counted from a level ground that none of them can get below. So no body is ever faster than sqrt(2 E / m), or higher
than `ground + E / (m g)`. For a single body that is its own fall and throw.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import dist, inf, sqrt

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.joints.mechanics import mechanics_of
from text2sim.lint.rule import Rule
from text2sim.lint.script.outcomes import asked_of, bound_of
from text2sim.lint.script.starts import norm, velocities_of
from text2sim.lint.script.values import subjects, values_of
from text2sim.spec_schema.errors import Problem

SPARE = 1.1
"""Contacts that push overlapping bodies apart, and rounding, may add a little."""


@dataclass(frozen=True)
class Budget:
    """What a scene has to spend."""

    energy: float
    """[J], all bodies at rest on the ground counting as none."""
    ground: float
    """Height [m]."""
    gravity: float
    """[m/s2]"""

    def speed(self, mass: float) -> float:
        """Largest speed [m/s] of a body, if it gets everything."""
        return sqrt(2 * SPARE * self.energy / mass)

    def height(self, mass: float) -> float:
        """Largest height [m] of its centre of mass."""
        return self.ground + SPARE * self.energy / (mass * self.gravity)


def _budget(facts: Facts) -> Budget | None:
    """The energy of a scene; None if something adds to it, or nothing bounds it from below."""
    gx, gy, gz = facts.plan.gravity
    if _adds_energy(facts) or gx or gy or gz >= 0.0 or facts.rows.welds:
        return None
    if any(is_soft(copy.model) for copy in facts.moving):
        return None  # they store it, and their solvers lose it
    levels = [ground for ground in facts.planes if ground.up[2] > 0.9999]
    if len(levels) != 1 or len(facts.planes) != 1:
        return None
    ground, mechanics = levels[0], mechanics_of(facts)
    energy, spread = 0.0, 0.0
    lightest = inf
    for copy in facts.moving:
        mass, box = facts.masses.get(copy.name), facts.box(copy)
        if not mass or box is None or box[0][2] < ground.level - 1e-3:
            return None
        center = copy.pos if facts.tree(copy) is None else mechanics.lump(copy).center
        energy += mass * -gz * (center[2] - ground.level) + _motion(facts, copy, mass, dist(*box))
        lightest = min(lightest, mass)
        spread = max(spread, ground.beside(copy.pos) + ground.half + dist(*box))
    if not facts.moving:
        return None
    # A body that comes to the edge of the ground falls off, and gains more.
    if spread + sqrt(2 * SPARE * energy / lightest) * facts.case.scene.duration > ground.half:
        return None
    return Budget(energy, ground.level, -gz)


def _adds_energy(facts: Facts) -> bool:
    """Whether anything but start velocities and gravity moves bodies."""
    plan = facts.plan
    if plan.drives or plan.wrenches or plan.prescribed or plan.contact or plan.motors or plan.changes:
        return True
    trees = facts.lowering.trees.values()
    return any(joint.spring > 0.0 for tree in trees for link in tree.links() for _, joint in link.all_joints())


def _motion(facts: Facts, copy: Copy, mass: float, size: float) -> float:
    # No part of it is farther from its centre than it is long.
    return sum(0.5 * mass * (norm(row.linear) + norm(row.angular) * size) ** 2 for row in velocities_of(facts, copy))


def _poor(facts: Facts) -> Iterator[Problem]:
    wanted = [
        (name, expect)
        for name, expect in facts.case.actions.expect.items()
        if expect.measure is not None and expect.above is not None
    ]
    if not wanted or (budget := _budget(facts)) is None:
        return
    for name, expect in wanted:
        measure = facts.case.actions.measures[expect.measure or ""]
        asked = asked_of(expect, facts.case.scene.duration)
        high = measure.kind == "position" and measure.axis == "z"
        if not high and measure.kind != "speed" or asked.stat in ("std", "range"):
            continue
        if measure.change_from is not None or getattr(measure, "stat", None) in ("count", "sum", "std", "range"):
            continue
        if values_of(facts, expect.measure or "").frozen:
            continue
        targets = subjects(facts, measure)
        masses = [facts.masses.get(target.copy.name, 0.0) if target.link is None else 0.0 for target in targets]
        if not masses or min(masses) <= 0.0:
            continue
        lightest = min(masses)
        most, unit = (budget.speed(lightest), "m/s") if not high else (budget.height(lightest), "m")
        if high:
            boxes = [box for target in targets if (box := facts.box(target.copy)) is not None]
            most += max((dist(*box) for box in boxes if facts.tree(targets[0].copy) is not None), default=1e-3)
        if asked.low > most:
            text = (
                f"`{expect.measure}` cannot get above {most:.3g} {unit}: all that moves has {budget.energy:.3g} J from "
                "where it starts, and nothing adds to it; start higher or faster, or ask for less"
            )
            yield facts.problem("too-little-energy", ("actions", "expect", name, bound_of(expect)), text)


_BALL = """\
scene: {duration: 1.5}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1.1]}}
actions:
  measures:
    speed: {kind: speed, of: ball}
  expect:
    is_fast: {measure: speed, during: [0.1, 1], stat: max, above: %s}
"""

RULES = (
    Rule(
        id="too-little-energy",
        severity="warning",
        title="An expectation for which the scene has not enough energy.",
        reason="""\
Without motors, forces or driven bodies the energy of a scene is that of its start: heights and start velocities. No
body gets faster than `sqrt(2 E / m)` or higher than `E / (m g)` above the ground, even if it gets all of it. A ball
that falls 1 m lands with 4.4 m/s.""",
        way_out="Start higher or faster, or ask for less.",
        example=_BALL % 6,
        mended=_BALL % 4,
        run=_poor,
    ),
)
