"""Rules about contact model sap: rigid bodies get one floor, no constraints, no overlaps."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import soft_facts, touches_soft
from text2sim.lint.start.escape import Effort, inside, overlap_of
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem

UPRIGHT = 1.0 - 1e-6
LEAST, STEPS = 1e-3, 4000
"""Depth [m] of an overlap that counts, and steps for finding it."""


def _floor(facts: Facts) -> Iterator[Problem]:
    """Planes that are not the one level floor that sap knows."""
    soft = soft_facts(facts)
    if soft.model != "sap":
        return
    level = [ground for ground in facts.planes if ground.up[2] > UPRIGHT]
    highest = max((ground.level for ground in level), default=0.0)
    for ground in facts.planes:
        where = facts.said(ground.copy.body, "pose", "place", "shape")
        if ground.up[2] <= UPRIGHT:
            text = (
                f"`{ground.copy.name}` is not level: contact model sap knows one floor, at one height, and no other "
                "plane; put a fixed box in its place"
            )
            yield facts.problem("sap-floor", where, text, key=True)
        elif ground.level < highest - 1e-9:
            text = (
                f"`{ground.copy.name}` lies lower than another plane: contact model sap has one floor for the whole "
                f"scene, at {highest:g} m; put a fixed box in place of one of them"
            )
            yield facts.problem("sap-floor", where, text, key=True)


def _crash(facts: Facts) -> Iterator[Problem]:
    """Rigid bodies that overlap at the start: sap ends the process."""
    soft = soft_facts(facts)
    if soft.model != "sap":
        return
    effort, seen = Effort(STEPS), set()
    for a, b in facts.near(slack=LEAST):
        if (a.body, b.body) in seen:
            continue
        pairs = [(p, q) for p in facts.parts(a) for q in facts.parts(b) if effort.spend() and inside(p, q)]
        if not pairs or effort.left <= 0:
            continue
        overlap = overlap_of(facts.parts(a), facts.parts(b), pairs, effort)
        if overlap.depth < LEAST:
            continue
        seen.add((a.body, b.body))
        text = (
            f"`{a.name}` and `{b.name}` overlap by {length(overlap.depth)} at the start: under contact model sap the "
            "engine crashes in its first step, and takes the process along; move one, or use place"
        )
        mover = a if b.body in facts.case.scene.statics else b
        yield facts.problem("sap-overlap", facts.said(mover.body, "place", "pose", "repeat"), text, key=True)


def _left_out(facts: Facts) -> Iterator[Problem]:
    """What holds rigid bodies by the engine's constraint solver, which sap takes the place of."""
    soft = soft_facts(facts)
    if soft.model != "sap":
        return
    for row in facts.rows.welds:
        if row.on:
            text = f"{_SAP} holds no rigid bodies together: `{row.a}` is not attached to `{row.b}`; {_WAY}"
            yield facts.problem("sap-constraints", ("actions", "controls", row.control), text, key=True)
    for name in facts.case.bodies:
        tree = facts.tree(facts.placed[name][0]) if facts.placed[name] else None
        if tree is None:
            continue
        joints = [joint for link in tree.links() for _, joint in link.all_joints()]
        lost = [
            word
            for word, found in (
                ("closed loops", bool(tree.loops)),
                ("the limits of joints", any(joint.range is not None for joint in joints)),
                ("dry friction in joints", any(joint.friction > 0.0 for joint in joints)),
            )
            if found
        ]
        if lost:
            text = f"{_SAP} leaves out {' and '.join(lost)} of `{name}`; {_WAY}"
            yield facts.problem("sap-constraints", facts.where(name), text, key=True)


def _touches_all(facts: Facts) -> Iterator[Problem]:
    """Rigid bodies that soft ones are not to feel, which sap does not know."""
    if soft_facts(facts).model != "sap":
        return
    for name, model in (facts.case.scene.statics | facts.case.bodies).items():
        if not touches_soft(model):
            text = f"{_SAP} has no `touch_soft`: fem bodies touch `{name}` all the same; leave room between them"
            yield facts.problem("sap-touches-all", (*facts.where(name), "material", "touch_soft"), text, key=True)


_SAP = "contact model sap"
_WAY = "soft bodies of solver mpm with contact model particle need no sap"
_BALL = "ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, 0.5]}"
_SOFT_BAR = """\
  bar: {kind: soft, solver: fem, cell: 0.05, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.5]}}
"""

RULES = (
    Rule(
        id="sap-floor",
        severity="error",
        title="A plane that contact model sap does not know.",
        reason="""\
The sap coupler refuses planes and has a floor of its own instead: level, endless, one in a scene. It stands where the
highest level plane is; through all others bodies fall.""",
        remedy="Put a fixed box, turned and placed as the plane, in its place.",
        example=f"""\
scene: {{statics: {{floor: {{shape: {{kind: plane}}, pose: {{euler_deg: [0, 20, 0]}}}}}}}}
bodies:
{_SOFT_BAR}""",
        fix="scene: {statics: {floor: {pose: null}}}",
        run=_floor,
    ),
    Rule(
        id="sap-overlap",
        severity="error",
        title="Rigid bodies overlap at the start under contact model sap.",
        reason="""\
Under sap, what overlaps at the start ends the process: two boxes of 100 mm, 40 mm inside each other, made the engine
read memory that is not its own in the trial step with which it builds a scene. One above the other they run.""",
        remedy="Move one of them, or say where it is with `place: {on: …}`.",
        example=f"""\
bodies:
{_SOFT_BAR}  {_BALL}}}
  box: {{kind: rigid, shape: {{kind: box, size: [0.2, 0.2, 0.2]}}, pose: {{pos: [1.1, 0, 0.4]}}}}
""",
        fix="bodies: {box: {pose: {pos: [1.3, 0, 0.4]}}}",
        run=_crash,
    ),
    Rule(
        id="sap-constraints",
        severity="error",
        title="Joint limits, dry friction, closed loops or attached rigid bodies under contact model sap.",
        reason="""\
Contact model sap takes the place of the engine's constraint solver, and knows contacts alone: limits of joints, dry
friction, `connect` loops (nets, closed linkages) and attached rigid bodies are left out without a word. Motors,
springs and the damping of joints work.""",
        remedy="Take soft bodies of solver mpm and contact model particle; or do without what is left out.",
        example=f"""\
bodies:
{_SOFT_BAR}  door:
    kind: rigid
    shape: {{kind: box, size: [0.4, 0.04, 0.8]}}
    pose: {{pos: [1, 0, 0.5]}}
    mount: {{kind: hinge, axis: z, range_deg: [-30, 30]}}
""",
        fix="bodies: {door: {mount: {range_deg: null}}}",
        run=_left_out,
    ),
    Rule(
        id="sap-touches-all",
        severity="warning",
        title="A body that soft ones are not to touch, under contact model sap.",
        reason="""\
The sap coupler takes every rigid shape into account, whatever `material.touch_soft` says: a hook that only holds pushes
what it holds.""",
        remedy="Leave `touch_soft` out and room between the bodies; or take soft bodies of solver mpm.",
        example=f"""\
bodies:
{_SOFT_BAR}  {_BALL}, material: {{touch_soft: false}}}}
""",
        fix="bodies: {ball: {material: null}}",
        run=_touches_all,
    ),
)
