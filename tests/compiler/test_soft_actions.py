"""What acts on bodies that deform: what the program says of it, and how it finds points."""

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from program_modules import load_module

from tests.compiler.test_soft_settings import SHEET, pbd, resolve
from text2sim.compiler.build import plan_case
from text2sim.compiler.emit import emit
from text2sim.compiler.soft.control_checks import MOVED_BY_FIELDS
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.controls import Control
from text2sim.spec_schema.published.language_reference import section_kinds
from text2sim.spec_schema.vocabulary.docstrings import model_doc

HEAD = """\
text2sim: 1
name: acted
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  hook:
    kind: rigid
    shape: {kind: sphere, radius: 0.01}
    mount: {kind: slider, axis: x, actuator: {stiffness: 400, damping: 40}}
    repeat: {kind: line, count: 3, step: [0.2, 0, 0], start: [-0.2, 0, 2]}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [2, 0, 1]}}
  stool:
    kind: rigid
    shape: {kind: compound, parts: {leg: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}}}
    pose: {pos: [3, 0, 1]}
  cube: {kind: soft, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.05, pose: {pos: [0, 1, 0.5]}}
  sheet: {kind: cloth, shape: {kind: sheet, size: [0.4, 0.6]}, cell: 0.04, pose: {pos: [0, 0, 1.7], euler_deg: [90, 0, 0]}}
actions:
  measures:
    height: {kind: position, of: cube, axis: z, region: {face: bottom}}
    far: {kind: distance, between: [ball, "hook[*]"]}
    weight: {kind: energy, of: ball}
    peak: {kind: position, of: ball, axis: z, so_far: max}
    lowest: {kind: position, of: [ball, cube, "hook[1]", ball], axis: z, stat: min}
  events:
    hit: {kind: contact, between: [ball, floor]}
    low: {kind: threshold, measure: height, below: 0.1, after: hit}
    away: {kind: leaves, of: "hook[*]", region: {kind: sphere, center: [0, 0, 2], radius: 0.5}}
    apart: {kind: threshold, measure: far, above: 3}
    down: {kind: threshold, measure: lowest, below: 0.2}
    out: {kind: leaves, of: [ball, "hook[0]"], region: {kind: sphere, center: [0, 0, 2], radius: 0.5}}
    heavy: {kind: threshold, measure: weight, above: 3}
    peaks: {kind: threshold, measure: peak, above: 3}
    rests: {kind: rest, of: [ball, "hook[1]"], speed: 0.05, after: hit}
    calms: {kind: rest, of: [ball, cube]}
    part: {kind: separation, between: [ball, floor]}
    slap: {kind: contact, between: [ball, sheet]}
    hard: {kind: contact, between: [ball, floor], min_impulse: 2}
    stands: {kind: contact, between: [stool.leg, floor]}
  controls:
"""


def plan(controls: str, **changes: str):
    text = HEAD
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    return plan_case(load_text(text + "".join(f"    {line}\n" for line in controls.splitlines())))


def actions(controls: str) -> str:
    return emit(plan(controls))["actions.py"].decode()


def test_points_are_shared_by_all_that_hold():
    text = actions(
        'hang: {kind: attach, body: sheet, region: {edge: back}, points: 6, to: "hook[*]", at: 0.1}\n'
        "off: {kind: release, attach: hang, at: 0.5}\n"
        "drop: {kind: release, attach: hang, on: low}"
    )
    assert (
        f"""\
        # case.yaml:{HEAD.count(chr(10)) + 1} hang
        Hold(
            scene,
            bodies["sheet"],
            pose=((0.0, 0.0, 1.7), (0.707106781, 0.707106781, 0.0, 0.0)),
            region=sides((1, 1), within=0.02),
            count=6,
            to=[main_link(bodies[name]) for name in ("hook[0]", "hook[1]", "hook[2]")],
            start=0.1,
            until=(0.5, "low"),
        ),
"""
        in text
    )
    assert "Holds(make_holds(scene, bodies), triggers.happened)," in text


def test_what_is_waited_for_comes_after_what_has_to_come_first():
    text = actions("hang: {kind: attach, body: cube, to: world}\noff: {kind: release, attach: hang, on: low}")
    begin = text.index("return [", text.index("def make_watches"))
    assert text.index('"hit",', begin) < text.index('"low",', begin)
    assert 'Touch(scene, [links(bodies["ball"])], [links(bodies["floor"])])' in text
    assert "below(" in text
    assert "sides((2, -1), within=0.032)" in text
    assert "from triggers import Crossing, Touch, Triggers, below, center, coordinate, links\n" in text


def test_each_event_has_its_words():
    for event, words in (
        ("away", "outside(in_ball(origin(scene, bodies['hook[1]']), (0.0, 0.0, 2.0), 0.5))"),
        (
            "down",
            "below(reduce('min', [coordinate(origin(scene, bodies['ball']), 2), "
            "coordinate(center(bodies['cube']), 2), coordinate(origin(scene, bodies['hook[1]']), 2)]), 0.2)",
        ),
        (
            "out",
            "Crossing([outside(in_ball(origin(scene, bodies['ball']), (0.0, 0.0, 2.0), 0.5)), "
            "outside(in_ball(origin(scene, bodies['hook[0]']), (0.0, 0.0, 2.0), 0.5))])",
        ),
        ("apart", "above(distance([(origin(scene, bodies['ball']), origin(scene, bodies['hook[0]'])),"),
        (
            "rests",
            "Rest([('ball', norm(velocity(scene, bodies['ball']))), "
            "('hook[1]', norm(velocity(scene, bodies['hook[1]'])))], 0.05, 0.2)",
        ),
    ):
        made = plan(f"hang: {{kind: attach, body: cube, to: world}}\noff: {{kind: release, attach: hang, on: {event}}}")
        assert words in made.watches[-1].make


CHAIN = """\
hang: {kind: attach, body: cube, to: world}
off: {kind: release, attach: hang, on: rests}
also_off: {kind: release, attach: hang, at: 0.7}
weld: {kind: attach, body: ball, to: world}
drop: {kind: release, attach: weld, on: next}"""


def test_an_event_may_come_after_a_release():
    """What the program does itself is watched for behind the event on which it does so."""
    let_go = (
        "    loose: {kind: released, attach: hang}\n    next: {kind: rest, of: stool, after: loose}\n    part: {kind"
    )
    watches = plan(CHAIN, **{"    part: {kind": let_go}).watches
    assert [(watch.name, watch.after) for watch in watches] == [
        ("hit", None), ("rests", "hit"), ("loose", None), ("next", "loose")
    ]  # fmt: skip
    assert watches[2].make == "Deed(['rests', 0.7])"
    with pytest.raises(SpecError) as refused:
        plan(CHAIN.replace("on: rests", "on: next"), **{"    part: {kind": let_go})
    assert {problem.message for problem in refused.value.problems} == {
        "`next` waits for itself: `after` or a release goes in a circle"
    }


def test_what_is_removed_is_not_at_rest():
    controls = "off: {kind: remove, body: stool, on: rests}"
    assert plan(controls).watches[-1].make.endswith("], 0.05, 0.2, gone)")
    assert "make_watches(scene, bodies, self.gone)" in actions(controls)


@pytest.mark.parametrize(
    ("event", "words"),
    [
        ("heavy", "it sees position, displacement, velocity, speed, distance and joint_position"),
        (
            "part",
            "it sees contact between bodies of links, enters, leaves, threshold, rest of bodies of links, released and removed",
        ),
        ("peaks", "a program cannot see `peak`, an extreme so far"),
        ("calms", "`calms` is about a deformable body, whose rest a program does not see"),
        ("slap", "whose contacts the engine does not report"),
        ("hard", "leave out min_impulse"),
        ("stands", "a program sees no parts (`stool.leg`) while it runs"),
    ],
)
def test_what_no_program_sees_is_refused(event, words):
    with pytest.raises(SpecError) as refused:
        plan(f"hang: {{kind: attach, body: cube, to: world}}\noff: {{kind: release, attach: hang, on: {event}}}")
    (problem,) = refused.value.problems
    assert problem.rule == "unseen-event"
    assert words in problem.message
    assert problem.path == "/actions/controls/off/on"


def test_a_rigid_body_is_let_go_by_an_event():
    text = actions("weld: {kind: attach, body: ball, to: world}\noff: {kind: release, attach: weld, on: away}")
    assert '(0.0, True, "ball", None, "floor", None)' in text
    assert '("away", False, "ball", None, "floor", None)' in text
    assert "Welds(scene, bodies, triggers.happened)" in text


def test_pushes_and_start_velocities():
    text = actions(
        "push: {kind: force, body: cube, force: [4, 0, 0], region: {sphere: {center: [0.1, 0, 0], radius: 0.06}}, "
        "drag: 8, scale: {kind: ramp, from: 0, to: 1, start: 0, end: 0.2}, during: [0, 0.5]}\n"
        "blow: {kind: impulse, body: sheet, impulse: [0, 1, 0], at: 0.3}\n"
        "go: {kind: initial_velocity, body: sheet, linear: [0, 2, 0]}"
    )
    assert "region=ball((0.1, 0.0, 0.0), 0.06)," in text
    assert 'scale=ramp(start=0.0, end=0.2, before=0.0, after=1.0, ease="smooth"),\n            drag=8.0,' in text
    assert "force=(0.0, 1.0, 0.0),\n            start=0.3,\n            end=0.3," in text
    assert 'set_velocity(bodies["sheet"], (0.0, 2.0, 0.0), (0.0, 0.0, 0.0))' in text
    assert "set_velocities" not in text  # which is for rigid bodies


def test_fields_are_added_before_the_scene_is_built():
    files = emit(plan("gale: {kind: wind, direction: [3, 0, 4], acceleration: 2, during: [0.2, 0.4]}\n"
                      "spin: {kind: vortex, swirl: 3, falloff: 1}"))  # fmt: skip
    text, program = files["actions.py"].decode(), files["main.py"].decode()
    assert "gs.force_fields.Constant(direction=(0.6, 0.0, 0.8), strength=2.0)), 0.2, 0.4)," in text
    assert "Whirl(center=(0.0, 0.0, 0.0), swirl=3.0, inward=0.0, falloff=1.0)" in text
    assert program.index("scene.fields = add_fields(scene)") < program.index("build(scene)")
    assert {"fields.py", "points.py"} & files.keys() == {"fields.py"}


@pytest.mark.parametrize(
    ("control", "rule", "where"),
    [
        ("it: {kind: attach, body: sheet, to: world, stiffness: 10}", "firm-only", "stiffness"),
        ("it: {kind: attach, body: sheet, region: {edge: top}, to: world}", "empty-region", "region"),
        (
            "it: {kind: force, body: cube, force: [1, 0, 0], region: {box: {min: [1, 0, 0], max: [2, 1, 1]}}}",
            "empty-region",
            "region",
        ),
    ],
)
def test_what_a_solver_or_a_shape_has_not_is_refused(control, rule, where):
    with pytest.raises(SpecError) as refused:
        plan(control)
    assert [(p.rule, p.path) for p in refused.value.problems] == [(rule, f"/actions/controls/it/{where}")]


def test_fields_that_move_nothing_are_refused():
    with pytest.raises(SpecError) as refused:
        plan(
            "gale: {kind: wind, direction: x, acceleration: 2}",
            **{"scene: {duration: 1,": "scene: {duration: 1, contact: {model: sap},", "kind: cloth": "kind: rigid",
               "{kind: sheet, size: [0.4, 0.6]}, cell: 0.04": "{kind: box, size: [0.4, 0.6, 0.1]}"},
        )  # fmt: skip
    assert [p.rule for p in refused.value.problems] == ["field-on-nothing"]


def test_copies_are_held_one_by_one_or_as_they_say():
    pair = {
        "cell: 0.05, pose: {pos: [0, 1, 0.5]}": "cell: 0.05, repeat: {kind: line, count: 3, step: [0.5, 0, 0], start: [0, 1, 0.5]}"
    }
    pair["axis: z, region"] = "axis: z, stat: max, region"
    one = plan('it: {kind: attach, body: "cube[*]", to: "hook[*]"}', **pair)
    assert [(h.entity, h.to) for h in one.holds] == [(f"cube[{k}]", (f"hook[{k}]",)) for k in range(3)]
    own = plan('it: {kind: attach, body: cube, to: "hook[${2 - i}]"}', **pair)
    assert [h.to for h in own.holds] == [("hook[2]",), ("hook[1]",), ("hook[0]",)]
    all_by_one = plan('it: {kind: attach, body: cube, to: "hook[1]"}', **pair)
    assert [h.to for h in all_by_one.holds] == [("hook[1]",)] * 3


# --- how the program finds points -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def points():
    """The module of the program, without the engine."""
    engine = {name: ModuleType(name) for name in ("genesis", "genesis.utils", "genesis.utils.misc", "torch")}
    engine["genesis.utils.misc"].qd_to_torch = None  # type: ignore[attr-defined]
    return load_module("points", **engine)


GRID = np.stack(np.meshgrid(*[np.linspace(0, 1, 11)] * 2, [0.0]), axis=-1).reshape(-1, 3)


def test_regions_find_points(points):
    assert len(points.everything(GRID)) == 121
    assert len(points.sides((0, -1), within=0.05)(GRID)) == 11
    assert GRID[points.sides((0, 1), (1, 1), within=0.01)(GRID)].tolist() == [[1, 1, 0]]
    assert len(points.box((0.25, 0.25, -1), (0.55, 0.55, 1))(GRID)) == 9
    assert len(points.ball((0.5, 0.5, 0), 0.101)(GRID)) == 5
    assert GRID[points.nearest((0.32, 0.77, 3))(GRID)].round(6).tolist() == [[0.3, 0.8, 0.0]]


def test_points_of_an_edge_are_spread_from_end_to_end(points):
    edge = np.stack([np.linspace(0, 1, 41), np.zeros(41), np.zeros(41)], axis=1)
    edge = edge[np.random.default_rng(3).permutation(41)]
    assert np.sort(edge[points.spread(edge, 5), 0]).tolist() == [0, 0.25, 0.5, 0.75, 1]
    assert edge[points.spread(edge, 1), 0].tolist() == [0.5]


def test_points_of_a_face_are_far_from_each_other(points):
    chosen = GRID[points.spread(GRID, 9)]
    apart = np.linalg.norm(chosen[:, None] - chosen[None], axis=2) + 9 * np.eye(9)
    assert apart.min() >= 0.39  # nine on a square can be 0.5 apart


def test_every_holder_takes_its_own_nearest_points(points):
    row = np.stack([np.linspace(0, 1, 11), np.zeros(11), np.zeros(11)], axis=1)
    anchors = np.array([[0.0, 0, 1], [0.04, 0, 1], [1.0, 0, 1]])
    assert points.assign(anchors, row, 1).tolist() == [[0], [1], [10]]
    taken = points.assign(anchors, row, 3)
    assert len(set(taken.ravel().tolist())) == 9
    assert sorted(taken[2].tolist()) == [8, 9, 10]


@pytest.mark.parametrize("kind", ["wind", "drag", "attraction", "vortex", "turbulence"])
def test_the_line_about_a_field_says_what_it_moves(kind: str) -> None:
    """The only line that a reader of all kinds of controls sees."""
    doc = model_doc(section_kinds(Control)[kind])
    assert all(solver in doc for solver in MOVED_BY_FIELDS)


def test_one_airflow_acts_on_each_copy(tmp_path: Path) -> None:
    def check(*bodies: str) -> list[tuple[str, str]]:
        rows = "".join(
            f"    {c}: {{kind: airflow, body: {b}, velocity: [1, 0, 0]}}\n" for c, b in zip("ab", bodies, strict=False)
        )
        text = (
            "text2sim: 2\nname: line\nscene: {duration: 1}\nbodies:\n"
            "  flag: {kind: cloth, cell: 0.1, shape: {kind: sheet, size: [0.5, 0.5]}, pose: {pos: [0, '${i}', 2]},\n"
            "    repeat: {kind: line, count: 2, step: [0, 0, 0]}}\n"
            f"actions:\n  controls:\n{rows}"
        )
        try:
            plan = plan_case(load_text(text, tmp_path / "case.yaml"))
        except SpecError as error:
            return [(problem.rule, problem.message) for problem in error.problems]
        return [(row.entity, row.control) for row in plan.airflows]

    assert check("'flag[0]'", "'flag[1]'") == [("flag[0]", "a"), ("flag[1]", "b")]
    assert check("['flag[1]', flag]") == [("flag[1]", "a"), ("flag[0]", "a")], "each once"
    assert check("'flag[*]'", "[flag]") == [
        ("second-airflow", "`a` already acts on `flag[0]`; change it by its `scale`"),
        ("second-airflow", "`a` already acts on `flag[1]`; change it by its `scale`"),
    ]


def test_a_stream_is_given_its_speed_by_its_shape():
    text = """text2sim: 2
name: tap
scene: {duration: 1}
bodies: {water: {kind: liquid, shape: {kind: stream, radius: 0.02, speed: 1, duration: 1}}}
actions: {controls: {go: {kind: initial_velocity, body: water, linear: [1, 0, 0]}}}
"""
    with pytest.raises(SpecError, match="its shape has the `speed` and `direction`"):
        plan_case(load_text(text))


def test_a_line_takes_its_cloth_as_far_as_a_motor_takes_the_line() -> None:
    bodies = f"""  a: {SHEET}
  line: {{kind: rope, along: [[0, 0, 0.5], [0, 0, 0.7]], segments: 4, radius: 0.005}}
  runner:
    kind: rigid
    shape: {{kind: sphere, radius: 0.02}}
    pose: {{pos: [0, 0, 0.75]}}
    mount: {{kind: slider, axis: z, actuator: {{stiffness: 100, damping: 10}}}}"""
    hitch = ", hitch: {kind: attach, body: runner, to: line.link_3}"
    pull = ", pull: {kind: drive, joint: runner, position: {kind: ramp, start: 0, end: 1, to: 1.5}}"

    def high(to: str, more: str) -> float:
        sewn = f"sewn: {{kind: attach, body: a, region: {{edge: back}}, to: {to}}}"
        return pbd(resolve(bodies, actions=f"actions: {{controls: {{{sewn}{more}}}}}")).high[2]

    assert high("line.link_0", hitch + pull) == high("runner", pull) > high("line.link_0", pull) + 1.5
    assert high("line.link_0", pull) == high("line.link_0", hitch), "tied to nothing, or to what stands still"
