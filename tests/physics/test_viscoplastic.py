"""Solids with a yield stress and a viscosity, against the law of Bingham."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from tests.physics.conftest import rows
from text2sim import templates

SHEARED = """
import json, sys
import genesis as gs
import numpy as np
import quadrants as qd

gs.init(backend=gs.cpu, precision="64", logging_level="error")
from viscoplastic import Viscoplastic

@qd.data_oriented
class Point:
    def __init__(self, viscosity, substep):
        self.law = Viscoplastic(E=3e4, nu=0.499999, von_mises_yield_stress=300.0, viscosity=viscosity, substep=substep)
        self.substep = substep
        self.F, self.S = (qd.Matrix.field(3, 3, dtype=gs.qd_float, shape=()) for _ in "FS")
        self.F.from_numpy(np.eye(3))

    @qd.kernel
    def flow(self, rate: gs.qd_float, steps: qd.i32):
        for _ in range(1):  # the outermost loop is parallel
            for _step in range(steps):
                L = qd.Matrix.zero(gs.qd_float, 3, 3)
                L[0, 1] = rate
                F = self.F[None] + self.substep * L @ self.F[None]
                U, S, V = qd.svd(F, gs.qd_float)
                F, S, Jp = self.law._update_viscoplastic(S.determinant(), F, U, S, V, gs.qd_float(1.0))
                self.F[None] = F
                self.S[None] = S

    def stress(self, rate, seconds):
        self.flow(rate, round(seconds / self.substep))
        strain = np.log(np.diag(self.S.to_numpy()))
        return 2 * self.law.mu * np.linalg.norm(strain - strain.mean())

thick, thin = Point(100.0, 1e-4), Point(1.0, 1e-3)
print(json.dumps([thick.stress(2.0, 0.2), thick.stress(0.0, 0.01), thin.stress(2.0, 0.2)]))
"""


def test_stress_of_steady_shear_is_that_of_bingham_and_relaxes_to_the_yield_stress(engine, agree, tmp_path):
    """The norm of the rate of deformation of a shear rate c is c / sqrt(2), and G is 1e4 Pa.

    The last viscosity relaxes ten times faster than a substep. Elastic strains of 3 % change the direction of the
    stress: hence a tolerance of 0.1 %.
    """
    (tmp_path / "sheared.py").write_text(SHEARED)  # kernels need their source
    env = os.environ | {"PYTHONPATH": str(Path(templates.__file__).parent)}
    done = subprocess.run(
        [sys.executable, str(tmp_path / "sheared.py")], env=env, capture_output=True, text=True, check=True
    )
    flowing, relaxed, thin = json.loads(done.stdout.splitlines()[-1])
    excess = 2 * 100 * 2 / np.sqrt(2)
    agree("stress of shear at 2 per second, 100 Pa s [Pa]", flowing, 300 + excess, within=0.6)
    agree("after the time viscosity / G [Pa]", relaxed, 300 + excess / np.e, within=1.0)
    agree("stress with 1 Pa s [Pa]", thin, 300 + excess / 100, within=0.3)


PRESSURE, LIMIT = 1000.0, 600.0
CUBES = """
scene:
  duration: 0.8
  dt: 0.004
  gravity: [0, 0, 0]
  record: {rate: 50}
  statics: {table: {shape: {kind: box, size: [0.3, 2, 0.1]}, material: {friction: 0.01}, pose: {pos: [0, 0, -0.05]}}}
bodies:
"""
CUBE = """
  plate_{name}:
    kind: rigid
    shape: {{kind: box, size: [0.16, 0.16, 0.05]}}
    material: {{density: 100, friction: 0.01}}
    pose: {{pos: [0, {y}, 0.085]}}
    mount: {{kind: slider, axis: z}}
  {name}:
    kind: soft
    solver: mpm
    cell: 0.01
    shape: {{kind: box, size: [0.06, 0.06, 0.06]}}
    material: {{model: elasto_plastic, youngs_modulus: 5e4, poisson_ratio: 0.4, yield_stress: {limit}, viscosity: {viscosity}}}
    pose: {{pos: [0, {y}, 0.03]}}
"""
PRESS = "    press_{name}: {{kind: force, body: plate_{name}, force: [0, 0, -3.6]}}\n"
PRESSED = {"firm": (1500, 20), "quick": (LIMIT, 20), "calm": (LIMIT, 40), "slow": (LIMIT, 200), "slower": (LIMIT, 400)}
"""Yield stress [Pa] and viscosity [Pa s] by name."""


def test_pressed_cubes_flow_at_the_rate_of_their_viscosity_until_they_bear_the_load(simulate, agree):
    """Between smooth plates a cube of stretch l is under a uniaxial stress p l, since its volume stays."""
    cubes = [
        CUBE.format(name=name, y=0.25 * (k - 2), limit=limit, viscosity=viscosity)
        for k, (name, (limit, viscosity)) in enumerate(PRESSED.items())
    ]
    presses = [PRESS.format(name=name) for name in PRESSED]
    trial = simulate("".join([CUBES, *cubes, "actions:\n  controls:\n", *presses]))
    stretch = {}
    for name in PRESSED:
        points, _ = rows(trial.states, name)
        z = points[0, :, 2] - points[0, :, 2].mean()
        stretch[name] = points[..., 2] @ z / (z @ z)
    agree(
        "a firm one sways about its elastic height",
        stretch["firm"].mean(),
        stretch_of(PRESSURE, 1500, 20, 0.0),
        within=0.03,
    )
    bears = LIMIT / PRESSURE * np.exp(-LIMIT / E)
    for name in ("quick", "calm"):
        agree(f"{name}: stretch at which it bears the load", stretch[name][-1], bears, within=0.1 * bears)
        agree(f"{name}: rests", stretch[name][-1], stretch[name][-10], within=2e-3)
    agree("whatever its viscosity", stretch["calm"][-1], stretch["quick"][-1], within=0.01)

    def spent(name):
        """Time in which the stretch falls from 0.92 to 0.8 [s]."""
        return np.diff(np.interp([-0.92, -0.8], -stretch[name], trial.time))[0]

    agree("twice the viscosity, twice the time", spent("slower") / spent("slow"), 2.0, within=0.3)
    for name in ("slow", "slower"):
        law = [stretch_of(PRESSURE, *PRESSED[name], t) for t in trial.time]
        agree(f"{name}: stretch over time", stretch[name], law, within=0.04)


DENSITY, HEIGHT, E = 1000.0, 0.12, 5e4
COLUMNS = """
scene: {duration: 0.6, dt: 0.004, record: {rate: 50}, statics: {floor: {shape: {kind: plane}, material: {friction: 0.01}}}}
bodies:
"""
COLUMN = """
  {name}:
    kind: soft
    solver: mpm
    cell: 0.01
    shape: {{kind: box, size: [0.06, 0.06, 0.12]}}
    material: {{model: elasto_plastic, youngs_modulus: 5e4, poisson_ratio: 0.4, yield_stress: {limit}, viscosity: {viscosity}}}
    pose: {{pos: [{x}, 0, 0.065]}}
"""
STANDING = {"firm": (2500, 40), "slow": (500, 400), "slower": (500, 800)}


def test_a_column_stands_if_its_foot_bears_its_weight_and_else_sinks_at_the_rate_of_its_viscosity(simulate, agree):
    """The foot bears 1177 Pa. On a smooth floor each layer is under uniaxial stress (slump test: Pashias et al., 1996).

    They begin without stress, and sway for a third of a second, with twice that stress at most. The flared foot, where
    stress is not even, flows a tenth faster.
    """
    columns = [
        COLUMN.format(name=name, limit=limit, viscosity=viscosity, x=0.2 * k)
        for k, (name, (limit, viscosity)) in enumerate(STANDING.items())
    ]
    trial = simulate(COLUMNS + "".join(columns))
    sunk = {}
    for name in STANDING:
        points, _ = rows(trial.states, name)
        top, bottom = (points[:, part, 2].mean(axis=1) for part in ends(points[0, :, 2]))
        sunk[name] = (top - bottom)[0] - (top - bottom)
    agree(
        "a firm one sways about its elastic height [m]",
        sunk["firm"].mean(),
        sinking(0.0, *STANDING["firm"]),
        within=2e-4,
    )
    for name in ("slow", "slower"):
        way = np.interp([0.3, 0.6], trial.time, sunk[name])
        law = [sinking(t, *STANDING[name]) for t in (0.3, 0.6)]
        agree(
            f"{name}: sinks from 0.3 s to 0.6 s by [m]",
            way[1] - way[0],
            law[1] - law[0],
            within=0.2 * (law[1] - law[0]),
        )


def ends(z):
    """Return which points are the uppermost and the lowest centimetre."""
    return z > z.max() - 0.01, z < z.min() + 0.01


def sinking(time, limit, viscosity):
    """Return by how much the middle of the uppermost centimetre comes nearer to that of the lowest [m] by a time [s].

    A layer that bore the weight w per area of what is above it, and has the stretch l, bears w l.
    """
    layers = np.linspace(0.005, HEIGHT - 0.005, 111)
    stretch = np.array([stretch_of(DENSITY * 9.81 * (HEIGHT - z), limit, viscosity, time) for z in layers])
    return np.trapezoid(1 - stretch, layers)


def stretch_of(pressure, limit, viscosity, time):
    """Return the stretch after a time [s] under a load per original area [Pa].

    Its volume stays, so that the stress grows as it gets wider. It is stretched elastically by `exp(-stress / E)`, and
    flows as `d(ln l)/dt = -(stress - limit) / (3 viscosity)` (Bingham's law under uniaxial stress).
    """
    flown, steps = 0.0, 500
    for _ in range(steps):
        flown -= time / steps * max(pressure * np.exp(flown) - limit, 0.0) / (3 * viscosity)
    return np.exp(flown - pressure * np.exp(flown) / E)
