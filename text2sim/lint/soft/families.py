"""Bodies of solvers that have no contact under the contact model of the scene."""

from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.lint.facts import Facts
from text2sim.lint.motion.whereabouts import Whereabouts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, SoftFacts
from text2sim.spec_schema.errors import Problem

TOUCHING_PAIRS: dict[str, set[frozenset[str]]] = {
    "rigid": {frozenset(("mpm",)), frozenset(("pbd",))},
    "particle": {frozenset(pair) for pair in (("rigid", "mpm"), ("rigid", "pbd"), ("mpm", "pbd"), ("mpm",), ("pbd",))},
    "sap": {frozenset(pair) for pair in (("rigid", "fem"), ("fem",), ("mpm",), ("pbd",))},
    "ipc": {frozenset(pair) for pair in (("rigid", "fem"), ("rigid", "ipc"), ("fem", "ipc"), ("fem",), ("ipc",))}
    | {frozenset(("mpm",)), frozenset(("pbd",))},
}
"""Pairs of families that have contact, by contact model: `rigid` and the solvers; a set of one is a solver with itself.

From the source of the engine's couplers (legacy, SAP, IPC). The legacy coupler also couples fem bodies with rigid
bodies that contain a vertex of their surface, but that contact is not reliable: a cube of 0.15 kg fell through a beam
of 290 vertices, and a ball sank 40 mm into the ground."""
CONTACT_MODEL_OF_PAIR = {
    frozenset(("rigid", "mpm")): "particle",
    frozenset(("rigid", "pbd")): "particle",
    frozenset(("mpm", "pbd")): "particle",
    frozenset(("rigid", "fem")): "sap",
    frozenset(("fem",)): "sap",
}
"""Contact model under which a pair has contact on every machine."""
MODELS_WITH_STILL_MPM = ("sap", "ipc")
"""Contact models under which the mpm grid does not move: a block of jelly stayed in the air."""
FAMILY_NAMES = {
    "rigid": "rigid bodies",
    "mpm": "mpm bodies",
    "pbd": "cloth of solver pbd",
    "fem": "fem bodies",
    "ipc": "cloth of solver ipc",
}


def _cloth_without_ipc(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    if soft.model == "ipc":
        return
    for name in _names(soft.of("ipc")):
        text = (
            f"`{name}` has solver ipc, but scene.contact.model is {soft.model}: the engine simulates such cloth only "
            "in its ipc coupler, and otherwise every point becomes nan without an error; leave scene.contact.model "
            "out, set it to ipc (needs a CUDA device), or use `solver: pbd`"
        )
        yield facts.problem("cloth-without-ipc", facts.first_given(name, "solver"), text, key=True)


def _frozen(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    if soft.model not in MODELS_WITH_STILL_MPM:
        return
    needs = next((b for b in soft.bodies if b.solver in ("fem", "ipc")), None)
    for name in _names(soft.of("mpm")):
        why = ""
        if facts.case.scene.contact.model is None and needs is not None:
            why = f", which `{needs.body}` (solver {needs.solver}) needs"
        text = (
            f"`{name}` has solver mpm, which does not move under contact model {soft.model}{why}: gravity and the "
            "motion of its grid are part of another coupler of the engine; "
            + ("give it `solver: fem`, or " if facts.case.bodies[name].kind == "soft" else "")
            + "use only bodies for contact model particle"
        )
        yield facts.problem("mpm-stands-still", facts.first_given(name, "solver"), text, key=True)


def _no_contact(facts: Facts) -> Iterator[Problem]:
    """Report each deformable body and each body that it would pass through once."""
    soft = facts.once(SoftFacts)
    seen: set[tuple[str, str]] = set()
    for body in soft.bodies:
        if body.solver == "ipc" and soft.model != "ipc" or body.solver == "mpm" and soft.model in MODELS_WITH_STILL_MPM:
            continue  # other rules report these
        for other, family in _possible_partners(soft, body):
            if family == "mpm" and soft.model in MODELS_WITH_STILL_MPM:
                continue
            if (body.body, other.body) in seen or frozenset((family, body.solver)) in TOUCHING_PAIRS[soft.model]:
                continue
            if not _could_meet(soft, body, other):
                continue
            seen |= {(body.body, other.body), (other.body, body.body)}
            yield _finding(facts, soft, body, other, family)


def _possible_partners(soft: SoftFacts, body: SoftBody) -> Iterator[tuple[Copy, str]]:
    for ground in soft.planes:
        yield ground.copy, "rigid"
    for copy in soft.rigid:
        yield copy, "rigid"
    for other in soft.bodies[soft.bodies.index(body) + 1 :]:
        yield other.copy, other.solver


def _could_meet(soft: SoftFacts, body: SoftBody, other: Copy) -> bool:
    if (ground := soft.facts.ground(other)) is not None:
        return soft.meets_plane(body, ground)
    return soft.facts.once(Whereabouts).meet(body.copy, other)


def _finding(facts: Facts, soft: SoftFacts, body: SoftBody, other: Copy, family: str) -> Problem:
    model = soft.model
    sure = facts.ground(other) is not None or (
        soft.comes_down_on(body.copy, other) or soft.comes_down_on(other, body.copy)
    )
    families = " and ".join(FAMILY_NAMES[name] for name in dict.fromkeys((body.solver, family)))
    text = (
        f"`{body.name}` and `{other.name}` {'have' if sure else 'may meet, but have'} no contact: under contact model "
        f"{model} {families} pass through each other"
    )
    if facts.case.scene.contact.model is None and model in ("sap", "ipc"):
        needs = next(b for b in soft.bodies if b.solver == ("fem" if model == "sap" else "ipc"))
        text += f" (the model is {model} because `{needs.name}` has solver {needs.solver})"
    text += f"; {_remedy(soft, body, family)}"
    where, severity = facts.first_given(body.body, "solver"), "error" if sure else "warning"
    return facts.problem("no-contact", where, text, key=True, severity=severity)


def _remedy(soft: SoftFacts, body: SoftBody, family: str) -> str:
    needed = CONTACT_MODEL_OF_PAIR.get(frozenset((family, body.solver)))
    others = {b.solver for b in soft.bodies if b is not body}
    if needed == "sap" and not others & {"mpm", "pbd"}:
        also = ", or `solver: mpm` with contact model particle" if body.model.kind == "soft" else ""
        return f"set `scene.contact.model: sap`{also}"
    if needed == "particle" and not others & {"fem", "ipc"}:
        return "set `scene.contact.model: particle`"
    if body.solver == "fem" or family == "fem":
        return "give the soft body `solver: mpm`, which has contact with rigid bodies, cloth of solver pbd and itself"
    if body.model.kind == "cloth" and body.solver == "pbd" and soft.model == "ipc":
        return "give this cloth `solver: ipc` too"
    return "use only bodies for contact model `particle`"


def _names(bodies: list[SoftBody]) -> list[str]:
    return list(dict.fromkeys(body.body for body in bodies))


RULES = (
    Rule(
        id="cloth-without-ipc",
        severity="error",
        title="A cloth of solver ipc is in a scene without contact model ipc.",
        reason="""\
The engine simulates its shells in the ipc coupler. Without it, the scene builds and steps, but every vertex is nan from
the first step, without an error.""",
        remedy="Leave `scene.contact.model` out, or set it to `ipc`; or use `solver: pbd`, which runs everywhere.",
        example="""\
scene: {contact: {model: particle}}
bodies:
  towel: {kind: cloth, solver: ipc, shape: {kind: sheet, size: [0.6, 0.4]}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {towel: {solver: pbd}}",
        run=_cloth_without_ipc,
    ),
    Rule(
        id="mpm-stands-still",
        severity="error",
        title="An mpm body is under contact model sap or ipc.",
        reason="""\
The step that updates the velocities of the mpm grid, including gravity, is part of the engine's coupler of rigid bodies
and particles. The couplers sap and ipc replace it and have no such step: a block of jelly stayed in the air for the
whole run, while fem bodies and cloth beside it fell. There is no error.""",
        remedy="Give soft bodies `solver: fem`; grains, liquids and snow need contact model particle.",
        example="""\
bodies:
  bar: {kind: soft, solver: fem, cell: 0.05, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.5]}}
  jelly: {kind: soft, solver: mpm, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [1, 0, 0.5]}}
""",
        fix="bodies: {jelly: {solver: fem, cell: 0.05}}",
        run=_frozen,
    ),
    Rule(
        id="no-contact",
        severity="error",
        title="Bodies of two solvers may meet and would pass through each other.",
        reason="""\
Each family of bodies has its own solver, and the contact model determines which of them have contact. `particle`: rigid
bodies with mpm and pbd bodies, mpm with pbd. `sap`: rigid bodies with fem bodies, fem bodies with each other and
themselves; cloth of solver pbd only with itself. `ipc`: rigid bodies, cloth and fem bodies, all with all; cloth of
solver pbd as under `sap`. `rigid`: no deformable bodies. There is no contact between fem and pbd bodies under any
model, and without sap or ipc, fem bodies only feel bodies that contain a vertex of their surface. It is an error if one
starts above the other, and a warning if they only may meet.""",
        remedy="""\
Use the contact model of the message, or solvers that work together: soft bodies of solver mpm and cloth of solver pbd
under `particle`; soft bodies of solver fem and rigid bodies under `sap`.""",
        example="""\
scene: {duration: 1.0}
bodies:
  jelly: {kind: soft, solver: fem, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.2]}}
  towel: {kind: cloth, solver: pbd, shape: {kind: sheet, size: [0.6, 0.4]}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {jelly: {solver: mpm}}",
        run=_no_contact,
    ),
)
