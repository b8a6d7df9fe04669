"""Stage of a case at its start: triangles from the compiler's shapes and colours, with shared surfaces for copies."""

from dataclasses import dataclass, field, replace
from math import log2, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from text2sim.assets.mechanism import Mechanism, MechanismLink
from text2sim.compiler.build import Resolution
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import EntityPlan
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.pictures import PREVIEW_SIDE, thumbnail
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import IDENTITY, Quaternion, Vec, frame_apply, quat_multiply, quats_to_matrices
from text2sim.compiler.shapes.sagging import is_bent
from text2sim.compiler.shapes.softmesh import soft_surface
from text2sim.compiler.shapes.surface import VisualMesh
from text2sim.compiler.soft.solvers import is_soft
from text2sim.compiler.trees.file_bodies import geom_of
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeLink, tree_links
from text2sim.drawing.meshes import Triangles, limited_surface, scale_of, solid, square, unit
from text2sim.drawing.prop import Prop, Stage
from text2sim.drawing.robots import urdf_visuals
from text2sim.spec_schema.models.sheets import Disc, Revolve, Ribbon, Sheet, Sleeve

Rgba = tuple[float, float, float, float]

STAGE_TRIANGLES = 90_000
"""Approximate number of triangles of a stage."""
FINE_STAGE_TRIANGLES = 400_000
"""Number of triangles of the meshes of a fine stage."""
FILE_COLOR: Rgba = (0.74, 0.77, 0.8, 1.0)
"""Colour of bodies from files, whose own colours are not read here."""
SHEET_CELLS = 48
"""Cells along the longer side of a sheet that is bent, or has a picture, because each triangle has one colour."""
RIBBON_CELLS = 2
"""Cells across a ribbon."""


def stage(resolution: Resolution, budget: int = STAGE_TRIANGLES, *, fine: bool = False) -> Stage:
    """Return the visible props of a case at its start.

    Args:
        resolution: The resolved case.
        budget: Approximate number of triangles, which limits the sides of round things.
        fine: Whether to read the visual meshes of robots, which takes seconds; otherwise collision shapes are drawn.
    """
    collector = _Collector(resolution, fine)
    for section, groups in (("statics", resolution.plan.statics), ("bodies", resolution.plan.bodies)):
        for group in groups:
            for entity, copy in zip(group.entities, resolution.placed[group.name], strict=True):
                if entity.options.get("visualization", True):
                    collector.entity(entity, copy, static=section == "statics")
    return collector.build(budget)


class _Instance(NamedTuple):
    """A surface at a pose."""

    scale: Vec
    pos: Vec
    quat: Quaternion
    prop: int


class _Key(NamedTuple):
    """Identity of a surface: equal ones are built once."""

    kind: str
    of: Any


@dataclass
class _Collector:
    resolution: Resolution
    fine: bool
    props: dict[tuple[Any, ...], int] = field(default_factory=dict)
    instances: dict[_Key, list[_Instance]] = field(default_factory=dict)
    things: dict[_Key, Any] = field(default_factory=dict)
    """Piece or surface by key."""

    def entity(self, entity: EntityPlan, copy: Copy, *, static: bool) -> None:
        """Add the visible surfaces of an entity."""
        color: Rgba | None = entity.surface.rgba if entity.surface else None
        finish = entity.surface.finish if entity.surface else copy.model.look.finish
        if is_soft(copy.model):
            self._soft(copy, color or FILE_COLOR, finish)
            return
        tree = self.resolution.lowering.trees.get(entity.name)
        if tree is not None:
            if getattr(copy.model, "file", None) is not None:
                mechanism = self.resolution.lowering.mechanisms[copy.model.file, copy.model.base]
                tree = _with_visuals(tree, mechanism, fine=self.fine)
            self._tree(tree, copy, color, finish, static)
            return
        mount = getattr(copy.model, "mount", None)
        moves = not static and (mount is None or mount.kind != "fixed")
        plane = entity.morph == "Plane"
        prop = self._prop(copy, color or FILE_COLOR, finish, moves, static, plane)
        if plane:
            x, y = entity.options["plane_size"]
            self._add(_Key("plane", None), None, _Instance((x, y, 1.0), copy.pos, copy.quat, prop))
            return
        options = entity.options
        size = options.get("size") or tuple(options[key] for key in ("radius", "height") if key in options)
        self._piece(Piece(entity.morph.lower(), size=tuple(size)), copy.pos, copy.quat, prop)

    def _soft(self, copy: Copy, color: Rgba, finish: str) -> None:
        """Add a deformable body in its rest shape: only the engine makes the points of its solver."""
        folder, prop = self.resolution.lowering.folder, self._prop(copy, color, finish, True, False)
        surfaces = cloth_surfaces(copy.shape, folder) or geometry.visual_mesh(copy.shape, folder)
        meshed = {mesh.part for mesh in surfaces or ()}
        if surfaces is None or copy.shape.kind == "compound":
            for piece in geometry.pieces(copy.shape, folder):
                if surfaces is None or piece.part not in meshed:
                    self._piece(piece, copy.pos, copy.quat, prop)
        own = copy.shape.kind == "sheet" or copy.model.look.color is None
        for mesh in surfaces or ():
            key = _Key("surface", (mesh.digest, own and mesh.picture is not None))
            self._add(key, mesh, _Instance((1.0, 1.0, 1.0), copy.pos, copy.quat, prop))

    def _tree(self, tree: Tree, copy: Copy, color: Rgba | None, finish: str, static: bool) -> None:
        # A colour of the entity applies to all parts; without one, each part has its own.
        def prop_of(own: Rgba | None, moves: bool) -> int:
            return self._prop(copy, color or own or FILE_COLOR, finish, moves and not static, static)

        for geom in tree.fixtures:
            self._piece(geom.piece, copy.pos, copy.quat, prop_of(geom.rgba, False))
        for link, pos, quat, moves in tree_links(tree, copy.pos, copy.quat):
            for geom in link.geoms:
                if geom.drawn:
                    self._piece(geom.piece, pos, quat, prop_of(geom.rgba, moves))
            for visual in link.visuals:
                mesh, picture = visual.mesh, color is None and visual.rgba is None
                prop = prop_of(visual.rgba, moves)
                key = _Key("surface", (mesh.digest, picture and mesh.picture is not None))
                self._add(key, mesh, _Instance((1.0, 1.0, 1.0), pos, quat, prop))

    def _prop(self, copy: Copy, rgba: Rgba, finish: str, moves: bool, static: bool, plane: bool = False) -> int:
        key = (copy.name, copy.body, rgba, finish, moves, static, plane)
        return self.props.setdefault(key, len(self.props))

    def _piece(self, piece: Piece, pos: Vec, quat: Quaternion, prop: int) -> None:
        if piece.pos != (0.0, 0.0, 0.0):
            pos = frame_apply(pos, quat, piece.pos)
        if piece.quat != IDENTITY:
            quat = quat_multiply(quat, piece.quat)
        scale = scale_of(piece.kind, piece.size)
        if scale is not None:
            kind = "ellipsoid" if piece.kind == "sphere" else piece.kind
            # Round things of similar size get the same number of sides.
            key = _Key(kind, 0 if kind == "box" else round(log2(max(scale[:2]))))
            self._add(key, piece, _Instance(scale, pos, quat, prop))
            return
        key = _Key(piece.kind, (piece.size, piece.vertices))
        self._add(key, piece, _Instance((1.0, 1.0, 1.0), pos, quat, prop))

    def _add(self, key: _Key, thing: Any, instance: _Instance) -> None:
        self.things.setdefault(key, thing)
        self.instances.setdefault(key, []).append(instance)

    # --- from instances to triangles ---------------------------------------------------------------------------

    def build(self, budget: int) -> Stage:
        """Return the stage."""
        surfaces = self._surfaces(budget)
        rows = list(self.props)
        colors = np.array([row[2][:3] for row in rows], np.float32).reshape(-1, 3)
        clear = np.array([row[2][3] < 1.0 for row in rows], bool)
        parts = []
        for key, surface in surfaces.items():
            corners, normals = _place_instances(surface, self.instances[key])
            owner = np.repeat(
                np.array([instance.prop for instance in self.instances[key]], np.int32), len(surface.corners)
            )
            own = colors[owner]
            if surface.colors is not None:
                own = np.tile(surface.colors.astype(np.float32), (len(self.instances[key]), 1))
            # Surfaces from files may be open or inverted, so that both sides are drawn.
            culled = clear[owner] | (key.kind not in ("surface", "plane"))
            parts.append((corners, normals, own, owner, culled))
        if not parts:
            empty = np.zeros((0, 3, 3))
            return Stage([], empty, empty, np.zeros((0, 3)), np.zeros(0, np.int32), np.zeros(0, bool))
        triangles, normals, own, owner, culled = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        order = np.argsort(owner, kind="stable")
        triangles, owner = triangles[order], owner[order]
        ends = np.searchsorted(owner, np.arange(len(rows) + 1))
        props = [
            Prop(name, body, triangles[ends[k] : ends[k + 1]], rgba[:3], rgba[3], moves, finish, plane, static)
            for k, (name, body, rgba, finish, moves, static, plane) in enumerate(rows)
        ]
        return Stage(props, triangles, normals[order], own[order], owner, culled[order])

    def _surfaces(self, budget: int) -> dict[_Key, Triangles]:
        """Every surface in its own frame, with detail according to its size and the number of its copies."""
        counts = {key: len(found) for key, found in self.instances.items()}
        boxes = 12 * sum(n for key, n in counts.items() if key.kind == "box")
        meshes = [(len(mesh.faces), counts[key]) for key, mesh in self.things.items() if key.kind == "surface"]
        room = max(budget - boxes, budget // 4)
        most = _level(meshes, FINE_STAGE_TRIANGLES if self.fine else 0.7 * room)
        meshed = sum(count * min(faces, most) for faces, count in meshes)
        sides = _sides(self.things, counts, max(room - meshed, 0.3 * room))
        found = {}
        for key, thing in self.things.items():
            if key.kind == "plane":
                found[key] = square()
            elif isinstance(thing, VisualMesh):
                found[key] = limited_surface(thing, most, picture=key.of[1])
            elif key.kind in ("box", "ellipsoid", "cylinder"):
                found[key] = unit(key.kind, sides.get(key, 0))
            else:
                found[key] = solid(thing, sides.get(key, 0))
        return found


def _level(meshes: list[tuple[int, int]], room: float) -> int:
    """The largest number of triangles of a mesh: coarse meshes keep theirs, fine ones share the rest.

    Args:
        meshes: Triangles and copies of each.
        room: Total number of triangles.
    """
    waiting = sum(count for _, count in meshes)
    for faces, count in sorted(meshes):
        if faces * waiting > room:
            return max(48, int(room / waiting))
        room -= faces * count
        waiting -= count
    return max((faces for faces, _ in meshes), default=0)


def _sides(things: dict[_Key, Any], counts: dict[_Key, int], room: float) -> dict[_Key, int]:
    """Numbers of sides of round things; n sides take about n² triangles, and larger things get more."""
    radii = {
        key: key.of[0][0] if key.kind == "capsule" else 2.0**key.of
        for key in things
        if key.kind in ("ellipsoid", "cylinder", "capsule")
    }
    largest = max(radii.values(), default=1.0)
    weights = {key: min(max(sqrt(radius / largest), 0.2), 1.0) for key, radius in radii.items()}
    most = sqrt(room / max(sum(counts[key] * weight**2 for key, weight in weights.items()), 1e-9))
    return {key: 2 * min(max(round(most * weight / 2), 4), 24) for key, weight in weights.items()}


def _place_instances(surface: Triangles, instances: list[_Instance]) -> tuple[np.ndarray, np.ndarray]:
    """Corners and normals of all instances of a surface."""
    scale = np.array([instance.scale for instance in instances])[:, None, :]
    turn = np.swapaxes(quats_to_matrices(np.array([instance.quat for instance in instances])), 1, 2)
    place = np.array([instance.pos for instance in instances])[:, None, :]
    corners = surface.corners.reshape(1, -1, 3) * scale @ turn + place
    normals = surface.normals.reshape(1, -1, 3)
    if np.ptp(scale, axis=2).any():
        normals = normals / scale
        normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    normals = normals.astype(np.float32) @ turn.astype(np.float32)
    return corners.reshape(-1, 3, 3), normals.reshape(-1, 3, 3)


def _with_visuals(tree: Tree, mechanism: Mechanism, *, fine: bool) -> Tree:
    """The tree of a body from a file, with visual shapes of its links in place of collision shapes."""
    shapes = {link.name: (_visual_shapes(link), ()) for link in mechanism.links}
    if fine and mechanism.kind == "urdf":
        shapes |= urdf_visuals(mechanism)

    def with_visuals(link: TreeLink) -> TreeLink:
        geoms, visuals = shapes.get(link.name, ((), ()))
        return replace(link, geoms=geoms, visuals=visuals, children=tuple(map(with_visuals, link.children)))

    return replace(tree, roots=tuple(map(with_visuals, tree.roots)), fixtures=shapes[mechanism.links[0].name][0])


def _visual_shapes(link: MechanismLink) -> tuple[TreeGeom, ...]:
    apart = any(not geom.touches for geom in link.geoms)
    return tuple(geom_of(geom) for geom in link.geoms if not (apart and geom.touches))


def cloth_surfaces(shape: Any, folder: Path) -> list[VisualMesh] | None:
    """Return the surface of an open cloth, with its picture if it is a sheet that has one; None for other shapes.

    Raises:
        AssetError: if the picture cannot be used.
    """
    if isinstance(shape, Disc):
        net = soft_surface(shape, folder, 2 * shape.radius / SHEET_CELLS)
        return [VisualMesh(net.vertices, net.faces, np.tile([0.0, 0.0, 1.0], (len(net.vertices), 1)))]
    if isinstance(shape, Sleeve):
        picture, bent, edge = None, True, 2 * max(shape.radii) / SHEET_CELLS
    elif isinstance(shape, Revolve):
        picture, bent, edge = None, True, 2 * max(radius for radius, _ in shape.profile) / SHEET_CELLS
    elif isinstance(shape, Ribbon):
        picture, bent, edge = None, True, shape.width / RIBBON_CELLS
    elif isinstance(shape, Sheet):
        picture = None if shape.texture is None else thumbnail(shape.texture, folder, PREVIEW_SIDE)
        bent = is_bent(shape)
        edge = max(shape.size) / (SHEET_CELLS if picture or bent else 1)
    else:
        return None
    net = soft_surface(shape, folder, edge)
    normals = np.tile([0.0, 0.0, 1.0], (len(net.vertices), 1))
    if bent:
        from trimesh import Trimesh  # slow to import

        normals = Trimesh(net.vertices, net.faces, process=False).vertex_normals
    return [VisualMesh(net.vertices, net.faces, normals, uvs=net.uvs, picture=picture)]
