"""Forces, torques and blows on free bodies, in space.

Each acts for whole steps: a force F over n steps gives the momentum F n dt exactly, whatever the substeps; what is left
is float32. Turning is exact to second order, (w h)^2, in one step.
"""

import numpy as np
import pytest

BODIES = """
scene: {duration: 0.5, dt: "${dt}", substeps: 2, gravity: [0, 0, 0]}
bodies:
  hammer:
    kind: rigid
    shape:
      kind: compound
      parts:
        head: {shape: {kind: box, size: [0.22, 0.15, 0.05]}, pose: {pos: [0.02, 0.01, 0.3], euler_deg: [10, 20, 30]}, density: 2000}
        handle: {shape: {kind: cylinder, radius: 0.04, height: 0.55}}
    pose: {pos: [1, 2, 3], euler_deg: [30, 50, 70]}
    repeat: {kind: line, count: 10, step: [0, 3, 0]}
  box:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.2, 0.3]}
    pose: {pos: [-5, 2, 3], euler_deg: [30, 50, 70]}
    repeat: {kind: line, count: 10, step: [0, 3, 0]}
actions:
  controls:
"""
CONTROLS = """
    blow_{0}: {{kind: impulse, body: "{0}[0]", impulse: [1, 2, 3], at: 0.1}}
    off_{0}: {{kind: impulse, body: "{0}[1]", impulse: [0.01, 0.02, 0.03], at: 0.1, point: [0.1, 0.2, -0.1]}}
    own_{0}: {{kind: force, body: "{0}[2]", force: [1, 2, 3], during: [0.1, 0.2], frame: body}}
    world_{0}: {{kind: force, body: "{0}[3]", force: [1, 2, 3], during: [0.1, 0.2]}}
    turn_{0}: {{kind: torque, body: "{0}[4]", torque: [0.02, 0.04, 0.06], during: [0.1, 0.2]}}
    turn_own_{0}: {{kind: torque, body: "{0}[5]", torque: [0.02, 0.04, 0.06], during: [0.1, 0.11], frame: body}}
    grow_{0}: {{kind: force, body: "{0}[6]", force: [1, 2, 3], scale: {{kind: ramp, from: 0, to: 2, start: 0.1, end: 0.3, ease: linear}}, during: [0.1, 0.3]}}
    steady_{0}: {{kind: force, body: "{0}[7]", force: [1, 0, 0], frame: body}}
    lever_{0}: {{kind: force, body: "{0}[8]", force: [0.2, 0.4, 0.6], during: [0.1, 0.2], point: [0.1, 0.2, -0.1]}}
    corner_{0}: {{kind: force, body: "{0}[9]", force: [0.2, 0.4, 0.6], during: [0.1, 0.2], frame: body, point: {1}}}
    spin_{0}: {{kind: initial_velocity, body: "{0}[7]", angular: [0, 0, 3]}}
"""
CORNERS = {
    "hammer": ("{face: bottom}", (0.0, 0.0, -0.275)),
    "box": ("{corner: [right, front, top]}", (0.05, -0.1, 0.15)),
}
"""Region of each body, and its middle."""
J, DT = np.array([1.0, 2.0, 3.0]), 0.01
ROUNDING = 2**-24 * 100


@pytest.fixture(scope="module")
def trial(simulate):
    controls = (CONTROLS.format(body, region) for body, (region, _) in CORNERS.items())
    return simulate(BODIES + "".join(controls), dt=DT)


def momentum(trial, body):
    return trial.link(body).mass * trial.vel(body)


@pytest.mark.parametrize("body", ["hammer", "box"])
def test_a_blow_through_the_centre_gives_its_momentum_and_no_spin(trial, agree, body):
    """It gives m dv = J (Newton II), at the step that begins at the blow's time, and for that step only."""
    p = momentum(trial, f"{body}[0]")
    agree(f"blow on the {body}: momentum before [N s]", p[:11], 0.0, within=0)
    agree(f"blow on the {body}: momentum after [N s]", p[11:], J, within=3 * ROUNDING)
    agree(f"blow on the {body}: spin [rad/s]", trial.ang(f"{body}[0]"), 0.0, within=2e-4)


@pytest.mark.parametrize("body", ["hammer", "box"])
def test_a_blow_beside_the_centre_gives_spin_too(trial, agree, body):
    """It gives dL = r x J about the centre of mass, with the point given in the body's frame (not in that of its principal axes)."""
    name = f"{body}[1]"
    lever = trial.turn(name)[10] @ (np.array([0.1, 0.2, -0.1]) - trial.link(name).com)
    agree(f"blow beside the centre of the {body}: momentum [N s]", momentum(trial, name)[-1], 0.01 * J, within=ROUNDING)
    spin, theory = trial.spin(name)[11], np.cross(lever, 0.01 * J)
    turn = np.linalg.norm(trial.ang(name)[11]) * DT
    agree(
        f"blow beside the centre of the {body}: angular momentum [N m s]",
        spin,
        theory,
        within=turn * np.linalg.norm(theory),
    )


@pytest.mark.parametrize("body", ["hammer", "box"])
def test_a_force_gives_momentum_in_the_frame_that_it_is_given_in(trial, agree, body):
    """It gives m v = F t in the world, R F t in a body that does not turn, and the integral of R(t) F in one that does."""
    turned = trial.turn(f"{body}[2]")[10] @ J
    agree(
        f"force in the frame of the {body}: momentum [N s]",
        momentum(trial, f"{body}[2]")[-1],
        0.1 * turned,
        within=ROUNDING,
    )
    agree(f"force on the {body}: momentum [N s]", momentum(trial, f"{body}[3]")[20:], 0.1 * J, within=ROUNDING)
    agree(f"force on the {body}: no spin [rad/s]", trial.ang(f"{body}[3]"), 0.0, within=1e-4)
    ways = trial.turn(f"{body}[7]")[:, :, 0]
    theory = np.concatenate([np.zeros((1, 3)), np.cumsum(ways, axis=0)[:-1]]) * DT
    agree(
        f"force that turns with the {body}: momentum [N s]", momentum(trial, f"{body}[7]"), theory, within=2 * ROUNDING
    )


@pytest.mark.parametrize("body", ["hammer", "box"])
def test_a_force_at_a_point_turns_the_body_too(trial, agree, body):
    """It gives m dv = F t and dL = sum r(t_k) x F dt, where r goes from the centre of mass to the point, and turns with it."""
    force = 0.2 * J
    for k, point in ((8, (0.1, 0.2, -0.1)), (9, CORNERS[body][1])):
        name = f"{body}[{k}]"
        turns = trial.turn(name)[10:20]
        forces = turns @ force if k == 9 else np.tile(force, (10, 1))
        levers = turns @ (np.array(point) - trial.link(name).com)
        agree(
            f"force at {point} of the {body}: momentum [N s]",
            momentum(trial, name)[-1],
            forces.sum(0) * DT,
            within=ROUNDING,
        )
        spin = np.cross(levers, forces).sum(0) * DT
        turn = np.linalg.norm(trial.ang(name), axis=1).max() * DT
        agree(
            f"force at {point} of the {body}: angular momentum [N m s]",
            trial.spin(name)[-1],
            spin,
            within=turn * np.linalg.norm(spin),
        )
        assert np.linalg.norm(spin) > 1e-3


@pytest.mark.parametrize("body", ["hammer", "box"])
def test_a_growing_force_is_taken_at_the_start_of_each_step(trial, agree, body):
    """The sum of scale(t_k) F dt: the left Riemann sum of the integral, F dt (half a step) short of it."""
    scale = 2 * np.arange(20) * DT / 0.2
    agree(
        f"growing force on the {body}: momentum [N s]",
        momentum(trial, f"{body}[6]")[-1],
        scale.sum() * DT * J,
        within=ROUNDING,
    )


@pytest.mark.parametrize("body", ["hammer", "box"])
def test_a_torque_gives_angular_momentum_and_nothing_else(trial, agree, body):
    """It gives dL = M t in the world, R M t in the body's frame; the centre of mass stays."""
    moment = np.array([0.02, 0.04, 0.06])
    size = np.linalg.norm(moment)
    for k, turn, span in ((4, np.eye(3), 0.1), (5, trial.turn(f"{body}[5]")[10], 0.01)):
        step = np.linalg.norm(trial.ang(f"{body}[{k}]"), axis=1).max() * DT
        agree(
            f"torque on the {body}, {'body' if k == 5 else 'world'} frame: angular momentum [N m s]",
            trial.spin(f"{body}[{k}]")[-1],
            turn @ moment * span,
            within=step * span * size,
        )
        agree(f"torque on the {body}: velocity of its centre [m/s]", trial.vel(f"{body}[{k}]"), 0.0, within=1e-6)


def test_a_force_on_one_link_moves_the_centre_of_the_whole(simulate, agree):
    """The momentum of a free tree is F t, through joints and all; to first order in h where joints turn (test_pendulums)."""
    gaps = []
    for dt in (0.004, 0.002):
        trial = simulate(
            """
scene: {duration: 0.4, dt: "${dt}", substeps: 1, gravity: [0, 0, 0], record: {rate: 250}}
bodies:
  arm:
    kind: articulated
    base: free
    pose: {euler_deg: [20, 30, 40]}
    links:
      trunk: {shape: {kind: box, size: [0.2, 0.3, 0.5]}, material: {mass: 2}}
      upper: {parent: trunk, pose: {pos: [0, 0.2, 0.2]}, shape: {kind: capsule, radius: 0.04, length: 0.3}, material: {mass: 1}, joint: {kind: ball, anchor: [0, 0, 0.15]}}
      lower: {parent: upper, pose: {pos: [0, 0, -0.3]}, shape: {kind: capsule, radius: 0.03, length: 0.3}, material: {mass: 0.5}, joint: {kind: hinge, axis: x, anchor: [0, 0, 0.15]}}
actions:
  controls: {pull: {kind: force, body: arm.lower, force: [1, 2, 3]}}
  measures: {px: {kind: momentum, of: arm, axis: x}, py: {kind: momentum, of: arm, axis: y}, pz: {kind: momentum, of: arm, axis: z}}
""",
            dt=dt,
        )
        p, theory = np.stack([trial.measure(f"p{axis}") for axis in "xyz"], axis=1), np.outer(trial.time, J)
        gaps.append(np.abs(p - theory).max())
        fastest = np.abs(trial.states.dofs_velocity).max()
        agree(
            f"pulled arm, dt {dt}: momentum of the whole [N s]",
            p,
            theory,
            within=fastest * dt * np.linalg.norm(theory[-1]),
        )
    agree("pulled arm: order of convergence", np.log2(gaps[0] / gaps[1]), 1.0, within=0.2)
