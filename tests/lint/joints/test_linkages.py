"""Loads of motors in mechanisms with loops, against the principle of virtual work."""

from math import cos, radians, sin, sqrt
from pathlib import Path

import pytest
from lint_support import expect_words, facts_of

from text2sim.lint.joints.motors import Powered, powered

G = 9.81
TABLE = """
bodies:
  table:
    kind: articulated
    pose: {{pos: [0, 0, 1]}}
    links:
      base: {{shape: {{kind: box, size: [0.5, 0.1, 0.02]}}}}
      left:
        parent: base
        shape: {{kind: box, size: [0.3, 0.02, 0.02]}}
        material: {{mass: 0.4}}
        pose: {{pos: ["${{-0.2 + 0.15 * cos(radians(20))}}", 0, "${{0.15 * sin(radians(20))}}"], euler_deg: [0, -20, 0]}}
        joint: {{kind: hinge, axis: [0, -1, 0], anchor: [-0.15, 0, 0], actuator: {{{motor}}}}}
      tray:
        parent: left
        shape: {{kind: box, size: [0.4, 0.2, 0.02]}}
        material: {{mass: 3}}
        pose: {{pos: [0.15, 0, 0], euler_deg: [0, 20, 0]}}
        joint: {{kind: hinge, axis: [0, -1, 0]{tray}}}
      right:
        parent: base
        shape: {{kind: box, size: [0.3, 0.02, 0.02]}}
        material: {{mass: 0.4}}
        pose: {{pos: ["${{0.2 + 0.15 * cos(radians(20))}}", 0, "${{0.15 * sin(radians(20))}}"], euler_deg: [0, -20, 0]}}
        joint: {{kind: hinge, axis: [0, -1, 0], anchor: [-0.15, 0, 0]{right}}}
    loops: {{pin: {{between: [tray, right], anchor: [0.4, 0, 0]}}}}
  {load}
actions: {{controls: {{go: {{kind: drive, joint: table.left, {target}}}{more}}}}}
"""
PRESS = """
bodies:
  press:
    kind: articulated
    pose: {pos: [0, 0, 1]}
    links:
      frame: {shape: {kind: box, size: [0.02, 0.02, 0.02]}}
      crank: {parent: frame, material: {mass: 0.2}, shape: {kind: box, size: [0.1, 0.02, 0.02]}, pose: {pos: [0.05, 0, 0]}, joint: {kind: hinge, axis: [0, -1, 0], anchor: [-0.05, 0, 0], actuator: {stiffness: 900, damping: 90}}}
      rod: {parent: crank, material: {mass: 0.3}, shape: {kind: box, size: [0.3, 0.02, 0.02]}, pose: {pos: [0.05, 0, "${h / 2}"], euler_deg: [0, 0, 0]}, joint: {kind: hinge, axis: [0, -1, 0], anchor: [0, 0, "${-h / 2}"]}}
      ram: {parent: frame, material: {mass: 2}, shape: {kind: box, size: [0.05, 0.05, 0.05]}, pose: {pos: [0.1, 0, "${h}"]}, joint: {kind: slider, axis: z, spring: 50}}
    loops: {wrist: {between: [rod, ram], anchor: [0, 0, "${h / 2}"]}}
params: {h: 0.25}
actions: {controls: {go: {kind: drive, joint: press.crank, position: 0}}}
"""


def table(
    motor="stiffness: 900, damping: 90, max_force: 50", target="position: 0", tray="", right="", more="", load=""
) -> str:
    return TABLE.format(motor=motor, target=target, tray=tray, right=right, more=more, load=load)


def motor_of(case: str) -> Powered:
    [motor] = powered(facts_of(case))
    return motor


@pytest.mark.parametrize("turn", [0.0, 0.7, -0.9])
def test_a_table_on_cranks_moves_without_turning(turn: float) -> None:
    """All of the tray rises by L cos a da, the middles of the cranks by half of it."""
    load = motor_of(table()).load(turn)
    assert load == pytest.approx(-G * 0.3 * cos(radians(20) + turn) * (3 + 0.4), rel=1e-5)


def test_springs_and_friction_of_other_joints_count() -> None:
    """A spring pulls the right crank back by k q; the tray turns by -q, and its friction takes part of the load."""
    weight = G * 0.3 * cos(radians(20) + 0.3) * 3.4
    assert motor_of(table(right=", spring: 4")).load(0.3) == pytest.approx(-weight - 4 * 0.3, rel=1e-5)
    assert motor_of(table(tray=", friction: 1.5")).load(0.3) == pytest.approx(-weight + 1.5, rel=1e-5)


def test_what_the_case_puts_on_a_link_is_part_of_the_load() -> None:
    """A crate of 2 kg moves with the tray; welded to it, it counts once; beside the table it is no load."""
    crate = "crate: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {mass: 2}, "
    arm = G * 0.3 * cos(radians(20))
    on = crate + "place: {on: table, at: [0.28, 0]}}"
    held = ", hold: {kind: attach, body: crate, to: table.tray}"
    away = crate + "pose: {pos: [0, 2, 3]}}"
    assert motor_of(table(load=on)).load(0.0) == pytest.approx(-arm * 5.4, rel=1e-5)
    assert motor_of(table(load=on, more=held)).load(0.0) == pytest.approx(-arm * 5.4, rel=1e-5)
    assert motor_of(table(load=away)).load(0.0) == pytest.approx(-arm * 3.4, rel=1e-5)


@pytest.mark.parametrize("turn", [0.0, 0.4, -1.0])
def test_a_crank_lifts_a_ram_by_its_rod(turn: float) -> None:
    """The ram is at z = r sin q + sqrt(h^2 - (r - r cos q)^2), r 0.1 m, h 0.25 m: the rod stands upright at q = 0."""
    r, h, e = 0.1, 0.25, 1e-5

    def energy(q: float) -> float:
        across = r - r * cos(q)
        z = r * sin(q) + sqrt(h**2 - across**2)
        return G * (0.2 * r / 2 * sin(q) + 0.3 * (r * sin(q) + z) / 2 + 2 * z) + 25 * (z - h) ** 2

    expected = -(energy(turn + e) - energy(turn - e)) / (2 * e)
    assert motor_of(PRESS).load(turn) == pytest.approx(expected, rel=1e-4)


# 9.81 x 0.3 x cos 20 deg x 3.4 kg = 9.40 N m at the start, and more further down: 10.0 N m where the cranks are level.
@pytest.mark.parametrize(
    ("case", "says"),
    [
        (table("stiffness: 900, damping: 90, max_force: 8"), "`table.left` and all that its loops move takes 9.4 N m"),
        (table("stiffness: 900, damping: 90, max_force: 9.6"), ""),
        (table("stiffness: 900, damping: 90, max_force: 8", "position: {kind: ramp, to: -0.6, end: 1}"), "takes 10 N m"),
        (table("damping: 100", "velocity: 0.05"), "with damping 100 its motor stalls at 5 N m"),
        # Two motors share the load: nothing is said.
        (
            table("stiffness: 900, damping: 90, max_force: 8", right=", actuator: {stiffness: 900, damping: 90}",
                  more=", too: {kind: drive, joint: table.right, position: 0}"),
            "",
        ),
    ],
)  # fmt: skip
def test_a_motor_of_a_linkage_is_too_weak(assets: Path, case: str, says: str) -> None:
    expect_words(assets, "weak-motor", says, case)


def test_a_motor_of_a_linkage_is_too_slow(assets: Path) -> None:
    up = "position: {kind: ramp, to: 0.5, end: 1}"
    expect_words(assets, "slow-motor", "for its load", table("stiffness: 900, damping: 90, max_force: 8", up))
    expect_words(assets, "slow-motor", "", table(target=up))


HOIST = """
bodies:
  hoist:
    kind: articulated
    pose: {pos: [0, 0, 2]}
    links:
      frame: {shape: {kind: box, size: [0.02, 0.02, 0.02]}}
      wheel: {parent: frame, pose: {pos: [0, 0, 0.3], euler_deg: [90, 0, 0]}, shape: {kind: cylinder, radius: 0.05, height: 0.02}, joint: {kind: hinge, axis: z, actuator: {stiffness: 900, damping: 90}}}
      load: {parent: frame, material: {mass: 2}, shape: {kind: box, size: [0.1, 0.1, 0.1]}, joint: {kind: slider, axis: z, spring: 30}}
    loops: {rack: {kind: gear, between: [load, wheel], ratio: 0.05}}
actions: {controls: {go: {kind: drive, joint: hoist.wheel, position: 0}}}
"""


@pytest.mark.parametrize("turn", [0.0, 4.0])
def test_a_motor_carries_what_is_geared_to_it(turn: float) -> None:
    """The load rises by r q, so that the moment is -r (m g + k r q)."""
    assert motor_of(HOIST).load(turn) == pytest.approx(-0.05 * (2 * G + 30 * 0.05 * turn), rel=1e-5)
