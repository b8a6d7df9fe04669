"""Overlapping parts of a compound, whose common volume counts twice in its mass."""

from collections.abc import Iterator
from itertools import combinations, product
from math import hypot, prod
from typing import Any

from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.piece import Piece, piece_reach
from text2sim.compiler.shapes.rotation import Vec, quat_conjugate, quat_rotate, vector_cross, vector_dot, vector_minus
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import AXES
from text2sim.spec_schema.models.bodies import FixedMount
from text2sim.spec_schema.models.materials import DENSITY

MIN_SHARED_MASS = 0.05
"""Smallest share of a body's mass that is reported."""
LATTICE_POINTS = 8
"""Sample points along each side of the intersection of two boxes."""
MAX_PAIRS = 150
"""Most pairs of pieces that are tested in a body."""


def _counted_twice(facts: Facts) -> Iterator[Problem]:
    for name, body in facts.case.bodies.items():
        shape = getattr(body, "shape", None)
        if body.kind != "rigid" or shape.kind != "compound" or body.material.mass is not None:  # type: ignore[union-attr]
            continue
        where = ("bodies", name, "shape", "parts")
        if isinstance(body.mount, FixedMount):
            continue  # what never moves needs no mass
        if facts.loaded.document.origin(where) is not None:
            continue  # the user of a prefab cannot fix it
        copy, density = facts.placed[name][0], body.material.density or DENSITY
        pieces = [piece for piece in geometry.pieces(copy.shape, facts.loaded.folder) if piece.kind != "mesh"]
        weights = {part: model.density or density for part, model in copy.shape.solids.items()}
        whole = sum(piece.volume() * weights.get(piece.part or "", 0.0) for piece in pieces)
        shared, looked = dict[tuple[str, str], float](), 0
        boxes = [_box(piece) for piece in pieces]
        for (a, box_a), (b, box_b) in combinations(zip(pieces, boxes, strict=True), 2):
            low, high = tuple(map(max, box_a[0], box_b[0])), tuple(map(min, box_a[1], box_b[1]))
            if a.part == b.part or any(p >= q for p, q in zip(low, high, strict=True)) or looked >= MAX_PAIRS:
                continue
            looked += 1
            pair = (a.part or "", b.part or "")
            extra = min(weights[part] for part in pair) * _common(a, b, low, high)
            shared[pair] = shared.get(pair, 0.0) + extra
        total = sum(shared.values())
        if whole <= 0.0 or total < MIN_SHARED_MASS * whole:
            continue
        worst = max(shared, key=lambda pair: shared[pair])
        text = (
            f"parts of `{name}` overlap, most of all `{worst[0]}` and `{worst[1]}`, and each counts with its whole "
            f"volume: about {total:.2g} of its {whole:.3g} kg ({total / whole:.0%}) is counted twice; give its "
            "`material.mass`, or let the parts only touch"
        )
        yield facts.problem("counted-twice", where, text, key=True)


def _box(piece: Piece) -> tuple[Any, Any]:
    """Return the corners [m] of the bounding box of a piece, in the body's frame."""
    low = tuple(-piece_reach(piece, (-x, -y, -z)) for x, y, z in AXES.values())
    return low, tuple(piece_reach(piece, axis) for axis in AXES.values())


def _common(a: Piece, b: Piece, low: Any, high: Any) -> float:
    """Return the volume [m3] that two pieces share within a box, sampled on a lattice; accurate to about a tenth."""
    sides = [
        [p + (q - p) * (k + 0.5) / LATTICE_POINTS for k in range(LATTICE_POINTS)]
        for p, q in zip(low, high, strict=True)
    ]
    inside_a, inside_b = _inside(a), _inside(b)
    hits = sum(1 for point in product(*sides) if inside_a(point) and inside_b(point))
    return prod(q - p for p, q in zip(low, high, strict=True)) * hits / LATTICE_POINTS**3


def _inside(piece: Piece) -> Any:
    """Return a function that tests whether a point [m] of the body's frame is inside a piece."""
    if piece.kind == "hull":
        planes = []
        for i, j, k in piece.faces:
            u, v, w = piece.vertices[i], piece.vertices[j], piece.vertices[k]
            planes.append((u, vector_cross(vector_minus(v, u), vector_minus(w, u))))
        return lambda point: all(vector_dot(normal, vector_minus(point, corner)) <= 0.0 for corner, normal in planes)
    back, size = quat_conjugate(piece.quat), piece.size

    def test(point: Vec) -> bool:
        x, y, z = quat_rotate(back, vector_minus(point, piece.pos))
        if piece.kind == "box":
            return 2 * abs(x) <= size[0] and 2 * abs(y) <= size[1] and 2 * abs(z) <= size[2]
        if piece.kind == "cylinder":
            return hypot(x, y) <= size[0] and 2 * abs(z) <= size[1]
        if piece.kind == "capsule":
            return hypot(x, y, max(abs(z) - size[1] / 2, 0.0)) <= size[0]
        if piece.kind == "ellipsoid":
            return hypot(x / size[0], y / size[1], z / size[2]) <= 1.0
        return hypot(x, y, z) <= size[0]

    return test


_PAIR = """\
bodies:
  dumbbell:
    kind: rigid
    shape:
      kind: compound
      parts:
        bar: {shape: {kind: box, size: [%s, 0.05, 0.05]}}
        left: {shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [-0.2, 0, 0]}}
        right: {shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.2, 0, 0]}}
    pose: {pos: [0, 0, 0.05]}
"""

RULES = (
    Rule(
        id="counted-twice",
        title="Parts of a compound overlap, and their common volume counts twice.",
        reason="""\
The mass of a compound is the sum of its parts, each with its whole volume: the engine ignores overlaps. A body whose
parts overlap deeply is heavier than it looks, and its centre of mass is wrong.""",
        remedy="Give the body's `material.mass`, or shorten a part so that it only touches the next.",
        example=_PAIR % "0.5",
        fix=_PAIR % "0.3",
        run=_counted_twice,
    ),
)
