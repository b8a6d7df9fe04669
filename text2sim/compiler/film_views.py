"""The direction to a camera that nobody placed: where statics hide least of what moves."""

from collections.abc import Iterable

from text2sim.compiler.looks import finish_of_body, hides
from text2sim.compiler.placing.body_points import BodyPoints
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import crosses, grown
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import Quaternion, Vec, quat_conjugate, quat_rotate, vector_unit
from text2sim.compiler.trees.tree import tree_pieces

Standing = tuple[Piece, Vec, Quaternion]

DIRECTIONS = (
    # From the front right and a little above, as people are used to; then the others, the best first.
    (0.55, -1.0, 0.3),
    (-0.55, -1.0, 0.3),
    (0.55, -1.0, 1.0),
    (-0.55, -1.0, 1.0),
    (0.55, 1.0, 0.3),
    (-0.55, 1.0, 0.3),
    (1.0, -0.3, 0.3),
    (-1.0, -0.3, 0.3),
    (0.4, -0.7, 1.8),
)
"""Directions from the scene to the camera."""
MAX_FLAT_RATIO = 0.3
"""What is thinner than this part of its width, and taller than that part, is filmed from its broad side."""
TESTED_POINTS = 16
"""About how many points of what moves are tested in each direction."""


def free_direction(points: list[Vec], statics: Iterable[Copy], bodies: BodyPoints, far: float, size: Vec) -> Vec:
    """Return the first of the directions in which the fewest points are hidden by statics.

    Args:
        points: Middles of what is to be seen [m].
        statics: What may stand in the way.
        bodies: Finds the pieces of copies.
        far: How far away the camera is, about [m].
        size: Extent of what is to be seen, along x, y and z [m].
    """
    directions = (*_broadside(size), *DIRECTIONS)
    standing = [piece for copy in statics if _hides(copy) for piece in _pieces(copy, bodies)]
    points = points[:: max(len(points) // TESTED_POINTS, 1)]
    if not standing or not points:
        return directions[0]

    def hidden(direction: Vec) -> int:
        x, y, z = (far * c for c in vector_unit(direction))
        return sum(any(_crosses(piece, p, (p[0] + x, p[1] + y, p[2] + z)) for piece in standing) for p in points)

    return min(directions, key=hidden)


def _broadside(size: Vec) -> tuple[Vec, ...]:
    """Return directions to the broad sides of what stands flat and upright; none of anything else."""
    wide, deep, tall = size
    if deep < MAX_FLAT_RATIO * wide and tall > MAX_FLAT_RATIO * wide:
        return ((0.25, -1.0, 0.3), (-0.25, -1.0, 0.3), (0.25, 1.0, 0.3))
    if wide < MAX_FLAT_RATIO * deep and tall > MAX_FLAT_RATIO * deep:
        return ((1.0, -0.25, 0.3), (-1.0, -0.25, 0.3))
    return ()


def _hides(copy: Copy) -> bool:
    look = copy.model.look
    solid = hides(look.opacity, finish_of_body(copy.model))
    return copy.shape is not None and copy.shape.kind != "plane" and look.visible and solid


def _pieces(copy: Copy, bodies: BodyPoints) -> list[Standing]:
    tree = bodies.trees.get(copy.name)
    if tree is not None:
        return [standing[:3] for standing in tree_pieces(tree, copy.pos, copy.quat)]
    return [(piece, copy.pos, copy.quat) for piece in pieces(copy.shape, bodies.folder)]


def _crosses(standing: Standing, start: Vec, end: Vec) -> bool:
    """Return whether a line goes through a piece: a box as it is, anything else as a box of two thirds of its ball."""
    piece, pos, quat = standing
    a, b = (_local(piece, _local_to(point, pos, quat)) for point in (start, end))
    if piece.kind == "box":
        x, y, z = (side / 2 for side in piece.size)
        return crosses(((-x, -y, -z), (x, y, z)), a, b)
    center, radius = _local(piece, piece.ball[0]), piece.ball[1]
    return crosses(grown((center, center), radius / 1.5), a, b)


def _local_to(point: Vec, pos: Vec, quat: Quaternion) -> Vec:
    return quat_rotate(quat_conjugate(quat), tuple(p - q for p, q in zip(point, pos, strict=True)))


def _local(piece: Piece, point: Vec) -> Vec:
    return _local_to(point, piece.pos, piece.quat)
