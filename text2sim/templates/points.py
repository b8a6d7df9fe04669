"""Points of deformable bodies: regions of them, positions and velocities.

A point is a particle (mpm, pbd) or a vertex (fem). All values are in SI units; quaternions are (w, x, y, z).
"""

import genesis as gs
import numpy as np
import torch
from genesis.utils.misc import qd_to_torch

INVERSE = np.array([1.0, -1.0, -1.0, -1.0])
STRAIGHT = 0.05
"""Largest ratio of width to length for points to count as a line."""


class NothingThere(ValueError):
    """A region of a body contains no points, or fewer than needed."""


class Points:
    """The points of one deformable body; create it before the first step, for `rest` are the positions at the start."""

    def __init__(self, entity):
        self.entity, self.solver = entity, entity.solver
        self.fem = isinstance(entity, gs.engine.entities.FEMEntity)
        self.mpm = isinstance(entity, gs.engine.entities.MPMEntity)
        self.rest = self.positions()
        self.masses = self._masses()

    def positions(self):
        """Return the current positions [m], (n, 3)."""
        return array(self.entity.get_state().pos[0] if self.fem else self.rows(self.solver.particles.pos))

    def velocities(self):
        """Return the current velocities [m/s], (n, 3)."""
        return array(self.entity.get_state().vel[0] if self.fem else self.rows(self.solver.particles.vel))

    def set_velocities(self, velocities):
        """Set the velocities of all points [m/s], (n, 3)."""
        if self.fem:
            # `set_velocity` would take effect only in the next step, and warn every time.
            self.entity.set_vel(self.entity.sim.cur_substep_local, tensor(velocities)[None])
        elif gs.use_zerocopy:
            self.rows(self.solver.particles.vel)[:] = tensor(velocities)
        else:
            self.entity.set_particles_vel(tensor(velocities))

    def rows(self, field):
        """Return the rows of the body in a field of the solver's particles, (n, …).

        These are the engine's own values if `gs.use_zerocopy`, and a copy otherwise; the engine's methods always copy.
        """
        values = qd_to_torch(field)
        if self.mpm:
            values = values[self.entity.sim.cur_substep_local]
        return values[self.entity.particle_start : self.entity.particle_end, 0]

    def set_gradient(self, gradient):
        """Set the velocity gradient that all particles of an mpm body carry [1/s], (3, 3)."""
        f = self.entity.sim.cur_substep_local
        state = self.solver.get_state(f)
        with torch.no_grad():
            state.C[:, self.entity.particle_start : self.entity.particle_end] = tensor(gradient)
        self.solver.set_state(f, state)

    def _masses(self):
        """Return the mass of each point [kg], (n,)."""
        if not self.fem:
            return np.full(len(self.rest), array(self.entity.get_mass()).item() / len(self.rest))
        corners = np.asarray(self.entity.elems)
        a, b, c, d = (self.rest[corners[:, k]] for k in range(4))
        volumes = np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)) / 6.0
        masses = np.zeros(len(self.rest))
        np.add.at(masses, corners, (self.entity.material.rho * volumes / 4.0)[:, None])
        return masses


def array(value):
    """Return a tensor of the engine as an array of float64."""
    return np.asarray(value.cpu(), dtype=float)


def tensor(value):
    """Return an array as a tensor of the engine."""
    return torch.as_tensor(np.ascontiguousarray(value), dtype=gs.tc_float, device=gs.device)


def rotate(quat, vectors):
    """Rotate vectors (..., 3) by a quaternion."""
    w, u = quat[0], quat[1:]
    return vectors + 2.0 * np.cross(u, np.cross(u, vectors) + w * vectors)


# --- regions: functions from points in the body's frame, (n, 3) [m], to the indices of those in the region --------


def everything(points):
    """The region of all points."""
    return np.arange(len(points))


def sides(*outermost, within):
    """Return the region of points within a distance [m] of all given sides, each (axis, -1 or 1)."""

    def region(points):
        inside = np.ones(len(points), dtype=bool)
        for axis, sign in outermost:
            along = sign * points[:, axis]
            inside &= along >= along.max() - within
        return np.flatnonzero(inside)

    return region


def box(low, high):
    """Return the region inside a box, given by its lowest and highest corner [m]."""
    return lambda points: np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))


def ball(center, radius):
    """Return the region inside a ball; centre and radius are in m."""
    return lambda points: np.flatnonzero(np.linalg.norm(points - center, axis=1) <= radius)


def nearest(point):
    """Return the region of the one point nearest to a position [m]."""
    return lambda points: np.array([np.linalg.norm(points - point, axis=1).argmin()])


def choose(points, pose, region, count=None):
    """Return the indices of the points of a body that lie in a region, in increasing order.

    Args:
        points: The points of the body.
        pose: Pose of the body's frame at the start: position [m], quaternion.
        region: One of the functions above.
        count: Number of points, evenly spread over the region; all if None.

    Raises:
        NothingThere: If the region contains no point, or fewer than `count`.
    """
    pos, quat = (np.array(value) for value in pose)
    local = rotate(quat * INVERSE, points.rest - pos)
    found = region(local)
    if len(found) == 0:
        raise NothingThere(f"none of the {len(local)} points of {points.entity.name} lies in this region")
    if count is None:
        return found
    if count > len(found):
        raise NothingThere(
            f"only {len(found)} points of {points.entity.name} lie in this region, and {count} are asked for"
        )
    return np.sort(found[spread(local[found], count)])


def spread(points, count):
    """Return the indices of `count` evenly spread points.

    Points on a line are spread from end to end. Otherwise each is the point farthest from those already chosen.
    """
    middle = points.mean(axis=0)
    _, reach, axes = np.linalg.svd(points - middle, full_matrices=False)
    along = (points - middle) @ axes[0]
    if len(reach) == 1 or reach[1] <= STRAIGHT * reach[0]:
        wanted = np.linspace(along.min(), along.max(), count) if count > 1 else [0.0]
        return assign(np.asarray(wanted)[:, None], along[:, None], 1)[:, 0]
    chosen = [int(np.linalg.norm(points - middle, axis=1).argmin() if count == 1 else along.argmin())]
    apart = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen)


def assign(anchors, points, share):
    """Return the indices of the points that each anchor takes, (anchors, share); no point is taken twice.

    Pairs of an anchor and a point are matched in the order of their distance.

    Args:
        anchors: Positions of the anchors [m], (n, 3).
        points: Positions of the points [m], (m, 3).
        share: Number of points for each anchor.
    """
    apart = np.linalg.norm(anchors[:, None] - points[None], axis=2)
    taken = np.full((len(anchors), share), -1)
    filled, free = np.zeros(len(anchors), dtype=int), np.ones(len(points), dtype=bool)
    for pair in np.argsort(apart, axis=None, kind="stable"):
        anchor, point = divmod(int(pair), len(points))
        if free[point] and filled[anchor] < share:
            taken[anchor, filled[anchor]] = point
            filled[anchor] += 1
            free[point] = False
    return taken


def each_substep(solver, act):
    """Call a function without arguments at the beginning of every substep of a solver."""
    substep = solver.substep_pre_coupling

    def acted(f):
        act()
        substep(f)

    solver.substep_pre_coupling = acted
