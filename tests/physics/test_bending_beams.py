"""Beams bend, swing and lose energy as Euler and Bernoulli's equation and the damping ratio say."""

import numpy as np
import pytest

from text2sim.recording.vectors import rotate

LINKS, LENGTH, WIDTH = 10, 0.3, 0.03
PLASTIC = (0.005, 1e9, 1100)
"""Thickness [m], Young's modulus [Pa], density [kg/m3]."""
STEEL = (0.001, 2e11, 7800)
FORCE, BLOW, RATIO = 0.2, 3e-3, 0.02
"""[N], [N s], damping ratio of what is struck."""


def strip(y, made_of, ratio, more=""):
    thickness, modulus, density = made_of
    return (
        f"{{kind: beam, size: [{LENGTH}, {WIDTH}, {thickness}], youngs_modulus: {modulus}, damping_ratio: {ratio}, "
        f"material: {{density: {density}}}, pose: {{pos: [0, {y}, 1]}}{more}}}"
    )


def load(body, kind, row):
    return f"{{kind: {kind}, body: {body}.link_{LINKS - 1}, point: [{LENGTH / LINKS}, 0, 0], {row}}}"


SCENE = f"""
scene:
  duration: 1.4
  dt: 0.004
  gravity: [0, 0, 0]
  record: {{rate: 250}}
  statics: {{block: {{shape: {{kind: box, size: [0.05, 0.05, 0.05]}}, pose: {{pos: [-0.025, 0.3, 1]}}}}}}
bodies:
  held: {strip(0, PLASTIC, 0.5)}
  stiff: {strip(0.1, STEEL, 0.5)}
  tied: {strip(0.3, PLASTIC, 0.5, ", anchored: false")}
  struck: {strip(0.5, PLASTIC, RATIO)}
actions:
  controls:
    tie: {{kind: attach, body: tied.link_0, to: block}}
    a: {load("held", "force", f"force: [0, 0, {FORCE}]")}
    b: {load("stiff", "force", f"force: [0, 0, {FORCE}]")}
    c: {load("tied", "force", f"force: [0, 0, {FORCE}]")}
    d: {load("struck", "impulse", f"impulse: [0, 0, {BLOW}], at: 0")}
"""


@pytest.fixture(scope="module")
def bent(simulate):
    return simulate(SCENE)


def tip(trial, body):
    """Height of the last link's end over the clamp [m], shape (F,)."""
    last = f"{body}.link_{LINKS - 1}"
    return (trial.pos(last) + rotate(trial.quat(last), np.array([LENGTH / LINKS, 0, 0])))[:, 2] - 1


def bending_stiffness(made_of):
    """E I [N m2], of a rectangular section."""
    thickness, modulus, _ = made_of
    return modulus * WIDTH * thickness**3 / 12


@pytest.mark.parametrize(("body", "made_of"), [("held", PLASTIC), ("stiff", STEEL)])
def test_a_force_bends_a_clamped_beam_by_f_l3_over_3_e_i(bent, agree, body, made_of):
    """Exact for links on hinges, but for large angles: (deflection / length)^2 = 4e-4; within twice that."""
    theory = FORCE * LENGTH**3 / (3 * bending_stiffness(made_of))
    agree(f"{body}: deflection of the tip [m]", tip(bent, body)[-1], theory, within=8e-4 * theory)


def test_a_beam_that_is_attached_bends_from_the_middle_of_its_first_link(bent, agree):
    """Links on hinges are 1 / (4 N^2) stiffer than the equation, with N = 10, and the weld gives way a little."""
    free = LENGTH - LENGTH / LINKS / 2
    theory = FORCE * free**3 / (3 * bending_stiffness(PLASTIC))
    agree("tied: deflection of the tip [m]", tip(bent, "tied")[-1], theory, within=5e-3 * theory)


def test_a_struck_beam_swings_with_its_first_frequency_and_damping_ratio(bent, agree):
    """The links swing 0.21 / N^2 slower than 1.8751^2 sqrt(E I / (rho A L^4)), and damping takes z^2 / 2 off.

    With it the decrement is 2 pi z (1 - 0.21 / N^2). The second mode decays 39 times as fast as the first: after 0.3 s
    it is gone.
    """
    thickness, _, density = PLASTIC
    first = 1.875104**2 * np.sqrt(bending_stiffness(PLASTIC) / (density * WIDTH * thickness * LENGTH**4))
    late = bent.time > 0.3
    time, height = bent.time[late], tip(bent, "struck")[late]
    cross = np.flatnonzero(np.diff(np.sign(height)))
    at = time[cross] - height[cross] * (time[cross + 1] - time[cross]) / (height[cross + 1] - height[cross])
    pace = np.pi / np.diff(at).mean()
    agree("first frequency [rad/s]", pace, first * (1 - 0.21 / LINKS**2), within=1e-3 * first)
    agree("first frequency over that of the equation", pace / first, 1.0, within=3e-3)
    peaks = [np.abs(height[a:b]).max() for a, b in zip(cross[:-1], cross[1:], strict=True)]
    decrement = -2 * np.polyfit(np.arange(len(peaks)), np.log(peaks), 1)[0]
    agree("logarithmic decrement", decrement, 2 * np.pi * RATIO, within=0.02 * 2 * np.pi * RATIO)
