"""Bodies that deform obey the equations that say how, as far as a coarse grid can; `docs/soft.md` has finer ones."""

import numpy as np

G = 9.81

HANGING = """
scene: {duration: 0.2, dt: 0.002, record: {rate: 500}}
bodies:
  bar:
    kind: soft
    shape: {kind: box, size: [0.06, 0.06, "${length}"]}
    cell: "${cell}"
    material: {youngs_modulus: 1e5, poisson_ratio: 0, density: 1000}
actions: {controls: {hang: {kind: attach, body: bar, region: {face: top}, to: world}}}
"""


def test_a_bar_lengthens_under_its_own_weight_and_rings(simulate, agree):
    """Let go, its end swings between 0 and 2 u, u = rho g L^2 / (2 E), in 4 L / c, c^2 = E / rho (nu = 0).

    (Timoshenko and Goodier, section 96; Landau and Lifshitz, Theory of Elasticity, section 25.) The grid holds it by the
    first layer of particles and what is within a cell of it: the bar is up to a cell shorter.
    """
    length, cell = 0.3, 0.02
    trial = simulate(HANGING, length=length, cell=cell)
    (bar,) = trial.states.deformables
    low = bar.rest[:, 2] < bar.rest[:, 2].min() + 0.006
    way = -(bar.points[:, low, 2].mean(axis=1) - bar.rest[low, 2].mean())
    period = 4 * length / np.sqrt(1e5 / 1000)
    theory = 1000 * G * length**2 / (2 * 1e5)
    t = trial.time
    first = int(way.argmax())
    agree("bar let go: when it is longest [s]", t[first], period / 2, within=cell / length * period / 2 + 0.002)
    agree("bar let go: twice its own-weight stretch [m]", way[first], 2 * theory, within=2 * cell / length * 2 * theory)
    back = first + int(way[first:][: int(0.7 * period / 0.002)].argmin())
    agree("bar let go: back where it began [m]", way[back], 0.0, within=0.1 * 2 * theory)


MEETING = """
scene:
  duration: 0.3
  dt: 0.0025
  record: {rate: 400}
  mpm: {cell: 0.025, bounds: {min: [-0.4, -0.3, -0.2], max: [0.7, 0.7, 1.3]}}
  statics: {slab: {shape: {kind: box, size: [0.8, 0.3, 0.1]}, material: {friction: 0.01}, pose: {pos: [0.1, 0, -0.05]}}}
bodies:
  slider: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {youngs_modulus: 1e5}, pose: {pos: [-0.1, 0, 0.06]}}
  soft: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {youngs_modulus: 1e5}, pose: {pos: [0, 0.5, 1]}}
  hard: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {density: 500}, pose: {pos: [0.16, 0.5, 1]}}
actions:
  controls:
    slide: {kind: initial_velocity, body: slider, linear: [0.8, 0, 0]}
    fly: {kind: initial_velocity, body: soft, linear: [1, 0, 0]}
"""


def test_soft_and_rigid_bodies_exchange_momentum_and_rub(simulate, agree):
    """A blow keeps m1 v1 + m2 v2 (Newton III). What slides loses mu of the momentum that its ground gives it (Coulomb).

    The latter, taken over the whole way, knows nothing of how it came down: mu = (v0 - v) / (g t + vz).
    """
    trial = simulate(MEETING.replace("friction: 0.01", 'friction: "${mu}"'), mu=0.25)
    states = trial.states
    mass = [body.mass for body in states.deformables]
    agree("mass of a soft cube [kg]", mass, 1.0, within=1e-5)
    soft, slider = (
        states.soft_velocity[:, k].astype(float)
        for name in ("soft", "slider")
        for k, body in enumerate(states.deformables)
        if body.body == name
    )
    total = soft[:, 0] + 0.5 * trial.vel("hard")[:, 0]
    agree("soft on hard: momentum along the way [kg m/s]", total, 1.0, within=0.01)
    assert trial.vel("hard")[-1, 0] > 2 / 3, "more than if they stuck together"
    assert trial.vel("hard")[-1, 0] - soft[-1, 0] < 1.0, "and they part no faster than they met"
    end = int(np.flatnonzero(slider[:, 0] > 0.1)[-1])
    rubbed = (0.8 - slider[end, 0]) / (G * trial.time[end] + slider[end, 2])
    agree("soft cube on a slab: friction", rubbed, 0.25, within=0.01)
