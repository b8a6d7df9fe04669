"""A beam that is clamped at one end: how far its own weight bends it, and its lowest frequency.

Tip, by Euler and Bernoulli and with Timoshenko's shear: u = q L^4 / (8 E I) + q L^2 / (2 k G A), q = rho g A,
I = h^4 / 12, k = 10 (1 + nu) / (12 + 11 nu) (Cowper 1966). Lowest frequency: f = (1.8751 / L)^2 sqrt(E I / (rho A)) /
(2 pi) (Euler and Bernoulli), and with that of a beam that only shears, f_s = sqrt(k G / rho) / (4 L), by Dunkerley:
1 / f^2 = 1 / f_b^2 + 1 / f_s^2. Linear tetrahedra are too stiff (they lock); they come closer with the number of edges
through the thickness.
"""

from math import pi, sqrt

import numpy as np

from benchmarks.softlab.lab import Lab, Run
from benchmarks.softlab.row import Row
from benchmarks.softlab.swing import period_and_mean

G, RHO, E, NU = 9.81, 1000.0, 2e6, 0.3
LENGTH, THICK = 0.3, 0.06

BEAM = """
scene: {duration: "${duration}", dt: "${dt}", record: {rate: "${1 / dt}"}}
bodies:
  beam:
    kind: soft
    solver: mpm
    shape: {kind: box, size: ["${length}", "${thick}", "${thick}"]}
    cell: "${cell}"
    material: {youngs_modulus: "${e}", poisson_ratio: 0.3, density: 1000}
actions: {controls: {clamp: {kind: attach, body: beam, region: {face: left}, to: world}}}
"""


def tip_and_frequency() -> tuple[float, float]:
    """Return the deflection of the tip [m] and the lowest frequency [Hz]."""
    area, second, shear = THICK**2, THICK**4 / 12, E / (2 * (1 + NU)) * 10 * (1 + NU) / (12 + 11 * NU)
    q = RHO * G * area
    tip = q * LENGTH**4 / (8 * E * second) + q * LENGTH**2 / (2 * shear * area)
    bending = (1.8751 / LENGTH) ** 2 * sqrt(E * second / (RHO * area)) / (2 * pi)
    shearing = sqrt(shear / RHO) / (4 * LENGTH)
    return tip, 1 / sqrt(1 / bending**2 + 1 / shearing**2)


def check(lab: Lab) -> list[Row]:
    """Run it with each solver, at several resolutions."""
    tip, frequency = tip_and_frequency()
    rows = []
    fem = BEAM.replace("mpm", "fem").replace("scene: {", "scene: {fem: {damping_beta: 0}, substeps: 1, ")
    for through in (1, 2, 3, 4, 6):
        cell = THICK / through
        run = lab.run(fem, "cantilever", duration=1.5, dt=0.05, length=LENGTH, thick=THICK, cell=cell, e=E)
        solver = f"fem, {through} edge{'s' if through > 1 else ''} thick"
        rows.append(Row("cantilever under its own weight: tip [mm]", solver, 1e3 * tip, 1e3 * _sag(run)[-1]))
    undamped = fem.replace("density: 1000}", "density: 1000, damping: 0}")
    run = lab.run(
        undamped, "frequency", duration=1.7 / frequency, dt=0.005, length=LENGTH, thick=THICK, cell=THICK / 3, e=E
    )
    found, _ = period_and_mean(run.time, _sag(run), 1 / frequency)
    rows.append(Row("cantilever: lowest frequency [Hz]", "fem, 3 edges thick, 5 ms", frequency, 1 / found))
    for through in (3, 4, 6):
        cell = THICK / through
        run = lab.run(
            BEAM, "cantilever_mpm", duration=1.7 / frequency, dt=0.002, length=LENGTH, thick=THICK, cell=cell, e=E
        )
        found, mean = period_and_mean(run.time, _sag(run), 1 / frequency)
        solver = f"mpm, {through} cells thick"
        rows.append(Row("cantilever under its own weight: tip [mm]", solver, 1e3 * tip, 1e3 * mean))
        rows.append(Row("cantilever: lowest frequency [Hz]", solver, frequency, 1 / found))
    return rows


def _sag(run: Run) -> np.ndarray:
    """How far the free end has come down [m], shape (F,)."""
    rest = run.rest("beam")["rest"]
    end = rest[:, 0] > rest[:, 0].max() - 0.1 * THICK
    return -(run.points("beam")[:, end, 2].mean(axis=1) - rest[end, 2].mean())
