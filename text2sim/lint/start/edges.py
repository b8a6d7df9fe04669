"""Boxes and polyhedra that start on an edge or a corner, on level ground or on a slope, and will tip."""

from collections.abc import Iterator
from itertools import product
from math import acos, degrees

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec, frame_apply, vector_cross, vector_dot, vector_minus, vector_unit
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import MAX_RESTING_GAP
from text2sim.lint.parts import StandingPart
from text2sim.lint.rule import Rule
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.words import more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of

MAX_FACE_ANGLE_DEG = 2.0
"""Largest angle [deg] between two faces at which a body counts as lying on its face."""
MIN_UPWARD = 0.5
"""Smallest cosine between the normal of a support and straight up."""

Face = tuple[Vec, Vec]
"""Outward normal of a face, and a point [m] of it."""


def _edges(facts: Facts) -> Iterator[Problem]:
    x, y, z = facts.case.scene.gravity
    if x or y or z >= 0.0:
        return
    held = {body_of(c.body) for c in facts.case.actions.controls.values() if c.kind == "attach"}
    held |= {body_of(name) for name in facts.bonded | facts.sprung}
    boxes = {
        copy.name: (name, copy, box)
        for name in facts.case.bodies
        if name not in held
        for copy in facts.placed[name]
        if facts.loose(copy) and (box := _edged(facts, copy)) is not None
    }
    neighbours: dict[str, list[Copy]] = {name: [] for name in boxes}
    for one, other in facts.near(-MAX_RESTING_GAP) if boxes else ():
        for a, b in ((one, other), (other, one)):
            if a.name in boxes:
                neighbours[a.name].append(b)
    gaps = facts.once(Gaps)
    found: dict[str, list[tuple[Copy, Copy, float]]] = {}
    for name, copy, box in boxes.values():
        touching = [g.copy for g in facts.planes if abs(gaps.to_plane(copy, g, 1.0)) < MAX_RESTING_GAP]
        for other in neighbours[copy.name]:
            if len({support.name for support in touching}) > 1:
                break
            if gaps.between(copy, other, 2 * MAX_RESTING_GAP) < MAX_RESTING_GAP:
                touching.append(other)
        if len({support.name for support in touching}) != 1:
            continue  # in the air, or leaning on several
        tilt = _tilt(facts, box, touching[0])
        if tilt > MAX_FACE_ANGLE_DEG:
            found.setdefault(name, []).append((copy, touching[0], tilt))
    for name, rows in found.items():
        copy, support, tilt = rows[0]
        text = (
            f"`{copy.name}` touches `{support.name}` only with an edge or a corner{more_copies(len(rows))}: its "
            f"nearest face is at {tilt:.3g} deg to the support, so it tips at once; turn it so that its face lies on "
            "the support, or waive this rule if it is meant to fall"
        )
        yield facts.problem("on-edge", ("bodies", name), text, key=True)


def _edged(facts: Facts, copy: Copy) -> StandingPart | None:
    """Return the only piece of a box or a polyhedron."""
    parts = facts.parts(copy)
    flat = len(parts) == 1 and getattr(copy.shape, "kind", "") in ("box", "polyhedron")
    return parts[0] if flat else None


def _corners(part: StandingPart) -> list[Vec]:
    piece = part.piece
    if piece.kind == "box":
        a, b, c = (size / 2 for size in piece.size)
        own: list[Vec] = [(x * a, y * b, z * c) for x, y, z in product((-1.0, 1.0), repeat=3)]
    else:
        own = list(piece.vertices)
    pos = frame_apply(part.pos, part.quat, piece.pos)
    return [frame_apply(pos, part.turn, corner) for corner in own]


def _faces(part: StandingPart) -> list[Face]:
    corners = _corners(part)
    if part.piece.kind == "box":
        # The first corner lies on the three faces that look against the axes, the last on the others.
        return [((-x, -y, -z), corners[0]) for x, y, z in part.axes] + [(axis, corners[-1]) for axis in part.axes]
    found = []
    for i, j, k in part.piece.faces:
        normal = vector_cross(vector_minus(corners[j], corners[i]), vector_minus(corners[k], corners[i]))
        if any(normal):
            found.append((vector_unit(normal), corners[i]))
    return found


def _tilt(facts: Facts, body: StandingPart, support: Copy) -> float:
    """Return the angle [deg] between the nearest faces of a body and of its support; 0 if that has no flat face."""
    if (ground := facts.ground(support)) is not None:
        return _angle(body, ground.up)
    corners = _corners(body)
    best: tuple[float, Vec] | None = None
    for part in facts.parts(support):
        if part.piece.kind not in ("box", "hull"):
            return 0.0
        for normal, point in _faces(part):
            above = min(vector_dot(normal, vector_minus(corner, point)) for corner in corners)
            if best is None or above > best[0]:
                best = (above, normal)
    if best is None or abs(best[0]) > MAX_RESTING_GAP or best[1][2] < MIN_UPWARD:
        return 0.0
    return _angle(body, best[1])


def _angle(body: StandingPart, normal: Vec) -> float:
    nearest = max(-vector_dot(face, normal) for face, _ in _faces(body))
    return degrees(acos(max(-1.0, min(nearest, 1.0))))


_SLOPE = """\
scene:
  statics:
    slope: {shape: {kind: box, size: [2, 1, 0.1]}, pose: {pos: [0, 0, 0.6], euler_deg: [0, 20, 0]}}
bodies:
  crate:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    place: {on: slope, at: [0, 0], euler_deg: [0, %s, 0]}
"""

RULES = (
    Rule(
        id="on-edge",
        title="A box or a polyhedron starts on an edge or a corner.",
        reason="""\
A body that touches its support only with an edge is not in balance: it tips before anything else happens. On a slope,
this is the result of `place: {on: slope}` if the body stays upright or is turned about the wrong axis.""",
        remedy="""\
Lay it flat with `flush_deg` in its `place`, turn it like its support (the same `euler_deg`; a turn about the normal of
the slope comes first), or waive the rule if it is meant to tip.""",
        example=_SLOPE % "0",
        fix=_SLOPE % "20",
        run=_edges,
    ),
)
