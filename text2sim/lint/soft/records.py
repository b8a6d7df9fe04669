"""What the contact models sap and ipc leave out of rigid bodies: constraints, bounce, records of contacts."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import soft_facts
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import DEFORMABLE
from text2sim.spec_schema.models.events import ContactEvent, SeparationEvent
from text2sim.spec_schema.models.measures import ContactCount, ContactForce, Penetration
from text2sim.spec_schema.text.document import Path

OTHER = ("sap", "ipc")
"""Contact models whose rigid bodies touch by another solver than the engine's own."""
UPRIGHT = 1.0 - 1e-6


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


def _no_records(facts: Facts) -> Iterator[Problem]:
    """Measures and events of contacts between rigid bodies, of which nothing is recorded."""
    soft = soft_facts(facts)
    if soft.model not in OTHER:
        return
    actions = facts.case.actions
    for name, measure in actions.measures.items():
        if isinstance(measure, ContactForce | ContactCount | Penetration):
            sides = [side for side in (measure.of, measure.by) if side is not None]
            if measure.kind == "penetration" and any(_soft(facts, side) for side in sides):
                continue
            text = (
                f"{measure.kind} has nothing to count: under contact model {soft.model} the engine returns no contacts "
                "of rigid bodies; measure a distance, a position or a `gap` instead"
            )
            yield facts.problem("contacts-not-recorded", ("actions", "measures", name, "kind"), text)
    for name, event in actions.events.items():
        if isinstance(event, ContactEvent | SeparationEvent) and not any(_soft(facts, side) for side in event.between):
            text = (
                f"this {event.kind} of rigid bodies is never seen: under contact model {soft.model} the engine returns "
                "no contacts of theirs; take a `threshold` of their distance"
            )
            yield facts.problem("contacts-not-recorded", ("actions", "events", name, "kind"), text)


def _soft(facts: Facts, selector: str) -> bool:
    body = facts.case.bodies.get(selector.split("[")[0].split(".")[0])
    return getattr(body, "kind", None) in DEFORMABLE


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


_SAP = "contact model sap"
_WAY = "soft bodies of solver mpm with contact model particle need no sap"


def _bounce(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    if soft.model not in OTHER:
        return
    for name in (*facts.case.scene.statics, *facts.case.bodies):
        where: Path = facts.where(name, "material", "restitution")
        if facts.raw(where):
            text = f"nothing bounces by a restitution under contact model {soft.model}; leave it out"
            yield facts.problem("restitution-unused", where, text)


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
        way_out="Put a fixed box, turned and placed as the plane, in its place.",
        example=f"""\
scene: {{statics: {{floor: {{shape: {{kind: plane}}, pose: {{euler_deg: [0, 20, 0]}}}}}}}}
bodies:
{_SOFT_BAR}""",
        mended=f"""\
scene: {{statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
{_SOFT_BAR}""",
        run=_floor,
    ),
    Rule(
        id="contacts-not-recorded",
        severity="error",
        title="A measure or event of contacts between rigid bodies, under a contact model that returns none.",
        reason="""\
Contacts are recorded as the engine's rigid solver returns them. Under sap and ipc another solver finds them, and the
engine's list stays empty: a force of 0, a contact that never happens. Contact with a body that deforms is found in the
recorded points, and works.""",
        way_out="Ask for a `threshold` of a `distance`, or for the `gap` to a body that deforms.",
        example=f"""\
bodies:
{_SOFT_BAR}  {_BALL}}}
actions:
  events:
    lands: {{kind: contact, between: [ball, floor]}}
""",
        mended=f"""\
bodies:
{_SOFT_BAR}  {_BALL}}}
actions:
  measures:
    height: {{kind: position, of: ball, axis: z}}
  events:
    lands: {{kind: threshold, measure: height, below: 0.11}}
""",
        run=_no_records,
    ),
    Rule(
        id="sap-constraints",
        severity="error",
        title="Joint limits, dry friction, closed loops or attached rigid bodies under contact model sap.",
        reason="""\
Contact model sap takes the place of the engine's constraint solver, and knows contacts alone: limits of joints, dry
friction, `connect` loops (nets, closed linkages) and attached rigid bodies are left out without a word. Motors,
springs and the damping of joints work.""",
        way_out="Take soft bodies of solver mpm and contact model particle; or do without what is left out.",
        example=f"""\
bodies:
{_SOFT_BAR}  door:
    kind: rigid
    shape: {{kind: box, size: [0.4, 0.04, 0.8]}}
    pose: {{pos: [1, 0, 0.5]}}
    mount: {{kind: hinge, axis: z, range_deg: [-30, 30]}}
""",
        mended=f"""\
bodies:
{_SOFT_BAR}  door:
    kind: rigid
    shape: {{kind: box, size: [0.4, 0.04, 0.8]}}
    pose: {{pos: [1, 0, 0.5]}}
    mount: {{kind: hinge, axis: z}}
""",
        run=_left_out,
    ),
    Rule(
        id="restitution-unused",
        severity="warning",
        title="A restitution under a contact model that has none.",
        reason="""\
Restitution is made from the damping of the engine's own rigid contacts. Under sap and ipc contacts are another
solver's, which takes no notice of it.""",
        way_out="Leave `restitution` out.",
        example=f"""\
bodies:
{_SOFT_BAR}  {_BALL}, material: {{restitution: 0.8}}}}
""",
        mended=f"""\
bodies:
{_SOFT_BAR}  {_BALL}}}
""",
        run=_bounce,
    ),
)
