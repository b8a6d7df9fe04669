"""Built-in prefabs do what they are for: things stand, rings hold, a gripper lifts, a robot keeps its pose."""

import numpy as np
import pytest

POSE = {1: 0.0, 2: -0.4, 3: 0.0, 4: -2.2, 5: 0.0, 6: 1.8, 7: 0.785}
"""Joints of the robot [rad] in the posture `ready`."""
HOLD = "\n".join(f"    hold_{k}: {{kind: drive, joint: arm.panda_joint{k}, position: {q}}}" for k, q in POSE.items())
SCENE = f"""\
scene:
  duration: 1.6
  dt: 0.01
  substeps: 10
  contact: {{timeconst: 0.002}}
  statics:
    floor: {{shape: {{kind: plane}}}}
    table: {{use: table, place: {{on: floor, at: [0, 2]}}}}
    ramp: {{shape: {{kind: box, size: [3, 1, 0.1]}}, pose: {{pos: [0, 5, 1], euler_deg: [0, 10, 0]}}}}
bodies:
  plate: {{use: plate, place: {{on: table, at: [0, 1.8]}}}}
  fork: {{use: fork, place: {{on: table, at: [-0.2, 1.8], euler_deg: [0, 0, 90]}}}}
  knife: {{use: knife, place: {{on: table, at: [0.2, 1.8], euler_deg: [0, 0, 90]}}}}
  spoon: {{use: spoon, place: {{on: table, at: [0.25, 1.8], euler_deg: [0, 0, 90]}}}}
  cup: {{use: cup, place: {{on: table, at: [-0.3, 2]}}}}
  bottle: {{use: bottle, with: {{fill: 1}}, place: {{on: table, at: [0, 2.1]}}}}
  glass: {{use: wine_glass, place: {{on: table, at: [0.2, 2.1]}}}}
  chain: {{use: ring_chain, with: {{at: [0, 0, 1.2], rings: 5}}}}
  load:
    kind: rigid
    shape: {{kind: sphere, radius: 0.09}}
    material: {{mass: 25}}
    place: {{below: "chain_ring[4]", clearance: 0.002}}
  clamp: {{use: clamp, pose: {{pos: [1, 0, 0.06]}}}}
  block:
    kind: rigid
    shape: {{kind: box, size: [0.08, 0.08, 0.1]}}
    material: {{mass: 2, friction: 0.6}}
    place: {{on: floor, at: [1, 0]}}
  wheel: {{use: wheel, pose: {{pos: [2, 0, 0.5]}}}}
  roller: {{use: wheel, mount: {{kind: free}}, place: {{on: floor, at: [-2, -1], clearance: 0.001}}}}
  cart: {{use: cart, place: {{on: ramp, at: [-0.9, 5], euler_deg: [0, 10, 0]}}}}
  arm: {{use: robot_arm, pose: {{pos: [-1.5, 0, 0]}}}}
actions:
  controls:
    hang: {{kind: attach, body: load, to: "chain_ring[4]"}}
    close_left: {{kind: drive, joint: clamp.left, position: {{kind: ramp, to: 0.06, end: 0.3}}}}
    close_right: {{kind: drive, joint: clamp.right, position: {{kind: ramp, to: 0.06, end: 0.3}}}}
    raise: {{kind: drive, joint: clamp.lift, position: {{kind: ramp, to: 0.2, start: 0.4, end: 1}}}}
    turn: {{kind: drive, joint: wheel, velocity: 10}}
    roll: {{kind: initial_velocity, body: roller, linear: [1.5, 0, 0], angular: [0, 6, 0]}}
    finger_1: {{kind: drive, joint: arm.panda_finger_joint1, position: 0.04}}
    finger_2: {{kind: drive, joint: arm.panda_finger_joint2, position: 0.04}}
{HOLD}
"""


@pytest.fixture(scope="module")
def trial(simulate):
    """All of them in one scene."""
    return simulate(SCENE)


@pytest.mark.parametrize("name", ["plate", "fork", "knife", "spoon", "cup", "bottle", "glass"])
def test_what_is_laid_on_a_table_stays_there(trial, agree, name):
    start, late = trial.pos(name)[0], trial.pos(name)[trial.time > 0.3]
    agree(f"{name} sinks and creeps [m]", late, np.broadcast_to(start, late.shape), within=3e-4)
    agree(f"{name} stays upright", trial.turn(name)[-1][2, 2], 1.0, within=1e-5)


def test_rings_carry_a_load_by_contact_alone(trial, agree):
    load = trial.pos("load")[:, 2]
    # The gaps of five pairs of rings close, a millimetre each, and the contacts give a little.
    agree("height of the load [m]", load[-1], load[0] - 5 * 0.001, within=0.002)
    late = trial.time > 0.8
    agree("load at rest [m]", load[late], load[-1], within=1e-4)
    heights = [trial.pos("chain_anchor")[-1, 2], *(trial.pos(f"chain_ring[{k}]")[-1, 2] for k in range(5))]
    # Inner radii of neighbours meet: none has slipped out of the other.
    # Rings of 16 bars meet at their corners, where bars of 10 mm are 20.8 mm apart.
    agree("pitch of the rings [m]", -np.diff(heights), 0.1 - 0.0208, within=5e-4)


def test_a_clamp_lifts_what_it_holds(trial, agree):
    block = trial.pos("block")
    agree("height of the block [m]", block[-1, 2] - block[0, 2], 0.2, within=0.005)
    _, _, force = trial.joint("clamp.left")
    agree("grip [N]", force[-1], 60.0, within=1.0)


def test_wheels_turn_and_roll(trial, agree):
    _, speed, _ = trial.joint("wheel")
    agree("driven wheel [rad/s]", speed[-1], 10.0, within=0.1)
    rolled = trial.pos("roller")[-1] - trial.pos("roller")[0]
    agree("way of the rolling wheel [m]", rolled[0], 1.5 * trial.time[-1], within=0.03)
    agree("turn of the rolling wheel [rad/s]", trial.ang("roller")[-1, 1], 6.0, within=0.1)


def test_a_cart_rolls_down_a_slope(trial, agree):
    """A = g sin 10 deg / (1 + sum of I / r^2 over the mass); I / r^2 of a tyre, a cylinder, is half its mass."""
    bed, tyres = trial.pos("cart"), 4 * 500 * np.pi * 0.12**2 * 0.35 * 0.12
    floor, sides, ends = 0.8 * 0.4 * 0.03, 2 * 0.8 * 0.02 * 0.08, 2 * 0.02 * 0.36 * 0.08
    mass = tyres + 500 * (floor + sides + ends)
    rate = 9.81 * np.sin(np.radians(10)) / (1 + tyres / 2 / mass)
    at = trial.time <= 1.0
    gone = np.linalg.norm(bed[at] - bed[0], axis=1)
    agree("way of the cart [m]", gone[-1], rate * trial.time[at][-1] ** 2 / 2, within=0.01)


def test_a_robot_that_is_driven_to_where_it_is_stays_there(trial, agree):
    for k, target in POSE.items():
        angle, _, _ = trial.joint(f"arm.panda_joint{k}")
        # Its servos have no integral part: the weight bends them by its torque over their stiffness.
        agree(f"robot's joint {k} [rad]", angle, target, within=0.02)
