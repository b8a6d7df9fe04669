"""Pressure and friction of moving air on cloth."""

import numpy as np
from points import Points, each_substep

DENSITY = 1.225
"""Density of air [kg/m3]."""
NORMAL, TANGENTIAL = 1.5, 0.05
"""Coefficients of the force across and along a thin plate (Hoerner, Fluid-Dynamic Drag, 1965: 1.2 for a square across
the flow, 2 for a long strip; friction of both sides of a rough plate)."""
WAVES = 24
"""Number of waves that gusts are made of."""
SMALLEST = 0.25
"""Wavelength of the smallest gusts, as a fraction of that of the largest."""


class Airflow:
    """Air that flows past a cloth.

    A triangle with area A, unit normal n and the air's velocity u relative to it feels the force
    `rho A |u| (C_n (u . n) n + C_t (u - (u . n) n)) / 2`, a third of it at each corner. It changes velocities in every
    substep, by the exact solution for a constant |u|, so that light cloth of an even mesh does not overshoot.

    Gusts are a frozen pattern of waves that the flow carries along (Taylor's hypothesis), without divergence, with
    energies as in Kolmogorov's spectrum.

    Args:
        scene: The built scene, before its first step.
        body: The cloth, of solver pbd. The engine's own air resistance of its points is switched off.
        velocity: Velocity of the air [m/s].
        scale: Factor on the velocity as a function of time; None for 1.
        gusts: Root mean square of the gusts in each direction, as a fraction of the velocity.
        size: Wavelength of the largest gusts [m].
        seed: Seed of the gusts.
        start: Time at which the air begins to flow [s]; before and after, it is still.
        end: Time at which it stops [s].
    """

    def __init__(self, scene, body, *, velocity, scale=None, gusts=0.0, size=1.0, seed=0, start=0.0, end=float("inf")):
        self.points, self.h = Points(body), scene.sim.substep_dt
        self.velocity, self.scale, self.gusts, self.start, self.end = np.array(velocity), scale, gusts, start, end
        self.waves, self.sways, self.phases = frozen_gusts(size, np.random.default_rng(seed))
        self.now, self.carried, self.last = np.zeros(3), np.zeros(3), 0.0
        self.faces = np.asarray(body.mesh.faces)
        area = np.linalg.norm(self._areas(self.points.rest), axis=1).sum()
        self.area_density = self.points.masses.sum() / area
        self.range = slice(body.particle_start, body.particle_end)
        resistance = body.solver.particles_info.air_resistance
        values = resistance.to_numpy()
        values[self.range] = 0.0
        resistance.from_numpy(values)
        each_substep(self.points.solver, self._substep)

    def __call__(self, t):
        """Set the flow for the step that begins at t [s]."""
        self.carried += self.now * (t - self.last)
        self.last, flows = t, self.start <= t + 1e-9 < self.end  # rounding must not exclude a step at `start`
        self.now = self.velocity * (0.0 if not flows else 1.0 if self.scale is None else self.scale(t))
        self.free = self.points.solver.particles.free.to_numpy()[self.range, 0].astype(bool)  # the others are held

    def air(self, places):
        """Return the velocity of the air at positions [m], both (n, 3)."""
        if not self.gusts or not self.now.any():
            return self.now
        swing = np.cos((places - self.carried) @ self.waves.T + self.phases)
        return self.now + self.gusts * np.linalg.norm(self.now) * swing @ self.sways

    def _areas(self, places):
        a, b, c = (places[self.faces[:, k]] for k in range(3))
        return np.cross(b - a, c - a) / 2

    def _substep(self):
        places, velocities = self.points.positions(), self.points.velocities()
        areas = self._areas(places)
        area = np.maximum(np.linalg.norm(areas, axis=1), 1e-12)[:, None]
        normals = areas / area
        air = self.air(places[self.faces].mean(axis=1)) - velocities[self.faces].mean(axis=1)
        across = np.einsum("ij,ij->i", air, normals)[:, None] * normals
        rate = DENSITY * np.linalg.norm(air, axis=1)[:, None] / (2 * self.area_density) * self.h
        impulse = across * -np.expm1(-NORMAL * rate) + (air - across) * -np.expm1(-TANGENTIAL * rate)
        impulse *= self.area_density * area / 3
        corners, count = self.faces.ravel(), len(places)
        taken = [np.bincount(corners, np.repeat(impulse[:, k], 3), count) for k in range(3)]
        velocities[self.free] += (np.stack(taken, axis=1) / self.points.masses[:, None])[self.free]
        self.points.set_velocities(velocities)


def frozen_gusts(size, dice):
    """Return waves of turbulence: wave vectors [rad/m] (n, 3), their velocities (n, 3) and phases [rad] (n,).

    Velocities are perpendicular to the wave vectors, so that nothing diverges; their energies fall with the power 5/3
    of the wave number, and their sum has a root mean square of 1 in each direction.

    Args:
        size: Wavelength of the largest gusts [m].
        dice: Random generator.
    """
    number = np.geomspace(1, 1 / SMALLEST, WAVES)
    directions, other = (unit(dice.normal(size=(WAVES, 3))) for _ in range(2))
    # Waves are spaced evenly in log k: each stands for an energy of k^(-5/3) dk, which is k^(-2/3).
    sways = unit(np.cross(directions, other)) * number[:, None] ** (-1 / 3)
    sways *= np.sqrt(3 / (np.square(sways).sum() / 2))
    return 2 * np.pi / size * number[:, None] * directions, sways, dice.uniform(0, 2 * np.pi, WAVES)


def unit(vectors):
    """Return vectors (n, 3) with length 1."""
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
