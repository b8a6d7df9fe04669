"""Sculpted shapes as closed meshes: a field of signed distances on a grid, and its zero level.

Nodes are counted before the grid is made. The surface is that of marching cubes (Lewiner et al., 2003), cut along the
borders of looks, then simplified within a part of a cell by `manifold3d`, which also guarantees that it is closed.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from text2sim.compiler.shapes.borders import FAR, cut_edges, labels_of, retriangulated
from text2sim.compiler.shapes.distance_field import rounded_down, rounded_up
from text2sim.compiler.shapes.distances import Bit, PartUnion, form_of
from text2sim.compiler.shapes.rotation import quat_of, quat_to_rows
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.sculpts import AnySculptPart, Sculpt

if TYPE_CHECKING:
    from manifold3d import Manifold

Array = np.ndarray
MAX_NODES = 1_500_000
"""Most nodes of the grid."""
MAX_ALONG = 1_500
"""Most nodes along a side: merging the triangles of a long flat shape costs the square of its length."""
MAX_WORK = 15_000_000
"""Most distances that are computed, of every bit of a part at the nodes in its box: two seconds of work. An elephant
takes 2.4 million."""
CELLS_THROUGH = 5
"""Cells through the thinnest part if `detail` is not given; with it, at least `MIN_CELLS_THROUGH`."""
MIN_CELLS_THROUGH = 1.6
MIN_CELLS_ALONG = 56
"""Least number of cells along the longest side."""
PADDING_CELLS = 2
"""Cells around everything."""
SLAB_NODES = 150_000
"""Most nodes that are computed at once."""
SIMPLIFY_TOLERANCE = 0.1
"""How far the surface may move when it is simplified, in cells."""


@dataclass(frozen=True)
class PlacedPart:
    """A part in the frame of the shape."""

    name: str
    part: AnySculptPart
    form: PartUnion
    blend: float
    """Radius of the fillet to the parts before it [m]."""

    @cached_property
    def frames(self) -> list[tuple[Array, Array, Array]]:
        """Frames of the part and of its mirror image.

        Each is (position [m], rotation matrix, signs (1 or −1) applied after both).
        """
        turn = np.array(quat_to_rows(quat_of(self.part.pose)))
        own = (np.array(self.part.pose.pos), turn, np.ones(3))
        if self.part.mirror is None:
            return [own]
        signs = np.where(np.array(list("xyz")) == self.part.mirror, -1.0, 1.0)
        return [own, (own[0], turn, signs)]

    def bits(self) -> Iterator[Bit]:
        """Yield its bits, with boxes in the frame of the shape."""
        for pos, turn, signs in self.frames:
            for bit in self.form.bits:
                ends = np.array([bit.low, bit.high])
                corners = np.array([ends[[i, j, k], [0, 1, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
                turned = (corners @ turn.T + pos) * signs

                def distance(p: Array, bit=bit, pos=pos, turn=turn, signs=signs) -> Array:
                    return bit.distance((p * signs - pos) @ turn)

                yield Bit(distance, turned.min(0), turned.max(0))

    def distance(self, p: Array) -> Array:
        """Return the distances (n,) of points (n, 3)."""
        return np.minimum.reduce([bit.distance(p) for bit in self.bits()])

    def atoms(self) -> Iterator[list[Array]]:
        """Yield the points of convex pieces, of the part and of its mirror image."""
        for pos, turn, signs in self.frames:
            yield [(atom @ turn.T + pos) * signs for atom in self.form.atoms]


def placed_parts(shape: Sculpt) -> list[PlacedPart]:
    """Return the parts of a shape, placed in the frame of the shape."""
    return [
        PlacedPart(name, part, form_of(part), shape.blend if part.blend is None else part.blend)
        for name, part in shape.parts.items()
    ]


@dataclass(frozen=True)
class LevelSetGrid:
    """Nodes at which the field is computed."""

    low: Array
    """First node [m]."""
    cell: float
    """[m]"""
    counts: tuple[int, int, int]

    def box(self, low: Array, high: Array, more: float) -> tuple[slice, slice, slice]:
        """Return the nodes within a box that is grown by `more` [m].

        Args:
            low: Lowest corner of the box, shape (3,) [m].
            high: Highest corner of the box, shape (3,) [m].
            more: How far the box is grown on all sides [m].
        """
        first = np.clip(np.floor((low - more - self.low) / self.cell), 0, self.counts).astype(int)
        last = np.clip(np.ceil((high + more - self.low) / self.cell) + 1, 0, self.counts).astype(int)
        return slice(first[0], last[0]), slice(first[1], last[1]), slice(first[2], last[2])

    def points(self, box: tuple[slice, slice, slice]) -> Array:
        """Return the places (n, 3) [m] of nodes."""
        axes = [self.low[k] + self.cell * np.arange(side.start, side.stop) for k, side in enumerate(box)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def grid_of(shape: Sculpt, parts: list[PlacedPart]) -> LevelSetGrid:
    """Choose the grid of a shape, as fine as its thinnest part needs and the limits allow.

    Raises:
        AssetError: if there would be too many nodes, or a part would be lost between them.
    """
    added = [bit for placed in _with_op(parts, "add") for bit in placed.bits()]
    low, high = np.min([bit.low for bit in added], axis=0), np.max([bit.high for bit in added], axis=0)
    boxes = [(bit, placed.blend) for placed in parts for bit in placed.bits()]
    size = float((high - low).max())

    def candidate(cell: float) -> tuple[LevelSetGrid, float, float]:
        pad = (PADDING_CELLS + 0.5) * cell
        counts = np.ceil((high - low + 2 * pad) / cell).astype(float) + 1
        nodes = float(counts.prod())
        if nodes > MAX_NODES or counts.max() > MAX_ALONG:
            return LevelSetGrid(low, cell, (0, 0, 0)), math.inf, 0.0
        # Shifted off round numbers, so that flat sides do not lie on nodes.
        grid = LevelSetGrid(low - pad + 0.013 * cell, cell, tuple(counts.astype(int).tolist()))
        work = sum(_size(grid.box(bit.low, bit.high, blend + PADDING_CELLS * cell)) for bit, blend in boxes)
        return grid, nodes, float(work)

    thinnest = min(parts, key=lambda placed: placed.form.thin)
    cell = shape.detail or min(thinnest.form.thin / CELLS_THROUGH, size / MIN_CELLS_ALONG)
    grid, nodes, work = candidate(cell)
    finest = cell
    while nodes > MAX_NODES or work > MAX_WORK:
        finest *= 1.1
        grid, nodes, work = candidate(finest)
    if shape.detail is not None and finest > cell:
        raise AssetError(
            f"needs too many nodes: the grid has at most {MAX_NODES:,}, {MAX_ALONG:,} along a side; with a size of "
            f"{size:.3g} m, `detail` can be {rounded_up(finest):g} m or more (got {cell:g})"
        )
    lost = list(dict.fromkeys(placed.name for placed in parts if placed.form.thin < MIN_CELLS_THROUGH * grid.cell))
    if lost:
        remedy = (
            f"take a `detail` of {rounded_down(thinnest.form.thin / MIN_CELLS_THROUGH):g} m"
            if shape.detail is not None
            else "make it a body of its own, or the rest smaller"
        )
        too = "".join(f", `{name}`" for name in lost if name != thinnest.name)
        raise AssetError(
            f"part `{thinnest.name}` is {thinnest.form.thin:.3g} m thick, and the cells of the grid are "
            f"{grid.cell:.3g} m: it would be lost{too and f', as would{too[1:]}'}; make it "
            f"{rounded_up(MIN_CELLS_THROUGH * grid.cell):g} m or thicker, or {remedy}"
        )
    return grid


def _with_op(parts: list[PlacedPart], op: str) -> list[PlacedPart]:
    return [placed for placed in parts if placed.part.op == op]


def _size(box: tuple[slice, slice, slice]) -> int:
    return math.prod(side.stop - side.start for side in box)


def fillet(a: Array, b: Array, radius: float) -> Array:
    """Join two fields with a fillet, which has that radius where their surfaces meet at right angles.

    It is `fOpUnionRound` of Mercury's hg_sdf library (https://mercury.sexy/hg_sdf).

    Args:
        a: Signed distances [m], any shape.
        b: Signed distances [m] of the same shape.
        radius: Radius of the fillet [m].
    """
    if radius <= 0:
        return np.minimum(a, b)
    return np.maximum(radius, np.minimum(a, b)) - np.hypot(np.maximum(radius - a, 0), np.maximum(radius - b, 0))


def field_of(parts: list[PlacedPart], grid: LevelSetGrid) -> Array:
    """Return the distances at the nodes: exact near the surface, a large number far from every part."""
    field = np.full(grid.counts, FAR)
    for placed in [*_with_op(parts, "add"), *_with_op(parts, "cut")]:
        bits = list(placed.bits())
        more = placed.blend + PADDING_CELLS * grid.cell
        whole = grid.box(np.min([b.low for b in bits], axis=0), np.max([b.high for b in bits], axis=0), more)
        own = np.full(tuple(side.stop - side.start for side in whole), FAR)
        for bit in bits:
            box = grid.box(bit.low, bit.high, more)
            rows = max(SLAB_NODES // max(_size((slice(0, 1), box[1], box[2])), 1), 1)
            for start in range(box[0].start, box[0].stop, rows):
                slab = (slice(start, min(start + rows, box[0].stop)), box[1], box[2])
                here = tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(slab, whole, strict=True))
                found = bit.distance(grid.points(slab)).reshape(own[here].shape)
                own[here] = np.minimum(own[here], found)
        if placed.part.op == "add":
            field[whole] = fillet(field[whole], own, placed.blend)
        else:
            field[whole] = -fillet(-field[whole], own, placed.blend)
    return field


@dataclass(frozen=True, eq=False)
class SculptMesh:
    """The mesh of a shape."""

    vertices: Array
    """(n, 3) float [m]"""
    faces: Array
    """(m, 3) int, counterclockwise from outside"""
    normals: Array
    """(n, 3) float: the slopes of the field"""
    looks: Array
    """(m,) int: which part gives a triangle its look; -1, the body."""
    pieces: list[Array]
    """Corners (k, 3) [m] of convex pieces."""


def sculpt_mesh(shape: Sculpt) -> SculptMesh:
    """Make the mesh of a shape.

    Raises:
        AssetError: if it cannot be made within the limits, or is in several pieces.
    """
    from skimage.measure import marching_cubes

    from text2sim.compiler.shapes.convex import convex_pieces

    parts = placed_parts(shape)
    grid = grid_of(shape, parts)
    field = field_of(parts, grid)
    if not (field < 0).any():
        raise AssetError("has nothing left after its cuts")
    if any((field.take((0, -1), axis=k) < 0).any() for k in range(3)):
        raise AssetError("is blended far beyond all of its parts; take a smaller `blend`")
    # Nodes on the surface would make triangles without area.
    near = 0.02 * grid.cell
    field = np.where(np.abs(field) < near, np.where(field < 0, -near, near), field)
    values = np.minimum(field, 8 * grid.cell).astype(np.float32)
    vertices, faces, _, _ = marching_cubes(values, 0.0, gradient_direction="descent")
    vertices = grid.low + grid.cell * vertices.astype(float)
    vertices, looks, faces = _bordered(parts, vertices, faces.astype(np.int64), grid)
    vertices, faces, looks = _simplify(vertices, faces, looks, grid.cell, parts)
    pieces = convex_pieces(shape, parts, vertices, lambda p: _sampled(values, grid, p), grid.cell)
    return SculptMesh(vertices, faces, _slopes(values, grid, vertices), looks, pieces)


def _sampled(values: Array, grid: LevelSetGrid, p: Array) -> Array:
    """Return the field at points (n, 3), interpolated between nodes; it is large beyond them."""
    from scipy.ndimage import map_coordinates

    return map_coordinates(values, ((p - grid.low) / grid.cell).T, order=1, mode="constant", cval=8 * grid.cell)


def _slopes(values: Array, grid: LevelSetGrid, p: Array) -> Array:
    step = 0.75 * grid.cell
    found = np.stack(
        [_sampled(values, grid, p + step * axis) - _sampled(values, grid, p - step * axis) for axis in np.eye(3)], 1
    )
    return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-12)


def _bordered(parts: list[PlacedPart], vertices: Array, faces: Array, grid: LevelSetGrid) -> tuple[Array, Array, Array]:
    """Cut triangles along the borders of looks; return vertices, the look of each triangle, triangles.

    A border runs where two parts are equally near, or where a part that paints or cuts ends.
    """
    groups, firsts = _look_groups(parts)
    if len(groups) == 1:
        return vertices, np.full(len(faces), -1), faces
    away, over = _look_distances(parts, groups, firsts, vertices, grid.cell)
    label = labels_of(away, over)
    points, on_edge = cut_edges(vertices, faces, label, away, over)
    points, labels, triangles = retriangulated(points, faces, label, on_edge)
    return points, np.array(firsts)[labels], triangles


def _look_groups(parts: list[PlacedPart]) -> tuple[list[list[int]], list[int]]:
    """Return the parts by look, and the first part of each group.

    The first group has the look of the body (-1), and may be empty; parts that paint or cut are groups of their own.
    """
    groups: list[list[int]] = [[]]
    firsts = [-1]
    known: dict[str, int] = {}
    for index, placed in enumerate(parts):
        if placed.part.look is None:
            if placed.part.op == "add":
                groups[0].append(index)
            continue
        key = f"{placed.part.op != 'add' and index}:{placed.part.look.model_dump_json()}"
        if key not in known:
            known[key] = len(groups)
            groups.append([])
            firsts.append(index)
        groups[known[key]].append(index)
    return groups, firsts


def _look_distances(
    parts: list[PlacedPart], groups: list[list[int]], firsts: list[int], vertices: Array, cell: float
) -> tuple[Array, Array]:
    """Return how far [m] vertices are from groups of parts (g, n), and which groups paint or cut (g,)."""
    far = np.full(len(vertices), FAR)
    away = np.stack(
        [np.minimum.reduce([parts[i].distance(vertices) for i in group]) if group else far for group in groups]
    )
    over = np.array([first >= 0 and parts[first].part.op != "add" for first in firsts])
    # The surface that a cut leaves lies on it, not in it.
    away[over] -= np.array([0.6 * cell * (parts[f].part.op == "cut") for f in np.array(firsts)[over]])[:, None]
    return away, over


def _simplify(
    vertices: Array, faces: Array, looks: Array, cell: float, parts: list[PlacedPart]
) -> tuple[Array, Array, Array]:
    """Merge triangles where the surface is flat, without crossing borders of looks."""
    from manifold3d import Manifold, Mesh64

    order = np.argsort(looks, kind="stable")
    faces, looks = faces[order], looks[order]
    names, first = np.unique(looks, return_index=True)
    mesh = Mesh64(
        vertices,
        faces.astype(np.uint64),
        run_index=np.append(3 * first, 3 * len(faces)).astype(np.uint64),
        run_original_id=(names + 1).astype(np.uint32),
    )
    whole = Manifold(mesh)
    if whole.is_empty():
        raise AssetError(f"made no closed surface ({whole.status()}): move a part a little, or use another `detail`")
    _require_one_piece(whole, parts)
    made = whole.simplify(SIMPLIFY_TOLERANCE * cell).to_mesh64()
    ends = np.asarray(made.run_index, np.int64) // 3
    found = np.empty(len(made.tri_verts), np.int64)
    for k, name in enumerate(made.run_original_id):
        found[ends[k] : ends[k + 1]] = int(name) - 1
    points, net = np.asarray(made.vert_properties)[:, :3], np.asarray(made.tri_verts, np.int64)
    # Along borders a vertex may occur several times: one is enough.
    same, back = np.unique(points, axis=0, return_inverse=True)
    return same, back.reshape(-1)[net], found


def _require_one_piece(whole: "Manifold", parts: list[PlacedPart]) -> None:
    apart = [piece for piece in whole.decompose() if piece.volume() > 0]
    if len(apart) > 1:
        least = min(apart, key=lambda piece: piece.volume())
        box = np.array(least.bounding_box()).reshape(2, 3)
        near = min(_with_op(parts, "add"), key=lambda placed: float(placed.distance(box.mean(0)[None])[0]))
        raise AssetError(
            f"is in {len(apart)} pieces: the smallest, around {_place(box.mean(0))}, belongs to part `{near.name}`; "
            "move it to the rest, or make it a body of its own"
        )


def _place(p: Array) -> str:
    return "(" + ", ".join(f"{x:.3g}" for x in p.tolist()) + ")"
