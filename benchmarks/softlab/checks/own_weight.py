"""A bar that hangs under its own weight, and the wave that runs through it when it is let go.

A bar of length L that hangs from its upper end is longer by u = rho g L^2 / (2 E) (Timoshenko and Goodier, Theory of
Elasticity, section 96, at its lower end, and exactly for nu = 0). Let go unstretched, its end swings between 0 and
2 u with the period 4 L / c, c = sqrt(E / rho): that of the slowest longitudinal wave (Landau and Lifshitz, Theory of
Elasticity, section 25). A cloth that does not stretch would stay as long as it is.
"""

import numpy as np

from benchmarks.softlab.lab import Lab
from benchmarks.softlab.row import Row
from benchmarks.softlab.swing import period_and_mean

G, RHO, E = 9.81, 1000.0, 1e5
LENGTH, WIDTH = 0.3, 0.06

BAR = """
scene: {duration: "${duration}", dt: "${dt}", substeps: "${substeps}", record: {rate: "${1 / dt}"}}
bodies:
  bar:
    kind: soft
    solver: mpm
    shape: {kind: box, size: ["${width}", "${width}", "${length}"]}
    cell: "${cell}"
    material: {youngs_modulus: "${e}", poisson_ratio: 0, density: 1000, damping: 0}
actions: {controls: {hang: {kind: attach, body: bar, region: {face: top}, to: world}}}
"""

STRIP = """
scene: {duration: 1.5, dt: 0.005}
bodies:
  strip: {kind: cloth, solver: pbd, shape: {kind: sheet, size: [0.1, 1.0]}, cell: 0.02, pose: {euler_deg: [90, 0, 0]}}
actions: {controls: {hang: {kind: attach, body: strip, region: {edge: back}, to: world}}}
"""


def check(lab: Lab) -> list[Row]:
    """Run it with each solver."""
    theory, period = RHO * G * LENGTH**2 / (2 * E), 4 * LENGTH / np.sqrt(E / RHO)
    rows = []
    text = BAR.replace("damping: 0}", "}").replace('substeps: "${substeps}", ', "")
    for through in (3, 6):
        run = lab.run(text, "own_weight", duration=0.3, dt=0.001, width=WIDTH, length=LENGTH, cell=WIDTH / through, e=E)
        found, mean = period_and_mean(run.time, _lengthening(run), period)
        solver = f"mpm, {through} cells thick"
        rows.append(Row("bar under its own weight: lengthening [mm]", solver, 1e3 * theory, 1e3 * mean))
        rows.append(Row("bar let go: period of its slowest wave [ms]", solver, 1e3 * period, 1e3 * found))
    fem = BAR.replace("mpm", "fem").replace("scene: {", "scene: {fem: {damping_beta: 0}, ")
    run = lab.run(
        fem, "own_weight_fem", duration=2, dt=0.05, substeps=1, width=WIDTH, length=LENGTH, cell=WIDTH / 2, e=E
    )
    rows.append(
        Row(
            "bar under its own weight: lengthening [mm]",
            "fem, 2 edges thick",
            1e3 * theory,
            1e3 * _lengthening(run)[-1],
        )
    )
    run = lab.run(
        fem, "wave_fem", duration=0.25, dt=0.0025, substeps=1, width=WIDTH, length=LENGTH, cell=WIDTH / 2, e=E
    )
    found, _ = period_and_mean(run.time, _lengthening(run), period)
    rows.append(
        Row("bar let go: period of its slowest wave [ms]", "fem, 2 edges thick, 2.5 ms", 1e3 * period, 1e3 * found)
    )
    run = lab.run(STRIP, "strip")
    low = run.rest("strip")["rest"][:, 2] < -0.49
    drop = -(run.points("strip")[:, low, 2].mean(axis=1) - run.rest("strip")["rest"][low, 2].mean())
    last = run.time > 1.0
    rows.append(
        Row("cloth strip, 1 m, under its own weight: lengthening [mm]", "pbd, 2 cm", 0.0, 1e3 * drop[last].mean(), 1e3)
    )
    return rows


def _lengthening(run) -> np.ndarray:  # noqa: ANN001
    """How far the lower end has come down [m], shape (F,)."""
    rest = run.rest("bar")["rest"]
    low = rest[:, 2] < rest[:, 2].min() + 0.1 * WIDTH
    return -(run.points("bar")[:, low, 2].mean(axis=1) - rest[low, 2].mean())
