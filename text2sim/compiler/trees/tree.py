"""Trees of links: the form of everything that the engine has no primitive for.

A tree becomes one MJCF file (`mjcf.py`). Poses are (pos [m], quat wxyz) of a link's frame in its parent's frame.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import NamedTuple

from text2sim.compiler.shapes.boxes import Bounds
from text2sim.compiler.shapes.inertials import Inertial, combined_inertial, piece_inertial
from text2sim.compiler.shapes.piece import Ball, Piece, piece_reach
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    ORIGIN,
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Quaternion,
    Vec,
    frame_apply,
    quat_conjugate,
    quat_from_axis_angle,
    quat_multiply,
    quat_rotate,
)
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.spec_schema.models.materials import Look


@dataclass(frozen=True)
class TreeGeom:
    """A convex piece of a link, with its material and colour."""

    piece: Piece
    density: float
    """[kg/m3]"""
    friction: float
    """Coulomb coefficient."""
    rgba: tuple[float, float, float, float] | None = None
    look: Look | None = None
    """None for the look of the body."""
    drawn: bool = True
    """False where a `visual` of the link is drawn instead."""
    touches: bool = True
    """False for what is only drawn."""
    torques: tuple[float, float] = (0.0, 0.0)
    """Coefficients [m] of torsional and rolling friction."""


@dataclass(frozen=True)
class TreeVisual:
    """A mesh that is drawn and touches nothing."""

    mesh: VisualMesh
    rgba: tuple[float, float, float, float] | None = None
    look: Look | None = None
    """None for a mesh in colours of its own."""


@dataclass(frozen=True)
class TreeJoint:
    """The joint between a link and its parent (or the world)."""

    kind: str
    """free, hinge, slider or ball."""
    axis: Vec = Z_AXIS
    anchor: Vec = ORIGIN
    range: tuple[float, float] | None = None
    """[rad] or [m]"""
    damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0
    spring: float = 0.0
    velocity: float = 0.0
    """At the start [rad/s or m/s]."""


@dataclass(frozen=True)
class TreeLink:
    """A link; without a joint it is fixed to its parent, or to the world."""

    name: str
    pos: Vec = ORIGIN
    quat: Quaternion = IDENTITY
    joint: TreeJoint | None = None
    joints: tuple[tuple[str, TreeJoint], ...] = ()
    """Several joints with names of their own (driven bodies slide along three axes), instead of `joint`."""
    geoms: tuple[TreeGeom, ...] = ()
    visuals: tuple[TreeVisual, ...] = ()
    inertia: Inertial | None = None
    """Where the pieces overlap, so that it does not follow from them."""
    children: tuple["TreeLink", ...] = ()

    def all_joints(self) -> tuple[tuple[str, TreeJoint], ...]:
        """Return name and joint for each joint of this link; a single joint has the link's name."""
        return self.joints if self.joint is None else ((self.name, self.joint),)

    def drawn(self) -> tuple[TreeGeom | TreeVisual, ...]:
        """Return what is drawn of this link, in the order of its model file."""
        return *(geom for geom in self.geoms if geom.drawn), *self.visuals

    @property
    def inertial(self) -> Inertial:
        """Mass, centre of mass and inertia of this link alone, in its frame; nothing for a link from a file."""
        if self.inertia is not None:
            return self.inertia
        return combined_inertial(piece_inertial(geom.piece, geom.density) for geom in self.geoms if geom.density > 0.0)


def strung(links: Iterable[TreeLink]) -> TreeLink:
    """Return the first of some links, with each of the others hanging on the one before it."""
    return reduce(lambda below, link: replace(link, children=(below,)), reversed([*links]))


@dataclass(frozen=True)
class TreeLoop:
    """An equality constraint between two links (`b` None: the world), or between their joints."""

    kind: str
    """connect, weld, or gear."""
    a: str
    b: str | None
    anchor: Vec
    """[m], in the frame of `a`."""
    ratio: float = 0.0
    """Of a gear: position of the joint of `a` per that of `b`."""


@dataclass(frozen=True)
class Tree:
    """A mechanism; each root is a child of the world."""

    roots: tuple[TreeLink, ...]
    loops: tuple[TreeLoop, ...] = ()
    fixtures: tuple[TreeGeom, ...] = ()
    """Pieces that belong to the world."""
    self_collision: bool = False
    initial: dict[str, float] = field(default_factory=dict)
    """Start position of joints [rad or m] by name."""

    def links(self) -> list[TreeLink]:
        """Return every link, parents before children."""
        found: list[TreeLink] = []
        queue = list(self.roots)
        while queue:
            link = queue.pop(0)
            found.append(link)
            queue[:0] = link.children
        return found

    def joints(self) -> list[tuple[str, TreeJoint]]:
        """Return name and joint for each joint of every link."""
        return [row for link in self.links() for row in link.all_joints()]

    def geoms(self) -> list[TreeGeom]:
        """Return the pieces of every link; those of the world are `fixtures`."""
        return [geom for link in self.links() for geom in link.geoms]


class StandingPiece(NamedTuple):
    """A piece with the pose of its link."""

    piece: Piece
    pos: Vec
    quat: Quaternion
    moves: bool
    """False for what is fixed to the world."""


class StandingLink(NamedTuple):
    """A link with its frame at the start."""

    link: TreeLink
    pos: Vec
    quat: Quaternion
    moves: bool
    """False for what is fixed to the world."""


def tree_links(tree: Tree, pos: Vec = ORIGIN, quat: Quaternion = IDENTITY) -> list[StandingLink]:
    """Return every link of a tree that stands at (`pos`, `quat`), all joints at their start positions.

    Args:
        tree: The tree.
        pos: Position of its origin [m].
        quat: Its orientation (w, x, y, z).
    """
    found = []
    queue = [(link, pos, quat, False) for link in tree.roots]
    while queue:
        link, pos, quat, moves = queue.pop()
        pos, quat = moved_frame(link, tree.initial, pos, quat)
        moves = moves or bool(link.all_joints())
        found.append(StandingLink(link, pos, quat, moves))
        queue += [(child, pos, quat, moves) for child in link.children]
    return found


def link_frame(tree: Tree | None, name: str | None, pos: Vec, quat: Quaternion) -> tuple[Vec, Quaternion]:
    """Return position [m] and orientation of a link at the start; those of the body itself if it has no links.

    Args:
        tree: Its tree; None for a body without links.
        name: The link; the first one if None.
        pos: Position of the body [m].
        quat: Its orientation (w, x, y, z).
    """
    if tree is None or not tree.roots:
        return pos, quat
    name = tree.roots[0].name if name is None else name
    return next(((row.pos, row.quat) for row in tree_links(tree, pos, quat) if row.link.name == name), (pos, quat))


def tree_pieces(
    tree: Tree, pos: Vec = ORIGIN, quat: Quaternion = IDENTITY, *, drawn: bool = False
) -> list[StandingPiece]:
    """Return every piece of a tree that stands at (`pos`, `quat`), all joints at their start positions.

    Args:
        tree: The tree.
        pos: Position of its frame [m].
        quat: Orientation of its frame (w, x, y, z).
        drawn: Whether pieces that touch nothing are included.
    """
    found = [StandingPiece(geom.piece, pos, quat, False) for geom in tree.fixtures]
    for link, at, turn, moves in tree_links(tree, pos, quat):
        found += [StandingPiece(geom.piece, at, turn, moves) for geom in link.geoms if geom.touches or drawn]
    return found


def moved_frame(link: TreeLink, positions: Mapping[str, float], pos: Vec, quat: Quaternion) -> tuple[Vec, Quaternion]:
    """Return a link's frame from its parent's, at positions of joints [rad or m] by name; the others are at 0.

    Args:
        link: The link.
        positions: Of joints [rad or m], by name.
        pos: Of the parent's frame [m].
        quat: Orientation of the parent's frame.
    """
    pos, quat = frame_apply(pos, quat, link.pos), quat_multiply(quat, link.quat)
    for name, joint in link.all_joints():
        start = positions.get(name, 0.0)
        if start and joint.kind == "slider":
            x, y, z = joint.axis
            pos = frame_apply(pos, quat, (start * x, start * y, start * z))
        elif start and joint.kind == "hinge":
            turned = quat_multiply(quat, quat_from_axis_angle(joint.axis, start))
            anchor = frame_apply(pos, quat, joint.anchor)
            x, y, z = quat_rotate(turned, joint.anchor)
            pos, quat = (anchor[0] - x, anchor[1] - y, anchor[2] - z), turned
    return pos, quat


def tree_balls(tree: Tree) -> list[Ball]:
    """Return centre [m] and radius [m] of a ball around every piece at the start, in the tree's frame."""
    found = []
    for piece, pos, quat, _ in tree_pieces(tree, drawn=True):
        center, radius = piece.ball
        found.append((frame_apply(pos, quat, center), radius))
    return found


def tree_bounds(tree: Tree, quat: Quaternion) -> Bounds:
    """Return the lowest and highest corner [m] of all pieces at the start, about the origin, turned by `quat`."""
    placed = tree_pieces(tree, quat=quat, drawn=True)
    low, high = [0.0] * 3, [0.0] * 3
    for k, axis in enumerate((X_AXIS, Y_AXIS, Z_AXIS)):
        back = (-axis[0], -axis[1], -axis[2])
        turned = [(piece, pos[k], quat_conjugate(q)) for piece, pos, q, _ in placed]
        high[k] = max((at + piece_reach(piece, quat_rotate(q, axis)) for piece, at, q in turned), default=0.0)
        low[k] = min((at - piece_reach(piece, quat_rotate(q, back)) for piece, at, q in turned), default=0.0)
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def link_colors(link: TreeLink) -> set[tuple[float, float, float, float] | None]:
    """Return the colours in which a link is drawn."""
    return {part.rgba for part in link.drawn()}


def uncolored(tree: Tree) -> Tree:
    """Return the tree without its colours."""

    def bare(link: TreeLink) -> TreeLink:
        return replace(
            link,
            geoms=tuple(replace(geom, rgba=None) for geom in link.geoms),
            visuals=tuple(replace(visual, rgba=None) for visual in link.visuals),
            children=tuple(bare(child) for child in link.children),
        )

    return replace(
        tree, roots=tuple(map(bare, tree.roots)), fixtures=tuple(replace(g, rgba=None) for g in tree.fixtures)
    )


def with_torques(tree: Tree, torques: tuple[float, float]) -> Tree:
    """Return a tree whose geoms have torsional and rolling friction [m], where they have none of their own."""

    def laid(geoms: tuple[TreeGeom, ...]) -> tuple[TreeGeom, ...]:
        return tuple(geom if any(geom.torques) else replace(geom, torques=torques) for geom in geoms)

    def with_own(link: TreeLink) -> TreeLink:
        return replace(link, geoms=laid(link.geoms), children=tuple(map(with_own, link.children)))

    return replace(tree, roots=tuple(map(with_own, tree.roots)), fixtures=laid(tree.fixtures))
