"""Drives and what joints do by themselves.

Stiffness, damping and the servo's gains enter the velocity step implicitly, so a steady state is exact and a velocity
under viscous damping is v' = (v + h F / m) / (1 + h c / m).
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from text2sim.spec_schema.published.reference_prose import MOTIONS

G = 9.81

LIFTS = """
scene: {duration: 2.0, dt: 0.005, substeps: 1}
bodies:
  lift:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    material: {mass: 2.0}
    mount: {kind: slider, axis: z, actuator: {stiffness: "${kp[i]}", damping: "${kv[i]}", max_force: 500}}
    pose: {pos: ["${i}", 0, 1]}
    repeat: {kind: line, count: 4, step: [0, 0, 0]}
actions:
  controls:
    hold: {kind: drive, joint: "lift[0]", position: 0.1}
    hold_stiffly: {kind: drive, joint: "lift[1]", position: 0.1}
    rise: {kind: drive, joint: "lift[2]", velocity: 0.3}
    rise_strongly: {kind: drive, joint: "lift[3]", velocity: 0.3}
  measures:
    force: {kind: joint_force, of: "lift[0]"}
    height: {kind: joint_position, of: "lift[0]"}
    speed: {kind: joint_velocity, of: "lift[2]"}
"""


@pytest.fixture(scope="module")
def lifts(simulate):
    return simulate(LIFTS, kp=[400, 4000, 0, 0], kv=[80, 300, 100, 1000])


def test_a_position_drive_sags_under_its_load_by_force_over_stiffness(lifts, agree):
    """At rest kp (q* - q) = m g: no secret gravity compensation, no integral part."""
    for k, kp in enumerate([400, 4000]):
        position, _, force = lifts.joint(f"lift[{k}]")
        # What is left of the start dies away as exp(-10 t) or faster.
        agree(
            f"position drive, kp {kp}: q* - q [m]", 0.1 - position[-1], 2 * G / kp, within=0.1 * np.exp(-10 * 2) + 1e-6
        )
        agree(f"position drive, kp {kp}: force [N]", force[-1], 2 * G, within=1e-3)
    agree("position drive: measured position [m]", lifts.measure("height")[-1], 0.1 - 2 * G / 400, within=1e-6)
    agree("position drive: measured force [N]", lifts.measure("force")[-1], 2 * G, within=1e-3)


def test_a_velocity_drive_lags_under_its_load_by_force_over_damping(lifts, agree):
    """In the end kv (v* - v) = m g; before that v' = (v + h (kv v* / m - g)) / (1 + h kv / m)."""
    for k, kv in ((2, 100), (3, 1000)):
        _, speed, force = lifts.joint(f"lift[{k}]")
        agree(f"velocity drive, kv {kv}: v* - v [m/s]", 0.3 - speed[-1], 2 * G / kv, within=1e-5)
        agree(f"velocity drive, kv {kv}: force [N]", force[-1], 2 * G, within=2e-3)
    h, expected = 0.005, [0.0]
    for _ in range(400):
        expected.append((expected[-1] + h * (100 * 0.3 / 2 - G)) / (1 + h * 100 / 2))
    agree("velocity drive, kv 100: run-up [m/s]", lifts.joint("lift[2]")[1], expected[::2], within=2e-6)
    agree("velocity drive: measured speed [m/s]", lifts.measure("speed"), expected[::2], within=2e-6)


def test_the_force_of_a_motor_is_its_impulse_over_the_step(simulate, agree):
    """(m + h kv) v = dt sum F: the last substep alone would have kp v dt / 2 less, as if a sled without friction braked."""
    sled = simulate("""
scene: {duration: 0.6, dt: 0.01, substeps: 10, gravity: [0, 0, 0]}
bodies:
  sled:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    material: {mass: 4}
    mount: {kind: slider, axis: x, actuator: {stiffness: 3000, damping: 300}}
actions:
  controls:
    push: {kind: drive, joint: sled, position: {kind: ramp, to: 0.4, start: 0, end: 0.4, ease: linear}}
  measures:
    force: {kind: joint_force, of: sled}
""")
    _, speed, force = sled.joint("sled")
    agree("impulse of a motor [N s]", 0.01 * np.cumsum(force[1:]), (4 + 0.001 * 300) * speed[1:], within=1e-3)
    agree("force that keeps a speed of 1 m/s [N]", sled.measure("force")[35], 0, within=0.5)


def test_an_arm_sags_to_where_its_servo_balances_gravity(simulate, agree):
    """At rest kp (q* - q) = m g d cos(q): a hinge whose load depends on where it is."""
    trial = simulate("""
scene: {duration: 3.0, dt: 0.005, substeps: 1}
bodies:
  arm:
    kind: rigid
    shape: {kind: box, size: [0.4, 0.04, 0.04]}
    material: {mass: 1.5}
    mount: {kind: hinge, axis: y, anchor: [-0.2, 0, 0], actuator: {stiffness: 30, damping: 4}}
actions: {controls: {hold: {kind: drive, joint: arm, position: -0.3}}}
""")
    # Turning about +y lowers the arm, which points along x: gravity's torque is + m g d cos(q).
    rest = brentq(lambda q: 30 * (-0.3 - q) + 1.5 * G * 0.2 * np.cos(q), -1, 1)
    agree("arm under load: angle [rad]", trial.joint("arm")[0][-1], rest, within=1e-5)


def test_a_servo_swings_in_as_a_damped_oscillator(simulate, agree):
    """Theory: q = q* (1 - e^(-z w t) (cos(W t) + z w / W sin(W t))), w^2 = kp / m, 2 z w = kv / m; first order in h."""
    m, kp, kv, goal = 2.0, 200.0, 12.0, 0.2
    w, z = np.sqrt(kp / m), kv / (2 * np.sqrt(kp * m))
    swing = w * np.sqrt(1 - z * z)
    errors = []
    for dt in (0.005, 0.0025):
        trial = simulate(
            """
scene: {duration: 1.5, dt: "${dt}", substeps: 1, gravity: [0, 0, 0]}
bodies:
  cart: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {mass: "${m}"}, mount: {kind: slider, axis: x, actuator: {stiffness: "${kp}", damping: "${kv}"}}}
actions: {controls: {go: {kind: drive, joint: cart, position: "${goal}"}}}
""",
            dt=dt, m=m, kp=kp, kv=kv, goal=goal,
        )  # fmt: skip
        t = trial.time
        theory = goal * (1 - np.exp(-z * w * t) * (np.cos(swing * t) + z * w / swing * np.sin(swing * t)))
        errors.append(np.abs(trial.joint("cart")[0] - theory).max())
        agree(f"step response, dt {dt}: position [m]", errors[-1], 0.0, within=goal * w * dt)
    agree("step response: order of convergence", np.log2(errors[0] / errors[1]), 1.0, within=0.2)


JOINTS = """
scene: {duration: 2.0, dt: 0.002, substeps: 1, gravity: [0, 0, 0], record: {rate: 500}}
bodies:
  cart:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    material: {mass: 2.0}
    pose: {pos: ["${i}", 0, 0]}
    mount:
      kind: slider
      axis: y
      damping: "${[0, 4, 0, 0, 0, 0, 0][i]}"
      spring: "${[0, 0, 50, 0, 0, 0, 0][i]}"
      friction: "${[0, 0, 0, 3, 3, 0, 0][i]}"
      armature: "${[0, 0, 0, 0, 0, 6, 0][i]}"
      actuator: {max_force: "${[100, 100, 100, 100, 100, 100, 5][i]}"}
    repeat: {kind: line, count: 7, step: [0, 0, 0]}
  wheel:
    kind: rigid
    shape: {kind: cylinder, radius: 0.1, height: 0.05}
    material: {mass: 2.0}
    pose: {pos: [0, 0, 3], euler_deg: [30, 40, 0]}
    mount: {kind: hinge, axis: z, actuator: {}}
actions:
  controls:
    push: {kind: drive, joint: "cart[*]", force: "${[8, 8, 8, 8, 2.9, 8, 8][i]}"}
    turn: {kind: drive, joint: wheel, force: {kind: ramp, from: 0, to: 0.02, start: 0, end: 1, ease: linear}}
"""


@pytest.fixture(scope="module")
def joints(simulate):
    return simulate(JOINTS)


def test_a_force_drive_accelerates_by_force_over_mass_and_armature(joints, agree):
    """Its speed is v = F t / (m + armature), clipped at max_force; nothing is added to the mass in secret."""
    for k, (force, inertia) in {0: (8, 2.0), 5: (8, 8.0), 6: (5, 2.0)}.items():
        _, speed, measured = joints.joint(f"cart[{k}]")
        name = {0: "bare", 5: "with armature", 6: "with max_force"}[k]
        agree(f"force drive, {name}: speed [m/s]", speed, force / inertia * joints.time, within=len(speed) * 2**-24 * 8)
        agree(f"force drive, {name}: force [N]", measured[1:], force, within=1e-6)
    # The torque of a step is the schedule's value at its start.
    n = np.arange(len(joints.time))
    torque = np.minimum(0.02 * n * 0.002, 0.02)
    turned = np.concatenate([[0], np.cumsum(torque)[:-1]]) * 0.002 / (2 * 0.1**2 / 2)
    agree("torque drive: angular velocity [rad/s]", joints.joint("wheel")[1], turned, within=len(n) * 2**-24 * 8)
    axis = joints.turn("wheel")[0, :, 2]
    agree(
        "torque drive: about the wheel's own axis [rad/s]",
        joints.ang("wheel"),
        np.outer(turned, axis),
        within=len(n) * 2**-24 * 8,
    )


def test_joint_damping_is_viscous(joints, agree):
    """Each step gives v' = (v + h F / m) / (1 + h c / m), which tends to F / c: the implicit Euler step of m v' = F - c v."""
    expected = [0.0]
    for _ in joints.time[1:]:
        expected.append((expected[-1] + 0.002 * 8 / 2) / (1 + 0.002 * 4 / 2))
    agree("joint damping: speed [m/s]", joints.joint("cart[1]")[1], expected, within=1e-5)
    agree(
        "joint damping: terminal speed [m/s]",
        joints.joint("cart[1]")[1][-1],
        8 / 4 * (1 - np.exp(-4 / 2 * 2.0)),
        within=8 / 4 * 0.002 * 4 / 2,
    )


def test_a_joint_spring_is_linear_about_the_start(joints, agree):
    """It swings as q = F / k (1 - cos(w t)), w^2 = k / m, under a constant force; phase and size to first order in w h."""
    w = np.sqrt(50 / 2)
    position = joints.joint("cart[2]")[0]
    agree(
        "joint spring: position [m]",
        position,
        8 / 50 * (1 - np.cos(w * joints.time)),
        within=8 / 50 * w * 0.002 * w * 2.0,
    )
    rise = joints.time[np.argmax(position)]
    agree("joint spring: half period [s]", np.mod(rise, 2 * np.pi / w), np.pi / w, within=2 * 0.002)


def test_joint_friction_holds_below_its_value_and_takes_it_off_above(joints, agree):
    """Coulomb: 3 N hold against 2.9 N, and leave 8 - 3 N to accelerate; what holds creeps, with an impedance of 0.9999."""
    agree(
        "joint friction: 8 N against 3 N, speed [m/s]",
        joints.joint("cart[3]")[1],
        (8 - 3) / 2 * joints.time,
        within=len(joints.time) * 2**-24 * 5,
    )
    creep = joints.joint("cart[4]")[1]
    # F / m (1 - d) / d over the damping 2 / (d timeconst): a fiftieth of a millimetre a second under a weight.
    agree("joint friction: 2.9 N against 3 N, speed [m/s]", creep, 0.0, within=2.9 / 2 * 1e-4 * 0.004 / 2 * 1.1)


def test_a_joint_stops_at_its_limit(simulate, agree):
    """A limit is a soft contact: pressed with F / m, it gives way by (1 - d) dmax^2 timeconst^2 / d^2 F / m."""
    trial = simulate("""
scene: {duration: 1.5, dt: 0.005, substeps: 1, gravity: [0, 0, 0]}
bodies:
  door: {kind: rigid, shape: {kind: box, size: [0.4, 0.04, 0.5]}, mount: {kind: hinge, axis: z, anchor: [-0.2, 0, 0], range_deg: [-10, 60], actuator: {}}}
  drawer: {kind: rigid, shape: {kind: box, size: [0.4, 0.2, 0.2]}, pose: {pos: [0, 2, 0]}, mount: {kind: slider, axis: x, range: [-0.1, 0.2], actuator: {}}}
actions:
  controls:
    open: {kind: drive, joint: door, force: 20}
    push: {kind: drive, joint: drawer, force: -30}
""")
    # d goes from 0.9 to 0.95 with depth: the softer one bounds the give.
    give = (1 - 0.9) * (0.95 * 0.01 / 0.9) ** 2
    turn = trial.link("door").inertia[2][2] + trial.link("door").mass * 0.2**2
    agree("hinge limit: angle [rad]", trial.joint("door")[0][-1], np.radians(60), within=give * 20 / turn + 1e-6)
    agree(
        "slider limit: travel [m]",
        trial.joint("drawer")[0][-1],
        -0.1,
        within=give * 30 / trial.link("drawer").mass + 1e-6,
    )


def test_a_group_of_joints_sets_out_at_an_event(simulate, agree):
    """From the event at te on both follow their ramp, which a servo with the speed of its target does without lag.

    A ball falls half a metre in te = sqrt(2 h / g); later another drive, of a time, takes over.
    """
    trial = simulate("""
scene: {duration: 1.3, dt: 0.005, substeps: 1}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.05}, pose: {pos: [0, 1, 1]}}
  doors:
    kind: articulated
    links:
      post: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      door:
        parent: post
        shape: {kind: box, size: [0.1, 0.1, 0.1]}
        pose: {pos: [0, 0, "${0.5 + k}"]}
        joint: {kind: slider, axis: x, actuator: {stiffness: 4000, damping: 200}}
        repeat: 2
actions:
  controls:
    open:
      kind: drive
      joint: doors.door_*
      on: is_low
      position: {kind: ramp, to: 0.2, start: 0.1, end: 0.5, ease: linear}
    close: {kind: drive, joint: doors.door_1, position: {kind: ramp, to: 0.05, start: 0.9, end: 1.2, ease: linear}}
  measures: {height: {kind: position, of: ball, axis: z}}
  events: {is_low: {kind: threshold, measure: height, below: 0.5}}
""")
    begin = np.sqrt(2 * 0.5 / G)
    expected = 0.2 * np.clip((trial.time - begin - 0.1) / 0.4, 0.0, 1.0)
    # A step of 5 ms is 2.5 mm of the way at 0.5 m/s; the corners take the servo a few steps.
    for door in ("door_0", "door_1"):
        here = slice(None) if door == "door_0" else trial.time <= 0.9
        position, _, _ = trial.joint(f"doors.{door}")
        agree(f"{door} from the event on [m]", position[here], expected[here], within=4e-3)
    # The later ramp sets out from where the event's has come to, 0.2 m and not 0.
    late = trial.time > 0.9
    way = 0.2 - 0.15 * np.clip((trial.time[late] - 0.9) / 0.3, 0.0, 1.0)
    agree("door_1 after the later drive [m]", trial.joint("doors.door_1")[0][late], way, within=5e-3)


REACH = """
scene: {duration: 2.5, dt: 0.005, gravity: [0, 0, 0]}
bodies:
  arm:
    kind: articulated
    pose: {pos: [1, 2, 0.5]}
    links:
      base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      turret: {parent: base, pose: {pos: [0, 0, 0.1]}, shape: {kind: box, size: [0.1, 0.1, 0.1]}, joint: {kind: hinge, axis: z, actuator: {stiffness: 500, damping: 30}}}
      upper: {parent: turret, pose: {pos: [0, 0, 0.1]}, shape: {kind: box, size: [0.04, 0.04, 0.4]}, joint: {kind: hinge, axis: y, actuator: {stiffness: 500, damping: 30}}}
      lower: {parent: upper, pose: {pos: [0, 0, 0.4]}, shape: {kind: box, size: [0.04, 0.04, 0.3]}, joint: {kind: hinge, axis: y, actuator: {stiffness: 500, damping: 30}}}
actions:
  controls:
    grab: {kind: reach, body: arm.lower, point: [0, 0, 0.3], times: [0.8, 1.2, 2.0], positions: [[1.25, 2.1, 0.8], [1.25, 2.1, 0.7], [0.9, 1.7, 0.9]]}
"""


def test_an_arm_reaches_where_it_is_told_to(simulate, agree):
    """At each time its tip is at the target, but for the 0.5 mm of inverse kinematics and what the servo trails."""
    trial = simulate(REACH)
    for t, at in ((0.8, (1.25, 2.1, 0.8)), (1.2, (1.25, 2.1, 0.7)), (2.5, (0.9, 1.7, 0.9))):
        frame = int(np.abs(trial.time - t).argmin())
        tip = trial.pos("arm.lower")[frame] + 0.3 * trial.turn("arm.lower")[frame, :, 2]
        agree(f"reach, tip at {t} s [m]", tip, at, within=1.5e-3)


def test_the_rolling_pin_of_the_reference_slides_and_turns_at_once(simulate, agree):
    """Servos with the speed of their target follow it without lag, so that it rolls without sliding on the way, too."""
    case = MOTIONS.split("```yaml\n")[1].split("```")[0]
    pin = simulate(f"scene: {{duration: 2.5, statics: {{floor: {{shape: {{kind: plane}}}}}}}}\n{case}")
    way, angle = pin.joint("pin.carriage")[0], pin.joint("pin.roller")[0]
    agree("rolling pin: way [m]", way[-1], 0.4, within=1e-6)
    agree("rolling pin: turn [rad]", angle[-1], -0.4 / 0.03, within=1e-4)
    u = np.clip(pin.time / 2, 0, 1)
    # The target of a step is that of its end: 10 ms at up to 0.3 m/s.
    agree("rolling pin: way on the way [m]", way, 0.4 * u**2 * (3 - 2 * u), within=3.1e-3)
    # At up to 6 * 0.4 / 2**2 = 0.6 m/s2, 1.23 kg on 20,000 N/m give by 37 um, and 3.8e-4 kg m2 on 20 N m by 12 um.
    agree("rolling pin: slip [m]", way + 0.03 * angle, 0.0 * way, within=5e-5)
