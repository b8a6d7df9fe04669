"""Sound scenes with deformable bodies have no problems, and bounds agree with measurements in the engine."""

import re
from pathlib import Path

import pytest
from lint_support import findings, report_on

from text2sim.spec_schema.errors import Problem

FUZZ = Path(__file__).resolve().parents[2] / "fuzz" / "soft"

PRESS = """\
scene: {statics: {cup: {shape: {kind: cup, radius: 0.12, height: 0.2, thickness: 0.02}, place: {on: floor}}}}
bodies:
  block:
    kind: soft
    cell: 0.0156
    shape: {kind: box, size: [0.07, 0.07, 0.07]}
    material: {youngs_modulus: 50000.0}
    pose: {pos: [0, 0, 0.07]}
  piston:
    kind: rigid
    shape: {kind: cylinder, radius: 0.08, height: 0.08}
    pose: {pos: [0, 0, 0.2]}
    mount: {kind: slider, axis: z, actuator: {stiffness: 20000, damping: 400}}
actions:
  controls:
    press: {kind: drive, joint: piston, position: {kind: ramp, to: -0.08, end: 1.0}}
"""
DRUM = """\
bodies:
  drum:
    kind: rigid
    shape:
      kind: compound
      parts:
        wall: {shape: {kind: tube, outer_radius: 0.34, inner_radius: 0.3, height: 0.3}}
        back: {shape: {kind: cylinder, radius: 0.34, height: 0.04}, pose: {pos: [0, 0, -0.17]}}
        front: {shape: {kind: cylinder, radius: 0.34, height: 0.04}, pose: {pos: [0, 0, 0.17]}}
        lifter: {shape: {kind: box, size: [0.06, 0.03, 0.3]}, pose: {pos: [0.27, 0, 0]}}
    pose: {pos: [0, 0, 0.6], euler_deg: [90, 0, 0]}
    mount: {kind: hinge, axis: y, actuator: {damping: 400}}
  cloth:
    kind: cloth
    cell: 0.02
    shape: {kind: sheet, size: [0.22, 0.22]}
    pose: {pos: [0, 0, 0.55]}
    repeat: {kind: stack, count: 3, gap: 0.03}
actions:
  controls:
    turn: {kind: drive, joint: drum, velocity: 4}
"""
TRAMPOLINE = """\
scene: {pbd: {stretch_iterations: 20}}
bodies:
  sheet: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.6, 0.6]}, pose: {pos: [0, 0, 0.6]}}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.06}, material: {density: 500}, pose: {pos: [0, 0, 1.2]}}
actions:
  controls:
    left: {kind: attach, body: sheet, region: {edge: left}, to: world}
    right: {kind: attach, body: sheet, region: {edge: right}, to: world}
"""
HOURGLASS = """\
scene:
  statics:
    upper:
      shape: {kind: funnel, top_radius: 0.15, bottom_radius: 0.04, height: 0.2, thickness: 0.05}
      pose: {pos: [0, 0, 0.5]}
bodies:
  sand: {kind: granular, cell: 0.0156, shape: {kind: sphere, radius: 0.07}, pose: {pos: [0, 0, 0.62]}}
"""
BAR = """\
scene: {gravity: [0, 0, 0]}
bodies:
  bar: {kind: soft, solver: fem, cell: 0.02, shape: {kind: box, size: [0.4, 0.08, 0.08]}, pose: {pos: [0, 0, 0.5]}}
actions:
  controls:
    hold: {kind: attach, body: bar, region: {face: left}, to: world}
"""


def soft_findings(folder: Path, *parts: str) -> list[Problem]:
    """Return the problems that the rules of `lint.soft` report."""
    from text2sim.lint.rules import RULES

    ids = {rule.id for rule in RULES if ".soft." in rule.run.__module__}
    return [problem for problem in report_on(folder, *parts).problems if problem.rule in ids]


@pytest.mark.parametrize(
    "part", [PRESS, DRUM, TRAMPOLINE, HOURGLASS, BAR], ids=["press", "drum", "sheet", "sand", "bar"]
)
def test_sound_scenes_are_quiet(tmp_path: Path, part: str) -> None:
    assert [str(problem) for problem in soft_findings(tmp_path, part)] == []


@pytest.mark.parametrize("name", ["press", "curtain", "bar", "towel"])
def test_the_bases_of_the_fuzz_have_no_errors(name: str) -> None:
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case
    from text2sim.spec_schema.load import load_case

    problems = lint_case(resolve_case(load_case(FUZZ / name))).problems
    assert [str(problem) for problem in problems if problem.severity == "error"] == []


@pytest.mark.parametrize(("cell", "lacking"), [(0.03, 36), (0.02, 19)])
def test_a_coarse_cantilever_lacks_what_it_lacked_in_the_engine(tmp_path: Path, cell: float, lacking: int) -> None:
    part = f"""\
bodies:
  bar: {{kind: soft, solver: fem, cell: {cell:.6f}, shape: {{kind: box, size: [0.3, 0.06, 0.06]}}, pose: {{pos: [0, 0, 1]}}}}
"""
    (problem,) = findings(tmp_path, "too-few-elements", part)
    found = re.search(r"by about (\d+)% too little", problem.message)
    assert found
    assert int(found[1]) == pytest.approx(lacking, abs=1)


def test_a_block_is_no_bar(tmp_path: Path) -> None:
    part = "bodies: {b: {kind: soft, solver: fem, cell: 0.1, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 1]}}}"
    assert findings(tmp_path, "too-few-elements", part) == []


RUBBER = """\
scene: {{dt: 0.004, substeps: {0}}}
bodies:
  rubber:
    kind: soft
    cell: 0.015625
    shape: {{kind: box, size: [0.2, 0.2, 0.2]}}
    material: {{youngs_modulus: 1.0e+7, poisson_ratio: 0.3, density: 1000}}
    pose: {{pos: [0, 0, 0.3]}}
"""


@pytest.mark.parametrize(("substeps", "severity"), [(40, "error"), (55, "warning"), (70, "")])
def test_sound_may_cross_half_a_cell(tmp_path: Path, substeps: int, severity: str) -> None:
    # 116 m/s: 0.74 of a cell at 40 substeps, which diverged in the engine; 0.54 at 55, 0.42 at 70.
    found = findings(tmp_path, "sound-too-fast", RUBBER.format(substeps))
    assert [problem.severity for problem in found] == ([severity] if severity else [])
    if severity == "error":
        assert "crosses 0.74 cells" in found[0].message
        needed = re.search(r"scene.substeps of (\d+)", found[0].message)
        assert needed
        assert findings(tmp_path, "sound-too-fast", RUBBER.format(needed[1])) == []


@pytest.mark.parametrize(("height", "severity"), [(0.02, "error"), (0.03, "error"), (0.045, "warning"), (0.08, "")])
def test_pistons_leak_as_they_did(tmp_path: Path, height: float, severity: str) -> None:
    piston = f"bodies: {{piston: {{shape: {{height: {height}}}}}}}"
    found = findings(tmp_path, "thin-wall", PRESS, piston)
    assert [problem.severity for problem in found] == ([severity] if severity else [])


def test_of_a_ram_the_part_in_front_counts(tmp_path: Path) -> None:
    rod = "rod: {shape: {kind: cylinder, radius: 0.005, height: 0.3}, pose: {pos: [0, 0, 0.19]}}"
    for height, expected in ((0.08, []), (0.03, ["error"])):
        head = f"head: {{shape: {{kind: cylinder, radius: 0.08, height: {height}}}}}"
        ram = f"bodies: {{piston: {{shape: {{kind: compound, parts: {{{head}, {rod}}}, radius: null, height: null}}}}}}"
        found = findings(tmp_path, "thin-wall", PRESS, ram)
        assert [problem.severity for problem in found] == expected


def test_a_piston_that_only_holds_is_not_felt(tmp_path: Path) -> None:
    piston = "bodies: {piston: {shape: {height: 0.02}, material: {touch_soft: false}}}"
    assert findings(tmp_path, "thin-wall", PRESS, piston) == []


@pytest.mark.parametrize(("speed", "iterations", "found"), [(4, 4, 0), (8, 4, 0), (16, 4, 1), (16, 20, 0), (32, 20, 1)])
def test_a_sheet_catches_what_it_caught(tmp_path: Path, speed: int, iterations: int, found: int) -> None:
    thrown = f"""\
scene: {{gravity: [0, 0, 0], pbd: {{stretch_iterations: {iterations}}}}}
actions: {{controls: {{go: {{kind: initial_velocity, body: ball, linear: [0, 0, {-speed}]}}}}}}
"""
    assert len(findings(tmp_path, "cloth-too-fast", TRAMPOLINE, thrown)) == found


@pytest.mark.parametrize(
    ("cell", "scene", "says"),
    [
        (0.005, "", ""),  # 16 iterations
        (0.003, "", ""),  # 32 iterations, 1.3 %
        (0.002, "", "2.8 % longer where it hangs; use cells of 3.37 mm, or scene.substeps of 17"),
        (0.002, "substeps: 17, ", ""),
        (0.0034, "", ""),
        (0.005, "pbd: {stretch_iterations: 4}, ", "3.6 % longer where it hangs; leave out `stretch_iterations`"),
        (0.002, "gravity: [0, 0, 0], ", ""),
    ],
)
def test_a_cloth_that_stretches_under_its_own_weight(tmp_path: Path, cell: float, scene: str, says: str) -> None:
    """By 3 g h^2 L / (n c^2), with L = 0.5 m in substeps of 0.5 ms."""
    strip = f"""\
scene: {{dt: 0.005, {scene}duration: 1}}
bodies:
  strip: {{kind: cloth, cell: {cell}, shape: {{kind: sheet, size: [0.04, 0.5]}}, pose: {{pos: [0, 0, 1]}}}}
"""
    found = findings(tmp_path, "cloth-sags", strip)
    assert len(found) == bool(says)
    assert all(says in problem.message for problem in found)


def test_what_never_meets_needs_no_contact(tmp_path: Path) -> None:
    part = """\
scene: {duration: 0.5, statics: {floor: null}}
bodies:
  bar: {kind: soft, solver: fem, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 5]}}
  sheet: {kind: cloth, solver: pbd, shape: {kind: sheet, size: [0.3, 0.3]}, pose: {pos: [3, 0, %s]}}
"""
    assert findings(tmp_path, "no-contact", part % 5) == []
    below = "bodies: {sheet: {pose: {pos: [0, 0, 4.5]}}}"
    assert [p.severity for p in findings(tmp_path, "no-contact", part % 5, below)] == ["error"]


def test_a_wheel_on_a_hinge_does_not_lie_on_sand(tmp_path: Path) -> None:
    wheel = """\
bodies:
  wheel: {kind: rigid, mount: {kind: hinge, axis: y}, shape: {kind: box, size: [0.4, 0.2, 0.02]}, pose: {pos: [0, 0, 0.3]}}
  sand: {kind: granular, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.6]}}
"""
    (found,) = findings(tmp_path, "thin-wall", wheel)
    assert "the body presses on it" in found.message
    free = findings(tmp_path, "thin-wall", wheel.replace("{kind: hinge, axis: y}", "{kind: free}"))
    assert "it may lie on the body" in free[0].message


FLAG = """\
scene: {duration: 4.0, pbd: {bounds: {min: [-1, -1.5, 0.9], max: [2, 1.5, 3.2]}}}
bodies:
  flag: {kind: cloth, cell: 0.025, shape: {kind: sheet, size: [0.9, 0.6]}, pose: {pos: [0.48, 0, 2.1], euler_deg: [90, 0, 0]}}
actions:
  controls:
    up: {kind: attach, body: flag, region: {corner: [back, left]}, to: world}
    low: {kind: attach, body: flag, region: {corner: [front, left]}, to: world}
"""


def test_a_cloth_that_is_held_does_not_fall_out_of_its_space(tmp_path: Path) -> None:
    """Its lowest point is 0.9 m below its top at 2.4 m; let go, it falls to the floor."""
    assert findings(tmp_path, "leaves-bounds", FLAG) == []
    let_go = """\
actions:
  controls:
    go: {kind: release, attach: up, at: 1}
    gone: {kind: release, attach: low, at: 1}
"""
    (found,) = findings(tmp_path, "leaves-bounds", FLAG, let_go)
    assert "beyond the -z side" in found.message


def test_a_layer_that_holds_no_particle_is_refused(tmp_path: Path) -> None:
    film = """\
bodies:
  film: {kind: liquid, cell: 0.02, shape: {kind: box, size: [0.3, 0.3, %s]}, pose: {pos: [0, 0, 0.05]}}
"""
    (found,) = findings(tmp_path, "thin-soft-body", film % "1.0e-6")
    assert found.severity == "error"
    assert "contains no particle; make it at least 5 mm thick" in found.message
    (found,) = findings(tmp_path, "thin-soft-body", film % "0.006")
    assert found.severity == "warning"


def test_a_stream_needs_two_cells_and_has_no_shape_to_keep(tmp_path: Path) -> None:
    syrup = """\
bodies:
  syrup: {kind: liquid, cell: 0.008, shape: {kind: stream, radius: %s, speed: 0.4, duration: 1}, pose: {pos: [0, 0, 0.3]}}
"""
    assert findings(tmp_path, "thin-soft-body", syrup % "0.008") == []
    (found,) = findings(tmp_path, "thin-soft-body", syrup % "0.006")
    assert ": it breaks up; `scene.mpm.cell` 0.006 gives it 2 " in found.message


@pytest.mark.parametrize(
    ("step", "state", "away"),
    [(0.035, "are 5 mm apart", 15), (0.03, "touch", 20), (0.02, "are 10 mm inside each other", 30)],
)
def test_soft_layers_are_said_to_touch_or_to_be_in_each_other(
    tmp_path: Path, step: float, state: str, away: int
) -> None:
    stack = f"""\
bodies:
  layer:
    kind: soft
    cell: 0.01
    shape: {{kind: cylinder, radius: 0.1, height: 0.03}}
    repeat: {{kind: line, count: 3, step: [0, 0, {step}]}}
    pose: {{pos: [0, 0, 0.2]}}
"""
    (found,) = findings(tmp_path, "soft-too-near", stack)
    assert re.match(rf"`layer\[\d\]` and `layer\[\d\]` {state} at the start \(and \d more pairs?\)", found.message)
    assert f"move one of them by {away} mm, or" in found.message


BORE = """\
scene:
  gravity: [0, 0, 0]
  mpm: {cell: 0.01}
  statics:
    tube:
      shape: {kind: tube, inner_radius: 0.04, outer_radius: 0.08, height: 0.3, segments: 12}
      material: {soft_reach: 0.01}
      pose: {pos: [0.3, 0, 0.5], euler_deg: [0, 90, 0]}
bodies:
  worm:
    kind: soft
    shape: {kind: cylinder, radius: 0.06, height: 0.2}
    material: {youngs_modulus: 20000.0}
    pose: {pos: [0, 0, 0.5], euler_deg: [0, 90, 0]}
"""
PULL = """\
actions:
  controls:
    pull: {kind: force, body: worm, force: [60, 0, 0], region: {face: top}, drag: 40}
"""


def test_the_stretch_that_a_bore_forces_counts(tmp_path: Path) -> None:
    # 0.06 m through a free bore of 0.04 - 0.01 m: (0.06 / 0.03)^2 = 4 times as long, and 3.1 is two cells.
    (whole,) = findings(tmp_path, "tearing-force", BORE, PULL.replace("region: {face: top}, ", ""))
    assert "to 4 times its length" in whole.message and "`tube`" in whole.message
    wide = BORE.replace("inner_radius: 0.04", "inner_radius: 0.05").replace("outer_radius: 0.08", "outer_radius: 0.09")
    assert findings(tmp_path, "tearing-force", wide, PULL.replace("region: {face: top}, ", "")) == []
    # 60 N on 113 cm2 strain by 0.27, which is no matter; drawn out by (0.06 / 0.04)^2 besides, it is.
    (pulled,) = findings(tmp_path, "tearing-force", wide, PULL)
    assert "`tube` also stretches it to 2.2 times" in pulled.message
    free = wide.replace("pos: [0.3, 0, 0.5]", "pos: [0.3, 9, 0.5]")
    assert findings(tmp_path, "tearing-force", free, PULL) == []
    # The force carries it to a tube that is far away, and not to one behind it.
    far, behind = (wide.replace("pos: [0.3, 0, 0.5]", f"pos: [{x}, 0, 0.5]") for x in (1.2, -1.2))
    assert len(findings(tmp_path, "tearing-force", far, PULL)) == 1
    assert findings(tmp_path, "tearing-force", behind, PULL) == []


def test_parts_of_one_soft_body_may_overlap(tmp_path: Path) -> None:
    body = """\
bodies:
  toy:
    kind: soft
    cell: 0.02
    pose: {pos: [0, 0, 0.3]}
    shape:
      kind: compound
      parts:
        a: {shape: {kind: sphere, radius: 0.1}}
        b: {shape: {kind: box, size: [0.3, 0.1, 0.1]}, pose: {pos: [0.1, 0, 0]}}
"""
    said = {problem.rule for problem in report_on(tmp_path, body).problems}
    assert not said & {"soft-too-near", "counted-twice", "soft-inside"}


@pytest.mark.parametrize("region", ["{corner: [left, back]}", "{sphere: {center: [0, 0, 0], radius: 0.05}}"])
def test_what_is_held_inside_of_a_body_shows_no_gap(assets: Path, region: str) -> None:
    """A ball has no corners, and its centre is not on the surface."""
    held = f"""\
scene: {{statics: {{peg: {{shape: {{kind: sphere, radius: 0.01}}, pose: {{pos: [0.2, 0, 1.03]}}}}}}}}
bodies:
  ball: {{kind: soft, cell: 0.02, shape: {{kind: sphere, radius: 0.2}}, pose: {{pos: [0, 0, 1]}}}}
actions: {{controls: {{hang: {{kind: attach, body: ball, region: {region}, to: peg}}}}}}
"""
    assert findings(assets, "held-at-a-distance", held) == []


@pytest.mark.parametrize(
    ("sides", "unseen"),
    [
        ("of: bar", False),
        ("of: ball", True),
        ("of: [bar, slab]", False),
        ("of: [bar, ball]", True),
        ("of: [bar, ball], by: [slab]", False),
    ],
)
def test_under_sap_a_depth_is_that_of_what_deforms(tmp_path, sides, unseen):
    bar = "{{kind: soft, solver: fem, cell: 0.05, shape: {{kind: box, size: [0.2, 0.2, 0.2]}}, pose: {{pos: [0, {}, 0.5]}}}}"
    ball = "{kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, 0.5]}}"
    bodies = f"bodies: {{bar: {bar.format(0)}, slab: {bar.format(1)}, ball: {ball}}}"
    measure = f"actions: {{measures: {{deep: {{kind: penetration, {sides}}}}}}}"
    found = findings(tmp_path, "unseen-contacts", bodies, measure)
    assert [problem.path for problem in found] == ["/actions/measures/deep/kind"] * unseen


BOUNDED = """\
scene:
  mpm: {bounds: {min: [-0.5, -0.5, 0], max: [0.5, 0.5, 1.5]}}
  statics:
    bench: {shape: {kind: box, size: [0.8, 0.8, 0.1]}, pose: {pos: [%s, 0, 0.4]}}
bodies:
  jelly: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.6]}}
"""


@pytest.mark.parametrize(("x", "floats"), [(0, False), (0.9, True)])
def test_what_stands_on_a_bench_does_not_rest_on_the_bounds(tmp_path: Path, x: float, floats: bool) -> None:
    assert bool(findings(tmp_path, "floats-on-bounds", BOUNDED % x)) == floats
