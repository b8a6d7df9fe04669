"""Export of a recorded run as binary glTF: links are animated nodes, deformable bodies have morph targets."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.assets.surface import unit_rows
from text2sim.exchange.files import move_into_place, save_picture, temporary_folder_beside
from text2sim.exchange.glb import Glb
from text2sim.exchange.materials import ExportMaterial
from text2sim.exchange.scenery import Figure, Scenery, SceneryLink, SceneryPiece, keyframe_rows
from text2sim.exchange.viewing import Track, camera_tracks
from text2sim.spec_schema.errors import RunError

Array = NDArray[np.floating]

MOST_TARGETS = 256
"""Largest number of frames with deformable bodies: each is a morph target, and each has weights for all of them."""
MOST_MORPHED = 4_000_000
"""Largest number of points of such bodies, times frames: 24 bytes each."""
POINTS = 0
"""Mode of a primitive."""
CORNERS = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], np.float32)
"""Corners of an octahedron."""
SIDES = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])
"""Triangles of the octahedron."""
UPRIGHT = [-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]
"""Rotation from z up to y up."""


def write_gltf(folder: Path, path: Path, *, every: int = 1) -> dict[str, int]:
    """Write a recorded run as a .glb file with embedded pictures.

    Args:
        folder: The run folder.
        path: The file.
        every: Write every N-th recorded frame, and the last.

    Returns:
        The numbers of bodies, frames and pictures.

    Raises:
        RunError: if nothing is recorded, deformable bodies have too many points, or the file cannot be written.
    """
    if path.suffix != ".glb":
        raise RunError(f"{path}: a binary glTF file ends in .glb")
    scenery = Scenery(folder, stride=every)
    _check(scenery, path, every)
    with temporary_folder_beside(path) as place:
        writer = _Writer(scenery, place)
        counts = writer.write()
        writer.glb.write(place / path.name)
        move_into_place(place / path.name, path)
    return counts


def _check(scenery: Scenery, path: Path, every: int) -> None:
    """Refuse recordings whose files no viewer would open."""
    if not scenery.figures:
        return
    count = len(scenery.frames)
    total = sum(figure.size for figure in scenery.figures) * count
    factor = max(count / MOST_TARGETS, total / MOST_MORPHED)
    if factor > 1:
        raise RunError(
            f"{path}: deformable bodies have {total // count} points in {count} frames, and glTF allows at most "
            f"{MOST_TARGETS} frames and {MOST_MORPHED} points in all frames; write USD (--usd), or fewer frames "
            f"(--every {math.ceil(every * factor * 1.02)})"
        )


class _Writer:
    """Writes one document."""

    def __init__(self, scenery: Scenery, place: Path) -> None:
        self.glb, self._scenery, self._place = Glb(), scenery, place
        self._channels: list[dict[str, Any]] = []
        self._samplers: list[dict[str, Any]] = []
        self._materials: dict[ExportMaterial, int] = {}
        self._textures: dict[Path, tuple[int, bool]] = {}
        self._shapes: dict[Path, dict[str, Any]] = {}
        self._meshes: dict[tuple[Path, ExportMaterial], int] = {}

    def write(self) -> dict[str, int]:
        scenery = self._scenery
        top: list[int] = []
        self.glb.add("nodes", {"name": "run", "rotation": UPRIGHT, "children": top})
        several = {link.body for link in scenery.links if link.row and scenery.links[link.row - 1].body == link.body}
        top += [self._add_link(link, link.body in several) for link in scenery.links if link.pieces]
        top += [self._add_figure(figure) for figure in scenery.figures]
        top += [self._add_camera(name, track) for name, track in camera_tracks(scenery.recording).items()]
        if self._channels:
            row = {"name": "run", "channels": self._channels, "samplers": self._samplers}
            self.glb.add("animations", row)
        bodies = {link.body for link in scenery.links if link.pieces} | {figure.body for figure in scenery.figures}
        return {"bodies": len(bodies), "frames": len(scenery.frames), "pictures": len(self._textures)}

    # --- contents --------------------------------------------------------------------

    def _add_link(self, link: SceneryLink, one_of_several: bool) -> int:
        name = f"{link.body}.{link.name}" if one_of_several else link.body
        node: dict[str, Any] = {"name": name, "extras": {"body": link.body, "link": link.name, "mass": link.mass}}
        pieces = link.pieces
        if len(pieces) == 1 and not any(pieces[0].pos) and abs(pieces[0].quat[0]) == 1:
            node["mesh"] = self._mesh(pieces[0])
        else:
            node["children"] = [
                self.glb.add(
                    "nodes",
                    {"translation": list(p.pos), "rotation": _gltf_quaternion(np.array(p.quat)), "mesh": self._mesh(p)},
                )
                for p in pieces
            ]
        number = self.glb.add("nodes", node)
        pos, quat = (values[:, link.row] for values in self._scenery.poses)
        self._animate(number, node, self._scenery.times, pos, quat)
        return number

    def _mesh(self, piece: SceneryPiece) -> int:
        key = piece.mesh, piece.material
        if key not in self._meshes:
            if piece.mesh not in self._shapes:
                mesh = self._scenery.mesh(piece.mesh)
                self._shapes[piece.mesh] = self._primitive(mesh.vertices, mesh.faces, mesh.normals, mesh.uvs)
            primitive = self._shapes[piece.mesh] | {"material": self._material(piece.material)}
            self._meshes[key] = self.glb.add("meshes", {"primitives": [primitive]})
        return self._meshes[key]

    def _primitive(self, vertices: Array, faces: Any, normals: Array, uvs: Array | None) -> dict[str, Any]:
        attributes = {
            "POSITION": self.glb.floats(vertices, bounds=True, vertices=True),
            "NORMAL": self.glb.floats(unit_rows(normals), vertices=True),
        }
        if uvs is not None:  # glTF has the origin of pictures at the upper left
            attributes["TEXCOORD_0"] = self.glb.floats(uvs * (1, -1) + (0, 1), vertices=True)
        return {"attributes": attributes, "indices": self.glb.indices(faces)}

    def _add_figure(self, figure: Figure) -> int:
        frames = [int(k) for k in self._scenery.frames]
        primitive, targets = self._surface(figure, frames) if figure.faces is not None else self._grains(figure, frames)
        primitive["material"] = self._material(figure.material)
        mesh: dict[str, Any] = {"name": figure.body, "primitives": [primitive]}
        if targets:
            primitive["targets"] = targets
            mesh["weights"] = [0.0] * len(targets)
        node = {"name": figure.body, "mesh": self.glb.add("meshes", mesh), "extras": {"body": figure.body}}
        number = self.glb.add("nodes", node)
        if targets:
            # The first frame is the mesh itself; each other frame has its target, blended in between.
            weights = np.eye(len(frames), dtype=np.float32)[:, 1:]
            self._channel(number, "weights", self._scenery.times, weights.ravel())
        return number

    def _surface(self, figure: Figure, frames: list[int]) -> tuple[dict[str, Any], list[dict[str, int]]]:
        first, lying = figure.points(frames[0]), unit_rows(figure.normals(frames[0]))
        targets = [
            {
                "POSITION": self.glb.floats(figure.points(k) - first, bounds=True, vertices=True),
                "NORMAL": self.glb.floats(unit_rows(figure.normals(k)) - lying, vertices=True),
            }
            for k in frames[1:]
        ]
        return self._primitive(first, figure.faces, lying, figure.uvs), targets

    def _grains(self, figure: Figure, frames: list[int]) -> tuple[dict[str, Any], list[dict[str, int]]]:
        """Particles as octahedra, because viewers draw points one pixel wide; as points if there are too many."""
        first, many = figure.points(frames[0]), len(CORNERS)
        if figure.size * many * len(frames) > MOST_MORPHED:
            attributes = {"POSITION": self.glb.floats(first, bounds=True, vertices=True)}
            primitive, many = {"attributes": attributes, "mode": POINTS}, 1
        else:
            vertices = (first[:, None] + 0.5 * figure.spacing * CORNERS).reshape(-1, 3)
            faces = np.arange(figure.size)[:, None, None] * many + SIDES
            primitive = self._primitive(vertices, faces, np.tile(CORNERS, (figure.size, 1)), None)
        targets = [
            {"POSITION": self.glb.floats((figure.points(k) - first).repeat(many, axis=0), bounds=True, vertices=True)}
            for k in frames[1:]
        ]
        return primitive, targets

    def _add_camera(self, name: str, track: Track) -> int:
        width, height = self._scenery.recording.film["resolution"]
        lens = {"yfov": math.radians(track.views[0].fov), "aspectRatio": width / height, "znear": 0.01, "zfar": 1000.0}
        camera = self.glb.add("cameras", {"name": name, "type": "perspective", "perspective": lens})
        node: dict[str, Any] = {"name": f"camera {name}", "camera": camera}
        number = self.glb.add("nodes", node)
        self._animate(number, node, track.times, *track.poses())
        return number

    # --- writing ----------------------------------------------------------------------

    def _animate(self, number: int, node: dict[str, Any], times: Array, pos: Array, quat: Array) -> None:
        node["translation"], node["rotation"] = pos[0].tolist(), _gltf_quaternion(quat[0])
        turned = unit_rows(np.roll(quat, -1, axis=1))
        for path, values in (("translation", pos), ("rotation", turned)):
            if (values != values[0]).any():
                kept = keyframe_rows(values)
                self._channel(number, path, times[kept], values[kept])

    def _channel(self, number: int, path: str, times: Array, values: Array) -> None:
        sampler = {
            "input": self.glb.floats(times, bounds=True), "output": self.glb.floats(values), "interpolation": "LINEAR",
        }  # fmt: skip
        self._samplers.append(sampler)
        target = {"node": number, "path": path}
        self._channels.append({"sampler": len(self._samplers) - 1, "target": target})

    def _material(self, material: ExportMaterial) -> int:
        if material in self._materials:
            return self._materials[material]
        surface: dict[str, Any] = {
            "baseColorFactor": [*material.color, material.opacity],
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        row: dict[str, Any] = {"pbrMetallicRoughness": surface, "doubleSided": material.two_sided}
        if material.opacity < 1:
            row["alphaMode"] = "BLEND"
        if material.picture is not None:
            number, holed = self._texture(material.picture)
            surface["baseColorTexture"] = {"index": number}
            if holed and material.opacity >= 1:
                row["alphaMode"] = "MASK"
        if material.clearcoat > 0:
            self.glb.use("KHR_materials_clearcoat")
            row["extensions"] = {"KHR_materials_clearcoat": {"clearcoatFactor": material.clearcoat}}
        self._materials[material] = self.glb.add("materials", row)
        return self._materials[material]

    def _texture(self, source: Path) -> tuple[int, bool]:
        if source not in self._textures:
            path = self._place / f"picture_{len(self._textures)}.png"
            holed = save_picture(source, path)
            image = self.glb.add("images", {"mimeType": "image/png", "bufferView": self.glb.view(path.read_bytes())})
            if "samplers" not in self.glb.document:
                self.glb.add("samplers", {"wrapS": 10497, "wrapT": 10497, "magFilter": 9729, "minFilter": 9987})
            self._textures[source] = self.glb.add("textures", {"source": image, "sampler": 0}), holed
        return self._textures[source]


def _gltf_quaternion(quat: Array) -> list[float]:
    """An orientation (w, x, y, z) in the order of glTF."""
    return np.roll(unit_rows(quat), -1).tolist()
