"""Gas in a closed cloth: its pressure acts on every triangle."""

import numpy as np
from points import Points, each_substep


class Gas:
    """Gas that a closed cloth encloses.

    At a volume V its pressure exceeds that outside by `pressure + modulus (V_start / V - 1)`. A triangle of area A
    feels that times A along its outward normal, a third of it at each corner.

    Args:
        scene: The built scene, before its first step.
        body: The cloth, of solver pbd.
        pressure: Excess pressure at the start [Pa].
        modulus: Rise of the pressure [Pa] for each unit of `V_start / V`.
    """

    def __init__(self, scene, body, pressure, modulus):
        self.points, self.h = Points(body), scene.sim.substep_dt
        self.pressure, self.modulus = pressure, modulus
        self.faces = np.asarray(body.mesh.faces)
        self.range = slice(body.particle_start, body.particle_end)
        volume = self._volume(self.points.rest)
        self.start, self.outward = abs(volume), np.sign(volume)  # negative where the faces look inward
        each_substep(self.points.solver, self._substep)

    def __call__(self, t):
        """Note which points are free in the step that begins at t [s]; the others are held."""
        self.free = self.points.solver.particles.free.to_numpy()[self.range, 0].astype(bool)

    def _volume(self, places):
        a, b, c = (places[self.faces[:, k]] for k in range(3))
        return np.einsum("ij,ij->", a - places[0], np.cross(b - places[0], c - places[0])) / 6

    def _substep(self):
        places, velocities = self.points.positions(), self.points.velocities()
        volume = max(self.outward * self._volume(places), 1e-3 * self.start)  # it may be crushed
        pressure = self.pressure + self.modulus * (self.start / volume - 1)
        a, b, c = (places[self.faces[:, k]] for k in range(3))
        impulse = self.outward * pressure * self.h / 6 * np.cross(b - a, c - a)  # the product is 2 A
        corners, count = self.faces.ravel(), len(places)
        received = [np.bincount(corners, np.repeat(impulse[:, k], 3), count) for k in range(3)]
        velocities[self.free] += (np.stack(received, axis=1) / self.points.masses[:, None])[self.free]
        self.points.set_velocities(velocities)
