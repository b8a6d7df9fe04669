"""Resolution of deformable bodies: one grid cell and one particle size for the scene, edges for each body."""

from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.boxes import sides
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.revolved import profile_length, revolved_area
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.compiler.shapes.softmesh import hull_area, solid_volume
from text2sim.compiler.soft.solvers import is_soft, solver_of
from text2sim.spec_schema.models.scene import Scene

PARTICLE_CELLS = 0.64
"""Distance of mpm particles in cells of the grid, as the engine chooses it."""
MPM_THROUGH, FLOW_THROUGH, STREAM_THROUGH, FEM_THROUGH, PBD_ACROSS = 5, 8, 4, 4, 40
"""Cells through the thinnest part of a soft body, of one that flows and of a stream, elements through a fem body,
particles across the shorter side of a sheet."""
MPM_BUDGET, FEM_BUDGET, PBD_BUDGET = 20_000, 4_000, 4_000
"""Particles, tetrahedra and particles in a scene that two cores still simulate in minutes."""
CONTACT_REACH, REACH_CELLS = 0.002, 8
"""How far [m] the contact of a rigid body reaches by default in the engine, and how many such reaches make a cell."""
STROKE_SHARE = 1 / 6
"""Thickness of the strokes of a bold letter, as a part of its height."""


@dataclass(frozen=True)
class Scales:
    """Resolution of all deformable bodies."""

    mpm_cell: float | None
    """Cell of the grid [m]; None without mpm bodies."""
    reach: float
    """Distance [m] from rigid bodies at which mpm bodies feel them, unless their material has a `soft_reach`."""
    pbd_size: float | None
    """Distance of particles [m]; None without pbd bodies."""
    edges: dict[str, float]
    """Edge [m] of the elements of fem and ipc bodies, by body."""
    why: dict[str, str]
    """A sentence for each value that was derived."""

    def spacing(self, body: str, solver: str) -> float:
        """Return the distance [m] between neighbouring points of a body at rest."""
        if solver == "mpm":
            assert self.mpm_cell is not None
            return PARTICLE_CELLS * self.mpm_cell
        if solver == "pbd":
            assert self.pbd_size is not None
            return self.pbd_size
        return self.edges[body]


def scales(scene: Scene, placed: dict[str, list[Copy]], folder: Path) -> Scales:
    """Choose what the author left open.

    Args:
        scene: The scene.
        placed: Copies by static and body.
        folder: Folder of the case, for files of shapes.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    by_solver = copies_by_solver(scene, placed)
    why: dict[str, str] = {}
    edges: dict[str, float] = {}
    for solver in ("fem", "ipc"):
        if solver in by_solver:
            edges |= _edges(solver, by_solver[solver], folder, why)
    cell = _mpm_cell(scene, by_solver["mpm"], folder, why) if "mpm" in by_solver else None
    return Scales(
        mpm_cell=cell,
        reach=0.0 if cell is None else _reach(cell, by_solver["mpm"], why),
        pbd_size=_pbd_size(scene, by_solver["pbd"], folder, why) if "pbd" in by_solver else None,
        edges=edges,
        why=why,
    )


def copies_by_solver(scene: Scene, placed: dict[str, list[Copy]]) -> dict[str, list[Copy]]:
    """Return the copies of deformable bodies by solver."""
    found: dict[str, list[Copy]] = {}
    for copies in placed.values():
        for copy in copies:
            if is_soft(copy.model):
                found.setdefault(solver_of(copy.model, scene) or "", []).append(copy)
    return found


def thickness(shape: Any, folder: Path) -> float:
    """Return the smallest thickness [m] of a solid, such as its wall, its bar or its strokes.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    if shape.kind in ("text", "sketch"):
        return min(shape.depth, STROKE_SHARE * shape.height)
    if shape.kind == "tube":  # its staves touch each other: their width does not count
        return min(shape.outer_radius - shape.inner_radius, shape.height)
    if shape.kind in ("cup", "funnel"):
        return shape.thickness
    if shape.kind == "stream":
        return 2 * shape.radius
    if shape.kind == "compound":
        return min(thickness(part.shape, folder) for part in shape.solids.values())
    if shape.kind == "sculpt":
        from text2sim.compiler.shapes.distances import form_of

        return min(form_of(part).thin for part in shape.parts.values() if part.op == "add")
    return min(piece.thickness for piece in geometry.pieces(shape, folder))


def sheet_size(shape: Any, folder: Path) -> tuple[float, float]:
    """Return the side lengths [m] of a cloth, the shorter first; for a mesh, the two longer sides of its bounds.

    A ribbon, a sleeve and a surface of revolution count as laid flat. A disc counts as a rectangle of its area, and as
    wide as both sides of the ring around its hole; a hull as one of its area, and as wide as both sides of the solid.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    if shape.kind == "sheet":
        return min(shape.size), max(shape.size)
    if shape.kind == "ribbon":
        long = hull_area(shape, folder) / shape.width
        return min(shape.width, long), max(shape.width, long)
    if shape.kind == "sleeve":
        around = shape.area / shape.slant
        return min(shape.slant, around), max(shape.slant, around)
    if shape.kind == "revolve":
        long = profile_length(shape)
        around = revolved_area(shape) / long
        return min(long, around), max(long, around)
    if shape.kind == "disc":
        wide = 2 * (shape.radius - shape.hole)
        return min(wide, shape.area / wide), max(wide, shape.area / wide)
    _, short, long = sorted(sides(extents(shape, IDENTITY, folder)))
    if shape.kind == "mesh":
        return short, long
    wide = 2 * short
    long = hull_area(shape, folder) / wide
    return min(wide, long), max(wide, long)


def _smallest_given_cell(copies: list[Copy]) -> float | None:
    """Return the smallest `cell` of the bodies; None if none has one."""
    return min((copy.model.cell for copy in copies if copy.model.cell is not None), default=None)


def _mpm_cell(scene: Scene, copies: list[Copy], folder: Path, why: dict[str, str]) -> float:
    if scene.mpm.cell is not None:
        return scene.mpm.cell
    given = _smallest_given_cell(copies)
    if given is not None:
        why["mpm_cell"] = "the smallest cell of its bodies"
        return given
    through = {copy.body: _cells_through(copy) for copy in copies}
    thin = [(thickness(copy.shape, folder) / through[copy.body], copy.body) for copy in copies]
    volume = sum(solid_volume(copy.shape, folder) for copy in copies)
    (fine, body), coarse = min(thin), (volume / MPM_BUDGET) ** (1 / 3) / PARTICLE_CELLS
    if fine >= coarse:
        why["mpm_cell"] = f"{through[body]} cells through the thinnest part of `{body}`"
        return _rounded(fine)
    why["mpm_cell"] = f"{MPM_BUDGET} particles fill its bodies ({volume:.3g} m3); finer is slow"
    return _rounded(coarse)


def _cells_through(copy: Copy) -> int:
    if copy.model.kind == "soft":
        return MPM_THROUGH
    return STREAM_THROUGH if copy.shape.kind == "stream" else FLOW_THROUGH


def _reach(cell: float, copies: list[Copy], why: dict[str, str]) -> float:
    if any(copy.model.kind == "liquid" for copy in copies):
        why["soft_reach"] = "a quarter of a cell: more would narrow what the liquid flows through"
        return cell / 4
    return min(cell / REACH_CELLS, CONTACT_REACH)


def _pbd_size(scene: Scene, copies: list[Copy], folder: Path, why: dict[str, str]) -> float:
    if scene.pbd.particle_size is not None:
        return scene.pbd.particle_size
    given = _smallest_given_cell(copies)
    if given is not None:
        why["pbd_size"] = "the smallest cell of its bodies"
        return given
    sizes = [sheet_size(copy.shape, folder) for copy in copies]
    short = min(size[0] for size in sizes)
    # Remeshed triangles are nearly equilateral: one corner for each sqrt(3)/2 of the square of an edge.
    coarse = sqrt(sum(a * b for a, b in sizes) / (0.866 * PBD_BUDGET))
    fine = short / PBD_ACROSS
    if fine >= coarse:
        why["pbd_size"] = f"{PBD_ACROSS} particles across the smallest cloth ({short:.3g} m)"
        return _rounded(fine)
    why["pbd_size"] = f"{PBD_BUDGET} particles make all cloths; finer is slow"
    return _rounded(coarse)


def _edges(solver: str, copies: list[Copy], folder: Path, why: dict[str, str]) -> dict[str, float]:
    """Return the edge [m] by body, one for all copies of a body."""
    edges: dict[str, float] = {}
    solids = [copy for copy in copies if copy.model.kind == "soft"]
    volume = sum(solid_volume(copy.shape, folder) for copy in solids)
    # A regular tetrahedron of edge a has the volume a^3 / (6 sqrt(2)).
    coarse = (6 * sqrt(2) * volume / FEM_BUDGET) ** (1 / 3)
    for copy in copies:
        if copy.model.cell is not None:
            edges[copy.body] = copy.model.cell
            continue
        if copy.model.kind == "cloth":
            short, _ = sheet_size(copy.shape, folder)
            edge = short / PBD_ACROSS
            why[f"{solver}_edge"] = f"{PBD_ACROSS} edges along the shorter side of a cloth"
        else:
            fine = thickness(copy.shape, folder) / FEM_THROUGH
            edge = max(fine, coarse)
            why[f"{solver}_edge"] = (
                f"{FEM_THROUGH} elements through its thinnest part"
                if fine >= coarse
                else f"{FEM_BUDGET} tetrahedra fill all bodies; finer is slow"
            )
        edges[copy.body] = min(edges.get(copy.body, edge), _rounded(edge))
    return edges


def _rounded(length: float) -> float:
    """Round to three digits, which are easier to read."""
    return float(f"{length:.3g}")
