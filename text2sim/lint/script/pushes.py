"""Impulses, forces and start velocities that are disproportionate.

An impulse J gives a free body of mass m the speed J / m within one time step; a force F gives it F dt / m in each step.
A body that moves by more than its own length within a substep passes through others instead of hitting them. A run
stops as diverged as soon as anything is faster than `scene.max_speed`. A `point` far outside its body acts like a force
at the end of a rod.
"""

from collections.abc import Iterator
from math import ceil, dist, hypot, inf

from text2sim.compiler.action_rows import Wrench
from text2sim.compiler.shapes.boxes import sides, union
from text2sim.compiler.shapes.rotation import frame_apply
from text2sim.compiler.trees.tree import tree_links
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, one_per_place
from text2sim.lint.words import amount, length, vector
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.controls import Force, Impulse
from text2sim.spec_schema.rounding import at_least, at_most

MAX_POINT_DISTANCE = 0.1
"""Largest distance of a point from its body, as a share of its length."""


def _length(facts: Facts, entity: str) -> float:
    box = facts.box(facts.copies[entity])
    return max(sides(box)) if box is not None else inf


def _launched(facts: Facts) -> Iterator[Problem]:
    most = facts.plan.max_speed
    for row in facts.rows.velocities:
        if (speed := hypot(*row.linear)) > most:
            where = ("actions", "controls", row.control, "linear")
            text = (
                f"`{row.entity}` starts at {speed:.4g} m/s, and the run stops as diverged at scene.max_speed "
                f"({most:g} m/s); start it slower, or raise max_speed"
            )
            yield facts.problem("violent-push", where, text, severity="error")


def _pushed(facts: Facts) -> Iterator[Problem]:
    for row in facts.rows.wrenches:
        control = facts.case.actions.controls[row.control]
        mass = facts.masses.get(row.entity, 0.0)
        if mass <= 0.0 or row.link is not None or not facts.free(facts.copies[row.entity]):
            continue
        if isinstance(control, Impulse):
            yield from _impulse(facts, row, hypot(*row.force) / mass, mass)
        elif isinstance(control, Force) and row.end > row.start:
            yield from _force(facts, row, hypot(*row.force) / mass, mass)


def _impulse(facts: Facts, row: Wrench, speed: float, mass: float) -> Iterator[Problem]:
    h, most, size = facts.substep, facts.plan.max_speed, _length(facts, row.entity)
    where = ("actions", "controls", row.control, "impulse")
    gives = f"gives `{row.entity}` ({mass:.3g} kg) {speed:.4g} m/s at once"
    if speed > most:
        text = (
            f"{gives}, and the run stops as diverged at scene.max_speed ({most:g} m/s); use less, such as "
            f"{at_least(0.1 * most * mass)} N s for a tenth of that"
        )
        yield facts.problem("violent-push", where, text, severity="error")
    elif speed * h > size:
        text = (
            f"{gives}: {amount(speed * h, 'm')} per substep, more than its length ({amount(size, 'm')}), so it passes "
            f"through others; use at most {at_most(size / h * mass)} N s, or scene.substeps of "
            f"{ceil(facts.case.scene.dt * speed / size)}"
        )
        yield facts.problem("violent-push", where, text)


def _force(facts: Facts, row: Wrench, acceleration: float, mass: float) -> Iterator[Problem]:
    scene = facts.case.scene
    dt, h, size, most = scene.dt, facts.substep, _length(facts, row.entity), facts.plan.max_speed
    where = ("actions", "controls", row.control, "force")
    time = min(row.end, scene.duration) - row.start
    if acceleration * dt * h > size:
        text = (
            f"gives `{row.entity}` ({mass:.3g} kg) {acceleration * dt:.3g} m/s in each time step, so it jumps by more "
            f"than its length ({amount(size, 'm')}); use at most {at_most(size / (dt * h) * mass)} N"
        )
        yield facts.problem("violent-push", where, text)
    elif row.scale is None and acceleration * time > most:
        text = (
            f"gives `{row.entity}` ({mass:.3g} kg) {acceleration * time:.3g} m/s within {time:.3g} s unless something "
            f"holds it, and the run stops as diverged at scene.max_speed ({most:g} m/s); use at most "
            f"{at_most(most / time * mass)} N, or a shorter `during`"
        )
        yield facts.problem("violent-push", where, text)


def _off_body(facts: Facts) -> Iterator[Problem]:
    done = set()
    for row in facts.rows.wrenches:
        control = facts.case.actions.controls[row.control]
        if row.control in done or row.point is None or not isinstance(getattr(control, "point", None), tuple):
            continue
        copy = facts.copies[row.entity]
        pos, quat = copy.pos, copy.quat
        if row.link is not None and (tree := facts.tree(copy)) is not None:
            frames = {link.name: (pos, quat) for link, pos, quat, _ in tree_links(tree, copy.pos, copy.quat)}
            pos, quat = frames.get(row.link, (pos, quat))
        boxes = [part.box for part in facts.parts(copy) if row.link is None or part.link == row.link]
        if not boxes:
            continue
        box = union(boxes)
        point = frame_apply(pos, quat, row.point)
        off = dist(point, [min(max(c, low), high) for c, low, high in zip(point, *box, strict=True)])
        if off > MAX_POINT_DISTANCE * max(sides(box)):
            done.add(row.control)
            name = row.entity if row.link is None else f"{row.entity}.{row.link}"
            text = (
                f"{vector(row.point)} is {length(off)} away from `{name}`: the {control.kind} acts as if at the end of "
                "a rod; points are in metres, from the body's own origin (a region like `{face: left}` is on it)"
            )
            yield facts.problem("point-off-body", ("actions", "controls", row.control, "point"), text)


@one_per_place
def _violent(facts: Facts) -> Iterator[Problem]:
    yield from _launched(facts)
    yield from _pushed(facts)


_PUCK = """\
bodies:
  puck:
    kind: rigid
    shape: {kind: cylinder, radius: 0.04, height: 0.02}
    material: {mass: 0.1}
    pose: {pos: [0, 0, 0.05]}
actions:
  controls:
    hit: {kind: %s, body: puck, %s}
"""

RULES = (
    Rule(
        id="violent-push",
        title="An impulse, a force or a start velocity is disproportionate.",
        reason="""\
An impulse gives a free body `impulse / mass` at once, a force `force x dt / mass` in each time step. A body that then
moves by more than its own length per substep passes through others instead of hitting them. Anything faster than
`scene.max_speed` ends the run as diverged: if that is certain, it is an error.""",
        remedy="Match impulses and forces to the mass: a speed v takes an impulse of m v. Or use more substeps.",
        example=_PUCK % ("impulse", "impulse: [50, 0, 0], at: 0.1"),
        fix=_PUCK % ("impulse", "impulse: [0.3, 0, 0], at: 0.1"),
        run=_violent,
    ),
    Rule(
        id="point-off-body",
        title="A force or impulse acts at a point away from its body.",
        reason=f"""\
A `point` is relative to the body's own origin, in metres. One that is farther from the body than
{MAX_POINT_DISTANCE:.0%} of its length makes it spin as no push on its surface can.""",
        remedy="Give the point in the body's frame, or a region of it: `point: {edge: [left, top]}`.",
        example=_PUCK % ("impulse", "impulse: [0.1, 0, 0], at: 0.1, point: [0, 0.5, 0]"),
        fix=_PUCK % ("impulse", "impulse: [0.1, 0, 0], at: 0.1, point: [0, 0.04, 0]"),
        run=_off_body,
    ),
)
