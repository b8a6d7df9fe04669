"""A case is shown in another way, and nothing else of it can be changed on that way."""

from pathlib import Path
from typing import Any

import pytest

from text2sim.agents.cinematography import appearance_of
from text2sim.agents.restyling import TouchesPhysics, physics_digest, restyle

PATH = Path("somewhere/case.yaml")
CASE = """\
text2sim: 2
name: kegs
params: {r: 0.1}
scene:
  duration: 1
  dt: 0.01
  statics: {floor: {shape: {kind: plane}}}
bodies:
  keg: {kind: rigid, shape: {kind: sphere, radius: "${r}"}, pose: {pos: [0, 0, 0.5]}}
  toy:
    kind: rigid
    shape:
      kind: compound
      parts:
        look: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
        hat: {shape: {kind: sphere, radius: 0.04}, pose: {pos: [0, 0, 0.09]}}
    pose: {pos: [1, 0, 0.5]}
  gate:
    kind: articulated
    links:
      post: {shape: {kind: box, size: [0.1, 0.1, 0.3]}}
      bar: {parent: post, shape: {kind: box, size: [0.4, 0.02, 0.02]}, joint: {kind: hinge, axis: y}, look: {color: red}}
    pose: {pos: [0, 2, 0.5]}
  flag:
    kind: rigid
    shape:
      kind: compound
      parts:
        pole: {shape: {kind: box, size: [0.02, 0.02, 0.3]}, look: {color: black}}
        cloth: {shape: {kind: box, size: [0.2, 0.02, 0.1]}, pose: {pos: [0.1, 0, 0.1]}}
    repeat: {kind: line, count: 2, step: [0, 0.5, 0], start: [2, 0, 0.5]}
    look: {color: [red, yellow]}
actions:
  events: {touch: {kind: contact, between: [keg, floor]}}
  expect: {lands: {event: touch, within: [0.1, 0.5]}}
"""
STYLE: list[list[dict[str, Any]]] = [
    [{"op": "add", "path": "/render", "value": {"lighting": "golden_hour", "speed": 0.5, "during": [0, 0.8]}}],
    [{"op": "add", "path": "/bodies/keg/look", "value": {"color": "teal", "finish": "polished_metal"}}],
    [{"op": "add", "path": "/scene/statics/floor/look", "value": {"color": "#222222"}}],
    [{"op": "add", "path": "/bodies/toy/look", "value": {"color": "red"}}],
    [{"op": "replace", "path": "/bodies/flag/look/color", "value": ["#d80f0f", "#ffc400"]}],
    [{"op": "replace", "path": "/bodies/flag/shape/parts/pole/look/color", "value": "white"}],
    [{"op": "add", "path": "/bodies/gate/links/post/look", "value": {"finish": "wood"}}],
]
PHYSICS: list[dict[str, Any]] = [
    {"op": "replace", "path": "/scene/dt", "value": 0.02},
    {"op": "replace", "path": "/params/r", "value": 0.2},
    {"op": "add", "path": "/bodies/keg/material", "value": {"density": 100}},
    {"op": "add", "path": "/bodies/look", "value": {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}}},
    {"op": "remove", "path": "/actions/expect/lands"},
    {"op": "add", "path": "/waive", "value": {"hidden": "I want it"}},
    {"op": "add", "path": "/name", "value": "other"},
    {"op": "add", "path": "", "value": {}},
    {"op": "replace", "path": "/bodies/toy/shape/parts/look/shape/size", "value": [0.2, 0.1, 0.1]},
    {"op": "move", "from": "/bodies/keg", "path": "/render/keg"},
    {"op": "copy", "from": "/bodies/keg/pose", "path": "/render/keg"},
]


@pytest.mark.parametrize("operations", STYLE, ids=lambda rows: rows[0]["path"])
def test_looks_and_film_change_and_the_physics_is_the_same(operations: list[Any]) -> None:
    made = restyle(CASE, operations, PATH)
    assert made != CASE
    assert physics_digest(made, PATH) == physics_digest(CASE, PATH)


@pytest.mark.parametrize("operation", PHYSICS, ids=lambda row: f"{row['op']} {row['path']}")
def test_whatever_touches_the_physics_is_refused(operation: Any) -> None:
    with pytest.raises(TouchesPhysics):
        restyle(CASE, [*STYLE[0], operation], PATH)


def test_the_digest_is_what_tells_physics_apart() -> None:
    heavier = CASE.replace('radius: "${r}"}, pose', 'radius: "${r}"}, material: {density: 500}, pose')
    assert physics_digest(heavier, PATH) != physics_digest(CASE, PATH)
    assert physics_digest(CASE.replace("[0.1, 0.5]", "[0.1, 0.6]"), PATH) != physics_digest(CASE, PATH)


def test_the_operation_that_touches_the_physics_is_named() -> None:
    hidden = {"op": "add", "path": "/scene/statics/floor/look", "value": {"visible": False}}
    before, after = (
        {"op": "add", "path": "/render", "value": {}},
        {"op": "add", "path": "/render/speed", "value": 0.5},
    )
    for operations, number in (([before, hidden, after], 2), ([before, hidden], 2), ([hidden], 1)):
        with pytest.raises(TouchesPhysics, match=rf"operation {number} \(`/scene/statics/floor/look`\)"):
            restyle(CASE, operations, PATH)


def test_parts_without_a_look_are_named_as_they_can_get_one() -> None:
    text = """
bodies:
  cart:
    links:
      bed: {shape: {kind: compound, parts: {deck: {shape: {kind: box}, look: {color: red}}, boom: {shape: {kind: box}}}}}
      wheel: {shape: {kind: cylinder, radius: 0.1}}
  ball: {shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}
"""
    assert appearance_of(text)["bodies"] == {
        "cart": {"links": {"bed": {"shape": {"parts": {"deck": {"look": {"color": "red"}}, "boom": {}}}}, "wheel": {}}},
        "ball": {},
    }
