"""Documents of older versions of the language: each step by itself, and what a case has of it."""

import copy
from typing import Any

import pytest
from small_case import only_problem, problems_of, small

from text2sim.spec_schema.changes.patch import apply_operations
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.reuse.migration import LATEST, STEPS, steps_for
from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.reuse.sweeps import runs_of

FIRST = """\
text2sim: 1
name: old
params: {wide: 50}
scene: {duration: 1}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}
render:
  cameras:
    near: {kind: still, from: [1, 1, 1], look_at: ball, fov: 35}
    far:
      kind: orbit
      fov: ${wide}
      look_at: ball
      radius: 2
      height: 1
    plain: {kind: still, from: [2, 1, 1], look_at: ball}
"""


def data_of(text: str) -> Any:
    return load_text(text).written.data


def test_there_is_a_step_from_every_version():
    assert sorted(STEPS) == list(range(1, LATEST))


def test_from_1_the_angle_of_a_camera_gets_its_unit():
    assert steps_for(data_of(FIRST)) == [
        {"op": "move", "from": "/render/cameras/near/fov", "path": "/render/cameras/near/fov_deg"},
        {"op": "move", "from": "/render/cameras/far/fov", "path": "/render/cameras/far/fov_deg"},
        {"op": "replace", "path": "/text2sim", "value": 2},
    ]


def test_a_document_is_migrated_in_memory_as_the_operations_say():
    loaded = load_text(FIRST)
    assert loaded.raw == apply_operations(loaded.written.data, steps_for(loaded.written.data))
    assert loaded.written.data["render"]["cameras"]["near"]["fov"] == 35
    assert [camera.field for camera in loaded.case.render.cameras.values()] == [35, 50, 40]
    assert loaded.case.text2sim == LATEST


@pytest.mark.parametrize("name", ["²", "007"])
def test_odd_names_of_cameras_are_reported_and_no_numbers(name: str):
    problem = only_problem(FIRST.replace("near:", f'"{name}":'))
    assert problem.path == f"/render/cameras/{name}"
    assert "a letter, then letters, digits or _" in problem.message


LAYERS = """\
variants:
  wide: {render: {cameras: {near: {fov: 60}}}}
sweeps:
  angles: {grid: {render.cameras.near.fov: [30, 40], params.wide: [40, 50]}}
  places: {points: {a: {render: {cameras: {near: {fov: 20}}}}, b: {render: {cameras: {far: {fov: 25}}}}}}
"""


def test_from_1_variants_and_sweeps_come_along():
    loaded = load_text(FIRST + LAYERS, overlay=CaseOverlay(point=("places", "b")))
    assert [camera.field for camera in loaded.case.render.cameras.values()] == [35, 25, 40]
    assert load_text(FIRST + LAYERS, overlay=CaseOverlay(("wide",))).case.render.cameras["near"].fov == 60
    label, overlay = runs_of(loaded.written, "angles")[1]
    assert label == "fov_deg=30, wide=50"
    assert load_text(FIRST + LAYERS, overlay=overlay).case.render.cameras["far"].fov == 50
    after = apply_operations(loaded.written.data, steps_for(loaded.written.data))
    assert set(after["sweeps"]["angles"]["grid"]) == {"render.cameras.near.fov_deg", "params.wide"}


def test_positions_and_order_are_kept():
    loaded = load_text(FIRST)
    assert loaded.line("/render/cameras/near/fov_deg") == 9
    assert loaded.problem("/render/cameras/far/fov_deg", "x").column == 12
    assert loaded.problem("/render/cameras/far/fov_deg", "x", key=True).column == 7
    assert list(loaded.raw["render"]["cameras"]["far"]) == ["kind", "fov_deg", "look_at", "radius", "height"]


def test_what_is_wrong_with_a_migrated_value_is_located():
    problem = only_problem(FIRST.replace("fov: 35", "fov: 350"))
    assert (problem.line, problem.path) == (9, "/render/cameras/near/fov_deg")
    assert problem.message == "must be from 2 to 140 (got 350)"


def test_a_document_of_the_latest_version_says_it_in_its_own_words():
    text = FIRST.replace("text2sim: 1", "text2sim: 2").replace("fov: ${wide}", "fov_deg: 50")
    problem = only_problem(text)
    assert (problem.rule, problem.hint, problem.line) == ("unknown-key", "fov_deg", 9)


@pytest.mark.parametrize("version", ["3", "0", "-1", "'2'", "[1]", "true", "1.5", "null", "x"])
def test_a_version_that_is_not_known_is_an_error(version):
    problem = only_problem(small().replace("text2sim: 1", f"text2sim: {version}"))
    assert (problem.path, problem.line, problem.rule) == ("/text2sim", 1, "version")
    assert problem.message.startswith(f"this text2sim supports versions 1 to {LATEST} of the language (got ")


def test_besides_a_version_that_means_nothing_the_rest_is_judged():
    problems = problems_of(small(radius="-1").replace("text2sim: 1", "text2sim: one"))
    assert [problem.rule for problem in problems] == ["version", "range"]


@pytest.mark.parametrize(
    "data",
    [None, [], "x", {}, {"text2sim": 1, "render": 3}, {"text2sim": 1, "render": {"cameras": {"a": {"fov": 1, "fov_deg": 2}}}},
     {"text2sim": 2, "render": {"cameras": {"a": {"fov": 1}}}}, {"text2sim": 99}],
)  # fmt: skip
def test_steps_take_any_data(data):
    before = copy.deepcopy(data)
    found = steps_for(data)
    assert all(operation["path"] == "/text2sim" for operation in found)
    assert data == before
