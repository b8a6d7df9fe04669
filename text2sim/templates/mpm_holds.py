"""Particles of mpm bodies that a link carries, and whose pull the link feels.

Genesis 1.4.5 holds particles by springs that are damped with respect to the world: they lag behind a link that moves,
brake one that turns, and never pull it.
"""

import genesis as gs
import numpy as np
import quadrants as qd
import torch
from genesis.constants import link_ref_frame
from genesis.engine.solvers.rigid.abd.forward_dynamics import func_vel_at_point
from genesis.engine.solvers.rigid.abd.misc import func_apply_coupling_force
from genesis.utils.array_class import LinksState
from genesis.utils.geom import qd_transform_by_trans_quat
from points import array, tensor

# Square of the angular frequency times substep of springs without a stiffness of their own: a particle that bears an
# acceleration a is 4 a h^2 off. Put exactly in their places, particles would not bear the nodes of the grid that they
# share with free ones, only brake them: the end of a hung bar then swings a fifth slower. With 1, a cantilever is a
# tenth too stiff (`python -m benchmarks.soft_physics --only cantilever`).
STIFF = 0.25


class Carried:
    """Particles that critically damped springs pull towards their places on a link.

    After each substep the springs, damped with respect to the link, change the velocity of a held particle by `-dv`,
    and the blow `m dv` is owed to the link. So momentum is conserved, and the link bears the weight and the inertia of
    what hangs on it.

    The link moves a substep later, and its particles with it. It gets the share `M / (M + m)` of what it is owed, where
    `M` is its mass and `m` that of its particles: their own inertia settles the rest, whichever is the heavier.
    """

    def __init__(self, hold):
        self.hold, self.solver = hold, hold.points.solver

    def begin(self):
        """Find the rows of the particles, which `Carrying` uses from now on."""
        hold = self.hold
        numbers = hold.chosen + hold.points.entity.particle_start
        own, share = hold.points.masses[hold.chosen], np.zeros(len(numbers))
        holders = np.asarray(hold.links)[hold.owner] if hold.links else np.full(len(numbers), -1)
        if hold.both_ways:
            weights = array(hold.rigid.get_links_invweight(hold.links)).reshape(-1, 2)
            middles = array(hold.rigid.get_links_pos(hold.links, ref=link_ref_frame.link_COM)).reshape(-1, 3)
            for k, (weight, middle) in enumerate(zip(weights, middles, strict=True)):
                mine = hold.owner == k
                share[mine] = _share(own[mine], hold.at[mine] - middle, *np.sqrt(weight))
        pull = np.full(len(numbers), STIFF / hold.h**2 if hold.stiffness is None else hold.stiffness / hold.mass)
        self.rows = (
            torch.as_tensor(numbers, dtype=gs.tc_int), torch.as_tensor(holders, dtype=gs.tc_int), tensor(hold.local),
            tensor(own), tensor(share), tensor(pull), tensor(np.zeros((len(numbers), 3))),
        )  # fmt: skip

    def step(self):
        """Do nothing: substeps do it."""

    def drop(self, gone):
        """Let go of some of the particles, given as a mask."""
        kept = torch.as_tensor(np.flatnonzero(~gone))
        self.rows = tuple(row[kept] for row in self.rows)


class Carrying:
    """Carries the particles of many holds with one kernel, since kernels for each hold add up."""

    def __init__(self, grips):
        self.grips, self.counts, self.rows = grips, [], None
        if grips:
            hold, settle = grips[0].hold, grips[0].solver.substep_post_coupling

            def carried(f):
                settle(f)
                if self.rows is not None:
                    _carry(grips[0].solver.particles, *self.rows, f + 1, hold.h, hold.rigid.dyn_state.links)

            grips[0].solver.substep_post_coupling = carried

    def __call__(self):
        """Gather the rows of the active holds if some have begun, or let go of particles, since the last step."""
        counts = [len(grip.hold.chosen) if grip.hold.active else 0 for grip in self.grips]
        if counts != self.counts:
            self.counts, active = counts, [grip for grip in self.grips if grip.hold.active]
            self.rows = [torch.cat(column) for column in zip(*(grip.rows for grip in active), strict=True)] or None
            # Holds keep parts of the same memory: `_carry` changes what is owed.
            parts = [row.split([count for count in counts if count]) for row in self.rows or ()]
            for k, grip in enumerate(active):
                grip.rows = [part[k] for part in parts]


def _share(masses, arms, along, about):
    """Return the share of what it is owed that a link gets in a substep, `1 / (1 + q)`.

    q is the inertia of its particles over its own, in the direction in which it is largest.

    Args:
        masses: Masses of the particles [kg], (n,).
        arms: Their places relative to the link's centre of mass [m], (n, 3).
        along: Root of the inverse of the link's mass [kg^-1/2].
        about: Root of the inverse of its moment of inertia [kg^-1/2 m^-1].
    """
    moved = np.concatenate([np.broadcast_to(along * np.eye(3), (len(arms), 3, 3)), about * _cross(arms)], axis=2)
    return 1.0 / (1.0 + np.linalg.eigvalsh(np.einsum("n,nij,nik->jk", masses, moved, moved))[-1])


def _cross(arms):
    """Return the matrices of the cross products with vectors (n, 3), (n, 3, 3)."""
    return np.cross(arms[:, None], np.eye(3))


@qd.kernel
def _carry(
    particles: qd.template(),
    numbers: qd.types.ndarray(),
    holders: qd.types.ndarray(),
    local: qd.types.ndarray(),
    masses: qd.types.ndarray(),
    share: qd.types.ndarray(),
    pull: qd.types.ndarray(),
    owed: qd.types.ndarray(),
    f: qd.i32,
    h: qd.f32,
    links: LinksState,
):
    for k in range(numbers.shape[0]):
        i, link = numbers[k], holders[k]
        at, speed = qd.Vector([local[k, 0], local[k, 1], local[k, 2]]), qd.Vector([0.0, 0.0, 0.0])
        if link >= 0:
            at = qd_transform_by_trans_quat(at, links.pos[link, 0], links.quat[link, 0])
            speed = func_vel_at_point(link, 0, at, links)
        lost = particles[f, i, 0].vel - speed
        # The exact decay of a critically damped spring, so that damping never reverses a velocity.
        off = particles[f, i, 0].pos - at
        lost = h * pull[k] * off + (1.0 - qd.exp(-2.0 * qd.sqrt(pull[k]) * h)) * lost
        particles[f, i, 0].vel -= lost
        if share[k] > 0.0:
            blow = qd.Vector([owed[k, 0], owed[k, 1], owed[k, 2]]) + masses[k] * lost
            for axis in qd.static(range(3)):
                owed[k, axis] = (1.0 - share[k]) * blow[axis]
            func_apply_coupling_force(link, 0, at, share[k] / h * blow, links)
