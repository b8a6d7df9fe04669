"""Bodies of solvers that do not meet under the contact model of the scene."""

from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.lint.facts import Facts
from text2sim.lint.motion.whereabouts import whereabouts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, SoftFacts, soft_facts
from text2sim.spec_schema.errors import Problem

TOUCHING: dict[str, set[frozenset[str]]] = {
    "rigid": {frozenset(("mpm",)), frozenset(("pbd",))},
    "particle": {frozenset(pair) for pair in (("rigid", "mpm"), ("rigid", "pbd"), ("mpm", "pbd"), ("mpm",), ("pbd",))},
    "sap": {frozenset(pair) for pair in (("rigid", "fem"), ("fem",), ("mpm",), ("pbd",))},
    "ipc": {frozenset(pair) for pair in (("rigid", "fem"), ("rigid", "ipc"), ("fem", "ipc"), ("fem",), ("ipc",))}
    | {frozenset(("mpm",)), frozenset(("pbd",))},
}
"""Pairs of families that touch, by contact model: `rigid` and the solvers; a set of one is a solver with itself.

Of the engine's couplers, as their source has it (legacy, SAP, IPC). The legacy coupler also moves fem bodies by the
rigid bodies in which a corner of their surface lies, and the other way round; that is no contact to build on: a cube
of 0.15 kg fell through a beam of 290 vertices, and a ball sank 40 mm into the ground."""
MEETS = {
    frozenset(("rigid", "mpm")): "particle",
    frozenset(("rigid", "pbd")): "particle",
    frozenset(("mpm", "pbd")): "particle",
    frozenset(("rigid", "fem")): "sap",
    frozenset(("fem",)): "sap",
}
"""Contact model under which a pair does touch, where one does on every machine."""
STILL = ("sap", "ipc")
"""Contact models under which the grid of mpm is never moved: a block of jelly stayed where it was in the air."""
WORDS = {"mpm": "mpm bodies", "pbd": "cloth of solver pbd", "fem": "fem bodies", "ipc": "cloth of solver ipc"}


def _cloth_without_ipc(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    if soft.model == "ipc":
        return
    for name in _names(soft.of("ipc")):
        text = (
            f"`{name}` has solver ipc, but scene.contact.model is {soft.model}: the engine computes such cloth in its "
            "ipc coupler alone, and without it turns every point into nan without a word; leave scene.contact.model "
            "out, or set it to ipc (needs a CUDA device), or take `solver: pbd`"
        )
        yield facts.problem("cloth-without-ipc", facts.said(name, "solver"), text, key=True)


def _frozen(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    if soft.model not in STILL:
        return
    needs = next((b for b in soft.bodies if b.solver in ("fem", "ipc")), None)
    for name in _names(soft.of("mpm")):
        why = ""
        if facts.case.scene.contact.model is None and needs is not None:
            why = f", which `{needs.body}` (solver {needs.solver}) needs"
        text = (
            f"`{name}` has solver mpm, which stands still under contact model {soft.model}{why}: gravity and the "
            "motion of its grid are part of the engine's other coupler; "
        )
        if facts.case.bodies[name].kind == "soft":
            text += "give it `solver: fem`, or let nothing in the scene need another contact model than particle"
        else:
            text += "let nothing in the scene need another contact model than particle"
        yield facts.problem("mpm-stands-still", facts.said(name, "solver"), text, key=True)


def _no_contact(facts: Facts) -> Iterator[Problem]:
    """One finding for each body that deforms and each thing that it would pass through."""
    soft = soft_facts(facts)
    seen: set[tuple[str, str]] = set()
    for body in soft.bodies:
        if body.solver == "ipc" and soft.model != "ipc":
            continue  # reported already, and it has no other fault then
        if body.solver == "mpm" and soft.model in STILL:
            continue
        for other, family in _others(soft, body):
            if family == "mpm" and soft.model in STILL:
                continue
            if (body.body, other.body) in seen or frozenset((family, body.solver)) in TOUCHING[soft.model]:
                continue
            if not _could_meet(soft, body, other):
                continue
            seen |= {(body.body, other.body), (other.body, body.body)}
            yield _finding(facts, soft, body, other, family)


def _others(soft: SoftFacts, body: SoftBody) -> Iterator[tuple[Copy, str]]:
    for ground in soft.planes:
        yield ground.copy, "rigid"
    for copy in soft.rigid:
        yield copy, "rigid"
    found = False
    for other in soft.bodies:
        found = found or other is body
        if found and other is not body:
            yield other.copy, other.solver


def _could_meet(soft: SoftFacts, body: SoftBody, other: Copy) -> bool:
    for ground in soft.planes:
        if ground.copy is other:
            return soft.meets_plane(body, ground)
    return whereabouts(soft.facts).meet(body.copy, other)


def _finding(facts: Facts, soft: SoftFacts, body: SoftBody, other: Copy, family: str) -> Problem:
    model, pair = soft.model, frozenset((family, body.solver))
    sure = any(ground.copy is other for ground in soft.planes) or (
        soft.comes_down_on(body.copy, other) or soft.comes_down_on(other, body.copy)
    )
    what = WORDS[body.solver] if family in ("rigid", body.solver) else f"{WORDS[body.solver]} and {WORDS[family]}"
    whom = "rigid bodies" if family == "rigid" else "each other"
    text = f"`{body.name}` and `{other.name}` {'' if sure else 'may come to each other, but '}do not touch: "
    text += f"under contact model {model} {what} and {whom} pass through each other"
    text = text.replace(f"{what} and each other pass", f"{what} pass")
    said = facts.case.scene.contact.model is not None
    if not said and model in ("sap", "ipc"):
        needs = next(b for b in soft.bodies if b.solver == ("fem" if model == "sap" else "ipc"))
        text += f" (the model is {model} because `{needs.name}` has solver {needs.solver})"
    text += _way_out(soft, body, other, family, pair)
    where = facts.said(body.body, "solver")
    return facts.problem("no-contact", where, text, key=True, severity="error" if sure else "warning")


def _way_out(soft: SoftFacts, body: SoftBody, other: Copy, family: str, pair: frozenset[str]) -> str:
    needed = MEETS.get(pair)
    others = {b.solver for b in soft.bodies if b is not body}
    if needed == "sap" and not others & {"mpm", "pbd"}:
        way = "; `scene.contact.model: sap` lets them touch"
        return way + (", and `solver: mpm` with contact model particle does too" if body.model.kind == "soft" else "")
    if needed == "particle" and not others & {"fem", "ipc"}:
        return "; `scene.contact.model: particle` lets them touch"
    if body.solver == "fem" or family == "fem":
        return "; give the soft body `solver: mpm`: mpm bodies touch rigid bodies, cloth of solver pbd and each other"
    if body.model.kind == "cloth" and body.solver == "pbd" and soft.model == "ipc":
        return "; give this cloth `solver: ipc`, too"
    return "; let no body of the scene need another contact model than `particle`"


def _names(bodies: list[SoftBody]) -> list[str]:
    return list(dict.fromkeys(body.body for body in bodies))


RULES = (
    Rule(
        id="cloth-without-ipc",
        severity="error",
        title="A cloth of solver ipc in a scene without contact model ipc.",
        reason="""\
The engine's shells are computed by its ipc coupler. Without the coupler nothing computes them: the scene is built, and
steps, and every vertex is nan from the first step on, with no error.""",
        remedy="Leave `scene.contact.model` out, or set it to `ipc`; or take `solver: pbd`, which runs everywhere.",
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
        title="An mpm body under contact model sap or ipc.",
        reason="""\
The step in which the grid of the material point method gets its velocities, gravity among them, is part of the
engine's coupler of rigid bodies and particles. Sap and ipc are couplers that take its place and have no such step: a
block of jelly in the air over nothing stayed where it was for the whole run, while fem bodies and cloth beside it fell.
There is no error.""",
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
        title="Bodies of two solvers could meet, and would pass through each other.",
        reason="""\
Each family of bodies has its own solver, and the contact model says which of them touch. `particle`: rigid bodies with
mpm and pbd bodies, mpm with pbd. `sap`: rigid bodies with fem bodies, fem bodies with each other and themselves; cloth
of solver pbd feels nothing but itself. `ipc`: rigid bodies, cloth and fem bodies, all with all; cloth of solver pbd as
under `sap`. `rigid`: nothing that deforms. There is no contact between fem and pbd bodies under any model, and
fem bodies without sap or ipc only feel what a corner of their surface is in. Where one starts over the other it is an
error, where they may only come to each other a warning.""",
        remedy="""\
Choose the contact model that the message names, or solvers that go together: soft bodies of solver mpm and cloth of
solver pbd under `particle`; soft bodies of solver fem and rigid bodies under `sap`.""",
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
