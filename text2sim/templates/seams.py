"""Seams: points of cloth that threads tie to points of cloth, of the same sheet or of another one.

A thread is as long as its points are apart when it is sewn. It does not stretch, and hangs loose if they come closer.
In each substep, after the threads of the cloth and before velocities are worked out, both points are moved together
along the thread, in inverse proportion to their masses: a projection as in position-based dynamics (Mueller et al.
2007), which conserves momentum.
"""

import genesis as gs
import numpy as np
import quadrants as qd
import torch
from points import NothingThere, Points, array, choose, tensor


class Seam:
    """Sews points of a cloth to the nearest points of a cloth, from a given time on.

    Args:
        scene: The built scene, before its first step.
        body: The cloth.
        to: What it is sewn to; the same body for a fold that is closed.
        pose: Pose of its frame at the start: position [m], quaternion.
        region: Region that is sewn, one of the functions of `points.py`.
        to_pose: The same of `to`.
        to_region: Region of `to`.
        count: Number of points of the region, evenly spread; None: all.
        start: Time at which the seam is sewn [s].
        until: Times [s] or names of events; the first of them undoes the seam.
        loads: What keeps its load, and says when it rips; None: it holds.

    Raises:
        NothingThere: If a region contains no point, or that of `to` none but those that are sewn to it.
    """

    def __init__(
        self,
        scene,
        body,
        to,
        *,
        pose,
        region,
        to_pose,
        to_region,
        count=None,
        start=0.0,
        until=(),
        loads=None,
    ):
        self.start, self.until, self.active, self.over, self.links = start, until, False, False, ()
        self.points, self.h = Points(body), scene.sim.substep_dt
        self.solver, other = self.points.solver, Points(to)
        self.own = choose(self.points, pose, region, count)
        self.other = choose(other, to_pose, to_region)
        if body is to:
            self.other = np.setdiff1d(self.other, self.own)
        if not len(self.other):
            raise NothingThere(f"`region` and `to_region` of {body.name} are the same points: a fold needs two sides")
        self.to, self.loads, self.hooked = other, loads, False

    def begin(self):
        """Sew: every thread is as long as its points are apart now."""
        self.active = True
        own, other = self.points.positions()[self.own], self.to.positions()[self.other]
        taken = np.linalg.norm(own[:, None] - other[None], axis=2).argmin(axis=1)
        middle, apart = (own + other[taken]) / 2.0, own - other[taken]
        numbers = self.own + self.points.entity.particle_start, self.other[taken] + self.to.entity.particle_start
        numbers = (torch.as_tensor(some, dtype=gs.tc_int, device=gs.device) for some in numbers)
        self.rows = *numbers, tensor(np.linalg.norm(apart, axis=1))
        self.pull = tensor(np.zeros(len(own)))
        if self.loads is not None:
            self.loads.begin([middle.mean(axis=0)])
        if not self.hooked:
            self.hooked = True
            sort = self.solver._kernel_reorder_particles  # what follows the threads; holds count the pull later

            def sew(f):
                if self.active:
                    _tighten(self.solver.particles, self.solver.particles_info, *self.rows, self.pull, self.h)
                sort(f)

            self.solver._kernel_reorder_particles = sew

    def step(self, t):
        """Rip the seam if the step that ended at t [s] has overloaded it."""
        if self.loads is None:
            return
        if len(self.loads.take([array(self.pull).sum()], t)):
            self.end()
        self.pull.zero_()

    def end(self):
        """Undo the seam."""
        self.active, self.over = False, True


@qd.kernel
def _tighten(
    particles: qd.template(),
    info: qd.template(),
    own: qd.types.ndarray(),
    other: qd.types.ndarray(),
    length: qd.types.ndarray(),
    pull: qd.types.ndarray(),
    h: qd.f32,
):
    qd.loop_config(serialize=True)  # several threads may end at a point
    for k in range(own.shape[0]):
        a, b = own[k], other[k]
        wa, wb = particles[a, 0].free / info[a].mass, particles[b, 0].free / info[b].mass
        apart = particles[b, 0].pos - particles[a, 0].pos
        excess = apart.norm() - length[k]
        if excess > 0.0 and wa + wb > 0.0:
            shift = apart / apart.norm(gs.EPS) * excess / (wa + wb)
            particles[a, 0].pos += wa * shift
            particles[b, 0].pos -= wb * shift
            pull[k] += shift.norm() / h
