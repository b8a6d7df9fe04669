"""Internal friction of cloth: it loses what is not the motion of a rigid body."""

import numpy as np
from points import Points


class Damping:
    """Damping that leaves linear and angular momentum of a free cloth as they are.

    Velocities approach those of the rigid motion with the same momenta, by `exp(-rate t)` (Müller et al., Position
    based dynamics, 2007, 3.5). So what sways and flutters has an amplitude that falls as `exp(-rate t / 2)`.

    Args:
        scene: The built scene.
        body: The cloth, of solver pbd.
        rate: Rate [1/s].
    """

    def __init__(self, scene, body, rate):
        self.points, self.lost = Points(body), -np.expm1(-rate * scene.sim.dt)
        self.range = slice(body.particle_start, body.particle_end)

    def __call__(self, t):
        """Damp the motion in the step that begins at t [s]."""
        free = self.points.solver.particles.free.to_numpy()[self.range, 0].astype(bool)  # the others are held
        places, velocities = self.points.positions(), self.points.velocities()
        away, relative = places - places.mean(axis=0), velocities - velocities.mean(axis=0)
        # All points have the same mass, which cancels. Points on one line have no inertia about it.
        inertia = np.eye(3) * np.square(away).sum() - away.T @ away
        spin = np.linalg.pinv(inertia) @ np.cross(away, relative).sum(axis=0)
        velocities[free] -= self.lost * (relative - np.cross(spin, away))[free]
        self.points.set_velocities(velocities)
