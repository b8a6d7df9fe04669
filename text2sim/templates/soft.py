"""Records deformable bodies: particles of MPM and PBD, vertices of FEM, and the surfaces that are drawn.

    OUT/states/layout.json             "deformables": meaning of the rows of the arrays below
    OUT/states/chunk_00000.npz         soft_points, soft_surface, soft_velocity, soft_spin, soft_kinetic, soft_speed
    OUT/geometry/soft_0.npz            one for each body: points at rest, masses, tetrahedra, faces, texture coordinates
    OUT/geometry/soft_index.json       color and texture of each body

Three of the solvers do not check for nan, and a nan can crash the process. Therefore this module checks their numbers.
"""

from pathlib import Path

import genesis as gs
import numpy as np
from contacts import in_place
from files import write_json, write_npz, write_paint
from genesis.engine.couplers import IPCCoupler
from genesis.utils.misc import qd_to_numpy
from recorder import Divergence
from skins import follow_sheet, follow_solid

GRANULAR = gs.materials.MPM.Sand, gs.materials.MPM.Liquid, gs.materials.MPM.Snow
CORNERED = 0.5  # share of a body's points in edges of its solver's domain above which the run counts as diverged


class Soft:
    """Reads the states of all deformable bodies.

    Args:
        scene: Built scene with one environment.
        bodies: Copy name -> entity.
        deformables: Copy name -> kind, solver (mpm, pbd, fem or ipc), spacing [m], initial pose of its frame (pos [m],
            quat) and its stream, if it is one, in the order of their rows.
        dt: Time step [s].
        speed_limit: Speed of a point above which the run counts as diverged [m/s].

    Attributes:
        names: Copy names, in the order of the rows.
    """

    def __init__(self, scene, bodies: dict, deformables: dict[str, dict], dt: float, speed_limit: float):
        self.names = list(deformables)
        self._sim, self._dt, self._speed_limit = scene.sim, dt, speed_limit
        self._fields = _fields(scene)
        self._bodies = [_Body(scene, bodies[name], **what) for name, what in deformables.items()]
        ends = np.cumsum([len(body.masses) for body in self._bodies]).tolist()
        self._starts = [0, *ends[:-1]]
        self._rows = [slice(start, end) for start, end in zip(self._starts, ends, strict=True)]
        self._masses = np.concatenate([body.masses for body in self._bodies])
        self._total = np.add.reduceat(self._masses, self._starts)
        # IPC does not expose velocities, so they are differences of positions.
        self._before = self._positions() if isinstance(scene.sim.coupler, IPCCoupler) else None
        self._moved = np.zeros_like(self._before) if self._before is not None else None

    def describe(self, folder: Path) -> list[dict]:
        """Writes the geometry of the bodies to `folder`, and returns their rows of the layout."""
        positions, rows, looks, vertices = self._positions(), [], [], 0
        for k, (name, body, here) in enumerate(zip(self.names, self._bodies, self._rows, strict=True)):
            arrays = {"rest": positions[here].astype(np.float32), "masses": body.masses, **body.topology}
            write_npz(folder / f"soft_{k}.npz", arrays)
            looks.append({"body": name, **write_paint(folder, body.entity.surface.get_rgba())})
            row = {"body": name, "kind": body.kind, "solver": body.solver, "points": [here.start, here.stop]}
            row["surface"] = None if body.skin is None else [vertices, vertices + len(body.skin)]
            row |= {"spacing": body.spacing, "mass": float(self._total[k])}
            row |= {"pos": [float(x) for x in body.pos], "quat": [float(x) for x in body.quat]}
            vertices += 0 if body.skin is None else len(body.skin)
            if body.stream is not None:
                row["stream"] = True
            if body.domain is not None:
                row["domain"] = [bound.tolist() for bound in body.domain]
            rows.append(row)
        write_json(folder / "soft_index.json", looks)
        return rows

    def watch_substeps(self) -> None:
        """Checks every substep of solvers in which a nan would crash the process, until `close`."""
        frail = [fields for name, fields in self._fields.items() if name != "mpm"]
        if not frail or self._before is not None:
            return
        substep = self._sim.substep

        def watched(f):
            substep(f)
            if not all(_is_sound(*read(f + 1), self._speed_limit) for read in frail):
                done = self._sim.cur_substep_global + 1
                divergence = self.check(done * self._dt / self._sim.substeps, f + 1)
                if divergence is not None:
                    raise divergence

        self._sim.substep = watched

    def close(self) -> None:
        """Restores the simulator."""
        vars(self._sim).pop("substep", None)

    def end_step(self, t: float) -> Divergence | None:
        """Checks a step that ends at time `t` [s]; returns its divergence, or None."""
        if self._before is not None:
            positions = self._positions()
            self._before, self._moved = positions, positions - self._before
        f = self._sim.cur_substep_local
        if all(_is_sound(*read(f), self._speed_limit) for read in self._fields.values()):
            return None
        return self.check(t)

    def read(self) -> dict[str, np.ndarray]:
        """Returns the arrays of one frame, for P points, S vertices of surfaces and B bodies.

        Returns:
            soft_points (P, 3): Positions [m].
            soft_surface (S, 3): Positions of the vertices of surfaces [m].
            soft_velocity (B, 3): Velocity of each centre of mass [m/s].
            soft_spin (B, 3): Angular momentum about each centre of mass [kg m2/s], sum m x × v - M c × u.
            soft_kinetic (B,): Kinetic energy of the points [J].
            soft_speed (B,): Largest speed of a point [m/s].
        """
        positions, velocities = self._positions(), self._velocities()
        squares = np.einsum("ij,ij->i", velocities, velocities)
        momenta = self._masses[:, None] * velocities
        momentum = np.add.reduceat(momenta, self._starts)
        centers = np.add.reduceat(self._masses[:, None] * positions, self._starts) / self._total[:, None]
        turning = np.add.reduceat(np.cross(positions, momenta), self._starts)
        drawn = [
            (body.skin, here) for body, here in zip(self._bodies, self._rows, strict=True) if body.skin is not None
        ]
        surface = [skin(positions[here]) for skin, here in drawn]
        return {
            "soft_points": positions.astype(np.float32),
            "soft_surface": np.concatenate([np.zeros((0, 3), np.float32), *surface]),
            "soft_velocity": momentum / self._total[:, None],
            "soft_spin": turning - np.cross(centers, momentum),
            "soft_kinetic": 0.5 * np.add.reduceat(self._masses * squares, self._starts),
            "soft_speed": np.sqrt(np.maximum.reduceat(squares, self._starts)),
        }

    def check(self, t: float, f: int | None = None) -> Divergence | None:
        """Checks every point in frame `f` of the solvers, or in the current frame if None; `t` is its time [s]."""
        positions, velocities = self._positions(f), self._velocities(f)
        lost = np.flatnonzero(~np.isfinite(positions).all(axis=1))
        if len(lost):
            return Divergence(self._owner(lost[0]), "position", t, float("nan"))
        squares = np.einsum("ij,ij->i", velocities, velocities)
        fastest = int(squares.argmax())  # nan counts as the largest
        if not squares[fastest] <= self._speed_limit**2:
            return Divergence(self._owner(fastest), "speed", t, float(np.sqrt(squares[fastest])), self._speed_limit)
        for name, body, here in zip(self.names, self._bodies, self._rows, strict=True):
            if body.domain is not None:
                at_walls = (positions[here] <= body.domain[0]) | (positions[here] >= body.domain[1])
                cornered = float((at_walls.sum(axis=1) > 1).mean())
                if cornered > CORNERED:
                    return Divergence(name, "domain", t, cornered)
        return None

    def _positions(self, f: int | None = None) -> np.ndarray:
        return self._gather(0, f)

    def _velocities(self, f: int | None = None) -> np.ndarray:
        return self._gather(1, f) if self._moved is None else self._moved / self._dt

    def _gather(self, which: int, f: int | None) -> np.ndarray:
        f = self._sim.cur_substep_local if f is None else f
        arrays = {name: read(f)[which] for name, read in self._fields.items()}
        return np.concatenate([body.values(arrays[body.field], which) for body in self._bodies])

    def _owner(self, point: int) -> str:
        return self.names[int(np.searchsorted(self._starts, point, side="right")) - 1]


class _Body:
    """One deformable body in its solver.

    Attributes:
        entity, kind, solver, spacing, pos, quat, stream: The arguments.
        field, span: Name of the engine's solver, and the body's rows in its fields.
        masses: Masses of its points [kg], shape (p,).
        topology: Arrays of its geometry file besides points and masses.
        skin: How its surface follows its points; None if it has no surface, or the faces join the points themselves.
        domain: Lower and upper bound of its solver's domain [m]; None if there is none.
    """

    def __init__(self, scene, entity, *, kind: str, solver: str, spacing: float, pos, quat, stream=None):
        self.entity, self.kind, self.solver, self.spacing, self.stream = entity, kind, solver, spacing, stream
        self.pos, self.quat = pos, quat
        self.skin, self.domain, self.topology = None, None, {}
        if solver in ("mpm", "pbd"):
            engine = scene.mpm_solver if solver == "mpm" else scene.pbd_solver
            self.field, self.span = solver, slice(entity.particle_start, entity.particle_end)
            self.domain = engine.boundary.lower, engine.boundary.upper
            scale = engine._particle_volume_scale if solver == "mpm" else 1.0
            self.masses = qd_to_numpy(engine.particles_info.mass, copy=True)[self.span].astype(float) / scale
            self._add_surface(np.asarray(entity._particles, float))
        else:
            self.field, self.span = "fem", slice(entity.v_start, entity.v_start + entity.n_vertices)
            self.masses = qd_to_numpy(scene.fem_solver.elements_v_info.mass, copy=True)[self.span].astype(float)
            self.topology["faces"] = np.asarray(entity.surface_triangles, np.int32)
            if isinstance(entity.material, gs.materials.FEM.Cloth):
                self._add_cloth()
            else:
                self.topology["tets"] = np.asarray(entity.elems, np.int32)

    def values(self, of_solver: np.ndarray, which: int) -> np.ndarray:
        """Returns its positions (`which` is 0) or velocities (1), from those of all bodies of its solver."""
        own = of_solver[self.span]
        return own if self.stream is None else self.stream.fill_in(own, which)

    def _add_surface(self, particles: np.ndarray) -> None:
        """Attaches the mesh from which the particles were sampled to the particles."""
        if isinstance(self.entity.material, GRANULAR):
            return
        mesh = self.entity.vmesh
        vertices = np.asarray(mesh.verts, float)
        if self.solver == "mpm":
            self.skin = follow_solid(vertices, particles, self.spacing)
        else:
            made = np.asarray(self.entity.mesh.faces, np.int32)
            self.skin = follow_sheet(vertices, particles, made)
            self.topology |= {"point_faces": made, "edges": np.asarray(self.entity.edges, np.int32)}
        self.topology["faces"] = np.asarray(mesh.faces, np.int32)
        self._add_uvs(np.arange(len(vertices)))

    def _add_cloth(self) -> None:
        """Sets masses and texture coordinates of IPC cloth."""
        a, b, c = np.moveaxis(self.entity.init_positions.cpu().numpy().astype(float)[self.topology["faces"]], 1, 0)
        # The engine's thickness is half of the cloth's.
        density = self.entity.material.rho * 2 * self.entity.material.thickness
        shares = density * np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
        self.masses = np.bincount(self.topology["faces"].ravel(), np.repeat(shares, 3), len(self.masses))
        (shape,) = self.entity.vgeoms
        self._add_uvs(np.asarray(shape.sim_verts_idx))

    def _add_uvs(self, points: np.ndarray) -> None:
        """Sets the texture coordinates in the file of a body, which the engine drops if it has no texture.

        Args:
            points: Index of each vertex of the file among those that are drawn, shape (n,).
        """
        file = Path(self.entity.morph.file)
        if file.suffix != ".obj":
            return
        rows = [line.split()[1:3] for line in file.read_text().splitlines() if line.startswith("vt ")]
        if len(rows) == len(points):
            uvs = np.empty((len(points), 2), np.float32)
            uvs[points] = np.array(rows, np.float32)
            uvs[:, 1] = 1 - uvs[:, 1]  # v is measured from the top of a picture, as in the engine
            self.topology["uvs"] = uvs


def _fields(scene) -> dict:
    """Returns a function for each active solver, which returns positions and velocities of a frame of its memory."""
    fields = {}
    if scene.mpm_solver.is_active:
        fields["mpm"] = _reader(scene.mpm_solver.particles, has_frames=True)
    if scene.pbd_solver.is_active:
        fields["pbd"] = _reader(scene.pbd_solver.particles, has_frames=False)
    if scene.fem_solver.is_active:
        fields["fem"] = _reader(scene.fem_solver.elements_v, has_frames=True)
    return fields


def _reader(field, *, has_frames: bool):
    members = field.pos, field.vel
    if in_place():
        views = [qd_to_numpy(member, copy=False)[..., 0, :] for member in members]
        return (lambda f: [view[f] for view in views]) if has_frames else (lambda f: views)
    if has_frames:
        return lambda f: [qd_to_numpy(member, copy=True)[f, :, 0] for member in members]
    return lambda f: [qd_to_numpy(member, copy=True)[:, 0] for member in members]


def _is_sound(positions: np.ndarray, velocities: np.ndarray, speed_limit: float) -> bool:
    """Whether all numbers are finite and no speed exceeds the limit; usually takes only two reductions."""
    positions, velocities = positions.reshape(-1), velocities.reshape(-1)
    if not np.isfinite(np.dot(positions, positions)):
        return False
    return bool(np.dot(velocities, velocities) <= speed_limit**2 or np.abs(velocities).max() * 3**0.5 <= speed_limit)
