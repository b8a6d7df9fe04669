"""Sweeps: their form, and the runs that they mean."""

import pytest
from small_case import problems_of

from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.reuse.sweeps import grid_runs, parse_grid, runs_of

CASE = """\
text2sim: 2
name: swept
params: {speed: 3, at: [0, 0, 1]}
scene: {duration: 1}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}
variants: {soft: {params: {speed: 1}}, hard: {params: {speed: 9}}}
sweeps:
  weights: {grid: {bodies.ball.material.density: [500, 1000], params.speed: [1, 2, 3]}}
  both: {variants: [soft, hard]}
  marked: {points: {light: {params: {speed: 2}}, heavy: {bodies: {ball: {material: {mass: 9}}}}}}
  places: {grid: {bodies.ball.pose.pos: [[0, 0, 1], "${at}"], bodies.ball.look: [{color: red}]}}
"""


def runs(name: str) -> list[tuple[str, CaseOverlay]]:
    return runs_of(load_text(CASE).written, name)


def problems(sweeps: str) -> list[Problem]:
    return problems_of(CASE.split("sweeps:")[0] + f"sweeps:\n  s: {sweeps}\n")


def test_a_grid_is_every_combination():
    found = runs("weights")
    assert [label for label, _ in found[:4]] == [
        "density=500, speed=1", "density=500, speed=2", "density=500, speed=3", "density=1000, speed=1",
    ]  # fmt: skip
    assert len(found) == 6
    loaded = load_text(CASE, overlay=found[5][1])
    assert loaded.case.bodies["ball"].material.density == 1000
    assert loaded.data["params"]["speed"] == 3


def test_variants_and_points_are_runs_by_name():
    assert runs("both") == [("soft", CaseOverlay(("soft",))), ("hard", CaseOverlay(("hard",)))]
    (light, first), (heavy, second) = runs("marked")
    assert (light, heavy) == ("light", "heavy")
    assert load_text(CASE, overlay=CaseOverlay(("hard",)) + first).data["params"]["speed"] == 2
    assert load_text(CASE, overlay=second).case.bodies["ball"].material.mass == 9
    assert first.label == "marked-light"


def test_any_value_can_be_swept():
    found = runs("places")
    positions = [load_text(CASE, overlay=overlay).case.bodies["ball"].pose.pos for _, overlay in found]
    assert positions == [(0, 0, 1), (0, 0, 1)]
    assert load_text(CASE, overlay=found[0][1]).case.bodies["ball"].look.color == "red"


def test_a_grid_that_is_made_up_on_the_spot():
    grid = parse_grid(["params.speed=[1, 2]", "bodies.ball.pose.pos[2]=[0.5]"])
    assert [overlay.sets for _, overlay in grid_runs(grid)] == [
        ("params.speed=1", "bodies.ball.pose.pos[2]=0.5"),
        ("params.speed=2", "bodies.ball.pose.pos[2]=0.5"),
    ]


def test_labels_tell_paths_apart():
    labels = [label for label, _ in grid_runs({"bodies.a.mass": ["1"], "bodies.b.mass": ["2"]})]
    assert labels == ["a.mass=1, b.mass=2"]


@pytest.mark.parametrize(
    ("sweep", "path", "says", "hint"),
    [
        ("{}", "", "give exactly one of grid, points, variants", None),
        ("{grid: {params.speed: [1]}, variants: [soft]}", "", "give exactly one of", None),
        ("{gird: {params.speed: [1]}}", "/gird", "unknown key `gird`; a sweep takes grid, points, variants", "grid"),
        ("{grid: {params.sped: [1]}}", "/grid/params.sped", "there is no `sped` in `params`", "speed"),
        ("{grid: {bodies.ball.mas: [1]}}", "/grid/bodies.ball.mas", "unknown key `mas`", None),
        ("{grid: {a b..c: [1]}}", "/grid/a b..c", "a path has the form", None),
        ("{grid: {params.speed: 3}}", "/grid/params.speed", "needs a list", None),
        ("{grid: {params.speed: []}}", "/grid/params.speed", "needs at least 1", None),
        ("{grid: {}}", "/grid", "needs at least 1", None),
        (
            f"{{grid: {{params.speed: [{', '.join(['1'] * 201)}]}}}}",
            "",
            "a sweep may have at most 200 runs (got 201)",
            None,
        ),
        ("{variants: [soft, sofd]}", "/variants/1", "there is no variant `sofd`; there are soft, hard", "soft"),
        ("{points: {a: {parms: 3}}}", "/points/a/parms", "the point `a` can change prompt, params", "params"),
        ("{points: {a: 3}}", "/points/a", "needs a mapping", None),
        ("3", "", "needs a mapping", None),
    ],
)
def test_what_is_wrong_with_a_sweep_is_reported_with_the_case(sweep, path, says, hint):
    found = [problem for problem in problems(sweep) if says in problem.message]
    (problem,) = found
    assert (problem.path, problem.line, problem.hint) == (f"/sweeps/s{path}", 9, hint)


@pytest.mark.parametrize(
    "words", ["", "a", "params.speed=", "params.speed=3", "params.speed=[]", "=[1]", "params.speed=[1"]
)
def test_an_axis_is_a_path_and_a_list(words):
    with pytest.raises(SpecError) as caught:
        parse_grid(["params.speed=[1]", words])
    (problem,) = caught.value.problems
    assert (problem.file, problem.line) == ("--grid", 2)


def test_an_axis_is_given_once():
    with pytest.raises(SpecError, match="twice"):
        parse_grid(["params.speed=[1, 2]", "params.speed=[3]"])


def test_a_grid_has_its_limit_before_it_is_made():
    axis = f"[{', '.join(['1'] * 100)}]"
    with pytest.raises(SpecError, match="at most 200 runs"):
        parse_grid([f"params.a{k}={axis}" for k in range(20)])


def test_a_sweep_that_is_not_there():
    with pytest.raises(SpecError) as caught:
        runs("weigths")
    (problem,) = caught.value.problems
    assert (problem.file, problem.hint) == ("--sweep", "weights")
