"""Rigid bodies: all parts with one material form one mesh, whose vertices are transformed for each frame."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.assets.surface import scaled_normals
from text2sim.compiler.shapes.rotation import quats_to_matrices
from text2sim.recording.film_record import Cut, WornMesh
from text2sim.rendering.decorating import Layer, decorated, drift, run_on, shifted, toned
from text2sim.rendering.finishes import EDGE_TINT, SCATTERED, drawn_finish, finish_of, material, needs_uvs
from text2sim.rendering.meshes import RenderMesh, boxed_uvs, read_mesh
from text2sim.rendering.shapes import filtering, mesh_shape, shaded
from text2sim.rendering.strands import is_strand, numbers_in_rows
from text2sim.rendering.wetting import Wall

Array = NDArray[np.floating]

PANE = 0.35
"""Largest thickness of a box that is a pane, as a fraction of its middle extent."""
MIN_RIM_OPACITY = 0.15
"""Opacity below which a pane has no rim."""
FACING, BOXY = 0.9, 0.88
"""Cosine from which a triangle belongs to the broad sides, and fraction of the broad sides that such triangles cover:
less, and the shape is not a box."""
EDGE = 1e-4
"""Largest distance of an edge's vertices from the bounds of a pane, as a fraction of its size."""


@dataclass(frozen=True)
class BatchMaterial:
    """Properties that all parts of one batch share."""

    finish: str
    opacity: float
    picture: Path | None
    moves: bool
    has_uvs: bool
    layer: Layer | None = None
    texture_scale: float = 1.0


class Batch:
    """All parts with one material.

    Args:
        shared: The material.
        parts: The parts.
        meshes: Meshes of the parts.

    Attributes:
        is_clear: Whether it is transparent; see `trace`.
        is_metal: Whether it reflects like metal.
        filters: Whether it is transparent with a colour.
    """

    def __init__(self, name: str, shared: BatchMaterial, parts: list[WornMesh], meshes: list[RenderMesh]):
        self.name, self.moves, self.is_clear = name, shared.moves, finish_of(shared.finish).kind == "clear"
        self.is_metal = bool(finish_of(shared.finish).metallic)
        self.filters = self.is_clear and shared.opacity < 1
        picture = None if shared.picture is None else read_picture(shared.picture)
        self._bsdf = material(
            shared.finish,
            opacity=shared.opacity,
            picture=picture,
            layer=shared.layer,
            texture_scale=shared.texture_scale,
        )
        sizes = [len(mesh.vertices) for mesh in meshes]
        starts = np.cumsum([0, *sizes[:-1]])
        self._faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)])
        self._uvs = np.concatenate([mesh.uvs for mesh in meshes if mesh.uvs is not None]) if shared.has_uvs else None
        turns = [quats_to_matrices(np.array([part.quat]))[0] for part in parts]
        self._vertices = np.concatenate(
            [m.vertices @ r.T + p.pos for m, r, p in zip(meshes, turns, parts, strict=True)]
        )
        self._normals = np.concatenate([m.normals @ r.T for m, r in zip(meshes, turns, strict=True)])
        self._links = np.repeat([part.link for part in parts], sizes)
        colors = [shaded(_color(part), part.look.finish) for part in parts]
        if self.filters:
            colors = [(color, filtering(color, shared.opacity)) for color, _ in colors]
        self._colors, self._shades = (np.repeat([row[i] for row in colors], sizes, axis=0) for i in (0, 1))
        rates = [_pattern_rates(mesh, part, shared.layer) for mesh, part in zip(meshes, parts, strict=True)]
        self._rates = np.concatenate(rates) if self._uvs is not None and any(rate.any() for rate in rates) else None
        self._made: Any = None
        self._parts, self._kind = parts, finish_of(shared.finish).kind

    def shape(self, pos: Array, quat: Array, t: float, bsdf: Any = None) -> Any:
        """Return the mesh for given poses of the links.

        Args:
            pos: Positions [m], shape (L, 3).
            quat: Unit quaternions (w, x, y, z), shape (L, 4).
            t: Simulated time [s], which says how far patterns have moved along.
            bsdf: Material instead of its own.
        """
        if self._made is None or self.moves or bsdf is not None:
            turn = quats_to_matrices(quat)[self._links]
            vertices = np.einsum("nij,nj->ni", turn, self._vertices) + pos[self._links]
            normals = np.einsum("nij,nj->ni", turn, self._normals)
            uvs = self._uvs if self._uvs is None or self._rates is None else self._uvs + t * self._rates
            shape = mesh_shape(
                self.name, bsdf or self._bsdf, vertices, self._faces, normals,
                colors=self._colors, shades=self._shades, uvs=uvs,
            )  # fmt: skip
            if bsdf is not None:
                return shape
            self._made = shape
        return self._made

    def walls(self, pos: Array, quat: Array) -> list[Wall]:
        """Return its surfaces as they were recorded, with sharp edges, for given poses of the links; see `shape`.

        Where two panes meet, a liquid would flow into the groove between rounded edges.
        """
        if self._kind == "edge":
            return []  # of panes that are part of another batch
        turn, clear = quats_to_matrices(quat), self._kind in ("clear", *SCATTERED)
        return [Wall(own @ turn[link].T + pos[link], faces, clear) for link, own, faces in self._recorded]

    @cached_property
    def _recorded(self) -> list[tuple[int, Array, NDArray[np.integer]]]:
        """Link, vertices in its frame [m] and triangles of each part."""
        meshes = [(part, read_mesh(part.mesh, rounded=False)) for part in self._parts]
        turns = [quats_to_matrices(np.array([part.quat]))[0] for part in self._parts]
        return [
            (part.link, mesh.vertices @ r.T + part.pos, mesh.faces)
            for (part, mesh), r in zip(meshes, turns, strict=True)
        ]


def batches(parts: list[WornMesh], statics: frozenset[str], texture_scale: float) -> list[Batch]:
    """Return the batches of all visible parts.

    Args:
        parts: The parts.
        statics: Names of the static bodies.
        texture_scale: Factor on the lengths that textures of finishes cover.
    """
    read: dict[Any, RenderMesh] = {}
    laid: dict[Any, tuple[RenderMesh, Layer]] = {}
    sorted_parts: dict[BatchMaterial, list[tuple[WornMesh, RenderMesh]]] = {}
    in_rows = numbers_in_rows(parts)
    for number, part in enumerate(parts):
        look = part.look
        if not look.visible or look.opacity <= 0:
            continue
        printed = look.decoration is not None or look.picture is not None  # which glass has no room for
        finish = drawn_finish(look.finish, look.color, 1.0 if printed else look.opacity)
        key = part.mesh, needs_uvs(finish)
        if key not in read:
            mesh = read_mesh(part.mesh, rounded=look.cut is None)  # edges with bevels would show where it breaks
            if key[1] and mesh.uvs is None:
                mesh = boxed_uvs(mesh) if look.cut is None else _grained(mesh, part, look.cut)
            read[key] = mesh
        mesh, layer = read[key], None
        if look.decoration is not None and finish_of(finish).kind != "clear":
            if part.mesh not in read:
                read[part.mesh] = read_mesh(part.mesh, rounded=look.cut is None)
            plain = replace(read[part.mesh], uvs=None)
            mesh, layer = _decorated(plain, part, in_rows.get(number), laid, textured=needs_uvs(finish))
        elif key[1] and look.picture is None and look.cut is None:
            mesh = shifted(mesh, part.body, None)
        # A texture without texture coordinates is not visible.
        picture = look.picture if mesh.uvs is not None and layer is None else None
        opacity = 1.0 if finish_of(look.finish).kind != "solid" else look.opacity
        moves = part.body not in statics or (layer is not None and part.surface_velocity is not None)
        has_uvs = mesh.uvs is not None
        shared = BatchMaterial(finish, opacity, picture, moves, has_uvs, layer, texture_scale)
        sorted_parts.setdefault(shared, []).append((part, mesh))
        rimmed = look.opacity >= MIN_RIM_OPACITY and finish_of(finish).kind == "clear"
        if rimmed and (narrow := _rim(read[part.mesh, False], part, look.cut)) is not None:
            tint = tuple(c * t for c, t in zip(look.color, EDGE_TINT, strict=True))
            edge = replace(part, look=replace(look, finish="glass_edge", color=tint))
            sorted_parts.setdefault(BatchMaterial("glass_edge", 1.0, None, moves, False), []).append((edge, narrow))
    return [
        Batch(f"rigid{k}", shared, [part for part, _ in rows], [mesh for _, mesh in rows])
        for k, (shared, rows) in enumerate(sorted_parts.items())
    ]


def _decorated(
    mesh: RenderMesh, part: WornMesh, number: int | None, laid: dict[Any, tuple[RenderMesh, Layer]], *, textured: bool
) -> tuple[RenderMesh, Layer]:
    """Return the mesh of a part with texture coordinates for its pattern, and the pattern.

    Args:
        mesh: The mesh.
        part: The part.
        number: Its number in a row of links that are alike.
        laid: Meshes that were decorated before; it is added to them.
        textured: Whether the finish below has a texture, too.
    """
    look, turn = part.look, quats_to_matrices(np.array([part.quat]))[0]
    assert look.decoration is not None
    in_strand = number is not None and look.decoration.kind != "dots" and is_strand(mesh, part)
    own = part.mesh, look.decoration, look.color, tuple(part.quat), in_strand
    if own not in laid:
        laid[own] = decorated(mesh, look.decoration, look.color, turn, textured=textured, strand=in_strand)[:2]
    mesh, layer = laid[own]
    if look.decoration.repeats:
        mesh = shifted(mesh, part.body, layer.unit)
        if in_strand and number:
            mesh = run_on(mesh, 2 * number * np.array(part.pos), turn, turned=look.decoration.turned)
    return mesh, layer


def _pattern_rates(mesh: RenderMesh, part: WornMesh, layer: Layer | None) -> Array:
    """Return how fast the texture coordinates of a mesh change, shape (n, 2): a repeating pattern moves with a surface.

    Args:
        mesh: The mesh, in its own frame.
        part: The part that it is drawn for.
        layer: The pattern.
    """
    if part.surface_velocity is None or layer is None or layer.unit is None:
        return np.zeros((len(mesh.vertices), 2))
    turn = quats_to_matrices(np.array([part.quat]))[0]
    return drift(mesh, np.asarray(part.surface_velocity) @ turn)


def narrow_sides(mesh: RenderMesh) -> RenderMesh | None:
    """Return the sides of a box-shaped pane that are as narrow as it is thick; None for any other shape.

    They show where a pane of clear glass ends: its broad sides are nearly invisible.
    """
    size = np.ptp(mesh.vertices, axis=0)
    axis = int(size.argmin())
    areas = scaled_normals(mesh.vertices[mesh.faces]) / 2
    broad = 2 * np.prod(np.delete(size, axis))
    flat = np.abs(areas[:, axis]) > np.linalg.norm(areas, axis=1) * FACING
    covered = np.linalg.norm(areas[flat], axis=1).sum()
    if size[axis] > PANE * np.median(size) or covered <= BOXY * broad or flat.all():
        return None
    return replace(mesh, faces=mesh.faces[~flat], uvs=None)


def _grained(mesh: RenderMesh, part: WornMesh, cut: Cut) -> RenderMesh:
    """Return a fragment with the texture coordinates that it has in the whole body, so that its texture goes on."""
    turn = quats_to_matrices(np.array([part.quat]))[0]
    whole = replace(mesh, vertices=_in_whole(mesh.vertices, part, cut), normals=mesh.normals @ turn.T)
    whole = boxed_uvs(whole, int(np.subtract(cut.high, cut.low).argmax()))
    back = whole.vertices - np.add(part.pos, cut.place)
    return replace(whole, vertices=back @ turn, normals=whole.normals @ turn)


def _in_whole(vertices: Array, part: WornMesh, cut: Cut) -> Array:
    """Return vertices (n, 3) [m] of a fragment in the frame of the body that it was cut from."""
    return vertices @ quats_to_matrices(np.array([part.quat]))[0].T + part.pos + cut.place


def _rim(mesh: RenderMesh, part: WornMesh, cut: Cut | None) -> RenderMesh | None:
    """Return what shows the edge of a pane of glass; of a fragment, the part on the edge of the whole pane."""
    if cut is None:
        return narrow_sides(mesh)
    size = np.subtract(cut.high, cut.low)
    across = np.arange(3) != size.argmin()
    if size.min() > PANE * np.median(size):
        return None
    placed = _in_whole(mesh.vertices, part, cut)
    near = np.stack([np.abs(placed - side) < EDGE * size for side in (cut.low, cut.high)])[:, mesh.faces]
    at_edge = np.any(np.all(near[..., across], axis=2), axis=(0, 2))  # all corners at the same side of the pane
    return replace(mesh, faces=mesh.faces[at_edge], uvs=None) if at_edge.any() else None


def _color(part: WornMesh) -> tuple[float, float, float]:
    """Return the colour of a part; copies of a body differ slightly."""
    look = part.look
    return look.color if look.alike or "[" not in part.body else toned(look.color, part.body, look.finish)


def read_picture(path: Path) -> Array:
    """Return a picture (h, w, 3 or 4), 0 to 1, with alpha if it has one."""
    from PIL import Image

    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGBA" if "A" in picture.getbands() else "RGB"), float) / 255
