"""Draws deformable bodies from their recorded states, with its own nodes in the engine's rasterizer.

The engine itself can only draw the current states of its solvers.
"""

import json
from pathlib import Path

import numpy as np
from genesis.ext import pyrender
from genesis.utils.mesh import create_sphere
from genesis.utils.particle import particles_to_mesh
from shading import LETS_GO, Shell, enclosed, part_of_triangles, smooth_normals
from soft_states import SoftStates
from streams import flowing

HERE = Path(__file__).resolve().parent
FINISH = {"metallicFactor": 0.2, "roughnessFactor": 0.8}  # the rasterizer's values for rigid bodies
SHADES = {"granular": (0.86, 1.0, 1.12), "snow": (0.96, 1.0)}  # factors on the color, which make grains distinguishable
GRAIN = 0.62  # radius of a drawn particle, in particle spacings: a heap has no visible gaps
SMOOTHING = "splashsurf-1.0-smooth-10"  # ten iterations; they take 3 % of the volume of two thousand particles
ENCLOSING = 1.5  # edge of the cells of `enclosed`, in particle spacings
ROUND = 3000  # largest number of particles that are drawn as smooth balls


class SoftFilm:
    """Draws the deformable bodies of a film.

    Args:
        scene: Scene whose visualizer is not yet built; the visualizer will not draw these bodies itself.
        states: Recorded states of the bodies.
        geometry: Folder of the geometry.
    """

    def __init__(self, scene, states: SoftStates, geometry: Path):
        self._scene, self._states, self._geometry, self._figures = scene, states, geometry, []
        self._mouths = {}  # where what has not come out of a stream waits, by number of the body
        context = scene.visualizer.context
        for solver in ("mpm", "pbd", "fem"):
            setattr(context, f"on_{solver}", _nothing)
            setattr(context, f"update_{solver}", _nothing)
        scene.mpm_solver.update_render_fields = scene.pbd_solver.update_render_fields = _nothing

    def show(self, around: tuple[int, int, float]) -> None:
        """Updates every body to its state between two frames, see `SoftStates.at`; call before rendering a picture."""
        self._figures = self._figures or self._make()
        for k, (figure, places) in enumerate(zip(self._figures, self._places(around), strict=True)):
            if k in self._mouths:
                places = places[flowing(places, self._mouths[k], self._states.rows[k]["spacing"])]
            figure.show(places) if len(places) else figure.clear()

    def _make(self) -> list:
        looks = json.loads((self._geometry / "soft_index.json").read_text())
        self._looks = json.loads((HERE / "looks.json").read_text())
        figures = []
        for k, (row, at_rest) in enumerate(zip(self._states.rows, self._places((0, 0, 0.0)), strict=True)):
            arrays = np.load(self._geometry / f"soft_{k}.npz")
            if "faces" in arrays:
                uvs = arrays["uvs"] if "uvs" in arrays else None
                material = _material(looks[k], self._geometry)
                figures.append(_Surface(self._scene, row, material, Shell(at_rest, arrays["faces"]), uvs))
                if (look := self._looks.get(row["body"], {})).get("regions"):
                    parts = part_of_triangles(HERE / look["regions"], at_rest, arrays["faces"], row["pos"], row["quat"])
                    figures[-1].wear([look, *(part or look for part in look["parts"])], parts)
            else:
                figures.append((_Liquid if row["kind"] == "liquid" else _Grains)(self._scene, row, looks[k]))
                if row.get("stream"):
                    self._mouths[k] = arrays["rest"]
        return figures

    def _places(self, around: tuple[int, int, float]) -> list[np.ndarray]:
        """Positions of the surface of each body, or of its particles if it has none, between two frames [m]."""
        points, surface = self._states.at("soft_points", around), self._states.at("soft_surface", around)
        return [
            points[slice(*row["points"])] if row["surface"] is None else surface[slice(*row["surface"])]
            for row in self._states.rows
        ]

    def close(self) -> None:
        """Removes the bodies from the scene."""
        for figure in self._figures:
            figure.clear()
        self._figures = []


def _nothing(*given, **named) -> None:
    """Replaces the drawing functions of the engine."""


class _Figure:
    """Nodes of one body; segmentation pictures show them under its name."""

    def __init__(self, scene, row: dict):
        self._scene, self._context, self._row = scene, scene.visualizer.context, row
        self._nodes = []

    def clear(self) -> None:
        for node in self._nodes:
            self._context.remove_node_seg(node)
            self._context.remove_node(node)
        self._nodes = []

    def _add(self, **primitive):
        node = self._context.add_node(pyrender.Mesh([pyrender.Primitive(**primitive)]))
        self._context.create_node_seg(self._row["body"], node)
        self._nodes.append(node)
        return node

    def _update(self, node, **buffers) -> None:
        for name, data in buffers.items():
            self._context.jit.update_buffer(node, name, data)


class _Surface(_Figure):
    """A body with a mesh. Cloth is drawn from both sides."""

    def __init__(self, scene, row: dict, material, shell: Shell, uvs: np.ndarray | None):
        super().__init__(scene, row)
        self._material, self._shell, self._uvs, self._colors = material, shell, uvs, None
        self._gap = LETS_GO * row["spacing"] if row["kind"] == "soft" and row["solver"] == "mpm" else np.inf
        self._whole = np.ones(len(shell.faces), bool)

    def wear(self, looks: list[dict], parts: np.ndarray) -> None:
        """Gives each vertex the color of its part; `looks[0]` is the body's, `parts` come from `part_of_triangles`."""
        colors = np.array([[*look["color"], look["opacity"]] for look in looks], np.float32)
        self._colors = np.empty((len(self._shell.sources), 4), np.float32)
        self._colors[self._shell.faces] = colors[parts + 1][:, None]
        self._material = _material({"color": [1.0, 1.0, 1.0, float(colors[:, 3].min())]})

    def show(self, vertices: np.ndarray) -> None:
        shell = self._shell
        positions, normals = vertices[shell.sources].astype(np.float32), shell.normals(vertices)
        whole = shell.whole(vertices, self._gap) if np.isfinite(self._gap) else self._whole
        if (whole != self._whole).any():  # the body tears or heals, so other triangles are drawn
            self.clear()
            self._whole = whole
        if self._nodes:
            self._update(self._nodes[0], pos=positions, normal=normals)
            return
        uvs = None if self._uvs is None else self._uvs[shell.sources]
        self._add(
            positions=positions,
            normals=normals,
            indices=shell.faces[self._whole],
            color_0=self._colors,
            # v is measured from the top of the picture.
            texcoord_0=None if uvs is None else uvs * np.array([1, -1]) + np.array([0, 1]),
            material=self._material,
            double_sided=self._row["kind"] == "cloth",
        )


class _Grains(_Figure):
    """A body of particles, drawn as balls. Hidden particles inside a heap are left out."""

    def __init__(self, scene, row: dict, look: dict):
        super().__init__(scene, row)
        self._shades = [_material({"color": _shade(look["color"], x)}) for x in SHADES.get(row["kind"], (1.0,))]

    def show(self, points: np.ndarray) -> None:
        self.clear()
        outside = ~enclosed(points, ENCLOSING * self._row["spacing"])
        ball = create_sphere(GRAIN * self._row["spacing"], subdivisions=1 if outside.sum() <= ROUND else 0)
        for k, material in enumerate(self._shades):
            mine = points[k :: len(self._shades)][outside[k :: len(self._shades)]]
            if len(mine):
                poses = np.tile(np.eye(4, dtype=np.float32), (len(mine), 1, 1))
                poses[:, :3, 3] = mine
                shape = {"positions": ball.vertices, "normals": ball.vertex_normals, "indices": ball.faces}
                self._add(**shape, material=material, poses=poses)


class _Liquid(_Figure):
    """A body of particles, drawn as one surface that is reconstructed for every picture."""

    def __init__(self, scene, row: dict, look: dict):
        super().__init__(scene, row)
        self._material = _material(look)

    def show(self, points: np.ndarray) -> None:
        mesh = particles_to_mesh(points.astype(np.float32), self._row["spacing"] / 2, SMOOTHING)
        self.clear()
        if len(mesh.faces):
            vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int32)
            normals = smooth_normals(vertices[faces], faces.ravel(), len(vertices))
            self._add(positions=vertices, normals=normals, indices=faces, material=self._material)


def _material(look: dict, folder: Path | None = None):
    """Returns the material for a look: its texture if it has one, else its color."""
    if folder is not None and "texture" in look:
        from PIL import Image

        picture = Image.open(folder / look["texture"])
        is_opaque = "A" not in picture.getbands() or picture.getextrema()[-1][0] == 255
        mode = "OPAQUE" if is_opaque else "BLEND"
        return pyrender.MetallicRoughnessMaterial(alphaMode=mode, baseColorTexture=picture, **FINISH)
    mode = "OPAQUE" if look["color"][3] == 1 else "BLEND"
    return pyrender.MetallicRoughnessMaterial(alphaMode=mode, baseColorFactor=look["color"], **FINISH)


def _shade(color: list[float], factor: float) -> list[float]:
    return [min(1.0, factor * x) for x in color[:3]] + [color[3]]
