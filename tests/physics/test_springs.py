"""Springs and cords between bodies, in space and under gravity, with one substep and with several.

On a mass m a spring of stiffness k swings with w = sqrt(k / m). The method is symplectic: the amplitude stays, energy swings
by w T / 2 of itself, and the period is too short by (w T)^2 / 24 (Hairer, Lubich, Wanner: Geometric Numerical
Integration, I.1). With n substeps the force lasts longer than the positions that it came from, and without a correction
the amplitude would grow by the factor 1 + (w T)^2 (n - 1) / (4 n) per step: 14 times in these runs.
"""

import numpy as np
import pytest

M, K, T = 0.5, 200.0, 0.01
W = np.sqrt(K / M)

SCENE = """
scene:
  duration: 6
  dt: 0.01
  substeps: ${substeps}
  gravity: [0, 0, 0]
  record: {rate: 100}
  statics: {wall: {shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [-0.5, 0, 0]}}}
bodies:
  bob: {kind: rigid, shape: {kind: sphere, radius: 0.02}, material: {mass: 0.5}, pose: {pos: [0, 0, 0]}}
  left: {kind: rigid, shape: {kind: sphere, radius: 0.02}, material: {mass: 0.3}, pose: {pos: [0, 1, 0]}}
  right: {kind: rigid, shape: {kind: sphere, radius: 0.02}, material: {mass: 0.6}, pose: {pos: [0.5, 1, 0]}}
  slow: {kind: rigid, shape: {kind: sphere, radius: 0.02}, material: {mass: 0.5}, pose: {pos: [0, 2, 0]}}
  rod: {kind: rigid, shape: {kind: box, size: [0.6, 0.02, 0.02]}, material: {mass: 0.5}, pose: {pos: [0, 3, 0]}}
  club:
    kind: rigid
    shape:
      kind: compound
      parts:
        shaft: {shape: {kind: box, size: [0.6, 0.02, 0.02]}}
        head: {shape: {kind: box, size: [0.06, 0.08, 0.1]}, pose: {pos: [-0.3, 0.02, 0]}}
    material: {mass: 0.5}
    pose: {pos: [0, 5, 0]}
  loose: {kind: rigid, shape: {kind: sphere, radius: 0.02}, material: {mass: 0.5}, pose: {pos: [0, 4, 0]}}
actions:
  controls:
    one: {kind: spring, body: bob, to: wall, stiffness: 200, length: 0.45}
    two: {kind: spring, body: left, to: right, stiffness: 80, length: 0.4}
    dashpot: {kind: spring, body: slow, to: wall, to_point: [0, 2, 0], stiffness: 200, damping: 4, length: 0.4}
    ends:
      kind: spring
      body: rod
      point: [0.3, 0, 0]
      to: wall
      to_point: [0.8, 3, 0.5]
      stiffness: 20
    club: {kind: spring, body: club, point: [0.3, 0, 0], to: wall, to_point: [0.8, 5, 0.5], stiffness: 20}
    tap: {kind: initial_velocity, body: club, linear: [0, 0.01, 0.05]}
    band: {kind: spring, form: cord, body: loose, to: wall, to_point: [0, 4, 0], stiffness: 200, length: 0.52, during: [0, 5]}
    throw: {kind: initial_velocity, body: loose, linear: [0.2, 0, 0]}
    nudge: {kind: initial_velocity, body: rod, linear: [0, 0, 0.05]}
  measures:
    pull: {kind: spring_force, spring: one}
    band: {kind: spring_force, spring: band}
"""


@pytest.fixture(scope="module", params=[1, 4])
def trial(request, simulate):
    return simulate(SCENE, substeps=request.param)


def fitted(time, values):
    """Angular frequency [rad/s] of a swing: the least squares of values'' = -w^2 values, by central differences.

    For a sampled sine the second difference is  -(2 sin(w h / 2) / h)^2  times the value, which is inverted.
    """
    h = time[1] - time[0]
    second = (values[2:] - 2 * values[1:-1] + values[:-2]) / h**2
    rate = -(second @ values[1:-1]) / (values[1:-1] @ values[1:-1])
    return 2 / h * np.arcsin(h * np.sqrt(rate) / 2)


def test_a_mass_swings_with_its_period_and_keeps_its_amplitude(trial, agree):
    x = trial.pos("bob")[:, 0] + 0.05
    # The symplectic method's own frequency: sin(w' T / 2) = w T / 2.
    agree("springs: frequency [rad/s]", fitted(trial.time, x), 2 / T * np.arcsin(W * T / 2), within=2e-3 * W)
    early, late = (np.abs(x[rows]).max() for rows in (slice(0, 100), slice(-100, None)))
    # A frame need not be at a crest, which the largest of seven swings misses by less than (w T)^2 / 8.
    agree("springs: amplitude [m]", late, early, within=(W * T) ** 2 / 8 * 0.05)
    agree("springs: pull [N]", trial.measure("pull"), K * x, within=1e-3)


def test_two_masses_swing_about_their_centre_with_the_reduced_mass(trial, agree):
    left, right = trial.pos("left")[:, 0], trial.pos("right")[:, 0]
    w = np.sqrt(80.0 / (0.3 * 0.6 / 0.9))
    agree(
        "springs: frequency of two [rad/s]",
        fitted(trial.time, right - left - 0.4),
        2 / T * np.arcsin(w * T / 2),
        within=2e-3 * w,
    )
    agree(
        "springs: centre of mass [m]",
        (0.3 * left + 0.6 * right) / 0.9,
        np.full(len(left), 0.5 * 0.6 / 0.9),
        within=1e-5,
    )


def test_damping_ends_a_swing_as_it_should(trial, agree):
    """X = x0 exp(-d t) (cos w' t + d / w' sin w' t) with d = c / (2 m), to first order in the step."""
    x, d = trial.pos("slow")[:, 0] + 0.1, 4.0 / (2 * M)
    w = np.sqrt(W**2 - d**2)
    exact = 0.1 * np.exp(-d * trial.time) * (np.cos(w * trial.time) + d / w * np.sin(w * trial.time))
    # The phase is off by (w T)^2 / 24 of itself, and the damping, which is explicit, by w T / 2.
    agree("springs: damped position [m]", x, exact, within=0.1 * W * T / 2)


@pytest.mark.parametrize("body", ["rod", "club"])
def test_an_end_off_the_centre_turns_its_body(trial, agree, body):
    """The energy swings by w T / 2 of what is exchanged; at the end of a rod, the spring meets a quarter of its mass.

    The club is a compound with its centre of mass off its origin.
    """
    turn = trial.ang(body)
    assert np.abs(turn).max() > 0.1
    end = trial.pos(body) + np.einsum("fij,j->fi", trial.turn(body), [0.3, 0, 0])
    anchor = end[0] + [0, 0, 0.5]
    stored = 10.0 * (np.linalg.norm(end - anchor, axis=1) - 0.5) ** 2
    moving = 0.25 * (trial.vel(body) ** 2).sum(axis=1) + 0.5 * (trial.spin(body) * turn).sum(axis=1)
    total, w = stored + moving, np.sqrt(20.0 / (M / 4))
    agree(f"springs: energy of the {body} [J]", total, total[0], within=w * T * total[0])


def test_a_cord_pulls_only_while_it_is_stretched_and_only_in_its_span(trial, agree):
    x, v, pull = trial.pos("loose")[:, 0], trial.vel("loose")[:, 0], trial.measure("band")
    slack = x < 0.0199
    assert slack.any() and (x > 0.021).any()
    agree("springs: pull of a slack cord [N]", pull[slack], np.zeros(slack.sum()), within=1e-9)
    # It throws the mass back as fast as it came: to first order in the step.
    back = v[(trial.time > 1.0) & slack][0]
    agree("springs: speed after the throw [m/s]", back, -0.2, within=0.2 * W * T / 2)
    assert (pull[trial.time >= 5.0] == 0.0).all()


def test_no_energy_is_left_over_in_the_account(trial):
    """`change` is what neither bodies nor springs explain: less than w T / 2 of the energy that is exchanged."""
    from text2sim.evidence.diagnostics import energy_account

    account = energy_account(trial.recording)
    assert {"one", "two", "dashpot", "ends", "club", "band"} == set(account["works"]["controls"])
    exchanged = 0.5 * K * (0.05**2 + 0.1**2) + 0.5 * 80 * 0.1**2
    assert abs(account["change"]) < W * T / 2 * exchanged
