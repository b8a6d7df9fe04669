"""Frames: what a tree of links looks like when its joints are moved, by the engine and by multiplying transforms."""

import numpy as np
from scipy.spatial.transform import Rotation

CASE = """
scene: {duration: 0.02, dt: 0.01, gravity: [0, 0, 0]}
bodies:
  arm:
    kind: articulated
    pose: {pos: [1, 2, 3], euler_deg: [10, 20, 30]}
    links:
      base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.1, 0, 0.2], euler_deg: [40, 50, 60]}}
      turn: {parent: base, pose: {pos: [0.3, 0.1, 0.2], euler_deg: [15, 25, 35]}, shape: {kind: box, size: [0.3, 0.1, 0.1]}, joint: {kind: hinge, axis: [1, 2, -2], anchor: [0.1, -0.2, 0.05]}}
      slide: {parent: turn, pose: {pos: [0.4, 0, 0], euler_deg: [0, 0, 70]}, shape: {kind: sphere, radius: 0.05}, joint: {kind: slider, axis: [3, 0, 4]}}
      glued: {parent: slide, pose: {pos: [0, 0.2, 0], euler_deg: [90, 0, 0]}, shape: {kind: cone, radius: 0.05, height: 0.1}, joint: {kind: fixed}}
      end: {parent: glued, pose: {pos: [0, 0, 0.2]}, shape: {kind: sphere, radius: 0.05}, joint: {kind: hinge, axis: z, anchor: [0, 0.1, 0]}}
    initial: {turn: 0.7, slide: -0.15, end: -1.1}
actions: {measures: {turn: {kind: joint_position, of: arm.turn}, slide: {kind: joint_position, of: arm.slide}}}
"""


def pose(pos=(0, 0, 0), euler_deg=(0, 0, 0)):
    """Homogeneous matrix of a pose of the language: turns about the fixed x, then y, then z axis."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xyz", euler_deg, degrees=True).as_matrix()
    matrix[:3, 3] = pos
    return matrix


def hinge(axis, anchor, angle):
    """Turn by an angle [rad] about an axis through an anchor, in the link's frame; right-handed."""
    turn = pose()
    turn[:3, :3] = Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis)).as_matrix()
    return pose(anchor) @ turn @ pose(-np.array(anchor))


def test_links_are_where_their_joints_put_them(simulate, agree):
    """T = T_parent T_pose T_joint(q) (Craig, Introduction to Robotics, 3), with q = 0 in the described pose."""
    trial = simulate(CASE)
    base = pose((1, 2, 3), (10, 20, 30)) @ pose((0.1, 0, 0.2), (40, 50, 60))
    turn = base @ pose((0.3, 0.1, 0.2), (15, 25, 35)) @ hinge((1, 2, -2), (0.1, -0.2, 0.05), 0.7)
    slide = turn @ pose((0.4, 0, 0), (0, 0, 70)) @ pose(-0.15 * np.array([3, 0, 4]) / 5)
    glued = slide @ pose((0, 0.2, 0), (90, 0, 0))
    end = glued @ pose((0, 0, 0.2)) @ hinge((0, 0, 1), (0, 0.1, 0), -1.1)
    for name, theory in (("base", base), ("turn", turn), ("slide", slide), ("glued", glued), ("end", end)):
        agree(f"arm, link {name}: position [m]", trial.pos(f"arm.{name}")[0], theory[:3, 3], within=2e-6)
        agree(f"arm, link {name}: rotation matrix", trial.turn(f"arm.{name}")[0], theory[:3, :3], within=2e-6)
    agree("arm: measured angle [rad]", trial.measure("turn"), 0.7, within=1e-6)
    agree("arm: measured travel [m]", trial.measure("slide"), -0.15, within=1e-6)
    agree("arm: it rests without gravity [m/s]", trial.states.vel, 0.0, within=1e-6)
