"""Springs and elastic cords between points of two links."""

from typing import NamedTuple

import genesis as gs
import numpy as np


class Spring(NamedTuple):
    """A spring between two points, each on a link of a body and in its frame [m]."""

    control: str  # its name in the case
    a: str
    a_link: str | None  # None for the first link
    a_point: tuple[float, float, float]
    b: str
    b_link: str | None
    b_point: tuple[float, float, float]
    stiffness: float  # [N/m]
    damping: float  # [N s/m]
    length: float | None  # without load [m]; None for the distance of its ends as it begins
    pulls_only: bool
    start: float  # [s]
    end: float


class Springs:
    """Pulls the ends of springs together before every step, with `k (d - length) + c d'`; d is their distance.

    The engine keeps the force over all n substeps of a step T. The distance at its start would raise the energy of a
    swing of frequency w by the factor 1 + (w T)^2 (n - 1) / (2 n) in each step; the distance that is expected after the
    share (n - 1) / (2 n) of the step cancels that exactly. With one substep, this is the symplectic Euler method. Lone
    free bodies turn by the midpoint rule, and move by it if their frame is not at their centre of mass: there the share
    is one half, whatever the substeps.

    Args:
        scene: Built scene.
        bodies: Entities by name.
        springs: The springs.
        dt: Time step [s].
        gone: Indices of the links of removed bodies, which change.
    """

    def __init__(self, scene, bodies, springs, dt, gone=()):
        self.solver, self.gone = scene.rigid_solver, gone
        self.rows = springs
        self.stiffness, self.damping, self.pulls_only, self.starts, self.stops = (
            np.array([getattr(s, name) for s in springs])
            for name in ("stiffness", "damping", "pulls_only", "start", "end")
        )
        self.lengths = np.array([np.nan if s.length is None else s.length for s in springs])
        ends = [[(bodies[s.a], s.a_link) for s in springs], [(bodies[s.b], s.b_link) for s in springs]]
        self.links = np.array([[_link(body, name) for body, name in side] for side in ends])
        self.points = np.array([[s.a_point for s in springs], [s.b_point for s in springs]])
        substeps = round(dt / scene.sim.substep_dt)
        lone = np.array([[_is_lone(body) for body, _ in side] for side in ends])
        flat = self.links.ravel()
        centers = self.solver.get_links_pos(flat, ref=gs.link_ref_frame.link_COM)
        off = np.asarray((self.solver.get_links_pos(flat) - centers).norm(dim=-1).cpu()).reshape(lone.shape) > 1e-6
        share = (substeps - 1) / (2 * substeps)
        self.ahead = dt * np.where(lone & off, 0.5, share)[..., None]  # [s]: of translation
        self.ahead_in_turn = dt * np.where(lone, 0.5, share)[..., None]

    def describe(self):
        """Return the springs for the layout of the recording, with indices of their links."""
        rows = zip(self.rows, self.links.T.tolist(), self.points.swapaxes(0, 1).tolist(), strict=True)
        kept = ("control", "stiffness", "damping", "length", "pulls_only", "start", "end")
        return [{name: getattr(s, name) for name in kept} | {"links": a, "points": b} for s, a, b in rows]

    def __call__(self, t):
        """Prepare the step that begins at t [s]."""
        now = t + 1e-9  # rounding must not exclude a step that begins at the start of a span
        acting = (self.starts <= now) & (now < self.stops)
        if self.gone:
            acting &= ~np.isin(self.links, list(self.gone)).any(axis=0)
        active = np.flatnonzero(acting)
        if not len(active):
            return
        arms, ends, velocities, turning = self._ends(active)
        between = ends[1] - ends[0]
        distance = np.linalg.norm(between, axis=1)
        along = between / np.maximum(distance, 1e-9)[:, None]
        moved = self.ahead[:, active] * velocities + self.ahead_in_turn[:, active] * turning
        growth, expected = (((rows[1] - rows[0]) * along).sum(axis=1) for rows in (velocities + turning, moved))
        new = np.isnan(self.lengths[active])
        self.lengths[active] = np.where(new, distance, self.lengths[active])
        stretch = distance + expected - self.lengths[active]
        pull = self.stiffness[active] * stretch + self.damping[active] * growth
        pull = np.where(self.pulls_only[active], np.where(stretch > 0.0, np.maximum(pull, 0.0), 0.0), pull)
        forces = np.stack([pull[:, None] * along, -pull[:, None] * along])
        self.solver.apply_links_external_wrench(
            force=forces.reshape(-1, 3),
            torque=np.cross(arms, forces).reshape(-1, 3),
            links_idx=self.links[:, active].ravel(),
            ref=gs.link_ref_frame.link_COM,
        )

    def _ends(self, active):
        """Return the arms of the ends of springs about centres of mass, and the ends [m], each of shape (2, n, 3).

        Then, of the same shape, the velocity [m/s] of each centre of mass, and what turning adds to it at the end.
        """
        links, solver = self.links[:, active].ravel(), self.solver
        middle = gs.link_ref_frame.link_COM
        read = (
            solver.get_links_pos(links, relative=True),
            solver.get_links_quat(links, relative=True),
            solver.get_links_pos(links, ref=middle),
            solver.get_links_vel(links, ref=middle),
            solver.get_links_ang(links),
        )
        origins, quats, centers, velocities, spins = (
            np.asarray(row.cpu(), dtype=float).reshape(2, len(active), -1) for row in read
        )
        w, axis, points = quats[..., :1], quats[..., 1:], self.points[:, active]
        ends = origins + points + 2.0 * np.cross(axis, np.cross(axis, points) + w * points)
        arms = ends - centers
        return arms, ends, velocities, np.cross(spins, arms)


def _link(body, name):
    """Return the index of a link; that of the first one that is not the world if `name` is None."""
    return (body.get_link(name) if name else next(link for link in body.links if link.name != "world")).idx


def _is_lone(body):
    """Return whether a body is one link on a free joint."""
    return body.n_dofs == 6 and body.joints[0].type == gs.JOINT_TYPE.FREE
