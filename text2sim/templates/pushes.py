"""Start velocities of deformable bodies, and forces and impulses on regions of them."""

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
    if points.mpm and any(angular):
        # Without it, the grid would keep only the part of the rotation that differs from cell to cell.
        points.set_gradient(np.cross(angular, np.eye(3)).T)


class Push:
    """A force on the points of a region; the points are chosen at the start. All get the same acceleration.

    In a substep h each velocity v changes by `F h / M`, where M is the mass of all chosen points. With a drag d it
    approaches `F / d`, the exact solution for the force `F - d v`: `dv = (F / d - v) (1 - exp(-d h / M))`. Drag acts on
    each point separately, so it slows points that run ahead and speeds up those that lag behind.

    Args:
        scene: The built scene, before its first step.
        body: The deformable body.
        pose: Pose of its frame at the start: position [m], quaternion.
        region: Region on which the force acts, one of the functions of `points.py`.
        force: Total force [N]; if start and end are equal, an impulse [N s].
        scale: Factor on the force as a function of time.
        drag: Drag coefficient of the region [N s/m].
        start: Time at which the force begins [s].
        end: Time at which the force ends [s].
    """

    def __init__(self, scene, body, *, pose, region, force, scale=None, drag=0.0, start=0.0, end=float("inf")):
        self.points, self.h = Points(body), scene.sim.substep_dt
        self.chosen = choose(self.points, pose, region)
        self.mass = self.points.masses[self.chosen].sum()
        self.force, self.scale, self.drag, self.start, self.end = np.array(force), scale, drag, start, end
        self.now = None
        if start != end:
            # Applied once per step, the force would be a series of impulses.
            each_substep(self.points.solver, self._substep)

    def __call__(self, t):
        """Set the force for the step that begins at t [s]."""
        t += 1e-9  # rounding must not exclude a step that begins at `start`
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
