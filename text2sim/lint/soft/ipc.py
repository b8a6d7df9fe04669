"""Rules about what contact model ipc refuses or ignores."""

from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.shapes.sagging import SHEET
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftFacts, soft_facts, touches_soft
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.start.escape import inside
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of

SAFE = 1e-4
"""Gap [m] besides the thickness of cloth that the check of libuipc surely takes for one."""
PAIRS = 2000
"""Pairs of links of one body that are tested."""


def _clearance(facts: Facts) -> Iterator[Problem]:
    """Bodies that touch at the start: libuipc's own check of the scene stops there."""
    soft = soft_facts(facts)
    if soft.model != "ipc":
        return
    gaps = Gaps(facts)
    coupled = [copy for copy in facts.copies.values() if _coupled(facts, soft, copy)]
    found: dict[tuple[str, str], tuple[float, float, Copy, Copy, int]] = {}
    for ground in soft.planes:
        for copy in coupled:
            need = _shell(copy) + SAFE
            gap = gaps.to_plane(copy, ground, need)
            if gap < need * (1 - 1e-6):
                _note(found, gap, need, copy, ground.copy)
    boxes = {copy.name: facts.box(copy) for copy in coupled}
    for k, a in enumerate(coupled):
        box = boxes[a.name]
        for b in coupled[k + 1 :]:
            its, need = boxes[b.name], _shell(a) + _shell(b) + SAFE
            if box is None or its is None or apart(box, its, -need):
                continue
            gap = gaps.between(a, b, need)
            if gap < need * (1 - 1e-6):
                _note(found, gap, need, *((b, a) if b.body in facts.case.bodies else (a, b)))
    for gap, need, mover, other, count in found.values():
        how = "overlap" if gap < -1e-6 else "touch" if gap < 1e-6 else f"are {length(gap)} apart"
        more = more_copies(count, "pairs of their copies")
        text = (
            f"`{mover.name}` and `{other.name}` {how} at the start{more}: contact model ipc takes no scene in which "
            f"bodies touch; it needs {length(need)} between them: `clearance: {need:.2g}` in place, or a pose so much "
            "farther away"
        )
        if mover.body in facts.case.scene.statics:
            text += " (or `material: {touch_soft: false}` for what nothing is to touch)"
        where = facts.said(mover.body, "place", "pose", "repeat")
        yield facts.problem("ipc-clearance", where, text, key=True)


def _note(
    found: dict[tuple[str, str], tuple[float, float, Copy, Copy, int]], gap: float, need: float, a: Copy, b: Copy
) -> None:
    old = found.get((a.body, b.body))
    if old is None or gap < old[0]:
        found[a.body, b.body] = gap, need, a, b, 1 if old is None else old[4] + 1
    else:
        found[a.body, b.body] = (*old[:4], old[4] + 1)


def _coupled(facts: Facts, soft: SoftFacts, copy: Copy) -> bool:
    """Whether ipc computes a copy: all but planes, what keeps out, and what it does not know."""
    if copy.model is not None and is_soft(copy.model):
        return any(body.copy is copy for body in soft.of("ipc", "fem"))
    return touches_soft(copy.model) and facts.box(copy) is not None


def _shell(copy: Copy) -> float:
    """By how much [m] half of a cloth, which counts from its middle to both sides, sticks out of what is compared."""
    return max(0.0, copy.model.material.thickness - SHEET) / 2 if getattr(copy.model, "kind", None) == "cloth" else 0.0


def _linked(facts: Facts) -> Iterator[Problem]:
    """Bodies of several links that overlap at their joints."""
    soft = soft_facts(facts)
    if soft.model != "ipc":
        return
    for name in facts.case.bodies:
        copy = facts.placed[name][0]
        if is_soft(copy.model) or not touches_soft(copy.model):
            continue
        parts, left = facts.parts(copy), PAIRS
        links = {part.link for part in parts}
        if len(links) < 2:
            continue
        for k, one in enumerate(parts):
            hit = None
            for other in parts[k + 1 :]:
                if one.link != other.link and left > 0 and not apart(one.box, other.box):
                    left -= 1
                    hit = other if inside(one, other) else None
                if hit is not None:
                    break
            if hit is not None:
                text = (
                    f"{_link(one)} and {_link(hit)} of `{name}` overlap at their joint: contact model ipc takes "
                    "each link for a body and no scene in which bodies touch; with `material: {touch_soft: false}` the "
                    "body stays out of it, and touches no cloth"
                )
                yield facts.problem("ipc-links", facts.where(name), text, key=True)
                break


def _link(part: StandingPart) -> str:
    return "what the world holds" if part.link is None else f"`{part.link}`"


def _unheard(facts: Facts) -> Iterator[Problem]:
    """Controls of deformable bodies that the coupler refuses or never reads."""
    soft = soft_facts(facts)
    if soft.model != "ipc":
        return
    names = {body.body for body in soft.of("ipc", "fem")}
    for name, control in facts.case.actions.controls.items():
        body = body_of(getattr(control, "body", ""))
        if body not in names or control.kind not in _UNHEARD:
            continue
        text = f"`{body}` cannot be {_UNHEARD[control.kind]} under contact model ipc: {_INSTEAD[control.kind]}"
        yield facts.problem("ipc-control", ("actions", "controls", name, "kind"), text)


_UNHEARD = {"attach": "attached", "initial_velocity": "thrown", "force": "pushed by a force"}
_INSTEAD = {
    "attach": "its coupler refuses to hold points; clamp it between two rigid bodies, which hold it by friction",
    "initial_velocity": "its solver starts everything at rest; let it fall, or let a rigid body push it",
    "force": "its solver takes no forces on points; let a rigid body push it",
}


def _fine(facts: Facts) -> Iterator[Problem]:
    """Cloth whose triangles are so small that neighbours are within its own thickness."""
    soft = soft_facts(facts)
    seen = set()
    for body in soft.of("ipc"):
        thick, edge = body.model.material.thickness, soft.scales.spacing(body.body, "ipc")
        if body.body in seen or edge > 2 * thick:
            continue
        seen.add(body.body)
        text = (
            f"`{body.name}` is {length(thick)} thick and cut into triangles of {length(edge)}: its points touch their "
            f"own neighbours at the start; `cell: {4 * thick:.2g}` or more, or a thinner cloth"
        )
        yield facts.problem("ipc-too-fine", facts.said(body.body, "cell", "material"), text, key=True)


_TOWEL = "  towel: {kind: cloth, solver: ipc, shape: {kind: sheet, size: [0.6, 0.4]}, pose: {pos: [0, 0, 0.5]}}\n"
_JELLY = """\
  jelly: {kind: soft, solver: fem, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 1]}}
"""

RULES = (
    Rule(
        id="ipc-clearance",
        severity="error",
        title="Bodies touch or overlap at the start under contact model ipc.",
        reason=f"""\
Ipc keeps every distance positive from the first step on, so it must find it positive: libuipc checks the scene before
it starts, and takes none in which surfaces intersect or are at a distance of 0, or nearer to a cloth than half its
thickness. That holds for what stands on the floor and for statics among each other, too. Asked for is that and
{SAFE * 1000:g} mm.""",
        remedy="""\
Give `place` a `clearance` of the size that the message names; what no cloth and no free body will touch can stay out of
it with `material: {touch_soft: false}`.""",
        example=f"""\
bodies:
  cup: {{kind: rigid, shape: {{kind: cylinder, radius: 0.04, height: 0.1}}, place: {{on: floor}}}}
{_TOWEL}""",
        fix="bodies: {cup: {place: {clearance: 0.0005}}}",
        run=_clearance,
    ),
    Rule(
        id="ipc-links",
        severity="error",
        title="Links of one body that overlap, under contact model ipc.",
        reason="""\
The coupler makes a body of its own of every link, with contact between all of them. Links of chains, ropes, nets and
dolls overlap at their joints, and libuipc takes no scene in which bodies intersect.""",
        remedy="""\
Leave gaps at the joints of an articulated body, or keep the body out of it with `material: {touch_soft: false}`.""",
        example=f"""\
bodies:
  line: {{kind: rope, length: 0.5, radius: 0.01, pose: {{pos: [1, 0, 1]}}}}
{_TOWEL}""",
        fix="bodies: {line: {material: {touch_soft: false}}}",
        run=_linked,
    ),
    Rule(
        id="ipc-control",
        severity="error",
        title="A control of a soft body that contact model ipc has no way to carry out.",
        reason="""\
Cloth and soft bodies are libuipc's under this contact model: it refuses constraints of points, starts everything at
rest, and reads no forces that the engine has for them. Rigid bodies can be driven, pushed and attached.""",
        remedy="Let rigid bodies do it: a clamp of two plates that close holds a body by friction.",
        example=f"""\
bodies:
{_TOWEL}{_JELLY}actions:
  controls:
    pin: {{kind: attach, body: jelly, region: {{face: left}}, to: world}}
""",
        fix="bodies: {towel: null}",
        run=_unheard,
    ),
    Rule(
        id="ipc-too-fine",
        severity="error",
        title="A cloth of solver ipc that is thicker than its triangles are long.",
        reason="""\
Points of a cloth that are no neighbours must be farther apart than it is thick, or libuipc takes them for touching at
the start and refuses the scene.""",
        remedy="Take a `cell` of several times the thickness, or a smaller `thickness`.",
        example="""\
bodies:
  felt:
    kind: cloth
    solver: ipc
    cell: 0.01
    shape: {kind: sheet, size: [0.6, 0.4]}
    material: {thickness: 0.008}
    pose: {pos: [0, 0, 0.5]}
""",
        fix="bodies: {felt: {cell: 0.03}}",
        run=_fine,
    ),
)
