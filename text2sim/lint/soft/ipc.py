"""Scenes and controls that contact model ipc refuses or ignores."""

from collections.abc import Iterator
from itertools import combinations, islice

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.shapes.sagging import SHEET_THICKNESS
from text2sim.compiler.soft.solvers import is_soft, touches_soft
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.start.escape import overlapping
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of

SAFE_GAP = 1e-4
"""Gap [m], in addition to the thickness of cloth, that the check of libuipc accepts."""
MAX_LINK_PAIRS = 2000
"""Most pairs of links of one body that are tested."""


def _clearance(facts: Facts) -> Iterator[Problem]:
    """Report bodies that touch at the start, which libuipc refuses."""
    soft = facts.once(SoftFacts)
    if soft.model != "ipc":
        return
    gaps = Gaps(facts)
    coupled = [copy for copy in facts.copies.values() if _coupled(facts, soft, copy)]
    found: dict[tuple[str, str], list[tuple[float, float, Copy, Copy]]] = {}
    for ground in soft.planes:
        for copy in coupled:
            need = _shell(copy) + SAFE_GAP
            gap = gaps.to_plane(copy, ground, need)
            if gap < need * (1 - 1e-6):
                found.setdefault((copy.body, ground.copy.body), []).append((gap, need, copy, ground.copy))
    for a, b in combinations(coupled, 2):
        need = _shell(a) + _shell(b) + SAFE_GAP
        gap = gaps.between(a, b, need)
        if gap < need * (1 - 1e-6):
            mover, other = (b, a) if b.body in facts.case.bodies else (a, b)
            found.setdefault((mover.body, other.body), []).append((gap, need, mover, other))
    for rows in found.values():
        gap, need, mover, other = min(rows, key=lambda row: row[0])
        how = "overlap" if gap < -1e-6 else "touch" if gap < 1e-6 else f"are {length(gap)} apart"
        text = (
            f"`{mover.name}` and `{other.name}` {how} at the start{more_copies(len(rows), 'pairs of their copies')}: "
            f"contact model ipc refuses scenes in which bodies touch; leave {length(need)} between them, with "
            f"`clearance: {need:.2g}` in place or by the pose"
        )
        if mover.body in facts.case.scene.statics:
            text += " (or set `material: {touch_soft: false}` if nothing should touch it)"
        where = facts.first_given(mover.body, "place", "pose", "repeat")
        yield facts.problem("ipc-clearance", where, text, key=True)


def _coupled(facts: Facts, soft: SoftFacts, copy: Copy) -> bool:
    """Return whether ipc simulates a copy: all but planes, excluded bodies, and other solvers."""
    if is_soft(copy.model):
        return any(body.copy is copy for body in soft.of("ipc", "fem"))
    return touches_soft(copy.model) and facts.box(copy) is not None


def _shell(copy: Copy) -> float:
    """Return by how much [m] half of the thickness of a cloth exceeds that of its pieces here."""
    return (
        max(0.0, copy.model.material.thickness - SHEET_THICKNESS) / 2
        if getattr(copy.model, "kind", None) == "cloth"
        else 0.0
    )


def _linked(facts: Facts) -> Iterator[Problem]:
    """Report bodies of several links that overlap at their joints."""
    soft = facts.once(SoftFacts)
    if soft.model != "ipc":
        return
    for name in facts.case.bodies:
        copy = facts.placed[name][0]
        if is_soft(copy.model) or not touches_soft(copy.model):
            continue
        pairs = ((a, b) for a, b in combinations(facts.parts(copy), 2) if a.link != b.link and not apart(a.box, b.box))
        hit = next((pair for pair in islice(pairs, MAX_LINK_PAIRS) if overlapping(*pair)), None)
        if hit is not None:
            one, other = ("the fixed part" if part.link is None else f"`{part.link}`" for part in hit)
            text = (
                f"{one} and {other} of `{name}` overlap at their joint: contact model ipc treats each link as a body "
                "and refuses scenes in which bodies touch; set `material: {touch_soft: false}` to exclude the body, "
                "which then has no contact with cloth"
            )
            yield facts.problem("ipc-links", facts.where(name), text, key=True)


def _controls(facts: Facts) -> Iterator[Problem]:
    """Report controls of deformable bodies that the coupler refuses or ignores."""
    soft = facts.once(SoftFacts)
    if soft.model != "ipc":
        return
    names = {body.body for body in soft.of("ipc", "fem")}
    for name, control in facts.case.actions.controls.items():
        if control.kind in _REFUSED and (body := body_of(getattr(control, "body", ""))) in names:
            text = f"`{body}` cannot be {_REFUSED[control.kind]} under contact model ipc: {_INSTEAD[control.kind]}"
            yield facts.problem("ipc-control", ("actions", "controls", name, "kind"), text)


_REFUSED = {"attach": "attached", "initial_velocity": "thrown", "force": "pushed by a force", "impulse": "hit"}
_INSTEAD = {
    "attach": "its coupler refuses attached points; clamp it between two rigid bodies, which hold it by friction",
    "initial_velocity": "its solver starts everything at rest; let it fall, or let a rigid body push it",
    "force": "its solver ignores forces on points; let a rigid body push it",
    "impulse": "its solver ignores changes of its points; let a rigid body hit it",
}


@first_per_place
def _fine(facts: Facts) -> Iterator[Problem]:
    """Report cloth whose triangles are smaller than its thickness."""
    soft = facts.once(SoftFacts)
    for body in soft.of("ipc"):
        thick, edge = body.model.material.thickness, soft.scales.spacing(body.body, "ipc")
        if edge > 2 * thick:
            continue
        text = (
            f"`{body.name}` is {length(thick)} thick and has triangles of {length(edge)}: its points touch their "
            f"neighbours at the start; use `cell: {4 * thick:.2g}` or more, or a thinner cloth"
        )
        yield facts.problem("ipc-too-fine", facts.first_given(body.body, "cell", "material"), text, key=True)


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
Ipc keeps all distances positive, so they must be positive at the start: libuipc checks the scene and refuses it if
surfaces intersect or touch, or are closer to a cloth than half its thickness. This includes bodies on the floor and
pairs of statics. The rule requires {SAFE_GAP * 1000:g} mm more than that.""",
        remedy="""\
Give `place` the `clearance` of the message; exclude bodies that no cloth and no free body will touch with `material:
{touch_soft: false}`.""",
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
        title="Links of one body overlap under contact model ipc.",
        reason="""\
The coupler treats every link as a body, with contact between all of them. Links of chains, ropes, nets and ragdolls
overlap at their joints, and libuipc refuses scenes in which bodies intersect.""",
        remedy="""\
Leave gaps at the joints of an articulated body, or exclude the body with `material: {touch_soft: false}`.""",
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
        title="Contact model ipc does not support a control of a soft body.",
        reason="""\
Libuipc simulates cloth and soft bodies under this contact model: it refuses constraints on points, starts everything at
rest, and ignores the engine's forces on them. Rigid bodies can be driven, pushed and attached.""",
        remedy="Use rigid bodies: a clamp of two plates that close holds a body by friction.",
        example=f"""\
bodies:
{_TOWEL}{_JELLY}actions:
  controls:
    pin: {{kind: attach, body: jelly, region: {{face: left}}, to: world}}
""",
        fix="bodies: {towel: null}",
        run=_controls,
    ),
    Rule(
        id="ipc-too-fine",
        severity="error",
        title="A cloth of solver ipc is thicker than its triangles are long.",
        reason="""\
Points of a cloth that are not neighbours must be farther apart than its thickness; otherwise libuipc finds contact at
the start and refuses the scene.""",
        remedy="Use a `cell` of several times the thickness, or a smaller `thickness`.",
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
