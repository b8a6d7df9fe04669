"""Rules about what solvers leave out.

Of rigid bodies under contact models sap and ipc: records of contacts, and bounce. Of cloth: the other solver's stuff.
"""

from collections.abc import Iterator

from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import soft_facts
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.events import ContactEvent, SeparationEvent
from text2sim.spec_schema.models.measures import ContactCount, ContactForce, Penetration
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.document import Path

OTHER = ("sap", "ipc")
"""Contact models whose rigid bodies touch by another solver than the engine's own."""


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
            yield facts.problem("unseen-contacts", ("actions", "measures", name, "kind"), text)
    for name, event in actions.events.items():
        if isinstance(event, ContactEvent | SeparationEvent) and not any(_soft(facts, side) for side in event.between):
            text = (
                f"this {event.kind} of rigid bodies is never seen: under contact model {soft.model} the engine returns "
                "no contacts of theirs; take a `threshold` of their distance"
            )
            yield facts.problem("unseen-contacts", ("actions", "events", name, "kind"), text)


def _soft(facts: Facts, selector: str) -> bool:
    body = facts.case.bodies.get(body_of(selector))
    return is_soft(body)


UNHEEDED = {
    "pbd": (("youngs_modulus", "poisson_ratio", "bending_stiffness"), "stretch_compliance and bending_compliance"),
    "ipc": (("stretch_compliance", "bending_compliance", "air_resistance"), "youngs_modulus and bending_stiffness"),
}
"""What the material of a cloth may say that its solver takes no notice of, and what it takes instead."""


def _stuff(facts: Facts) -> Iterator[Problem]:
    """One finding for each value that changes nothing."""
    soft = soft_facts(facts)
    seen = set()
    for body in soft.of("pbd", "ipc"):
        if body.model.kind != "cloth" or body.body in seen:
            continue
        seen.add(body.body)
        unheeded, instead = UNHEEDED[body.solver]
        for key in unheeded:
            where: Path = facts.where(body.body, "material", key)
            if facts.raw(where) is not None:
                text = f"`{body.body}` has solver {body.solver}, which takes no notice of {key}; it takes {instead}"
                yield facts.problem("unheeded-stuff", where, text, key=True)
    if soft.model in OTHER:
        for name in (*facts.case.scene.statics, *facts.case.bodies):
            where = facts.where(name, "material", "restitution")
            if facts.raw(where):
                text = f"nothing bounces by a restitution under contact model {soft.model}; leave it out"
                yield facts.problem("unheeded-stuff", where, text)
    if soft.of("mpm"):
        return
    for name in (*facts.case.scene.statics, *facts.case.bodies):
        where = facts.where(name, "material", "soft_reach")
        if facts.raw(where) is not None:
            text = "soft_reach is for bodies of solver mpm, which this scene has none of; leave it out"
            yield facts.problem("unheeded-stuff", where, text, key=True)


_BALL = "ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, 0.5]}"
_RAG = """\
bodies:
  rag: {kind: cloth, shape: {kind: sheet, size: [0.5, 0.5]}, material: {%s}, pose: {pos: [0, 0, 1]}}
"""
_SOFT_BAR = """\
  bar: {kind: soft, solver: fem, cell: 0.05, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.5]}}
"""

RULES = (
    Rule(
        id="unseen-contacts",
        severity="error",
        title="A measure or event of contacts between rigid bodies, under a contact model that returns none.",
        reason="""\
Contacts are recorded as the engine's rigid solver returns them. Under sap and ipc another solver finds them, and the
engine's list stays empty: a force of 0, a contact that never happens. Contact with a body that deforms is found in the
recorded points, and works.""",
        remedy="Ask for a `threshold` of a `distance`, or for the `gap` to a body that deforms.",
        example=f"""\
bodies:
{_SOFT_BAR}  {_BALL}}}
actions:
  events:
    lands: {{kind: contact, between: [ball, floor]}}
""",
        fix="""\
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  events: {lands: {between: null, kind: threshold, measure: height, below: 0.11}}
""",
        run=_no_records,
    ),
    Rule(
        id="unheeded-stuff",
        severity="warning",
        title="A value in a material that the solver takes no notice of.",
        reason="""\
Cloth of solver pbd knows how much its threads and folds give, in units of that method; cloth of solver ipc is an
elastic shell with a stiffness in Pa. Neither takes what is meant for the other, and nothing translates between
them. Only the grid of mpm bodies knows a reach of rigid surfaces. Restitution is made from the damping of the
engine's own rigid contacts, which contact models sap and ipc do not use.""",
        remedy="Give what the solver takes, or leave the value out.",
        example=_RAG % "youngs_modulus: 1.0e+6",
        fix="bodies: {rag: {material: {youngs_modulus: null, bending_compliance: 0.001}}}",
        run=_stuff,
    ),
)
