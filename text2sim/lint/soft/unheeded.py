"""Contacts that solvers do not record, and material values that they ignore."""

import math
from collections.abc import Iterator

from text2sim.compiler.soft.settings import ELASTIC_SWEEPS, bending_step, elastic_step
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import REPLACING_CONTACT_MODELS, Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftFacts
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.bodies import Articulated, FreeMount, Rigid
from text2sim.spec_schema.models.events import ContactEvent, SeparationEvent
from text2sim.spec_schema.models.measures import ContactCount, ContactForce, Penetration
from text2sim.spec_schema.models.soft_bodies import Cloth
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.document import Path


def _no_records(facts: Facts) -> Iterator[Problem]:
    """Report measures and events of contacts between rigid bodies, which are not recorded."""
    soft = facts.once(SoftFacts)
    if soft.model not in REPLACING_CONTACT_MODELS:
        return
    actions = facts.case.actions
    for name, measure in actions.measures.items():
        if isinstance(measure, ContactForce | ContactCount | Penetration):
            sides = [side for side in (measure.subjects, listed(measure.by)) if side]
            if measure.kind == "penetration" and any(all(_soft(facts, one) for one in side) for side in sides):
                continue
            text = (
                f"{measure.kind} has no data: under contact model {soft.model} the engine reports no contacts of rigid "
                "bodies; measure a distance, a position or a `gap` instead"
            )
            yield facts.problem("unseen-contacts", ("actions", "measures", name, "kind"), text)
    for name, event in actions.events.items():
        if isinstance(event, ContactEvent | SeparationEvent) and not any(_soft(facts, side) for side in event.between):
            text = (
                f"this {event.kind} of rigid bodies is never found: under contact model {soft.model} the engine "
                "reports no contacts of rigid bodies; use a `threshold` of their distance"
            )
            yield facts.problem("unseen-contacts", ("actions", "events", name, "kind"), text)


def _soft(facts: Facts, selector: str) -> bool:
    return is_soft(facts.case.bodies.get(body_of(selector)))


IGNORED_FIELDS = {
    "pbd": (("poisson_ratio",), "youngs_modulus"),
    "ipc": (
        (
            "prestretch",
            "stretch_compliance",
            "bending_compliance",
            "crease_radius",
            "rest_shape",
            "damping",
            "air_resistance",
        ),
        "youngs_modulus and rigidity",
    ),
}
"""Values of a cloth's material that its solver ignores, and those that it uses instead."""


def _ignored(facts: Facts) -> Iterator[Problem]:
    """Report each material value that has no effect."""
    soft = facts.once(SoftFacts)
    for name, solver in {body.body: body.solver for body in soft.of("pbd", "ipc")}.items():
        model = facts.case.bodies[name]
        if not isinstance(model, Cloth):
            continue
        keys, instead = IGNORED_FIELDS[solver]
        for key in keys:
            where: Path = facts.where(name, "material", key)
            if facts.value_at(where) is not None:
                text = f"`{name}` has solver {solver}, which ignores {key}; use {instead}"
                yield facts.problem("unheeded-stuff", where, text, key=True)
        if solver == "pbd" and (rigidity := model.material.rigidity) is not None:
            yield from _rigidity(facts, name, model, rigidity)
        if solver == "pbd" and model.material.tension_modulus is not None:
            yield from _elasticity(facts, name, model)
        radius, cell = model.material.crease_radius, soft.scales.spacing(name, solver)
        if solver == "pbd" and radius is not None and math.pi * radius < cell:
            text = (
                f"no fold of `{name}` can be as tight as {radius:g} m with cells of {cell:g} m, so hardly one stays; "
                f"use {cell:g} m, or smaller cells"
            )
            yield facts.problem("unheeded-stuff", facts.where(name, "material", "crease_radius"), text)
    for name, solver in {body.body: body.solver for body in soft.of("fem", "ipc")}.items():
        for key, what in (("tear_stretch", "tears"), ("adhesion", "sticks")):
            where = facts.where(name, "material", key)
            if facts.value_at(where):
                text = f"`{name}` has solver {solver}, in which nothing {what}: {key} is ignored; use `solver: mpm`"
                yield facts.problem("unheeded-stuff", where, text, key=True)
    if soft.model in REPLACING_CONTACT_MODELS and not soft.bodies:
        text = (
            f"contact model {soft.model} is for scenes with deformable bodies; the bodies here touch as under `rigid`"
        )
        yield facts.problem("unheeded-stuff", ("scene", "contact", "model"), text)
    for name in (*facts.case.scene.statics, *facts.case.bodies):
        where = facts.where(name, "material", "restitution")
        if soft.model in REPLACING_CONTACT_MODELS and facts.value_at(where):
            text = f"restitution has no effect under contact model {soft.model}; leave it out"
            yield facts.problem("unheeded-stuff", where, text)
        where = facts.where(name, "material", "soft_reach")
        if not soft.of("mpm") and facts.value_at(where) is not None:
            text = "soft_reach is for bodies of solver mpm, and this scene has none; leave it out"
            yield facts.problem("unheeded-stuff", where, text, key=True)
    for name, body in facts.case.bodies.items():
        mount = body.mount if isinstance(body, Rigid) else None
        if soft.model == "ipc" and soft.bodies and isinstance(mount, FreeMount) and mount.damping:
            text = f"contact model ipc moves free bodies without damping, so `{name}` is not slowed; leave it out"
            yield facts.problem("unheeded-stuff", facts.where(name, "mount", "damping"), text, key=True)
        for link in (body.links or ()) if isinstance(body, Articulated) else ():
            # Under other contact models, rules of their own say what becomes of `touch_soft`.
            for key in ("soft_reach", *(("touch_soft",) if soft.model != "particle" else ())):
                where = facts.where(name, "links", link, "material", key)
                if facts.value_at(where) is not None:
                    text = f"{key} of a link is ignored: it holds for whole bodies; give it in `{name}`'s own material"
                    yield facts.problem("unheeded-stuff", where, text, key=True)


def _rigidity(facts: Facts, name: str, model: Cloth, rigidity: float) -> Iterator[Problem]:
    """Report a rigidity that the substeps do not reach, and a compliance beside it."""
    if model.material.bending_compliance is not None:
        where = facts.where(name, "material", "bending_compliance")
        text = f"`{name}` has a rigidity, which replaces this; leave it out"
        yield facts.problem("unheeded-stuff", where, text, key=True)
    cell, h = facts.once(SoftFacts).scales.spacing(name, "pbd"), facts.substep
    reached = (bending_step(model, cell) / h) ** 2
    if reached < MIN_REACHED_RIGIDITY:
        text = (
            f"in substeps of {h:.2g} s and with cells of {cell:.2g} m, `{name}` is about "
            f"{max(1, round(100 * reached))} % as stiff as that; "
            f"use `cell: {cell / reached**0.25:.2g}` or more, a rigid body, scene.substeps of "
            f"{math.ceil(facts.case.scene.dt / h / math.sqrt(reached))}, or a rigidity of {reached * rigidity:.2g}"
        )
        yield facts.problem("unheeded-stuff", facts.where(name, "material", "rigidity"), text, key=True)


def _elasticity(facts: Facts, name: str, model: Cloth) -> Iterator[Problem]:
    """Report a Young's modulus that the sweeps of its solver do not reach."""
    pbd = facts.settings.soft.pbd if facts.settings.soft is not None else None
    if pbd is None:
        return
    step, h = elastic_step(model, pbd.particle_size), facts.substep
    reached = pbd.stretch_iterations / ELASTIC_SWEEPS * (step / h) ** 2
    if reached < MIN_REACHED_ELASTICITY:
        text = (
            f"in substeps of {h:.2g} s, with {pbd.stretch_iterations} sweeps in cells of {pbd.particle_size:.2g} m, "
            f"`{name}` is about {max(1, round(100 * reached))} % as stiff as that; use scene.substeps of "
            f"{math.ceil(facts.case.scene.dt / h / math.sqrt(reached))}, or larger cells"
        )
        yield facts.problem("unheeded-stuff", facts.where(name, "material", "youngs_modulus"), text, key=True)


MIN_REACHED_RIGIDITY, MIN_REACHED_ELASTICITY = 0.5, 0.8
"""Parts of its rigidity and Young's modulus below which a sheet is reported to be softer."""
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
        title="A measure or event needs contacts of rigid bodies that the contact model does not report.",
        reason="""\
Contacts are recorded from the engine's rigid solver. Under sap and ipc another solver computes them, and the engine's
list stays empty: forces are 0, contacts never happen. Contacts with deformable bodies are found in the recorded points,
and work.""",
        remedy="Use a `threshold` of a `distance`, or the `gap` to a deformable body.",
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
        title="The solver ignores a value of a material, or a contact model has nothing to do.",
        reason="""\
Cloth of solver pbd has compliances in stretch and bending, in units of that method; cloth of solver ipc is an elastic
shell with a Poisson's ratio. Each ignores the values of the other; `youngs_modulus` and `rigidity` serve both, as far
as the sweeps of pbd reach. Where cells are large, no edge is bent enough for a small `crease_radius`. Only mpm bodies
use the `soft_reach` of rigid surfaces, which a body has as a whole, not each link. Restitution is made from the damping
of the engine's own rigid contacts, which contact models sap and ipc do not use; ipc moves free bodies without their
`damping`. These two are for scenes with deformable bodies; where all bodies are rigid, the engine's own contact solver
runs.""",
        remedy="Give the values that the solver uses, or leave the value out.",
        example=_RAG % "poisson_ratio: 0.4",
        fix="bodies: {rag: {material: {poisson_ratio: null, bending_compliance: 0.001}}}",
        run=_ignored,
    ),
)
