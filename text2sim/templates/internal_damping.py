"""Internal friction of cloth and soft bodies: they lose what is not the motion of a rigid body."""

import genesis as gs
import numpy as np
import quadrants as qd
from points import Points, array


class Damping:
    """Damping that leaves linear and angular momentum of a free body as they are.

    Velocities approach those of the rigid motion with the same momenta, by `exp(-rate t)` (Müller et al., Position
    based dynamics, 2007, 3.5). So what wobbles and flutters has an amplitude that falls as `exp(-rate t / 2)`.

    Args:
        scene: The built scene.
        body: The body, of solver pbd or mpm.
        rate: Rate [1/s].
    """

    def __init__(self, scene, body, rate):
        self.points, self.lost = Points(body), -np.expm1(-rate * scene.sim.dt)

    def __call__(self, t):
        """Damp the motion in the step that begins at t [s]."""
        places, velocities = self.points.positions(), self.points.velocities()
        away, relative = places - places.mean(axis=0), velocities - velocities.mean(axis=0)
        # All points have the same mass, which cancels. Points on one line have no inertia about it.
        inertia, moments = np.eye(3) * np.square(away).sum() - away.T @ away, away.T @ relative
        x, y, z = np.linalg.pinv(inertia) @ [moments[k - 2, k - 1] - moments[k - 1, k - 2] for k in range(3)]
        rotation = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        changes = self.lost * (away @ rotation.T - relative)
        if not self.points.mpm:
            changes *= array(self.points.rows(self.points.solver.particles.free))[:, None]  # the others are held
        self.points.set_velocities(velocities + changes)
        if self.points.mpm:
            entity = self.points.entity
            first, end, f = entity.particle_start, entity.particle_end, entity.sim.cur_substep_local
            _damp_gradients(self.points.solver.particles, f, first, end, x, y, z, 1 - self.lost)


@qd.kernel
def _damp_gradients(
    particles: qd.template(), f: qd.i32, first: qd.i32, end: qd.i32, x: qd.f32, y: qd.f32, z: qd.f32, kept: qd.f32
):
    """Let the velocity gradients of mpm particles approach that of the rotation (x, y, z) [rad/s]."""
    rotation = qd.Matrix([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]], dt=gs.qd_float)
    for i in range(first, end):
        particles[f, i, 0].C = rotation + kept * (particles[f, i, 0].C - rotation)
