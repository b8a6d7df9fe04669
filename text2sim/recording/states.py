"""The recorded states of a run: the arrays that its program's recorder wrote, chunk by chunk."""

import json
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.recording.bonds import BondRecord, read_bonds
from text2sim.recording.chunks import Array, Chunks, readable_chunks
from text2sim.recording.deformables import RecordedDeformable, read_deformables
from text2sim.recording.inventory import first_fault
from text2sim.recording.record import RunRecord
from text2sim.spec_schema.errors import RunError
from text2sim.templates.playback import read_removed

__all__ = ["Array", "JointRecord", "LinkRecord", "RunStates"]

# Shape of one row of each array; L links, Q positions, D degrees of freedom.
FRAME_FIELDS: dict[str, tuple[int | str, ...]] = {
    "time": (),
    "links_pos": ("L", 3),
    "links_quat": ("L", 4),
    "links_vel": ("L", 3),
    "links_ang": ("L", 3),
    "qpos": ("Q",),
    "dofs_velocity": ("D",),
    "dofs_control_force": ("D",),
}
# B deformable bodies, P points and S vertices of surfaces of all of them; only where there are any.
SOFT_FIELDS: dict[str, tuple[int | str, ...]] = {
    "soft_points": ("P", 3),
    "soft_surface": ("S", 3),
    "soft_velocity": ("B", 3),
    "soft_spin": ("B", 3),
    "soft_kinetic": ("B",),
    "soft_speed": ("B",),
}
CONTACT_FIELDS: dict[str, tuple[int | str, ...]] = {
    "contact_step": (),
    "contact_links": (2,),
    "contact_force": (3,),
    "contact_pos": (3,),
    "contact_penetration": (),
    "contact_normal_force": (),
}


@dataclass(frozen=True)
class LinkRecord:
    """One link of the recorded scene."""

    index: int
    """Column of the arrays."""
    body: str
    """Name of the copy it belongs to: `ball`, `brick[3]`."""
    name: str
    mass: float
    """[kg]"""
    com: tuple[float, float, float]
    """Centre of mass [m], in the link's frame."""
    inertia: tuple[tuple[float, ...], ...]
    """About the centre of mass [kg m2], in the link's frame."""
    fixed: bool
    """Whether it is fixed to the world."""
    parent: int = -1
    """Column of the link that carries it; -1 for a root, and in a recording of an older version."""


@dataclass(frozen=True)
class JointRecord:
    """One joint of the recorded scene."""

    body: str
    """Name of the copy it belongs to."""
    name: str
    kind: str
    """free, hinge, slider, ball or fixed."""
    q: tuple[int, int]
    """Its columns of `qpos`: start (inclusive) and stop (exclusive)."""
    dof: tuple[int, int]
    """Its columns of `dofs_velocity` and of `dofs_force` (recorded as `dofs_control_force`): start (inclusive) and stop
    (exclusive)."""
    limits: tuple[float | None, float | None]
    """[rad or m]; None without a limit."""
    link: int = -1
    """Column of the link that it carries."""
    max_force: float | None = None
    """Limit of its motor [N or N m]; None without one, and in a recording of an older version."""
    anchor: tuple[float, ...] = (0.0, 0.0, 0.0)
    """A point of a hinge's axis at the start [m], world."""
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Direction of a hinge or slider at the start, world."""


@dataclass(frozen=True)
class RunStates:
    """What was recorded, as arrays over all frames; each is read when it is first needed."""

    dt: float
    """Time step [s]."""
    every: int
    """Steps from one frame to the next."""
    gravity: tuple[float, float, float]
    """[m/s2]"""
    links: tuple[LinkRecord, ...]
    joints: tuple[JointRecord, ...]
    parts: tuple[tuple[int, str], ...]
    """Parts of compounds that contacts tell apart: link and name; none in a recording of an older version."""
    chunks: Chunks
    """Chunks that could be read, in order, without a gap."""
    deformables: tuple[RecordedDeformable, ...] = ()
    """Deformable bodies, in the order of the arrays."""
    removed: dict[str, float] = field(default_factory=dict)
    """When bodies left the scene [s], by copy."""
    bonds: tuple[BondRecord, ...] = ()
    """Bonds of rigid bodies, in the order of the case."""
    losses: tuple[str, ...] = ()
    """Messages about what could not be read."""
    layout: dict[str, Any] = field(default_factory=dict, repr=False)
    """The layout file as written."""

    @classmethod
    def load(cls, run_dir: Path) -> "RunStates":
        """Open the recording of a run. Chunks from the first unreadable one on are left out and reported.

        Raises:
            RunError: if the layout is missing or invalid.
        """
        folder = run_dir / "states"
        try:
            layout = json.loads((folder / "layout.json").read_text("utf-8"))
            links = tuple(_link(index, row) for index, row in enumerate(layout["links"]))
            joints = tuple(_joint(row) for row in layout["joints"])
            parts = tuple((int(link), str(part)) for link, part in layout.get("parts", ()) if 0 <= link < len(links))
            dt, every = float(layout["dt"]), int(layout["every"])
            x, y, z = (float(v) for v in layout["gravity"])
            soft, soft_sizes, soft_losses = read_deformables(run_dir, layout)
        except OSError as error:
            raise RunError(f"{folder / 'layout.json'}: nothing was recorded ({error.strerror})") from error
        except (ValueError, TypeError, LookupError, OverflowError, RecursionError) as error:
            raise RunError(f"{folder / 'layout.json'}: not the layout of a recording ({error!r})") from error
        if not (0 < dt < np.inf and every > 0):
            raise RunError(f"{folder / 'layout.json'}: not the layout of a recording (dt {dt}, every {every})")
        sizes = {"L": len(links), "Q": max((j.q[1] for j in joints), default=0)}
        sizes["D"] = max((j.dof[1] for j in joints), default=0)
        fields = FRAME_FIELDS | {k: row for k, row in SOFT_FIELDS.items() if soft_sizes.get(str(row[0]))}
        paths, losses = readable_chunks(folder, fields, CONTACT_FIELDS, sizes | soft_sizes)
        record = RunRecord.read(run_dir)
        if not losses and record and (damage := first_fault(run_dir, record.recorded, content=False)):
            losses = [damage]
        chunks = Chunks(paths)
        bodies = tuple(body.recorded_in(chunks) for body in soft)
        removed, bonds = read_removed(folder), read_bonds(folder)
        losses = [*losses, *soft_losses]
        return cls(dt, every, (x, y, z), links, joints, parts, chunks, bodies, removed, bonds, tuple(losses), layout)

    @property
    def frames(self) -> int:
        """Number of recorded frames."""
        return len(self.time)

    @property
    def end(self) -> float:
        """Time [s] of the last frame; 0 without frames."""
        return float(self.time[-1]) if self.frames else 0.0

    def gone(self, copy: str) -> Array:
        """Return whether a copy has left the scene, in each frame, shape (F,)."""
        return self.time > self.removed.get(copy, np.inf) + 1e-9

    def lacks(self, state: str) -> str:
        """Return what a run that ended in `state` should have recorded but has not; empty if nothing is missing."""
        if self.losses:
            return self.losses[0]
        wanted = self.layout.get("n_frames")
        if state == "finished" and isinstance(wanted, int) and self.frames < wanted:
            return f"{wanted - self.frames} of {wanted} frames are missing"
        return ""

    @cached_property
    def time(self) -> Array:
        """Times of the frames [s], shape (F,)."""
        return self.chunks.gather("time", ())

    @cached_property
    def steps(self) -> Array:
        """Number of time steps done before each frame, shape (F,)."""
        return np.rint(self.time / self.dt).astype(np.int64)

    @cached_property
    def pos(self) -> Array:
        """Origins of the links [m], world, shape (F, L, 3)."""
        return self.chunks.gather("links_pos", (len(self.links), 3))

    @cached_property
    def quat(self) -> Array:
        """Orientations (w, x, y, z) of the links, shape (F, L, 4)."""
        return self.chunks.gather("links_quat", (len(self.links), 4))

    @cached_property
    def vel(self) -> Array:
        """Velocities of the links' centres of mass [m/s], world, shape (F, L, 3)."""
        return self.chunks.gather("links_vel", (len(self.links), 3))

    @cached_property
    def ang(self) -> Array:
        """Angular velocities of the links [rad/s], world, shape (F, L, 3)."""
        return self.chunks.gather("links_ang", (len(self.links), 3))

    @cached_property
    def qpos(self) -> Array:
        """Joint positions [rad or m], shape (F, Q)."""
        return self.chunks.gather("qpos", (max((j.q[1] for j in self.joints), default=0),))

    @cached_property
    def dofs_velocity(self) -> Array:
        """Joint velocities [rad/s or m/s], shape (F, D)."""
        return self.chunks.gather("dofs_velocity", (self._dofs,))

    @cached_property
    def dofs_force(self) -> Array:
        """Forces of the motors [N or N m], shape (F, D)."""
        return self.chunks.gather("dofs_control_force", (self._dofs,))

    @cached_property
    def soft_velocity(self) -> Array:
        """Velocities of the deformable bodies' centres of mass [m/s], world, shape (F, B, 3)."""
        return self.chunks.gather("soft_velocity", (len(self.deformables), 3))

    @cached_property
    def soft_spin(self) -> Array:
        """Angular momenta of the deformable bodies about their centres of mass [kg m2/s], world, shape (F, B, 3).

        Nan in a recording of an older version.
        """
        found = self.chunks.gather("soft_spin", (len(self.deformables), 3))
        return found if len(found) else np.full((self.frames, len(self.deformables), 3), np.nan)

    @cached_property
    def soft_kinetic(self) -> Array:
        """Kinetic energies of the deformable bodies [J], shape (F, B)."""
        return self.chunks.gather("soft_kinetic", (len(self.deformables),))

    @cached_property
    def soft_speed(self) -> Array:
        """Largest speed of any point of each deformable body [m/s], shape (F, B)."""
        return self.chunks.gather("soft_speed", (len(self.deformables),))

    def contact(self, name: str) -> Array:
        """Return one array of the contacts of all steps, without the prefix `contact_`, shape (n, ...)."""
        key = f"contact_{name}"
        return self.chunks.gather(key, tuple(int(n) for n in CONTACT_FIELDS[key]))

    @cached_property
    def surface_links(self) -> Array:
        """Links of the surfaces that contacts tell apart: every link, then every part, shape (L + P,)."""
        return np.array([*range(len(self.links)), *(link for link, _ in self.parts)], dtype=np.int64)

    @cached_property
    def _contact_parts(self) -> Array:
        return self.chunks.gather("contact_parts", (2,)).astype(np.int64)

    @property
    def tells_parts(self) -> bool:
        """Whether all of its contacts tell parts of compounds apart, which those of old versions do not."""
        return len(self._contact_parts) == len(self.contact("links"))

    @cached_property
    def contact_surfaces(self) -> Array:
        """Indices of the surfaces of all contacts, shape (n, 2): those of the links where no parts are told apart."""
        links, parts = self.contact("links").astype(np.int64), self._contact_parts
        if not self.tells_parts:
            return links
        return np.where((parts >= 0) & (parts < len(self.parts)), len(self.links) + parts, links)

    @property
    def _dofs(self) -> int:
        return max((j.dof[1] for j in self.joints), default=0)


def _link(index: int, row: dict[str, Any]) -> LinkRecord:
    a, b, c = (float(v) for v in row["com"])
    inertia = np.asarray(row["inertia"], dtype=float).reshape(3, 3)
    return LinkRecord(
        index, str(row["body"]), str(row["link"]), float(row["mass"]), (a, b, c),
        tuple(tuple(r) for r in inertia.tolist()), bool(row["fixed"]), int(row.get("parent", -1)),
    )  # fmt: skip


def _joint(row: dict[str, Any]) -> JointRecord:
    low, high = row["limits"][0] if row["kind"] in ("hinge", "slider") else (None, None)
    (q0, q1), (d0, d1) = row["q"], row["dofs"]
    limit = row["max_force"][0] if row["kind"] in ("hinge", "slider") and "max_force" in row else None
    anchor, axis = (tuple(float(v) for v in row.get(key, (0.0, 0.0, 0.0))) for key in ("anchor", "axis"))
    return JointRecord(
        str(row["body"]), str(row["joint"]), str(row["kind"]), (int(q0), int(q1)), (int(d0), int(d1)),
        (None if low is None else float(low), None if high is None else float(high)), int(row.get("link", -1)),
        None if limit is None else float(limit), anchor, axis,
    )  # fmt: skip
