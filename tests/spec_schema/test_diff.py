"""Differences of meaning: what is said about them, and the patch that they come to."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from patch_strategies import VALUES, patches

from text2sim.spec_schema.changes.diff import Change, difference, operations
from text2sim.spec_schema.changes.diff_words import change_line, effect_line, sections
from text2sim.spec_schema.changes.effects import effects
from text2sim.spec_schema.changes.naming import Rename, follow
from text2sim.spec_schema.changes.patch import apply_operations, same
from text2sim.spec_schema.changes.renames import find_renames
from text2sim.spec_schema.load import load_case, load_text
from text2sim.spec_schema.text.document import parse_document, parse_pointer
from text2sim.spec_schema.text.source import read_source

STAGE = parse_document(read_source(Path(__file__).with_name("stage.yaml"))).data
CASES = sorted((Path(__file__).parents[2] / "cases").glob("*/case.yaml"))
LAX = settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
Stage = Callable[..., Any]


def edited(edits: dict[str, Any]) -> Any:
    """The stage with values set at JSON Pointers; None takes a value away."""
    data = copy.deepcopy(STAGE)
    for where, value in edits.items():
        *way, last = parse_pointer(where)
        target = data
        for step in way:
            target = target[step]
        if value is None:
            del target[last]
        else:
            target[last] = value
    return data


def lines(edits: dict[str, Any]) -> list[str]:
    return [change_line(change) for change in difference(STAGE, edited(edits))]


def test_a_case_does_not_differ_from_itself():
    again = dict(reversed(copy.deepcopy(STAGE).items()))
    again["scene"]["duration"] = 3
    assert difference(STAGE, again) == []
    assert operations(STAGE, again) == []


WORDS = [
    ("a number", {"/bodies/ball/material/density": 500}, "~ bodies.ball.material.density  7800 → 500"),
    ("a short list", {"/bodies/drum/mount/axis": [0, 1, 1]}, "~ bodies.drum.mount.axis  y → [0, 1, 1]"),
    ("moved", {"/bodies/ball/pose/pos": [-2, 0, 0.7]},
     "~ bodies.ball.pose.pos  moved by [0, 0, 0.2] (0.2 m): [-2, 0, 0.5] → [-2, 0, 0.7]"),
    ("moved in relation", {"/bodies/brick/place/at": [3, 4]}, "~ bodies.brick.place.at  moved by [3, 4] (5 m): [0, 0] → [3, 4]"),
    ("a camera", {"/render/cameras/main/from": [3, -3, 5]},
     "~ render.cameras.main.from  moved by [0, 0, 3] (3 m): [3, -3, 2] → [3, -3, 5]"),
    ("not a place", {"/params/brick": [0.2, 0.1, 0.1]}, "~ params.brick  [0.24, 0.11, 0.07] → [0.2, 0.1, 0.1]"),
    ("another kind", {"/bodies/ball/shape": {"kind": "box", "size": [1, 1, 1]}},
     "~ bodies.ball.shape  sphere → box: {kind: sphere, radius: 0.15} → {kind: box, size: [1, 1, 1]}"),
    ("another kind of body", {"/bodies/ball/kind": "soft"}, "~ bodies.ball.kind  rigid → soft"),
    ("added", {"/bodies/ball/look": {"color": "red"}}, "+ bodies.ball.look  {color: red}"),
    ("removed", {"/actions/expect/hits": None}, "- actions.expect.hits  (was {event: impact, within: [0, 1]})"),
    ("an expression", {"/actions/controls/open/position": "${-0.1 * i}"},
     "~ actions.controls.open.position  ${-0.08 * i} → ${-0.1 * i}"),
    ("text that moves the cursor", {"/prompt": "\x1b[2J"}, "~ prompt  Everything that the tests need. → \" [2J\""),
]  # fmt: skip


@pytest.mark.parametrize(("edits", "line"), [row[1:] for row in WORDS], ids=[row[0] for row in WORDS])
def test_what_is_said(edits: dict[str, Any], line: str):
    assert lines(edits) == [line]


def test_a_long_list_is_compared_item_by_item():
    a, b = {"params": {"times": list(range(20))}}, {"params": {"times": [*range(19), 30]}}
    assert [change_line(change) for change in difference(a, b)] == ["~ params.times[19]  19 → 30"]
    a["params"]["times"].append(1)
    (change,) = difference(a, b)
    assert change.path == ("params", "times")


def test_a_rename_is_one_difference_and_its_mentions_follow():
    data, count = follow(STAGE, [Rename(("bodies",), "ball", "shot")])
    assert count.total() == 4  # launch, ball_speed, impact, the camera
    assert data["actions"]["controls"]["launch"]["body"] == "shot"
    assert data["actions"]["events"]["impact"]["between"] == ["shot", "brick"]
    assert data["render"]["cameras"]["main"]["look_at"] == "shot"
    data["bodies"]["shot"]["material"]["density"] = 500
    assert [change_line(change) for change in difference(STAGE, data)] == [
        "> bodies.ball renamed to bodies.shot  (4 mentions of it follow)",
        "~ bodies.shot.material.density  7800 → 500",
    ]
    data["actions"]["measures"]["ball_speed"]["of"] = "drum"
    assert "~ actions.measures.ball_speed.of  shot → drum" in map(change_line, difference(STAGE, data))


RENAMES = [
    (("params",), "speed", "v", "/actions/controls/launch/linear", ["${v}", 0, 0]),
    (("scene", "statics"), "floor", "ground", "/bodies/brick/place/on", "ground"),
    (("bodies",), "hook", "peg", "/actions/controls/open/joint", "peg"),
    (("bodies",), "arm", "limb", "/actions/controls/grip/to", "limb.hand"),
    (("bodies", "arm", "links"), "hand", "claw", "/actions/controls/grip/to", "arm.claw"),
    (("bodies", "arm", "links"), "elbow", "joint1", "/bodies/arm/links/hand/parent", "joint1"),
    (("bodies", "arm", "links"), "elbow", "joint1", "/bodies/arm/initial", {"joint1": 0.5}),
    (("actions", "controls"), "grip", "hold", "/actions/controls/let_go/attach", "hold"),
    (("actions", "measures"), "height", "tallness", "/actions/expect/stays_up/measure", "tallness"),
    (("actions", "events"), "impact", "bang", "/actions/events/settled/after", "bang"),
    (("actions", "events"), "impact", "bang", "/actions/expect/hits/event", "bang"),
]


@pytest.mark.parametrize(("path", "old", "new", "where", "value"), RENAMES)
def test_every_kind_of_name_is_followed(path: Any, old: str, new: str, where: str, value: Any):
    rename = Rename(path, old, new)
    data, count = follow(STAGE, [rename])
    target = data
    for step in parse_pointer(where):
        target = target[step]
    assert target == value
    assert count[rename] >= 1
    assert find_renames(STAGE, data) == [rename]
    (change,) = difference(STAGE, data)
    assert (change.kind, change.old, change.new) == ("renamed", old, new)
    assert follow(data, [Rename(path, new, old)])[0] == STAGE


def test_a_word_that_is_no_name_does_not_follow():
    data = edited({"/bodies/ball/look": {"color": "gold"}, "/bodies/gold": copy.deepcopy(STAGE["bodies"]["ball"])})
    data["prompt"] = "gold"
    after, count = follow(data, [Rename(("bodies",), "gold", "silver")])
    assert count.total() == 0
    assert after["bodies"]["ball"]["look"]["color"] == "gold"
    assert after["prompt"] == "gold"


def test_names_in_variants_and_sweeps_follow():
    data = copy.deepcopy(STAGE) | {
        "variants": {"soft": {"bodies": {"ball": {"material": {"density": 5}}}, "actions": {"measures": {"m": {"of": "ball"}}}}},
        "sweeps": {"grids": {"grid": {"bodies.ball.material.density": [1, 2]}}, "list": {"variants": ["soft"]}},
    }  # fmt: skip
    after, _ = follow(data, [Rename(("bodies",), "ball", "shot"), Rename(("variants",), "soft", "light")])
    assert after["variants"]["light"]["bodies"] == {"shot": {"material": {"density": 5}}}
    assert after["variants"]["light"]["actions"]["measures"]["m"]["of"] == "shot"
    assert after["sweeps"]["grids"]["grid"] == {"bodies.shot.material.density": [1, 2]}
    assert after["sweeps"]["list"] == {"variants": ["light"]}


RAIL = """\
text2sim: 2
name: rail
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  c: {use: curtain_rod, with: {at: [0, 0, 2]}, hook: {look: {color: gold}}}
  c_x: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {below: "c_hook[0]", clearance: 0.1}}
actions: {measures: {a: {kind: speed, of: "c_hook[1]"}, b: {kind: speed, of: c_x}}}
variants: {still: {actions: {measures: {a: {of: c_rod}}}}}
"""


def test_the_bodies_of_a_prefab_follow_the_name_of_its_use():
    a, b = (
        load_text(text)
        for text in (
            RAIL,
            RAIL.replace("  c: {", "  rail: {").replace("c_hook", "rail_hook").replace("c_rod", "rail_rod"),
        )
    )
    (change,) = difference(a.written.data, b.written.data, (a.data, b.data))
    assert change_line(change) == "> bodies.c renamed to bodies.rail  (3 mentions of it follow)"
    assert list(effects(a.written.data, b.written.data, (a.data, b.data), {})) == []
    c = load_text(b.source.text.replace("at: [0, 0, 2]", "at: [0, 0, 3]"))
    paths = {effect.path[:2] for effect in effects(a.written.data, c.written.data, (a.data, c.data), {})}
    assert paths == {("bodies", "rail_rod"), ("bodies", "rail_hook")}


def test_another_body_is_no_rename():
    fork = {"kind": "rigid", "shape": {"kind": "box", "size": [1, 2, 3]}, "material": {"density": 7800}}
    kinds = {
        (change.kind, change.path) for change in difference(STAGE, edited({"/bodies/ball": None, "/bodies/fork": fork}))
    }
    assert ("removed", ("bodies", "ball")) in kinds
    assert ("added", ("bodies", "fork")) in kinds


def test_two_parameters_of_one_value_are_not_taken_for_each_other():
    a, b = {"params": {"x": 1, "y": 1}}, {"params": {"v": 1, "w": 1}}
    assert {change.kind for change in difference(a, b)} == {"added", "removed"}


def test_values_behind_expressions(stage: Stage):
    a = stage({"/actions/expect/hits/within": ["${speed / 100}", "${speed / 10}"]})
    b = stage({"/actions/expect/hits/within": ["${speed / 100}", "${speed / 10}"], "/params/speed": 20.0})
    (change,) = difference(a.raw, b.raw, (a.data, b.data))
    assert change == Change("changed", ("params", "speed"), 12.0, 20.0)
    depends = {path: site.names for path, site in b.resolver.sites.items()}
    found = [effect_line(effect) for effect in effects(a.raw, b.raw, (a.data, b.data), depends)]
    assert found == [
        "= actions.controls.launch.linear[0]  12 → 20  (speed)",
        "= actions.expect.hits.within[0]  0.12 → 0.2  (speed)",
        "= actions.expect.hits.within[1]  1.2 → 2  (speed)",
    ]
    c = stage({"/actions/expect/hits/within": ["${speed / 50}", "${speed / 10}"]})
    (change,) = difference(a.raw, c.raw, (a.data, c.data))
    assert change_line(change).endswith('→ ["${speed / 50}", "${speed / 10}"]  ([0.12, 1.2] → [0.24, 1.2])')


def test_changes_are_grouped_by_section():
    changes = difference(STAGE, edited({"/bodies/ball/material/density": 1, "/params/speed": 2, "/name": "other"}))
    assert list(sections(changes)) == ["", "params", "bodies"]


def test_a_patch_is_short():
    assert operations(STAGE, edited({"/bodies/ball/material/density": 500})) == [
        {"op": "replace", "path": "/bodies/ball/material/density", "value": 500}
    ]
    assert operations({"a": [1, 2, 3, 4]}, {"a": [1, 3, 4]}) == [{"op": "remove", "path": "/a/1"}]
    assert operations({"a": {"b": 1, "c": 2}}, {"a": {}}) == [{"op": "replace", "path": "/a", "value": {}}]
    long = {"a": [f"item number {n}" for n in range(20)]}
    shorter = {"a": [item for item in long["a"] if not item.endswith(" 7")]}
    assert operations(long, shorter) == [{"op": "remove", "path": "/a/7"}]
    renamed = follow(STAGE, [Rename(("bodies",), "doll", "puppet")])[0]
    assert operations(STAGE, renamed) == [
        {"op": "move", "from": "/bodies/doll", "path": "/bodies/puppet"},
        {"op": "replace", "path": "/actions/controls/grip/body", "value": "puppet"},
    ]


def test_every_case_differs_from_every_other_by_a_patch():
    cases = [load_case(path).raw for path in CASES]
    for a, b in zip(cases, [*cases[1:], cases[0]], strict=True):
        assert same(apply_operations(a, operations(a, b)), b)
        assert difference(a, b)


@LAX
@given(st.data())
def test_the_patch_leads_from_the_one_to_the_other(data: st.DataObject):
    a = data.draw(st.just(STAGE) | VALUES)
    b = apply_operations(a, data.draw(patches(a, most=6)))
    patch = operations(a, b)
    assert same(apply_operations(a, patch), b)
    assert (patch == []) == same(a, b)
    if isinstance(a, dict) and isinstance(b, dict):
        assert (difference(a, b) == []) == same(a, b)
        for change in difference(a, b):
            assert "\n" not in change_line(change)
