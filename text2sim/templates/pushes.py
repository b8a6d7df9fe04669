"""What pushes deformable bodies: start velocities, forces and blows on a region of them."""

import numpy as np
from points import Points, choose, each_substep


def set_velocity(body, linear, angular):
    """Give all points of a deformable body the velocity of a rigid motion.

    Args:
        body: The body.
        linear: Velocity of the centre of mass [m/s].
        angular: Angular velocity about the centre of mass [rad/s].
    """
    points = Points(body)
    center = points.masses @ points.rest / points.masses.sum()
    points.set_velocities(np.asarray(linear) + np.cross(angular, points.rest - center))


class Push:
    """A force on the points of a region, which are chosen at the start. All of them get the same acceleration.

    Per substep h a velocity v changes by `F / M h`; with a drag d, that of each point goes towards `F / d`, as it would
    with its share of that force and of `-d v` together: `dv = (F / d - v) (1 - exp(-d h / M))`. M is the mass of the
    points. Each has a drag of its own, so that one that runs ahead is held back, and those behind it are pulled on.

    Args:
        scene: The built scene, before its first step.
        body: The deformable body.
        pose: Where its frame is at the start: position [m], quaternion.
        region: What of it is pushed.
        force: [N]; of a blow, where start and end are equal, momentum [N s].
        scale: Factor, a function of time.
        drag: [N s/m]
        start: Time [s].
        end: Time [s].
    """

    def __init__(self, scene, body, *, pose, region, force, scale=None, drag=0.0, start=0.0, end=float("inf")):
        self.points, self.h = Points(body), scene.sim.substep_dt
        self.chosen = choose(self.points, pose, region)
        self.mass = self.points.masses[self.chosen].sum()
        self.force, self.scale, self.drag, self.start, self.end = np.array(force), scale, drag, start, end
        self.now = None
        if start != end:
            # Once in a step would be a row of blows.
            each_substep(self.points.solver, self._substep)

    def __call__(self, t):
        """Say how strong it is in the step that begins at t [s]."""
        t += 1e-9  # a step that begins at the start of a span belongs to it, whatever the rounding
        if self.start == self.end:
            if t >= self.start > float("-inf"):
                self._change(self.points.velocities(), self.force / self.mass)
                self.start = self.end = float("-inf")
            return
        self.now = self.force * (1.0 if self.scale is None else self.scale(t)) if self.start <= t < self.end else None

    def _substep(self):
        if self.now is None:
            return
        velocities = self.points.velocities()
        if self.drag == 0.0:
            change = self.now / self.mass * self.h
        else:
            change = self.now / self.drag - velocities[self.chosen]
            change *= -np.expm1(-self.drag * self.h / self.mass)
        self._change(velocities, change)

    def _change(self, velocities, change):
        velocities[self.chosen] += change
        self.points.set_velocities(velocities)
