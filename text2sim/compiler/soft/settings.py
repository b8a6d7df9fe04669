"""Settings of the solvers of deformable bodies, derived from the scene, each with its reason."""

from collections.abc import Callable
from functools import partial
from math import ceil, exp, floor, hypot, inf, sqrt
from pathlib import Path
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds, sides
from text2sim.compiler.soft import ipc
from text2sim.compiler.soft.gas import gas_step
from text2sim.compiler.soft.materials import DAMPING
from text2sim.compiler.soft.scales import Scales, copies_by_solver, sheet_size
from text2sim.compiler.soft.setup import FemSettings, MpmSettings, PbdSettings, SapSettings, SoftSettings
from text2sim.compiler.soft.solver_domain import domain_box, find_surroundings, floor_height
from text2sim.compiler.soft.travel import Travel
from text2sim.spec_schema.models.scene import Scene
from text2sim.spec_schema.models.sheets import Sleeve
from text2sim.spec_schema.models.soft_bodies import Cloth, Liquid, Snow
from text2sim.spec_schema.models.soft_materials import SnowMaterial

PADDING = 3
"""Cells at each side of the grid in which the engine stops all motion."""
MAX_COURANT = 0.5
"""Largest Courant number: the part of a cell that sound crosses in a substep. From 0.74 on stiff bodies diverge, with
finite numbers."""
STEPS_PER_CELL = 0.02, 0.05
"""Substep [s] per metre of cell that the engine suggests, whatever moves, and the longest where sound and motion are so
slow that they cross `MAX_COURANT` of a cell in no less: the engine's is for 25 m/s, and most soft bodies are slower."""
MAX_MPM_CELLS, MAX_PBD_CELLS = 3_000_000, 1_000_000
"""Largest numbers of cells of the grid, because of their memory, and of the space of cloth."""
HASH_CELL_DISTANCES, HASH_CELLS_PER_AXIS = 1.25, 32
"""Cell of the spatial hash of cloth in particle distances, as the engine has it, and cells along each axis; rounding
may make the engine add one. The hash repeats in space, and every substep clears all of it: `python -m
benchmarks.engine_defaults` measures 5.1 ms a substep, and 13.8 ms with the engine's default, which covers the whole
space.
"""
SNOW_EXPONENT = 10.0
"""Exponent of the engine's law of snow: at a part Jp of its volume, it is exp(10 (1 - Jp)) times as stiff."""
LEAST_COMPRESSION = 0.1
"""Part by which snow is assumed to be compressed even if nothing hits it."""
MIN_SHEET_STEP = 1e-4
"""Shortest substep [s] that is derived for a stiff sheet: one that needs a shorter substep is softer, but stable."""
MAX_PBD_STEP = 0.0005
"""Longest substep [s] of cloth, which is stiffer the more sweeps its solver makes in a second."""
STRETCH_RELAXATION = 0.3
"""Part of its error by which a sweep corrects a thread: the engine's."""
STRETCH_ITERATIONS = (4, 8, 16, 32)
"""Sweeps over the threads in a substep: the engine's number, and more for fine cloth. 16 instead of 4 make a substep of
922 points take 2.3 ms instead of 1.5. Few numbers, because the engine compiles kernels for each."""
ELASTIC_SWEEPS = 16
"""Sweeps for which the substep of an elastic sheet is derived: four times as many make it as stiff as half the step."""
MAX_OWN_STRETCH = 0.01
"""Part by which a cloth may get longer under its own weight, if its sweeps are derived."""
MAX_FEM_STEP = 0.01
"""Longest substep [s] of the implicit solver: longer ones damp motion."""


def derive_soft(
    scene: Scene,
    model: str,
    scales: Scales,
    placed: dict[str, list[Copy]],
    travel: Travel,
    fastest: float,
    impact: float,
    folder: Path,
) -> SoftSettings:
    """Choose what the author left open in a scene with deformable bodies.

    Args:
        scene: The section.
        model: Its contact model.
        scales: Resolution of bodies.
        placed: Copies by static and body.
        travel: How far bodies may get.
        fastest: Largest initial velocity [m/s] of a pbd body.
        impact: Speed [m/s] at which something may hit an mpm body.
        folder: The case's folder.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    by_solver = copies_by_solver(scene, placed)
    why = dict(scales.why)
    if scene.contact.model is None:
        why["model"] = {
            "particle": "mpm and pbd bodies touch rigid bodies, both ways",
            "sap": "fem bodies touch rigid bodies and each other in this model alone",
            "ipc": "cloth with solver ipc needs it",
        }[model]
    around = find_surroundings(placed, scene, travel, folder)

    def domain(solver: str, margin: float, volume: float, cell: float) -> Bounds:
        box = domain_box(by_solver[solver], around, margin, volume)
        return _to_whole_cells(box, cell)

    substeps: list[tuple[float, str]] = []
    mpm = pbd = fem = sap = coupler = None
    if "mpm" in by_solver:
        mpm = _mpm(scene, scales, domain, why)
        substeps += _mpm_steps(mpm.cell, by_solver["mpm"], impact)
    if "pbd" in by_solver:
        assert scales.pbd_size is not None
        substeps += _pbd_steps(scales.pbd_size, by_solver["pbd"], fastest, folder)
        step = scene.dt / (scene.substeps or max(ceil(scene.dt / step - 1e-9) for step, _ in substeps))
        pbd = _pbd(scene, scales.pbd_size, by_solver["pbd"], step, folder, domain, why)
    if "fem" in by_solver or "ipc" in by_solver:
        if model == "ipc":
            coupler = ipc.settings(scene, scales.edges, why)
        else:
            fem = _fem(scene, by_solver.get("fem", []), placed, why)
        substeps.append((MAX_FEM_STEP, "the implicit solver damps motion at longer steps"))
    if model == "sap":
        sap = SapSettings(fem is not None and fem.floor is not None, bool(around.solids))
        why["precision"] = "the sap model is solved in double precision alone"
    precision = "64" if model == "sap" else "32"
    return SoftSettings(model, precision, mpm, pbd, fem, sap, tuple(substeps), why, coupler, impact=impact)


def bending_step(model: Cloth, cell: float) -> float:
    """Return the substep [s] up to which a sheet with points `cell` [m] apart is as stiff as its rigidity says.

    On a grid of cells c, a plate of rigidity D and mass per area m has the highest frequency 8 / c^2 sqrt(D / m); one
    over it would do, but meshes are not so even.
    """
    assert model.material.rigidity is not None
    return cell**2 / 12 * sqrt(model.material.area_density / model.material.rigidity)


def elastic_step(model: Cloth, cell: float) -> float:
    """Return the substep [s] up to which `ELASTIC_SWEEPS` make a sheet as stiff as its material says.

    In a substep h, K sweeps of relaxation w let two points of mass m pull with `K w m / (2 h^2)` [N/m] for each metre
    that their thread is too long, and no more. Points c apart have the mass `sqrt(3) / 2 c^2` times that per area, and
    their threads need `sqrt(3) / 2` of the tension modulus (`templates/elastic_sheets.py`).

    Args:
        model: An elastic sheet.
        cell: Distance of its points [m].
    """
    own = model.material
    assert own.tension_modulus is not None
    narrower = own.prestretch or 1.0 if isinstance(model.shape, Sleeve) else 1.0  # of its triangles at rest
    wanted = own.tension_modulus * narrower
    return cell * sqrt(ELASTIC_SWEEPS * STRETCH_RELAXATION * own.area_density / (2 * wanted))


def snap_speed(model: Any) -> float:
    """Return the speed [m/s] at which a cloth that is stretched at the start draws together; 0 for any other body.

    Its energy per area `E t e^2 / 2`, in both directions, becomes `m v^2 / 2`, with e = prestretch - 1 and its mass per
    area m.
    """
    own = model.material if isinstance(model, Cloth) else None
    if own is None or own.prestretch is None or own.tension_modulus is None:
        return 0.0
    return (own.prestretch - 1) * sqrt(2 * own.tension_modulus / own.area_density)


def own_stretch(long: float, size: float, step: float, iterations: int, gravity: float) -> float:
    """Return the part by which a pbd cloth gets longer under its own weight where it hangs, at rest.

    It comes from the solver, not from the material. In every substep h a point falls by g h^2, and K sweeps of
    relaxation w take it back. In a net of equal triangles of side c, one sweep moves it by w / 2 times the sum over its
    six threads, 9/16 w c^2 de/dz. So the stretch e grows by 16 g h^2 / (9 w K c^2) for each metre above the hem; half
    of that times the length is the mean. Strips of 0.5 m that were let go had 3.2 % for 3.6 % (5 mm, 4 sweeps), and
    0.81 % for 0.91 % (16 sweeps).

    Args:
        long: Its length [m].
        size: Distance of its points [m].
        step: Substep [s].
        iterations: Sweeps over its threads in each substep.
        gravity: Its magnitude [m/s2].
    """
    return 8 * gravity * step**2 * long / (9 * STRETCH_RELAXATION * iterations * size**2)


def snow_hardening(material: SnowMaterial, impact: float) -> float:
    """Return the factor by which snow gets stiffer where it is hit.

    Its stress is about the modulus E times the strain `crush`, times h = exp(10 e) once it is compressed by a part e of
    its volume. A blow compresses it until the work E crush (h - 1) / 10 per volume is the kinetic energy rho v^2 / 2,
    so that h = 1 + 5 rho v^2 / (E crush).

    Args:
        material: Of the snow.
        impact: Speed v [m/s].
    """
    work = material.youngs_modulus * material.crush / SNOW_EXPONENT
    struck = 1 + material.density * impact**2 / 2 / work
    return min(max(struck, exp(SNOW_EXPONENT * LEAST_COMPRESSION)), exp(SNOW_EXPONENT))


def wave_speed(material: Any, model: Any, substep: float = inf, impact: float = 0.0) -> float:
    """Return the fastest sound wave [m/s] in what a body is made of: c^2 = E (1 - nu) / ((1 + nu) (1 - 2 nu) rho).

    Args:
        material: Of the body.
        model: The body.
        substep: Substep [s], in which a viscosity is a shear modulus `viscosity / substep`.
        impact: Speed [m/s] at which something may hit snow, which hardens it.
    """
    if isinstance(model, Liquid):
        # lambda is the stiffness; a viscous liquid also has a shear modulus, 1.5 times as large.
        modulus = material.stiffness * (4.0 if material.viscous else 1.0) + 2 * material.viscosity / substep
        return sqrt(modulus / material.density)
    young, nu = material.youngs_modulus, material.poisson_ratio
    if isinstance(model, Snow):
        young *= snow_hardening(material, impact)
    return sqrt(young * (1 - nu) / ((1 + nu) * (1 - 2 * nu) * material.density))


def sound_step(material: Any, model: Any, cell: float, impact: float) -> float:
    """Return the longest substep s [s] at which sound crosses `MAX_COURANT` of a cell.

    With a viscosity it is the root of `(modulus + 2 viscosity / s) s^2 = density (MAX_COURANT cell)^2`.

    Args:
        material: Of an mpm body.
        model: The body.
        cell: Cell of the grid [m].
        impact: Speed [m/s] at which something may hit snow.
    """
    most, speed = MAX_COURANT * cell, wave_speed(material, model, impact=impact)
    eta = material.viscosity / material.density if isinstance(model, Liquid) else 0.0
    return most**2 / (sqrt(eta**2 + (most * speed) ** 2) + eta)  # without cancellation


# --- the solvers ------------------------------------------------------------------------------------------------


Domain = Callable[[str, float, float, float], Bounds]
"""Returns the box [m] that bodies of a solver stay in, from a margin [m], the most volume [m3] and a cell [m]."""


def _mpm(scene: Scene, scales: Scales, domain: Domain, why: dict[str, str]) -> MpmSettings:
    cell = scales.mpm_cell
    assert cell is not None
    if scene.mpm.bounds is not None:
        low, high = scene.mpm.bounds.min, scene.mpm.bounds.max
    else:
        low, high = domain("mpm", (PADDING + 1) * cell, MAX_MPM_CELLS * cell**3, cell)
        why["mpm_bounds"] = (
            f"where its bodies can come to, and {PADDING + 1} cells more: three of them are a wall of the grid"
        )
    return MpmSettings(cell, float(f"{1 / cell:.6g}"), low, high)


def _mpm_steps(cell: float, copies: list[Copy], impact: float) -> list[tuple[float, str]]:
    steps = ((sound_step(copy.model.material, copy.model, cell, impact), copy.model) for copy in copies)
    shortest, stiffest = min(steps, key=lambda row: row[0])
    fastest = wave_speed(stiffest.material, stiffest, shortest, impact)
    hard = ""
    if isinstance(stiffest, Snow) and snow_hardening(stiffest.material, impact) > snow_hardening(stiffest.material, 0):
        hard = f", hardened where it is hit at up to {impact:.2g} m/s"
    suggested, longest = (step * cell for step in STEPS_PER_CELL)
    calm = MAX_COURANT * cell / (fastest + impact)
    return [
        (suggested, f"as the engine suggests for a grid of {cell:g} m cells")
        if calm <= suggested
        else (min(calm, longest), f"sound and motion, at {fastest + impact:.2g} m/s, cross no more than half a cell"),
        (shortest, f"sound runs at {fastest:.3g} m/s in the stiffest mpm body{hard}: half a cell in a step"),
    ]


def _pbd_steps(size: float, copies: list[Copy], fastest: float, folder: Path) -> list[tuple[float, str]]:
    steps = [(MAX_PBD_STEP, "cloth stretches at longer steps")]
    if stiff := [copy.model for copy in copies if copy.model.material.rigidity]:
        shortest = min(bending_step(model, size) for model in stiff)
        reason = "a stiff sheet is softer at longer steps, and may be at this one"
        steps.append((max(shortest, MIN_SHEET_STEP), reason))
    if elastic := [copy.model for copy in copies if copy.model.material.tension_modulus]:
        shortest = min(elastic_step(model, size) for model in elastic)
        reason = "an elastic sheet is softer than its material at longer steps"
        steps.append((max(shortest, MIN_SHEET_STEP), reason))
        if snap := max(map(snap_speed, elastic)):
            reason = f"at {snap:.3g} m/s, as a stretched sheet draws together, a particle may not cross half its size"
            steps.append((max(size / 2 / snap, MIN_SHEET_STEP), reason))
    if breaths := [step for copy in copies if (step := gas_step(copy, folder)) is not None]:
        steps.append((min(breaths), "a hull springs on the gas in it"))
    if fastest:
        reason = f"at {fastest:g} m/s a particle may not cross half its own size in one step"
        steps.append((size / 2 / fastest, reason))
    return steps


def _pbd(
    scene: Scene, size: float, copies: list[Copy], step: float, folder: Path, domain: Domain, why: dict[str, str]
) -> PbdSettings:
    if scene.pbd.bounds is not None:
        low, high = scene.pbd.bounds.min, scene.pbd.bounds.max
    else:
        low, high = domain("pbd", 4 * size, MAX_PBD_CELLS * (HASH_CELL_DISTANCES * size) ** 3, size)
        why["pbd_bounds"] = "where its bodies can come to; its sides are walls"
    stretch, bending = scene.pbd.stretch_iterations, scene.pbd.bending_iterations
    if stretch is None:
        long = max(sheet_size(copy.shape, folder)[1] for copy in copies)
        stretch_of = partial(own_stretch, long, size, step, gravity=hypot(*scene.gravity))
        elastic = [copy.model for copy in copies if copy.model.material.tension_modulus]
        sweeps = max((ELASTIC_SWEEPS * (step / elastic_step(model, size)) ** 2 for model in elastic), default=0.0)
        enough = (number for number in STRETCH_ITERATIONS if stretch_of(number) <= MAX_OWN_STRETCH and number >= sweeps)
        stretch = next(enough, STRETCH_ITERATIONS[-1])
        why["stretch_iterations"] = f"its own weight then stretches a cloth that hangs by {stretch_of(stretch):.1%}"
        if sweeps:
            why["stretch_iterations"] = f"an elastic sheet needs {sweeps:.3g} to be as stiff as its material"
    if bending is None:
        bending, why["bending_iterations"] = 1, "as the engine has it"
    reach = HASH_CELLS_PER_AXIS * HASH_CELL_DISTANCES * size
    x, y, z = (round(min(side, reach), 6) for side in sides((low, high)))
    return PbdSettings(size, low, high, stretch, bending, (x, y, z))


def _fem(scene: Scene, copies: list[Copy], placed: dict[str, list[Copy]], why: dict[str, str]) -> FemSettings:
    newton = scene.fem.newton_iterations
    if newton is None:
        newton, why["newton_iterations"] = 2, "one leaves turning elements unsolved"
    given = [copy.model.material.damping for copy in copies if copy.model.material.damping is not None]
    alpha = max(given, default=DAMPING)
    if not given:
        why["damping_alpha"] = "as the engine has it: half of the velocity is lost in 1.4 s"
    beta = scene.fem.damping_beta
    if beta is None:
        beta, why["damping_beta"] = 5e-4, "as the engine has it"
    floors = [h for copies in placed.values() for copy in copies if (h := floor_height(copy)) is not None]
    return FemSettings(newton, alpha, beta, max(floors, default=None))


def _to_whole_cells(box: Bounds, cell: float) -> Bounds:
    """Return a box enlarged to whole cells."""
    low, high = box
    a, b, c = (round(floor(x / cell) * cell, 6) for x in low)
    d, e, f = (round(ceil(x / cell) * cell, 6) for x in high)
    return (a, b, c), (d, e, f)
