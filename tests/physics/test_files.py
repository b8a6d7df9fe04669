"""Bodies from files move as their files say: masses, motors, joints, and meshes that are not convex."""

import numpy as np
import pytest

G = 9.81

BRACKET = """\
v 0 0 0
v 0.2 0 0
v 0.2 0.04 0
v 0.04 0.04 0
v 0.04 0.2 0
v 0 0.2 0
v 0 0 0.06
v 0.2 0 0.06
v 0.2 0.04 0.06
v 0.04 0.04 0.06
v 0.04 0.2 0.06
v 0 0.2 0.06
f 1 3 2
f 1 4 3
f 1 6 4
f 4 6 5
f 7 8 9
f 7 9 10
f 7 10 12
f 10 11 12
f 1 2 8
f 1 8 7
f 2 3 9
f 2 9 8
f 3 4 10
f 3 10 9
f 4 5 11
f 4 11 10
f 5 6 12
f 5 12 11
f 6 1 7
f 6 7 12
"""
"""An L: a bar of 0.2 m x 0.04 m along x, another along y, 0.06 m thick."""

ARM = """\
<robot name="arm">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="upper">
    <inertial><origin xyz="0.3 0 0"/><mass value="2"/>
      <inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.3 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision>
  </link>
  <link name="hand"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="60" velocity="9"/>
  </joint>
  <joint name="wrist" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="0.6 0 0"/></joint>
</robot>
"""

PENDULUM = """\
<mujoco>
  <worldbody>
    <body name="rod">
      <joint name="pin" type="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <actuator><position joint="pin" kp="40" kv="4"/></actuator>
</mujoco>
"""

CASE = """
scene: {duration: 1.5, dt: 0.002, statics: {floor: {shape: {kind: plane}}}}
bodies:
  arm:
    kind: articulated
    file: arm.urdf
    pose: {pos: [0, 2, 1]}
    initial: {shoulder: -0.5}
    joints: {shoulder: {actuator: {stiffness: 400, damping: 40}}}
  slack: {kind: articulated, file: arm.urdf, pose: {pos: [0, 4, 1]}, initial: {shoulder: -0.5}}
  stuck:
    kind: articulated
    file: arm.urdf
    pose: {pos: [0, 6, 1]}
    joints: {shoulder: {friction: 7}}
  held: {kind: articulated, file: pendulum.xml, pose: {pos: [0, 8, 1]}}
  slow:
    kind: articulated
    file: pendulum.xml
    pose: {pos: [0, 10, 1]}
    joints: {pin: {armature: 0.5, actuator: {}}}
  hull: {kind: rigid, shape: {kind: mesh, file: bracket.obj}, mount: {kind: fixed}, pose: {pos: [3, 0, 0]}}
  pieces:
    kind: rigid
    shape: {kind: mesh, file: bracket.obj, collision: decompose}
    mount: {kind: hinge, axis: x, anchor: [0, 0.1, 0.03]}
    pose: {pos: [4, 0, 0.5], euler_deg: [0, 90, 0]}
  corner:
    kind: rigid
    shape: {kind: mesh, file: bracket.obj, collision: decompose}
    mount: {kind: fixed}
    pose: {pos: [5, 0, 0]}
  loose: {kind: rigid, shape: {kind: mesh, file: bracket.obj}, material: {mass: 2}, pose: {pos: [6, 0, 0.5]}}
  on_hull: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [3.075, 0.075, 0.2]}}
  in_corner: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [5.075, 0.075, 0.2]}}
actions:
  controls:
    lift: {kind: drive, joint: arm.shoulder, position: -0.5}
    hold: {kind: drive, joint: held.pin, position: 0.3}
  measures:
    reach: {kind: position, of: arm.hand, axis: z}
"""


@pytest.fixture(scope="module")
def trial(simulate):
    """All of it in one scene, out of each other's way."""
    return simulate(CASE, {"arm.urdf": ARM, "pendulum.xml": PENDULUM, "bracket.obj": BRACKET})


def test_a_servo_on_a_urdf_joint_settles_where_gravity_balances_it(trial, agree):
    """Kp (target - q) = -m g l cos q, to first order in the small sag."""
    q = trial.joint("arm.shoulder")[0]
    agree("start", q[0], -0.5, within=1e-6)
    sag = 2 * G * 0.3 * np.cos(0.5) / 400
    agree("sag [rad]", q[-1] + 0.5, sag, within=1e-4)
    agree("hand [m]", trial.measure("reach")[-1], 1 + 0.6 * np.sin(0.5 - sag), within=1e-4)


def test_a_urdf_joint_without_an_actuator_swings_freely(trial, agree):
    """Energy of the start pose is kinetic at the bottom; a servo of the engine's would show."""
    q, rate, force = trial.joint("slack.shoulder")
    down = int(np.argmax(q > np.pi / 2))
    fallen = 2 * G * 0.3 * (np.sin(q[down]) + np.sin(0.5))
    agree("rate at the bottom [rad/s]", rate[down], np.sqrt(2 * fallen / (0.05 + 2 * 0.3**2)), within=0.02)
    agree("force of motors [N m]", force, 0.0, within=0.0)


def test_dry_friction_of_the_case_holds_what_it_can(trial, agree):
    """7 N m are more than m g l = 5.9 N m."""
    speed = 2 * G * 0.3 / (0.05 + 2 * 0.3**2) * 1e-4 * 0.004 / 2  # of a constraint with an impedance of 0.9999
    agree("creep [rad]", trial.joint("stuck.shoulder")[0], 0.0, within=1.5 * speed * 1.5)


def test_the_motor_of_an_mjcf_file_is_its_own(trial, agree):
    q, _, force = trial.joint("held.pin")
    mass = trial.link("held.rod").mass
    agree("mass [kg]", mass, 1000 * np.pi * 0.02**2 * (0.4 + 4 / 3 * 0.02), within=1e-6)
    torque = -mass * G * 0.2 * np.cos(q[-1])
    agree("torque [N m]", force[-1], torque, within=2e-3)
    agree("sag [rad]", q[-1] - 0.3, -torque / 40, within=2e-4)


def test_armature_of_the_case_slows_a_joint_of_a_file(trial, agree):
    """The first moments of the fall: q'' = m g l / (I + armature)."""
    q = trial.joint("slow.pin")[0]
    link = trial.link("slow.rod")
    inertia = np.array(link.inertia)[1, 1] + link.mass * 0.2**2 + 0.5
    early = trial.time < 0.2
    agree("fall [rad]", q[early], link.mass * G * 0.2 / inertia * trial.time[early] ** 2 / 2, within=2e-3)


def test_a_mesh_has_the_mass_and_centre_of_its_solid(trial, agree):
    """Two bars that share a corner; the hull would weigh twice as much."""
    bars = np.array([[0.2 * 0.04, 0.1, 0.02], [0.04 * 0.16, 0.02, 0.12]])
    center = bars[:, 0] @ bars[:, 1:] / bars[:, 0].sum()
    for name, mass in (("loose", 2.0), ("pieces", 1000 * 0.06 * bars[:, 0].sum())):
        agree(f"mass of {name} [kg]", trial.link(name).mass, mass, within=1e-5)
        agree(f"centre of {name} [m]", trial.link(name).com, [*center, 0.03], within=1e-6)
    agree("loose rests [m]", trial.pos("loose")[-1, 2], 0.0, within=1e-3)


def test_a_ball_stays_on_a_hull_and_falls_into_a_corner(trial, agree):
    agree("ball in the corner [m]", trial.pos("in_corner")[-1], [5.075, 0.075, 0.02], within=2e-3)
    assert trial.pos("on_hull")[-1, 2] > 0.07
    assert np.isfinite(trial.pos("pieces")).all()
