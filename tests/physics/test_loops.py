"""Mechanisms whose loop is closed by a constraint.

A loop is closed by the engine as a spring and damper with the time constant 2 h, so it opens by about the acceleration
of the closing point times h^2: second order.
"""

import numpy as np
import pytest

SLIDER = """
scene: {duration: 2.0, dt: "${dt}", substeps: 1, gravity: [0, 0, 0]}
bodies:
  engine:
    kind: articulated
    links:
      frame: {shape: {kind: box, size: [0.02, 0.02, 0.02]}}
      crank: {parent: frame, shape: {kind: compound, parts: {bar: {shape: {kind: box, size: ["${r}", 0.02, 0.02]}, pose: {pos: ["${r / 2}", 0, 0]}}}}, joint: {kind: hinge, axis: y, actuator: {damping: 20}}}
      rod: {parent: crank, pose: {pos: ["${r}", 0, 0]}, shape: {kind: compound, parts: {bar: {shape: {kind: box, size: ["${l}", 0.02, 0.02]}, pose: {pos: ["${l / 2}", 0, 0]}}}}, joint: {kind: hinge, axis: y}}
      piston: {parent: frame, pose: {pos: ["${r + l}", 0, 0]}, shape: {kind: box, size: [0.05, 0.05, 0.05]}, joint: {kind: slider, axis: x}}
    loops: {wrist: {kind: connect, between: [rod, piston], anchor: ["${l}", 0, 0]}}
actions: {controls: {motor: {kind: drive, joint: engine.crank, velocity: "${speed}"}}}
"""
FOUR_BAR = """
scene: {duration: 2.0, dt: "${dt}", substeps: 1, gravity: [0, 0, 0]}
bodies:
  bars:
    kind: articulated
    links:
      ground: {shape: {kind: box, size: [0.02, 0.02, 0.02]}}
      crank: {parent: ground, pose: {euler_deg: [0, "${-deg(0)}", 0]}, shape: {kind: compound, parts: {bar: {shape: {kind: box, size: [0.1, 0.02, 0.02]}, pose: {pos: [0.05, 0, 0]}}}}, joint: {kind: hinge, axis: y, actuator: {damping: 20}}}
      coupler: {parent: crank, pose: {pos: [0.1, 0, 0], euler_deg: [0, "${-deg(1)}", 0]}, shape: {kind: compound, parts: {bar: {shape: {kind: box, size: [0.4, 0.02, 0.02]}, pose: {pos: [0.2, 0, 0]}}}}, joint: {kind: hinge, axis: y}}
      rocker: {parent: ground, pose: {pos: [0.4, 0, 0], euler_deg: [0, "${-deg(2)}", 0]}, shape: {kind: compound, parts: {bar: {shape: {kind: box, size: [0.25, 0.02, 0.02]}, pose: {pos: [0.125, 0, 0]}}}}, joint: {kind: hinge, axis: y}}
    loops: {joint: {kind: connect, between: [coupler, rocker], anchor: [0.4, 0, 0]}}
actions: {controls: {motor: {kind: drive, joint: bars.crank, velocity: -6.283185307}}}
"""


def test_a_crank_slider_moves_its_piston_as_geometry_says(simulate, agree):
    """The piston is at x = r cos q + sqrt(l^2 - r^2 sin^2 q) (Norton, Design of Machinery, 4.11)."""
    r, rod, speed = 0.1, 0.3, 2 * np.pi
    gaps = []
    for dt in (0.01, 0.005, 0.0025):
        trial = simulate(SLIDER, dt=dt, r=r, l=rod, speed=speed)
        q, rate, _ = trial.joint("engine.crank")
        x = trial.pos("engine.piston")[:, 0]
        theory = r * np.cos(q) + np.sqrt(rod**2 - (r * np.sin(q)) ** 2)
        turning = trial.time > 0.5  # the motor starts with a jerk
        gaps.append(np.abs(x - theory)[turning].max())
        largest = r * speed**2 * (1 + r / rod)
        agree(f"crank-slider, dt {dt}: piston [m]", x[turning], theory[turning], within=2.5 * largest * dt**2)
        end = trial.pos("engine.rod") + 0.3 * trial.turn("engine.rod")[:, :, 0]
        agree(
            f"crank-slider, dt {dt}: gap of the loop [m]",
            np.linalg.norm(end - trial.pos("engine.piston"), axis=1)[turning],
            0.0,
            within=2.5 * largest * dt**2,
        )
        agree(
            f"crank-slider, dt {dt}: mean motor speed [rad/s]",
            (q[-1] - q[len(q) // 2]) / (trial.time[-1] - trial.time[len(q) // 2]),
            speed,
            within=1e-4,
        )
    agree("crank-slider: order of convergence", np.log2(gaps[0] / gaps[2]) / 2, 2.0, within=0.1)


def four_bar(q):
    """Angle of the rocker from Freudenstein's equation K1 cos p - K2 cos q + K3 = cos(q - p), open branch.

    Crank a, coupler b, rocker c, ground d; K1 = d / a, K2 = d / c, K3 = (a^2 - b^2 + c^2 + d^2) / (2 a c) (Freudenstein
    1954; Norton, Design of Machinery, 4.5): A tan^2(p / 2) + B tan(p / 2) + C = 0.
    """
    a, b, c, d = 0.1, 0.4, 0.25, 0.4
    k1, k2, k3 = d / a, d / c, (a**2 - b**2 + c**2 + d**2) / (2 * a * c)
    big_a = np.cos(q) - k1 - k2 * np.cos(q) + k3
    big_b, big_c = -2 * np.sin(q), k1 - (k2 + 1) * np.cos(q) + k3
    return 2 * np.arctan2(-big_b - np.sqrt(big_b**2 - 4 * big_a * big_c), 2 * big_a)


def test_a_four_bar_linkage_obeys_freudensteins_equation(simulate, agree):
    """The rocker's angle for every angle of the crank over two turns, from the links' poses; and its whole swing."""
    start = np.pi / 3
    rocker = four_bar(start)
    pin, far = (
        0.1 * np.array([np.cos(start), np.sin(start)]),
        np.array([0.4, 0]) + 0.25 * np.array([np.cos(rocker), np.sin(rocker)]),
    )
    coupler = np.arctan2(*(far - pin)[::-1])
    angles = np.degrees([start, coupler - start, rocker])
    text = FOUR_BAR
    for k in range(3):
        text = text.replace(f"-deg({k})", f"{-angles[k]:.9f}")
    gaps = []
    for dt in (0.01, 0.005, 0.0025):
        trial = simulate(text, dt=dt)

        def angle(link, trial=trial):
            axis = trial.turn(f"bars.{link}")[:, :, 0]
            return np.arctan2(axis[:, 2], axis[:, 0])

        turning = trial.time > 0.5
        theory = four_bar(angle("crank"))
        error = np.angle(np.exp(1j * (angle("rocker") - theory)))[turning]
        gaps.append(np.abs(error).max())
        reach = 0.1 * (2 * np.pi) ** 2 * 2 / 0.25
        agree(f"four-bar, dt {dt}: rocker against Freudenstein [rad]", error, 0.0, within=2 * reach * dt**2)
        swing = np.ptp(np.unwrap(angle("rocker"))[turning])
        full = np.ptp(np.unwrap(four_bar(np.linspace(0, 2 * np.pi, 2001))))
        agree(f"four-bar, dt {dt}: swing of the rocker [rad]", swing, full, within=4 * reach * dt**2)
    agree("four-bar: order of convergence", np.log2(gaps[0] / gaps[2]) / 2, 2.0, within=0.1)


@pytest.mark.parametrize("substeps", [1, 4])
def test_a_weld_loop_carries_a_load(simulate, agree, substeps):
    """A bar welded to the world at its far end sags by the give of the constraint: (1 - d) / d (dmax timeconst)^2 g."""
    trial = simulate(
        """
scene: {duration: 1.5, dt: 0.01, substeps: "${substeps}"}
bodies:
  shelf:
    kind: articulated
    links:
      post: {shape: {kind: box, size: [0.02, 0.02, 0.02]}}
      board: {parent: post, shape: {kind: compound, parts: {board: {shape: {kind: box, size: [0.5, 0.2, 0.02]}, pose: {pos: [0.25, 0, 0]}}}}, joint: {kind: hinge, axis: y}}
    loops: {screw: {kind: connect, between: [board, world], anchor: [0.5, 0, 0]}}
""",
        substeps=substeps,
    )
    tip = trial.pos("shelf.board") + 0.5 * trial.turn("shelf.board")[:, :, 0]
    give = (1 - 0.9) / 0.9 * (0.95 * 2 * 0.01 / substeps) ** 2 * 9.81
    agree(f"shelf on a loop to the world, {substeps} substeps: sag [m]", tip[-1, 2], 0.0, within=give)
    agree(
        f"shelf on a loop to the world, {substeps} substeps: speed [m/s]",
        trial.vel("shelf.board")[-1],
        0.0,
        within=1e-4,
    )


RACK = """
scene: {duration: 0.6, dt: "${dt}", substeps: 1}
bodies:
  clock:
    kind: articulated
    pose: {pos: [0, 0, 3]}
    material: {density: 1000}
    links:
      frame: {shape: {kind: box, size: [0.02, 0.02, 0.02]}}
      rack: {parent: frame, shape: {kind: box, size: [0.05, 0.05, 0.2]}, joint: {kind: slider, axis: z}}
      pinion: {parent: frame, pose: {pos: [0.3, 0, 0], euler_deg: [90, 0, 0]}, shape: {kind: cylinder, radius: 0.1, height: 0.05}, joint: {kind: hinge, axis: z}}
      flywheel: {parent: frame, pose: {pos: [0.6, 0, 0], euler_deg: [90, 0, 0]}, shape: {kind: cylinder, radius: 0.15, height: 0.02}, joint: {kind: hinge, axis: z}}
    loops:
      teeth: {kind: gear, between: [pinion, rack], ratio: "${1 / r}"}
      wheels: {kind: gear, between: [flywheel, pinion], ratio: "${step}"}
"""


@pytest.mark.parametrize("ratio", [-2.0, 0.5])
def test_a_falling_rack_turns_geared_wheels(simulate, agree, ratio):
    """With q = z / r of the pinion and n q of the flywheel, Lagrange gives z'' = -m g / (m + (I1 + n^2 I2) / r^2).

    The gears are springs and dampers with the time constant 2 h, of which the motion is late by at most a few steps.
    """
    r, dt = 0.08, 0.002
    trial = simulate(RACK, dt=dt, r=r, step=ratio)
    z, pinion, flywheel = (trial.joint(f"clock.{name}")[0] for name in ("rack", "pinion", "flywheel"))
    mass = 1000 * 0.05 * 0.05 * 0.2
    wheels = [1000 * np.pi * radius**4 * height / 2 for radius, height in ((0.1, 0.05), (0.15, 0.02))]
    pull = mass * 9.81 / (mass + (wheels[0] + ratio**2 * wheels[1]) / r**2)
    fallen = pull * trial.time**2 / 2
    agree(f"rack, n {ratio}: fall [m]", -z, fallen, within=3 * dt * pull * trial.time[-1])
    agree(f"rack, n {ratio}: pinion [rad]", pinion, z / r, within=3 * pull / r * (2 * dt) ** 2)
    agree(
        f"rack, n {ratio}: flywheel [rad]", flywheel, ratio * pinion, within=3 * abs(ratio) * pull / r * (2 * dt) ** 2
    )


def test_a_light_pinion_holds_a_heavy_rack(simulate, agree):
    """The teeth give way by (1 - d) timeconst^2 (1 / I + n^2 / m) of the torque m g r, where 1 - d = 1e-4."""
    r, dt, mass, light = 0.05, 0.005, 20.0, 0.05
    trial = simulate(
        """
scene: {duration: 1.5, dt: "${dt}", substeps: 1}
bodies:
  hoist:
    kind: articulated
    links:
      frame: {shape: {kind: box, size: [0.02, 0.02, 0.02]}}
      pinion:
        parent: frame
        pose: {pos: [0.3, 0, 0], euler_deg: [90, 0, 0]}
        shape: {kind: cylinder, radius: "${r}", height: 0.02}
        material: {mass: "${light}"}
        joint: {kind: hinge, axis: z, armature: 0, actuator: {stiffness: 2000, damping: 40}}
      rack: {parent: frame, shape: {kind: box, size: [0.1, 0.1, 0.4]}, material: {mass: "${mass}"}, joint: {kind: slider, axis: z}}
    loops: {teeth: {kind: gear, between: [pinion, rack], ratio: "${1 / r}"}}
actions: {controls: {hold: {kind: drive, joint: hoist.pinion, position: 0}}}
""",
        r=r,
        dt=dt,
        mass=mass,
        light=light,
    )
    pinion, rack = (trial.joint(f"hoist.{name}")[0][-1] for name in ("pinion", "rack"))
    torque = mass * 9.81 * r
    agree("hoist: sag of the motor [rad]", pinion, -torque / 2000, within=2e-5)
    give = 1e-4 * (2 * dt) ** 2 * (2 / (light * r**2) + 1 / (r**2 * mass)) * torque
    agree("hoist: give of the teeth [rad]", rack / r, pinion, within=1.1 * give)


GATE = """\
<robot name="gate">
  <link name="post"><collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link>
  <link name="arm">
    <inertial><origin xyz="0.15 0 0"/><mass value="0.3"/>
      <inertia ixx="1e-4" iyy="0.0023" izz="0.0023" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.15 0 0"/><geometry><box size="0.2 0.02 0.03"/></geometry></collision>
  </link>
  <link name="tip">
    <inertial><origin xyz="0.05 0 0"/><mass value="0.05"/>
      <inertia ixx="1e-5" iyy="5e-5" izz="5e-5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.05 0 0"/><geometry><box size="0.06 0.02 0.02"/></geometry></collision>
  </link>
  <joint name="swing" type="revolute">
    <parent link="post"/><child link="arm"/><origin xyz="0 0 0.18"/><axis xyz="0 -1 0"/>
    <limit lower="-0.5" upper="1.4" effort="5" velocity="2"/>
  </joint>
  <joint name="fold" type="revolute">
    <parent link="arm"/><child link="tip"/><origin xyz="0.3 0 0"/><axis xyz="0 -1 0"/>
    <limit lower="-1.4" upper="0.5" effort="2" velocity="2"/>
    <mimic joint="swing" multiplier="-0.5" offset="0"/>
  </joint>
</robot>
"""
JAWS = """\
<mujoco>
  <worldbody>
    <body name="left">
      <joint name="left" type="slide" axis="0 1 0" damping="2"/>
      <geom type="box" size="0.02 0.02 0.02" pos="0 0.1 0"/>
    </body>
    <body name="right">
      <joint name="right" type="slide" axis="0 -1 0" damping="2"/>
      <geom type="box" size="0.02 0.02 0.02" pos="0 -0.1 0"/>
    </body>
  </worldbody>
  <equality><joint joint1="left" joint2="right" polycoef="0 1 0 0 0"/></equality>
  <actuator><position joint="left" kp="200" kv="10" forcerange="-3 3"/></actuator>
</mujoco>
"""


def test_couplings_of_files_and_loops_share_a_scene(simulate, agree):
    """A `mimic` follows by its factor, coupled jaws open alike, a loop stays closed; limits of motors are recorded."""
    trial = simulate(
        """
scene: {duration: 1.0, dt: 0.005}
bodies:
  pair:
    kind: articulated
    pose: {pos: [0, 0, 2]}
    links:
      base: {shape: {kind: box, size: [0.02, 0.02, 0.02]}}
      a: {parent: base, pose: {pos: [0, 0, -0.3]}, shape: {kind: box, size: [0.02, 0.02, 0.2]}, joint: {kind: hinge, axis: y, anchor: [0, 0, 0.1], actuator: {stiffness: 50, damping: 5, max_force: 4}}}
      b: {parent: base, pose: {pos: [0.05, 0, -0.3]}, shape: {kind: box, size: [0.02, 0.02, 0.2]}, joint: {kind: hinge, axis: y, anchor: [0, 0, 0.1], actuator: {damping: 0.1}}}
    loops: {pin: {between: [a, b], anchor: [0, 0, -0.1]}}
  gate: {kind: articulated, file: gate.urdf, pose: {pos: [1, 0, 1]}, joints: {swing: {actuator: {stiffness: 60, damping: 6}}}}
  jaws: {kind: articulated, file: jaws.xml, pose: {pos: [2, 0, 1]}}
actions:
  controls:
    open: {kind: drive, joint: gate.swing, position: {kind: ramp, to: 0.8, end: 0.6}}
    part: {kind: drive, joint: jaws.left, position: {kind: ramp, to: 0.05, end: 0.6}}
""",
        {"gate.urdf": GATE, "jaws.xml": JAWS},
    )
    swing, fold = trial.joint("gate.swing")[0], trial.joint("gate.fold")[0]
    assert swing[-1] > 0.75
    agree("mimic joint: follows its factor [rad]", fold, -0.5 * swing, within=0.01)
    left, right = trial.joint("jaws.left")[0], trial.joint("jaws.right")[0]
    assert left[-1] > 0.045
    agree("coupled jaws: open alike [m]", right, left, within=1e-3)
    ends = [
        trial.pos(f"pair.{name}") + trial.turn(f"pair.{name}") @ (x, 0, -0.1) for name, x in (("a", 0), ("b", -0.05))
    ]
    agree("loop beside a mimic: gap [m]", np.linalg.norm(ends[1] - ends[0], axis=1), 0.0, within=1e-4)
    joints = {(j.body, j.name): j for j in trial.states.joints}
    limits = [joints[name].max_force for name in (("pair", "a"), ("pair", "b"), ("gate", "swing"), ("jaws", "left"))]
    assert limits == [4.0, None, 5.0, 3.0]
    pin = joints["gate", "fold"]
    agree("recorded axis", pin.axis, (0, -1, 0), within=1e-6)
    agree("recorded anchor [m]", pin.anchor, (1.3, 0, 1.18), within=1e-6)
