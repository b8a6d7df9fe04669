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
