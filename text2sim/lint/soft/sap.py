"""Scenes that contact model sap does not support: several planes, constraints and overlaps."""

from collections.abc import Iterator

from text2sim.compiler.soft.solvers import touches_soft
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.start.escape import Effort, overlap_of, overlapping
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem

MIN_UPRIGHT_COSINE = 1.0 - 1e-6
MAX_LISTED = 4
"""Largest number of bodies that a message names."""
MIN_OVERLAP, STEP_BUDGET = 1e-3, 4000
"""Smallest depth [m] of an overlap, and budget for finding it."""


def _floor(facts: Facts) -> Iterator[Problem]:
    """Report planes other than the one level floor of sap."""
    soft = facts.once(SoftFacts)
    if soft.model != "sap":
        return
    level = [ground for ground in facts.planes if ground.up[2] > MIN_UPRIGHT_COSINE]
    highest = max((ground.level for ground in level), default=0.0)
    for ground in facts.planes:
        where = facts.first_given(ground.copy.body, "pose", "place", "shape")
        if ground.up[2] <= MIN_UPRIGHT_COSINE:
            text = (
                f"`{ground.copy.name}` is not level: contact model sap has one level floor and no other plane; replace "
                "it by a fixed box"
            )
            yield facts.problem("sap-floor", where, text, key=True)
        elif ground.level < highest - 1e-9:
            text = (
                f"`{ground.copy.name}` is lower than another plane: contact model sap has one floor for the whole "
                f"scene, at {highest:g} m; replace one of them by a fixed box"
            )
            yield facts.problem("sap-floor", where, text, key=True)


def _crash(facts: Facts) -> Iterator[Problem]:
    """Report rigid bodies that overlap at the start, which crash sap."""
    soft = facts.once(SoftFacts)
    if soft.model != "sap":
        return
    effort, seen = Effort(STEP_BUDGET), set()
    for a, b in facts.near(slack=MIN_OVERLAP):
        if (a.body, b.body) in seen:
            continue
        pairs = [(p, q) for p in facts.parts(a) for q in facts.parts(b) if effort.spend() and overlapping(p, q)]
        if not pairs or effort.left <= 0:
            continue
        overlap = overlap_of(facts.parts(a), facts.parts(b), pairs, effort)
        if overlap.depth < MIN_OVERLAP:
            continue
        seen.add((a.body, b.body))
        text = (
            f"`{a.name}` and `{b.name}` overlap by {length(overlap.depth)} at the start: under contact model sap the "
            "process crashes in the first step; move one, or use place"
        )
        mover = a if b.body in facts.case.scene.statics else b
        yield facts.problem("sap-overlap", facts.first_given(mover.body, "place", "pose", "repeat"), text, key=True)


def _left_out(facts: Facts) -> Iterator[Problem]:
    """Report constraints of the engine's own solver, which sap replaces."""
    soft = facts.once(SoftFacts)
    if soft.model != "sap":
        return
    for row in facts.rows.welds:
        if row.on:
            text = f"{_SAP} has no attachments of rigid bodies: `{row.a}` is not attached to `{row.b}`; {_REMEDY}"
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
            text = f"{_SAP} ignores {' and '.join(lost)} of `{name}`; {_REMEDY}"
            yield facts.problem("sap-constraints", facts.where(name), text, key=True)


def _touches_all(facts: Facts) -> Iterator[Problem]:
    """Report rigid bodies with `touch_soft: false`, which sap ignores."""
    if facts.once(SoftFacts).model != "sap":
        return
    models = facts.case.scene.statics | facts.case.bodies
    if names := [name for name, model in models.items() if not touches_soft(model)]:
        listed = ", ".join(f"`{name}`" for name in names[:MAX_LISTED])
        more = f" and {len(names) - MAX_LISTED} more" if len(names) > MAX_LISTED else ""
        text = f"{_SAP} ignores `touch_soft`: fem bodies touch {listed}{more} anyway; leave room between them"
        yield facts.problem("sap-touches-all", (*facts.where(names[0]), "material", "touch_soft"), text, key=True)


_SAP = "contact model sap"
_REMEDY = "use soft bodies of solver mpm with contact model particle"
_BALL = "ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, 0.5]}"
_SOFT_BAR = """\
  bar: {kind: soft, solver: fem, cell: 0.05, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.5]}}
"""

RULES = (
    Rule(
        id="sap-floor",
        severity="error",
        title="Contact model sap does not support a plane.",
        reason="""\
The sap coupler refuses planes and has its own floor instead: one per scene, level and infinite. It is at the height of
the highest level plane; bodies fall through all others.""",
        remedy="Replace it by a fixed box with the pose of the plane.",
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
Under sap, bodies that overlap at the start crash the process: two boxes of 100 mm, 40 mm inside each other, made the
engine access invalid memory in the trial step that builds a scene. One above the other they run.""",
        remedy="Move one of them, or place it with `place: {on: …}`.",
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
Contact model sap replaces the engine's constraint solver and only has contacts: it ignores joint limits, dry friction,
`connect` loops (nets, closed linkages) and attached rigid bodies without an error. Motors, springs and the damping of
joints work.""",
        remedy="Use soft bodies of solver mpm and contact model particle; or remove the constraints.",
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
        title="Contact model sap ignores `touch_soft: false`.",
        reason="""\
The sap coupler includes every rigid shape, whatever `material.touch_soft` is: a hook pushes the soft body that it
holds.""",
        remedy="Leave `touch_soft` out and room between the bodies; or use soft bodies of solver mpm.",
        example=f"""\
bodies:
{_SOFT_BAR}  {_BALL}, material: {{touch_soft: false}}}}
""",
        fix="bodies: {ball: {material: null}}",
        run=_touches_all,
    ),
)
