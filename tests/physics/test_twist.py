"""Ropes that are twisted: they carry the twist, and buckle where a rod does, without flying apart."""

import numpy as np
import pytest

E, RADIUS, LINKS, LINK = 2e6, 0.005, 20, 0.02
STIFFNESS = E * np.pi * RADIUS**4 / 4
"""Of bending, E I, and of torsion, G J [N m2]: Poisson's ratio is 0."""
TORQUE = 0.01
TURNS = {"under": 1.2, "over": 1.8}
"""Turns of the driven ends of two ropes, below and above the critical number."""


def rod(y, name):
    """Bodies and controls of a rope along x that `turner` turns at its first end; its last end may slide along x."""
    speed = 2 * np.pi * TURNS[name]
    head = f"pose: {{pos: [-0.021, {y}, 1]}}"
    bodies = f"""
  {name}: {{kind: rope, length: {LINKS * LINK}, radius: {RADIUS}, segments: {LINKS}, direction: x, anchored: false, youngs_modulus: {E}, pose: {{pos: [0, {y}, 1]}}}}
  {name}_turner: {{kind: driven, shape: {{kind: box, size: [0.04, 0.02, 0.02]}}, {head}, motion: {{kind: spin, axis: x, speed: {{kind: piecewise, times: [0, 0.1, 1, 1.1], values: [0, {speed}, {speed}, 0]}}}}}}
  {name}_slide: {{kind: rigid, shape: {{kind: box, size: [0.02, 0.02, 0.02]}}, mount: {{kind: slider, axis: x}}, pose: {{pos: [0.412, {y}, 1]}}}}"""
    controls = f"""
    {name}_grip: {{kind: attach, body: {name}.link_0, to: {name}_turner}}
    {name}_hold: {{kind: attach, body: {name}.link_{LINKS - 1}, to: {name}_slide}}
    {name}_nudge: {{kind: impulse, body: {name}.link_10, impulse: [0, 0, 1e-4], at: 1.2}}"""
    return bodies, controls


PARTS = [rod(0.3 * k, name) for k, name in enumerate(TURNS)]
TWISTED = f"""
scene:
  duration: 3
  dt: 0.01
  gravity: [0, 0, 0]
  record: {{rate: 50}}
  statics: {{wall: {{shape: {{kind: box, size: [0.02, 0.02, 0.02]}}, pose: {{pos: [-0.011, -0.3, 1]}}}}}}
bodies:
  rotor: {{kind: rigid, shape: {{kind: cylinder, radius: 0.02, height: 0.02}}, mount: {{kind: hinge, axis: z, damping: 0.002}}, pose: {{pos: [0.211, -0.3, 1], euler_deg: [0, 90, 0]}}}}
  rod: {{kind: rope, length: 0.2, radius: {RADIUS}, segments: 10, direction: x, anchored: false, youngs_modulus: {E}, pose: {{pos: [0, -0.3, 1]}}}}{"".join(bodies for bodies, _ in PARTS)}
actions:
  controls:
    grip: {{kind: attach, body: rod.link_0, to: wall}}
    hold: {{kind: attach, body: rod.link_9, to: rotor}}
    twist: {{kind: torque, body: rotor, torque: [{TORQUE}, 0, 0]}}{"".join(controls for _, controls in PARTS)}
"""


def twist(trial, rope, links):
    """Angle of the last link of a straight rope against its first about its axis at the end [rad], by its joints."""
    turns = [trial.turn(f"{rope}.link_{k}")[-1] for k in range(links)]
    steps = [before.T @ after for before, after in zip(turns, turns[1:], strict=False)]
    return abs(sum(np.arctan2(step[1, 0] - step[0, 1], step[0, 0] + step[1, 1]) for step in steps))


@pytest.fixture(scope="module")
def twisted(simulate):
    return simulate(TWISTED)


def test_a_torque_twists_a_rope_by_its_stiffness(twisted, agree):
    """T = G J phi / L, where L is the length between the middles of both clamped links."""
    theory = TORQUE * 9 * LINK / STIFFNESS
    agree("twist of a rope [rad]", twist(twisted, "rod", 10), theory, within=0.02 * theory)


def test_a_twisted_rope_leaves_its_line_where_a_rod_does(twisted, agree):
    """A clamped rod whose ends may approach buckles under M L / (2 E I) = 4.493, the first root of tan x = x.

    With G J = E I that are 8.99 rad, 1.43 turns of its free length (Love 1927, article 272). A nudge dies out below it.
    """
    critical = 2 * 4.4934 / (2 * np.pi)
    assert TURNS["under"] < critical < TURNS["over"]
    ways = {
        name: np.hypot(*(twisted.pos(f"{name}.link_10")[:, 1:] - np.array([0.3 * k, 1.0])).T)
        for k, name in enumerate(TURNS)
    }
    agree("a rope below stays in its line [m]", ways["under"][-1], 0.0, within=2e-3)
    assert ways["over"][-1] > 0.05
