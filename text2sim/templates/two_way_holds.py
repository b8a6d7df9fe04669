"""Particles of cloth that a link carries, and whose pull the link feels, or only counts."""

import genesis as gs
import numpy as np
import quadrants as qd
import torch
from genesis.engine.solvers.rigid.abd.forward_dynamics import func_vel_at_point
from genesis.engine.solvers.rigid.abd.misc import func_apply_coupling_force
from genesis.utils.array_class import LinksState
from genesis.utils.geom import qd_transform_by_trans_quat
from points import array, tensor

LEAST = 1e-6
"""Smallest inverse mass [1/kg] assumed for a holder; that of the world is zero."""
HEAVY = 20.0
"""Mass of a point whose holder only counts the pull, in masses of a particle: with more, single precision is too coarse
for the little that the pull moves it in a substep."""


class Mutual:
    """Particles that a link carries, and that act on the link.

    In each substep a held particle first moves with its link as if it were a part of it. Then threads and contacts give
    it a momentum `m dv`, which is passed on to the link as a force `m dv / h` in the next substep, and is taken from it
    again. So momentum is conserved. `m` is the link's effective mass at the point, divided by its number of points: the
    threads move the particle as far as they would move the link. Of a link that feels nothing, the force is only
    counted, and any `m` serves.
    """

    def __init__(self, hold):
        self.hold, self.solver, self.hooked = hold, hold.points.solver, False

    def begin(self):
        """Weigh the points as their links need it, and act in every substep from now on."""
        hold = self.hold
        chosen = hold.chosen + hold.points.entity.particle_start
        weights = array(hold.rigid.get_links_invweight(hold.links)).reshape(len(hold.links), -1)[hold.owner]
        arms = np.linalg.norm(hold.local, axis=1)
        mass = 1.0 / np.maximum(weights[:, 0] + weights[:, 1] * arms**2, LEAST) / np.bincount(hold.owner)[hold.owner]
        self.numbers, self.own = torch.as_tensor(chosen, dtype=gs.tc_int), hold.points.masses[hold.chosen]
        if not hold.both_ways:
            mass = HEAVY * self.own
        links = torch.as_tensor(np.asarray(hold.links)[hold.owner], dtype=gs.tc_int)
        self.rows = self.numbers, links, tensor(hold.local)
        self.mass, self.given = tensor(mass), tensor(np.zeros((len(mass), 3)))
        self._weigh(mass)
        if not self.hooked:
            self.hooked = True
            self._hook()

    def step(self):
        """Do nothing: substeps do it."""

    def drop(self, gone):
        """Let go of some of the points, given as a mask."""
        self._weigh(np.where(gone, self.own, array(self.mass)))
        kept = torch.as_tensor(np.flatnonzero(~gone))
        self.numbers, self.mass, self.given = self.numbers[kept], self.mass[kept], self.given[kept]
        self.rows, self.own = tuple(row[kept] for row in self.rows), self.own[~gone]

    def _weigh(self, masses):
        for number, mass in zip(self.numbers.tolist(), masses, strict=True):
            self.solver.particles_info.mass[number] = float(mass)

    def _hook(self):
        solver, links = self.solver, self.hold.rigid.dyn_state.links
        fall, solve, settle = (
            solver._kernel_apply_external_force,
            solver.substep_pre_coupling,
            solver.substep_post_coupling,
        )

        def carried(f, t):
            fall(f, t)
            if self.hold.active:
                carry(solver.particles, *self.rows, self.hold.h, links)

        def felt(f):
            settle(f)
            if self.hold.active:
                _feel(solver.particles, *self.rows, self.mass, int(self.hold.both_ways), self.hold.h, links)

        def counted(f):
            solve(f)
            if self.hold.active:
                _count(solver.particles, *self.rows, self.mass, self.given, self.hold.h, links)

        # Between gravity, which already acts on the link, and the threads.
        solver._kernel_apply_external_force, solver.substep_post_coupling = carried, felt
        if self.hold.loads is not None:  # before contacts, in which the holder pushes its own points, too
            solver.substep_pre_coupling = counted


@qd.func
def _anchor(link, x, y, z, links: LinksState):
    return qd_transform_by_trans_quat(qd.Vector([x, y, z], dt=gs.qd_float), links.pos[link, 0], links.quat[link, 0])


@qd.kernel
def carry(
    particles: qd.template(),
    numbers: qd.types.ndarray(),
    holders: qd.types.ndarray(),
    local: qd.types.ndarray(),
    h: qd.f32,
    links: LinksState,
):
    """Place particles where their holders are, with the velocities of these.

    Args:
        particles: The solver's particles.
        numbers: Numbers of those that are held, (n,).
        holders: Numbers of the links that hold them, (n,).
        local: Their places in the frames of these [m], (n, 3).
        h: Substep [s].
        links: State of the links.
    """
    for k in range(numbers.shape[0]):
        at = _anchor(holders[k], local[k, 0], local[k, 1], local[k, 2], links)
        speed = func_vel_at_point(holders[k], 0, at, links)
        particles[numbers[k], 0].pos = at
        particles[numbers[k], 0].vel = speed
        particles[numbers[k], 0].ipos = at - speed * h


@qd.kernel
def _feel(
    particles: qd.template(),
    numbers: qd.types.ndarray(),
    holders: qd.types.ndarray(),
    local: qd.types.ndarray(),
    mass: qd.types.ndarray(),
    both_ways: qd.i32,
    h: qd.f32,
    links: LinksState,
):
    for k in range(numbers.shape[0]):
        at = _anchor(holders[k], local[k, 0], local[k, 1], local[k, 2], links)
        speed = func_vel_at_point(holders[k], 0, at, links)
        given = mass[k] * (particles[numbers[k], 0].vel - speed)
        if both_ways == 1:
            func_apply_coupling_force(holders[k], 0, at, given / h, links)
        # What the pull made of it was only asked for: where the point is, its link is.
        particles[numbers[k], 0].pos = at
        particles[numbers[k], 0].vel = speed


@qd.kernel
def _count(
    particles: qd.template(),
    numbers: qd.types.ndarray(),
    holders: qd.types.ndarray(),
    local: qd.types.ndarray(),
    mass: qd.types.ndarray(),
    given: qd.types.ndarray(),
    h: qd.f32,
    links: LinksState,
):
    for k in range(numbers.shape[0]):
        at = _anchor(holders[k], local[k, 0], local[k, 1], local[k, 2], links)
        pull = mass[k] * (particles[numbers[k], 0].pos - at) / h  # velocities follow later
        for axis in qd.static(range(3)):
            given[k, axis] += pull[axis]
