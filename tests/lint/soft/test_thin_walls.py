"""Walls, pistons and links that are too thin for bodies of particles."""

from pathlib import Path

import pytest
from lint_support import expect_words, findings

CUTTER = """\
bodies:
  dough: {{kind: soft, cell: 0.009, shape: {{kind: box, size: [0.2, 0.2, 0.05]}}, pose: {{pos: [0, 0, 0.026]}}}}
  cutter:
    kind: driven
    shape: {{kind: tube, outer_radius: {outer}, inner_radius: 0.036, height: 0.04, segments: 24}}
    material: {{soft_reach: {reach}}}
    pose: {{pos: [0, 0, 0.12]}}
    motion: {{kind: oscillate, axis: z, amplitude: 0.06, frequency: 0.5}}
"""


@pytest.mark.parametrize(
    ("outer", "reach", "severity"),
    [(0.05, 0.001, "error"), (0.054, 0.0045, "warning"), (0.057, 0.0045, ""), (0.063, 0.001, "")],
)
def test_the_wall_of_a_ring_counts_with_its_reach_and_not_its_staves(
    tmp_path: Path, outer: float, reach: float, severity: str
) -> None:
    found = findings(tmp_path, "thin-wall", CUTTER.format(outer=outer, reach=reach))
    assert [problem.severity for problem in found] == ([severity] if severity else [])


PIN = """\
bodies:
  dough: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.1]}, pose: {pos: [0, 0, 0.06]}}
  pin:
    kind: articulated
    pose: {pos: [0, 0, 0.3]}
    links:
      root: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      rod:
        parent: root
        shape: {kind: box, size: [0.1, 0.1, %s]}
        material: {%s}
        joint: {kind: slider, axis: z, actuator: {stiffness: 100, damping: 10}}
actions: {controls: {down: {kind: drive, joint: pin.rod, position: -0.2}}}
"""


def test_a_link_has_no_reach_of_its_own(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "unheeded-stuff", PIN % (0.1, "soft_reach: 0.01"))
    assert "soft_reach of a link is ignored" in found.message
    assert found.path == "/bodies/pin/links/rod/material/soft_reach"


def test_a_link_may_leave_soft_bodies_alone(tmp_path: Path) -> None:
    alone = PIN % (0.01, "touch_soft: false")
    assert findings(tmp_path, "unheeded-stuff", alone) == []
    assert findings(tmp_path, "thin-wall", alone) == []


def test_thin_links_of_a_body_are_reported_together(tmp_path: Path) -> None:
    more = "  tine: {parent: root, shape: {kind: box, size: [0.1, 0.1, 0.012]}, joint: {kind: hinge, axis: x}}\n"
    pin = (PIN % (0.01, "density: 100")).replace("actions:", f"    {more}actions:")
    (found,) = findings(tmp_path, "thin-wall", pin)
    assert found.message.startswith("`pin.rod` is 10 mm thick")
    assert found.message.endswith("`decor: true`; the same holds for `pin.tine` (12 mm)")


def test_a_thin_link_is_named(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "thin-wall", PIN % (0.01, "density: 100"))
    assert "`pin.rod` is 10 mm thick" in found.message
    assert "decor: true" in found.message
    assert found.path == "/bodies/pin/links/rod/shape"


@pytest.mark.parametrize(
    ("kind", "thick", "says"),
    [
        ("liquid", 0.022, ""),
        ("granular", 0.022, ""),
        ("granular", 0.016, "`a` loses its level behind it"),
        ("liquid", 0.011, ""),
        ("liquid", 0.009, "`a` loses its level behind it"),
        ("soft", 0.006, "`a` is pushed through it"),
        ("soft", 0.026, ""),
        ("liquid", 0.005, "`a` loses its level behind it"),
    ],
)
def test_walls_of_a_cell_hold_what_flows(tmp_path: Path, kind: str, thick: float, says: str) -> None:
    tank = f"""\
scene:
  statics:
    wall: {{shape: {{kind: box, size: [{thick}, 0.3, 0.3]}}, pose: {{pos: [0.12, 0, 0.15]}}}}
bodies:
  a: {{kind: {kind}, cell: 0.02, shape: {{kind: box, size: [0.2, 0.2, 0.2]}}, pose: {{pos: [0, 0, 0.12]}}}}
"""
    expect_words(tmp_path, "thin-wall", says, tank)


@pytest.mark.parametrize("mount", ["", ", mount: {kind: slider, axis: x}"])
@pytest.mark.parametrize(("thick", "says"), [(0.017, ""), (0.012, "make it 16 mm or thicker")])
def test_walls_that_move_hold_a_liquid_with_less_than_a_cell(
    tmp_path: Path, thick: float, says: str, mount: str
) -> None:
    tank = f"""\
bodies:
  wall: {{kind: rigid, shape: {{kind: box, size: [{thick}, 0.3, 0.3]}}, pose: {{pos: [0.12, 0, 0.15]}}{mount}}}
  a: {{kind: liquid, cell: 0.02, shape: {{kind: box, size: [0.2, 0.2, 0.2]}}, pose: {{pos: [0, 0, 0.12]}}}}
"""
    expect_words(tmp_path, "thin-wall", says, tank)


@pytest.mark.parametrize(
    "post", ["{kind: box, size: [0.016, 0.016, 0.3]}", "{kind: cylinder, radius: 0.008, height: 0.3}"]
)
def test_a_post_holds_nothing_up(tmp_path: Path, post: str) -> None:
    pool = f"""\
scene:
  statics: {{post: {{shape: {post}, pose: {{pos: [0.12, 0, 0.15]}}}}}}
bodies:
  a: {{kind: liquid, cell: 0.02, shape: {{kind: box, size: [0.2, 0.2, 0.2]}}, pose: {{pos: [0, 0, 0.12]}}}}
"""
    expect_words(tmp_path, "thin-wall", "", pool)


@pytest.mark.parametrize(("target", "says"), [("0", ""), ("-0.03", "a motor moves it")])
def test_a_motor_that_only_holds_a_tray_presses_on_nothing(tmp_path: Path, target: str, says: str) -> None:
    tray = f"""\
bodies:
  tray:
    kind: rigid
    shape: {{kind: box, size: [0.3, 0.3, 0.028]}}
    mount: {{kind: slider, axis: z, actuator: {{stiffness: 1.0e+5, damping: 1000}}}}
    pose: {{pos: [0, 0, 0.05]}}
  a: {{kind: soft, cell: 0.02, shape: {{kind: box, size: [0.2, 0.2, 0.2]}}, pose: {{pos: [0, 0, 0.18]}}}}
actions: {{controls: {{weigh: {{kind: drive, joint: tray, position: {target}}}}}}}
"""
    expect_words(tmp_path, "thin-wall", says, tray)
