"""Pressure and friction of moving air on cloth."""

import genesis as gs
import numpy as np
import quadrants as qd
import torch
from points import Points, each_substep, tensor

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
    energies as in Kolmogorov's spectrum. In a step each triangle feels those of its place when the step begins.

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
        self.faces, count = np.asarray(body.mesh.faces), len(self.points.rest)
        area = np.linalg.norm(np.cross(*np.diff(self.points.rest[self.faces], axis=1).transpose(1, 0, 2)), axis=1).sum()
        masses = self.points.masses
        self.area_density, self.mass = float(masses.sum() / (area / 2)), float(masses[0])
        corners = self.faces.ravel()
        around = np.argsort(corners, kind="stable")
        ends = np.searchsorted(corners[around], np.arange(count + 1))
        self.mesh = [
            torch.as_tensor(np.ascontiguousarray(rows), dtype=gs.tc_int, device=gs.device)
            for rows in (self.faces, around // 3, ends)
        ]
        self.wind, self.impulses = (tensor(np.zeros(self.faces.shape)) for _ in range(2))
        resistance = body.solver.particles_info.air_resistance
        values = resistance.to_numpy()
        values[body.particle_start : body.particle_end] = 0.0
        resistance.from_numpy(values)
        each_substep(self.points.solver, self._substep)

    def __call__(self, t):
        """Set the flow for the step that begins at t [s]."""
        self.carried += self.now * (t - self.last)
        self.last, flows = t, self.start <= t + 1e-9 < self.end  # rounding must not exclude a step at `start`
        self.now = self.velocity * (0.0 if not flows else 1.0 if self.scale is None else self.scale(t))
        self.wind.copy_(tensor(self.air(self.points.positions()[self.faces].mean(axis=1))))

    def air(self, places):
        """Return the velocity of the air at positions [m], both (n, 3)."""
        if not self.gusts or not self.now.any():
            return self.now
        swing = np.cos((places - self.carried) @ self.waves.T + self.phases)
        return self.now + self.gusts * np.linalg.norm(self.now) * swing @ self.sways

    def _substep(self):
        solver, first = self.points.solver, self.points.entity.particle_start
        _press(solver.particles, first, *self.mesh, self.wind, self.impulses, self.area_density, self.mass, self.h)


@qd.func
def _lost(x):
    """Return 1 - exp(-x), with all its digits for small x."""
    t = qd.tanh(x / 2)
    return 2 * t / (1 + t)


@qd.kernel
def _press(
    particles: qd.template(),
    first: qd.i32,
    faces: qd.types.ndarray(),
    around: qd.types.ndarray(),
    ends: qd.types.ndarray(),
    wind: qd.types.ndarray(),
    impulses: qd.types.ndarray(),
    area_density: qd.f32,
    mass: qd.f32,
    h: qd.f32,
):
    """Let the air press on each triangle (f, 3), and each point take its share.

    Shares are summed in the order of `around`, the triangles about each point, so that runs repeat bit for bit. Those
    about point i are from `ends[i]` to `ends[i + 1]`. `wind` and `impulses` have a row for each triangle.
    """
    for k in range(faces.shape[0]):
        a, b, c = first + faces[k, 0], first + faces[k, 1], first + faces[k, 2]
        normal = (particles[b, 0].pos - particles[a, 0].pos).cross(particles[c, 0].pos - particles[a, 0].pos)
        twice = qd.max(normal.norm(), 1e-12)
        normal /= twice
        air = qd.Vector([wind[k, 0], wind[k, 1], wind[k, 2]])
        air -= (particles[a, 0].vel + particles[b, 0].vel + particles[c, 0].vel) / 3
        across = air.dot(normal) * normal
        rate = DENSITY * air.norm() / (2 * area_density) * h
        impulse = across * _lost(NORMAL * rate) + (air - across) * _lost(TANGENTIAL * rate)
        for j in qd.static(range(3)):
            impulses[k, j] = area_density * twice / 6 * impulse[j]
    for i in range(ends.shape[0] - 1):
        if particles[first + i, 0].free:  # the others are held
            taken = qd.Vector([0.0, 0.0, 0.0], dt=qd.f32)
            for n in range(ends[i], ends[i + 1]):
                taken += qd.Vector([impulses[around[n], j] for j in range(3)])
            particles[first + i, 0].vel += taken / mass


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
