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

HEAD = """
scene: {duration: "${duration}", dt: "${dt}", record: {rate: "${1 / dt}"}SOLVER}
bodies:
"""
BEAM = """
  beam_{k}:
    kind: soft
    solver: {solver}
    shape: {{kind: box, size: [{length}, {thick}, {thick}]}}
    cell: {cell}
    material: {{youngs_modulus: {e}, poisson_ratio: {nu}, density: {rho}{more}}}
    pose: {{pos: [0, {y}, 0]}}
"""
CLAMP = "    clamp_{k}: {{kind: attach, body: beam_{k}, region: {{face: left}}, to: world}}\n"
IMPLICIT = ", fem: {damping_beta: 0}, substeps: 1"


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
    rows, fine = [], (1, 2, 3, 4, 6)
    run = lab.run(_text("fem", fine), "cantilever", duration=1.5, dt=0.05)
    for k, through in enumerate(fine):
        solver = f"fem, {through} edge{'s' if through > 1 else ''} thick"
        rows.append(Row("cantilever under its own weight: tip [mm]", solver, 1e3 * tip, 1e3 * _sag(run, k)[-1]))
    run = lab.run(_text("fem", (3,), ", damping: 0"), "frequency", duration=1.7 / frequency, dt=0.005)
    found, _ = period_and_mean(run.time, _sag(run, 0), 1 / frequency)
    rows.append(Row("cantilever: lowest frequency [Hz]", "fem, 3 edges thick, 5 ms", frequency, 1 / found))
    for through in (3, 6):
        run = lab.run(_text("mpm", (through,)), "cantilever_mpm", duration=1.7 / frequency, dt=0.002)
        found, mean = period_and_mean(run.time, _sag(run, 0), 1 / frequency)
        solver = f"mpm, {through} cells thick"
        rows.append(Row("cantilever under its own weight: tip [mm]", solver, 1e3 * tip, 1e3 * mean))
        rows.append(Row("cantilever: lowest frequency [Hz]", solver, frequency, 1 / found))
    return rows


def _text(solver: str, fine: tuple[int, ...], more: str = "") -> str:
    """Return a case with a beam for each number of elements through the thickness."""
    values = {"solver": solver, "length": LENGTH, "thick": THICK, "e": E, "nu": NU, "rho": RHO, "more": more}
    beams = [BEAM.format(k=k, cell=THICK / n, y=0.2 * k, **values) for k, n in enumerate(fine)]
    clamps = [CLAMP.format(k=k) for k in range(len(fine))]
    head = HEAD.replace("SOLVER", IMPLICIT if solver == "fem" else "")
    return head + "".join(beams) + "actions:\n  controls:\n" + "".join(clamps)


def _sag(run: Run, k: int) -> np.ndarray:
    """How far the free end of a beam has come down [m], shape (F,)."""
    rest = run.rest(f"beam_{k}")["rest"]
    end = rest[:, 0] > rest[:, 0].max() - 0.1 * THICK
    return -(run.points(f"beam_{k}")[:, end, 2].mean(axis=1) - rest[end, 2].mean())
