"""Bodies that deform obey the equations that say how, as far as a coarse grid can; `docs/soft.md` has finer ones."""

import numpy as np
import pytest

G = 9.81

SCENE = """
scene:
  duration: 0.3
  dt: 0.002
  record: {rate: 500}
  mpm: {cell: 0.02, bounds: {min: [-0.25, -0.15, -0.1], max: [0.5, 0.65, 0.8]}}
  statics: {slab: {shape: {kind: box, size: [0.8, 0.3, 0.1]}, material: {friction: "${mu}"}, pose: {pos: [0.1, 0, -0.05]}}}
bodies:
  bar:
    kind: soft
    shape: {kind: box, size: [0.06, 0.06, "${length}"]}
    material: {youngs_modulus: 1e5, poisson_ratio: 0, density: 1000}
    pose: {pos: [0.4, 0.25, 0.5]}
  slider: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {youngs_modulus: 1e5}, pose: {pos: [-0.1, 0, 0.06]}}
  soft: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {youngs_modulus: 1e5}, pose: {pos: [0, 0.5, 0.65]}}
  spinner: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {youngs_modulus: 1e5}, pose: {pos: [-0.1, 0.25, 0.65]}}
  hard: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {density: 500}, pose: {pos: [0.16, 0.5, 0.65]}}
actions:
  controls:
    hang: {kind: attach, body: bar, region: {face: top}, to: world}
    slide: {kind: initial_velocity, body: slider, linear: [0.8, 0, 0]}
    fly: {kind: initial_velocity, body: soft, linear: [1, 0, 0]}
    spin: {kind: initial_velocity, body: spinner, linear: [0.2, 0, 0], angular: [0, 0, "${rate}"]}
"""
LENGTH, CELL, MU, RATE = 0.3, 0.02, 0.25, 10.0


@pytest.fixture(scope="module")
def trial(simulate):
    return simulate(SCENE, length=LENGTH, mu=MU, rate=RATE)


def test_a_bar_lengthens_under_its_own_weight_and_rings(trial, agree):
    """Let go, its end swings between 0 and 2 u, u = rho g L^2 / (2 E), in 4 L / c, c^2 = E / rho (nu = 0).

    (Timoshenko and Goodier, section 96; Landau and Lifshitz, Theory of Elasticity, section 25.) The grid holds it by the
    first layer of particles and what is within a cell of it: the bar is up to a cell shorter.
    """
    bar = next(body for body in trial.states.deformables if body.body == "bar")
    low = bar.rest[:, 2] < bar.rest[:, 2].min() + 0.006
    way = -(bar.points[:, low, 2].mean(axis=1) - bar.rest[low, 2].mean())
    period = 4 * LENGTH / np.sqrt(1e5 / 1000)
    theory, part = 1000 * G * LENGTH**2 / (2 * 1e5), CELL / LENGTH
    t = trial.time
    first = int(way[t < 0.75 * period].argmax())
    agree("bar let go: when it is longest [s]", t[first], period / 2, within=part * period / 2 + 0.002)
    agree("bar let go: twice its own-weight stretch [m]", way[first], 2 * theory, within=2 * part * 2 * theory)
    back = first + int(way[first:][: int(0.7 * period / 0.002)].argmin())
    agree("bar let go: back where it began [m]", way[back], 0.0, within=0.1 * 2 * theory)


def test_soft_and_rigid_bodies_exchange_momentum_and_rub(trial, agree):
    """A blow keeps m1 v1 + m2 v2 (Newton III). What slides loses mu of the momentum that its ground gives it (Coulomb).

    The latter, taken over the whole way, knows nothing of how it came down: mu = (v0 - v) / (g t + vz).
    """
    states = trial.states
    mass = [body.mass for body in states.deformables if body.body in ("soft", "slider")]
    agree("mass of a soft cube [kg]", mass, 1.0, within=1e-5)
    soft, slider = (
        states.soft_velocity[:, k].astype(float)
        for name in ("soft", "slider")
        for k, body in enumerate(states.deformables)
        if body.body == name
    )
    total = soft[:, 0] + 0.5 * trial.vel("hard")[:, 0]
    # The rigid body feels in a substep what the grid gave it in the one before: some 50 N for half a millisecond.
    agree("soft on hard: momentum along the way [kg m/s]", total, 1.0, within=0.03)
    agree("soft on hard: momentum when they have parted [kg m/s]", total[-1], 1.0, within=0.002)
    assert trial.vel("hard")[-1, 0] > 2 / 3, "more than if they stuck together"
    assert trial.vel("hard")[-1, 0] - soft[-1, 0] < 1.0, "and they part no faster than they met"
    end = int(np.flatnonzero(slider[:, 0] > 0.1)[-1])
    rubbed = (0.8 - slider[end, 0]) / (G * trial.time[end] + slider[end, 2])
    agree("soft cube on a slab: friction", rubbed, MU, within=0.01)


def test_a_soft_cube_that_spins_in_flight_keeps_its_angular_momentum(trial, agree):
    """L = I w, with the moment of inertia I of its particles: gravity has no moment about the centre of mass."""
    states = trial.states
    row, body = next((k, body) for k, body in enumerate(states.deformables) if body.body == "spinner")
    spin = states.soft_spin[:, row].astype(float)
    around = body.rest[:, :2] - body.rest[:, :2].mean(axis=0)
    theory = body.mass * (around**2).sum(axis=1).mean() * RATE
    agree("spinning soft cube: moment of inertia [kg m2]", theory / RATE, 1.0 * 0.1**2 / 6, within=1e-4)
    agree("spinning soft cube: angular momentum about z [kg m2/s]", spin[:, 2], theory, within=0.02 * theory)
    agree("spinning soft cube: about x and y [kg m2/s]", spin[:, :2], 0.0, within=0.02 * theory)
