"""Records a run of Genesis. Nothing is drawn during the simulation; `film.py` does that afterwards.

    OUT/progress.jsonl           one line per progress report
    OUT/states/layout.json       meaning of the columns of the states
    OUT/states/removed.json      time of removal [s] by copy; only if bodies were removed
    OUT/states/bonds.json        load of each bond, and when it broke; only if bodies are bonded
    OUT/states/chunk_00000.npz   frames and contacts; a chunk is complete on disk before the next begins, and the
                                 unfinished one is written every few seconds
    OUT/geometry/index.json      link -> meshes, poses and colours; the meshes are in geometry/<hash>.npz
    OUT/geometry/solids.json     link -> collision shapes, see `solids.py`

Deformable bodies are recorded by `soft.py`, which only programs with such bodies contain.
All values are in SI units; quaternions are (w, x, y, z). Poses are those of each link's authored frame in the world:
Genesis moves the frame of a free body to its centre of mass, and the recorder undoes that shift.
"""

import json
import time
from pathlib import Path

import genesis as gs
import numpy as np
from contacts import Contacts, in_place
from files import write_json, write_mesh, write_npz, write_paint
from genesis.utils.misc import qd_to_numpy

FRAMES_PER_CHUNK = 100
BYTES_PER_CHUNK = 64_000_000
SECONDS_IN_HAND = 5.0
PROGRESS_PERIOD = 0.2
BEGAN = time.monotonic()

JOINT_KINDS = {
    gs.JOINT_TYPE.FIXED: "fixed",
    gs.JOINT_TYPE.REVOLUTE: "hinge",
    gs.JOINT_TYPE.PRISMATIC: "slider",
    gs.JOINT_TYPE.SPHERICAL: "ball",
    gs.JOINT_TYPE.FREE: "free",
}
INVERSE = np.array([1.0, -1.0, -1.0, -1.0])
IDENTITY = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


class Divergence(RuntimeError):
    """The state is not finite, or beyond what the scene can physically reach.

    Attributes:
        body: Copy name of the first body affected, such as `brick[3]`.
        quantity: `position`, `speed`, `domain` or `solver`.
        time: Simulated time [s].
        value: Value of the quantity, in SI units; may be nan or inf.
        limit: Largest permitted value; 0 if there is none to tell.
    """

    def __init__(self, body: str, quantity: str, time: float, value: float, limit: float = 0.0):
        more = f", more than {limit:.4g}" if limit else ""
        super().__init__(f"diverged at t = {time:.4g} s: {quantity} of {body} is {value:.4g}{more}")
        self.body, self.quantity, self.time, self.value = body, quantity, time, value


class Progress:
    """Appends the progress of a run to `progress.jsonl`, at most a few lines per second."""

    def __init__(self, out: Path):
        Path(out).mkdir(parents=True, exist_ok=True)
        self._file = (Path(out) / "progress.jsonl").open("a")
        self._last = 0.0

    def __call__(self, phase: str, t: float = 0.0, duration: float = 0.0, *, force: bool = False, **more) -> None:
        """Reports simulated time `t` [s] of `duration` [s] in `phase`; `force` overrides the limit on lines."""
        wall = time.monotonic() - BEGAN
        if force or wall - self._last >= PROGRESS_PERIOD:
            self._last = wall
            line = {"phase": phase, "t": round(t, 6), "duration": duration, "wall": round(wall, 3), **more}
            self._file.write(json.dumps(line) + "\n")
            self._file.flush()


def build(scene) -> None:
    """Builds the scene without opening an OpenGL context.

    `scene.build()` ends by building the visualizer, which needs OpenGL even when nothing is drawn. `film` does that
    step later.
    """
    scene.visualizer.build = lambda: None
    try:
        scene.build()
    finally:
        del scene.visualizer.build


class Recorder:
    """Writes the states and contacts of every body of a built scene.

    Args:
        scene: Built scene with one environment.
        bodies: Copy name -> entity, statics included.
        out: Folder of the run.
        dt: Time step [s].
        every: Steps between recorded frames. Contacts are recorded for every step, as means over its substeps.
        duration: Intended simulated time [s].
        speed_limit: Speed of a centre of mass above which the run counts as diverged [m/s].
        deformables: Copy name -> kind, solver, spacing and pose of every deformable body, in the order of their rows.
    """

    def __init__(self, scene, bodies: dict, out: Path, dt, every, duration, *, speed_limit=200.0, deformables=None):
        self._soft = None
        if deformables:
            from soft import Soft

            self._soft = Soft(scene, bodies, deformables, dt, speed_limit)
            bodies = {name: entity for name, entity in bodies.items() if name not in deformables}
        self._scene, self._solver, self._bodies, self._out = scene, scene.rigid_solver, bodies, Path(out)
        self._dt, self._every, self._duration, self._speed_limit = dt, every, duration, speed_limit
        self._progress = Progress(out)
        self._contacts = Contacts(self._solver)
        names = {entity.idx: name for name, entity in bodies.items()}
        self._link_bodies = [names.get(link.entity.idx, link.entity.name) for link in self._solver.links]
        self._frames, self._chunk, self._step = [], 0, 0
        self._motor_forces = []  # of the substeps of this step
        self._flushed = time.monotonic()
        self.gone, self.bonds, self.springs = {}, [], []  # time of removal [s] by copy; what can break; springs
        self.belts = {}  # velocity of the surface [m/s] of what never moves itself, in its frame, by copy
        links, dofs = self._solver.dyn_state.links, self._solver.dyn_state.dofs
        # The clipped force of the last substep; `get_dofs_control_force` would give that of the next one.
        self._motor_force = _reader(dofs.qf_applied)
        self._reads = {
            "links_pos": _reader(links.pos),
            "links_quat": _reader(links.quat),
            "links_vel": _reader(links.cd_vel),
            "links_ang": _reader(links.cd_ang),
            "links_lever": _reader(links.i_pos),
            "qpos": _reader(self._solver.qpos),
            "dofs_velocity": _reader(dofs.vel),
            "dofs_control_force": self._mean_motor_force,
        }
        # The engine allocates one row even for fields that the scene has no use for.
        empty = [*self._reads] if not self._solver.is_active else ["qpos", "dofs_velocity", "dofs_control_force"]
        if not self._solver.n_dofs:
            self._reads |= {name: lambda read=self._reads[name]: read()[:0] for name in empty}

    def start(self) -> None:
        """Writes layout and geometry and records frame 0; call after setting the initial conditions."""
        states = self._out / "states"
        states.mkdir(parents=True, exist_ok=True)
        for stale in states.glob("chunk_*.npz"):
            stale.unlink()
        for stale in ("removed.json", "bonds.json"):
            (states / stale).unlink(missing_ok=True)
        self._offsets = _link_offsets(self._solver)
        self._shifted = np.flatnonzero((self._offsets != IDENTITY).any(axis=1))
        expected = round(self._duration / self._dt) // self._every + 1
        run = {"dt": self._dt, "every": self._every, "duration": self._duration, "n_frames": expected}
        layout = run | _layout(self._scene, self._bodies, self._link_bodies, self._offsets)
        layout |= {"parts": self._contacts.parts} | ({"springs": self.springs} if self.springs else {})
        for row in layout["links"]:
            if row["body"] in self.belts:
                row |= {"fixed": True, "surface_velocity": self.belts[row["body"]]}
        _write_geometry(self._solver, self._offsets, self._out / "geometry")
        from solids import write_solids  # it imports this module

        write_solids(self._solver, self._offsets, self._out / "geometry")
        if self._soft is not None:
            layout["deformables"] = self._soft.describe(self._out / "geometry")
        write_json(states / "layout.json", layout)
        self._progress("simulate", 0.0, self._duration, force=True)
        self._watch_substeps()
        self._record(0.0)

    def after_step(self, step: int) -> None:
        """Records one step.

        Args:
            step: Number of steps completed, 1 after the first.

        Raises:
            Divergence: If a value is not finite or a body is too fast. All valid frames are on disk by then.
        """
        self._step = step
        self._contacts.end_step(step)
        if self._soft is not None:
            self._stop_at(self._soft.end_step(step * self._dt))
        if step % self._every == 0:
            self._record(step * self._dt)
            self._progress("simulate", step * self._dt, self._duration)
        self._motor_forces.clear()
        if self._is_chunk_full():
            self._flush()
        elif time.monotonic() - self._flushed > SECONDS_IN_HAND:
            self._flush(whole=False)  # where a chunk ends must not depend on the speed of the machine

    def diverged(self, error: gs.GenesisException) -> Divergence | None:
        """Returns a `Divergence` for the solver's error about nan; None if `error` is about something else."""
        if not any(word in str(error) for word in ("'nan'", "NaN detected", "not finite")):
            return None
        self._flush()
        t, frame = self._step * self._dt, {name: read() for name, read in self._reads.items()}
        if self._soft is not None and (divergence := self._soft.check(t)) is not None:
            return divergence
        if not self._link_bodies:
            return Divergence(self._soft.names[0], "solver", t, float("nan"))
        fastest = int(np.linalg.norm(_velocity_of_com(frame), axis=-1).argmax())
        return self._check(t, frame) or Divergence(self._link_bodies[fastest], "solver", t, float("nan"))

    def close(self, state: str) -> None:
        """Writes what is still in memory; `state` tells how the run ended, such as `finished` or `diverged`."""
        vars(self._solver).pop("substep", None)
        if self._soft is not None:
            self._soft.close()
        self._flush()
        self._progress("simulate", self._step * self._dt, self._duration, force=True, state=state)

    def _watch_substeps(self) -> None:
        """Gathers contacts and motor forces after every substep: an impact can begin and end within a step."""
        substep = self._solver.substep

        def watched(f):
            substep(f)
            self._contacts.gather(self._step + 1)
            self._motor_forces.append(self._motor_force())

        self._solver.substep = watched
        if self._soft is not None:
            self._soft.watch_substeps()

    def _mean_motor_force(self) -> np.ndarray:
        # A servo's target moves once in a step, so that its force falls from the first substep to the last.
        return np.mean(self._motor_forces, axis=0) if self._motor_forces else self._motor_force()

    def _record(self, t: float) -> None:
        frame = {name: read() for name, read in self._reads.items()}
        # This one reduction suffices for nearly every frame; nan and high speeds fail it.
        if not np.dot(frame["dofs_velocity"], frame["dofs_velocity"]) <= self._speed_limit**2:
            self._stop_at(self._check(t, frame))
        if self._soft is not None:
            self._stop_at(self._soft.check(t))
            frame |= self._soft.read()
        frame["time"] = t
        self._frames.append(frame)

    def _stop_at(self, divergence: Divergence | None) -> None:
        if divergence is not None:
            self._flush()
            raise divergence

    def _is_chunk_full(self) -> bool:
        frames = self._frames
        if len(frames) < 2 or self._soft is None:
            return len(frames) >= FRAMES_PER_CHUNK
        bytes_per_frame = sum(array.nbytes for name, array in frames[0].items() if name != "time")
        return len(frames) >= FRAMES_PER_CHUNK or len(frames) * bytes_per_frame > BYTES_PER_CHUNK

    def _check(self, t: float, frame: dict[str, np.ndarray]) -> Divergence | None:
        poses = np.concatenate([frame["links_pos"], frame["links_quat"]], axis=1)
        lost = np.flatnonzero(~np.isfinite(poses).all(axis=1))
        if len(lost):
            return Divergence(self._link_bodies[lost[0]], "position", t, float("nan"))
        speed = np.linalg.norm(_velocity_of_com(frame), axis=-1)
        fastest = int(speed.argmax())  # nan counts as the largest
        if speed[fastest] <= self._speed_limit:
            return None
        return Divergence(self._link_bodies[fastest], "speed", t, float(speed[fastest]), self._speed_limit)

    def _flush(self, whole: bool = True) -> None:
        if self.gone:
            write_json(self._out / "states" / "removed.json", self.gone)
        if self.bonds:
            write_json(self._out / "states" / "bonds.json", [row for some in self.bonds for row in some.report()])
        contacts = self._contacts.take(keep=not whole)
        chunk = {}
        if self._frames:
            chunk = {name: np.stack([frame[name] for frame in self._frames]) for name in self._frames[0]}
            chunk["links_vel"] = _velocity_of_com(chunk)
            del chunk["links_lever"]
            offsets = self._offsets[self._shifted]
            quat = multiply(chunk["links_quat"][:, self._shifted], offsets[:, 3:] * INVERSE)
            chunk["links_pos"][:, self._shifted] -= rotate(quat, offsets[:, :3])
            chunk["links_quat"][:, self._shifted] = quat
            chunk = {name: array if name == "time" else array.astype(np.float32) for name, array in chunk.items()}
        if self._frames or len(contacts["contact_step"]):
            write_npz(self._out / "states" / f"chunk_{self._chunk:05d}.npz", chunk | contacts)
            if whole:
                self._frames, self._chunk = [], self._chunk + 1
        self._flushed = time.monotonic()


def _reader(field):
    """Returns a function that copies a field of the solver's only environment; under a microsecond on the CPU."""
    if in_place():
        return qd_to_numpy(field, transpose=True, copy=False)[0].copy
    return lambda: qd_to_numpy(field, transpose=True, copy=True)[0]


def _velocity_of_com(frame: dict[str, np.ndarray]) -> np.ndarray:
    """Returns the velocity of each link's centre of mass [m/s], shape (..., L, 3).

    The solver stores the link's velocity at the centre of mass of its whole tree, `links_lever` away.
    """
    return frame["links_vel"] + np.cross(frame["links_ang"], frame["links_lever"])


def _link_offsets(solver) -> np.ndarray:
    """Returns the pose of each link's solver frame in its authored frame, shape (L, 7): position [m], quaternion."""
    if not solver.is_active:
        return np.zeros((0, 7))
    own_pos, own_quat, pos, quat = (
        get(relative=relative).cpu().numpy().astype(float)
        for relative in (False, True)
        for get in (solver.get_links_pos, solver.get_links_quat)
    )
    offsets = np.concatenate([rotate(quat * INVERSE, own_pos - pos), multiply(quat * INVERSE, own_quat)], axis=1)
    offsets[(own_pos == pos).all(axis=1) & (own_quat == quat).all(axis=1)] = IDENTITY
    return offsets


def _layout(scene, bodies: dict, link_bodies: list[str], offsets: np.ndarray) -> dict:
    """Describes the columns of the states: links in order with their inertia, joints with their slices."""
    solver = scene.rigid_solver
    engine = {"name": "genesis", "version": gs.__version__, "dtype": np.dtype(gs.np_float).name}
    if not solver.is_active:
        gravity = [float(x) for x in scene.sim.options.gravity]
        return {"engine": engine, "gravity": gravity, "links": [], "joints": []}
    mass, com, inertia = (
        tensor.cpu().numpy().astype(float)
        for tensor in (solver.get_links_mass(), solver.get_links_COM(), solver.get_links_inertia())
    )
    axes = qd_to_numpy(solver.dyn_info.links.inertial_quat, copy=True).reshape(-1, 4).astype(float)
    com = offsets[:, :3] + rotate(offsets[:, 3:], com)
    turn = rotate(multiply(offsets[:, 3:], axes)[:, None], np.eye(3)).swapaxes(1, 2)
    inertia = turn @ inertia @ turn.swapaxes(1, 2)
    limits = np.stack([bound.cpu().numpy() for bound in solver.get_dofs_limit()], axis=1).astype(float).tolist()
    links = [
        {
            "body": link_bodies[link.idx],
            "link": link.name,
            "mass": float(mass[link.idx]),
            "com": com[link.idx].tolist(),
            "inertia": inertia[link.idx].tolist(),
            "fixed": bool(link.is_fixed),
            "parent": link.parent_idx,
        }
        for link in solver.links
    ]
    limits = [[x if np.isfinite(x) else None for x in pair] for pair in limits]
    low, high = (bound.cpu().numpy().astype(float) for bound in solver.get_dofs_force_range())
    strongest = [x if np.isfinite(x) else None for x in np.maximum(-low, high)]
    anchors, axes = (
        rows.cpu().numpy().astype(float).tolist()
        for rows in (solver.get_joints_anchor_pos(), solver.get_joints_anchor_axis())
    )
    joints = [
        {
            "body": name,
            "joint": joint.name,
            "kind": JOINT_KINDS[joint.type],
            "link": joint.link.idx,
            "q": [joint.q_start, joint.q_end],
            "dofs": [joint.dof_start, joint.dof_end],
            "limits": limits[joint.dof_start : joint.dof_end],
            "max_force": strongest[joint.dof_start : joint.dof_end],
            "anchor": anchors[joint.idx],
            "axis": axes[joint.idx],
        }
        for name, entity in bodies.items()
        for joint in entity.joints
    ]
    gravity = solver.get_gravity().cpu().numpy().astype(float).reshape(3).tolist()
    return {"engine": engine, "gravity": gravity, "links": links, "joints": joints}


def _write_geometry(solver, offsets: np.ndarray, folder: Path) -> None:
    """Writes each distinct visual mesh once, and an index of the links that use it, with poses and colours."""
    folder.mkdir(parents=True, exist_ok=True)
    index = {}
    for link in solver.links:
        pos, quat = offsets[link.idx, :3], offsets[link.idx, 3:]
        index[link.idx] = [
            {
                "mesh": write_mesh(folder, vgeom.vmesh),
                "pos": (pos + rotate(quat, np.asarray(vgeom.init_pos, float))).tolist(),
                "quat": multiply(quat, np.asarray(vgeom.init_quat, float)).tolist(),
                **write_paint(folder, vgeom.surface.get_rgba()),
            }
            for vgeom in link.vgeoms
        ]
    write_json(folder / "index.json", index)


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the product of quaternions, shape (..., 4): the rotation by b, followed by that by a."""
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    w = aw * bw - (av * bv).sum(axis=-1, keepdims=True)
    return np.concatenate([w, aw * bv + bw * av + np.cross(av, bv)], axis=-1)


def rotate(quat: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Rotates vectors, shape (..., 3), by unit quaternions, shape (..., 4)."""
    twist = 2.0 * np.cross(quat[..., 1:], vector)
    return vector + quat[..., :1] * twist + np.cross(quat[..., 1:], twist)
