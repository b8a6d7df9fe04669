"""Differences of meaning: what is said about them, and the patch that they come to."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from patch_strategies import VALUES, patches
from staged import STAGE, edited

from text2sim.spec_schema.changes.diff import Change, difference, effects, operations
from text2sim.spec_schema.changes.diff_words import change_line, effect_line, sections
from text2sim.spec_schema.changes.patch import apply_operations, same
from text2sim.spec_schema.load import load_case

CASES = sorted((Path(__file__).parents[2] / "cases").glob("*/case.yaml"))
LAX = settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
Stage = Callable[..., Any]


def lines(edits: dict[str, Any]) -> list[str]:
    return [change_line(change) for change in difference(STAGE, edited(edits))]


def test_a_case_does_not_differ_from_itself():
    again = dict(reversed(copy.deepcopy(STAGE).items()))
    again["scene"]["duration"] = 3
    assert difference(STAGE, again) == []
    assert operations(STAGE, again) == []


WORDS = [
    ("a number", {"/bodies/ball/material/density": 500}, "~ bodies.ball.material.density  7800 → 500"),
    ("one body more", {"/actions/measures/ball_speed/of": ["ball", "drum"]},
     "~ actions.measures.ball_speed.of  ball → [ball, drum]"),
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


def test_another_name_is_another_entry():
    data = edited({"/bodies/ball": None, "/bodies/shot": STAGE["bodies"]["ball"]})
    assert [(change.kind, change.path[-1]) for change in difference(STAGE, data)] == [
        ("removed", "ball"),
        ("added", "shot"),
    ]


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


def test_the_shots_of_a_film_get_their_order():
    """A new shot before the last one was put behind it: the film showed the outcome first."""
    old = {"render": {"fps": 30, "shots": {"course": {"to": 3}, "end": {"to": 5}}}}
    inserted = {"render": {"fps": 25, "shots": {"course": {"to": 3}, "knock": {"to": 4}, "end": {"to": 5}}}}
    swapped = {"render": {"fps": 30, "shots": {"end": {"to": 5}, "course": {"to": 3}}}}
    for new in (inserted, swapped):
        made = apply_operations(old, operations(old, new))
        assert made == new
        assert [*made["render"]["shots"]] == [*new["render"]["shots"]]
    appended = {"render": {"fps": 30, "shots": old["render"]["shots"] | {"more": {"to": 6}}}}
    assert operations(old, appended) == [{"op": "add", "path": "/render/shots/more", "value": {"to": 6}}]


def test_every_case_differs_from_every_other_by_a_patch():
    cases = [load_case(path).raw for path in CASES]
    for a, b in zip(cases, [*cases[1:], cases[0]], strict=True):
        assert same(apply_operations(a, operations(a, b)), b)
        assert difference(a, b)


def test_a_kind_that_is_no_name_is_compared_as_in_json():
    assert [change.kind for change in difference({"kind": 0}, {"kind": False})] == ["kind"]


def test_a_kind_with_line_breaks_stays_on_the_line():
    (change,) = difference({"kind": "box", "size": 1}, {"kind": "two\nlines", "size": 1})
    assert change_line(change).startswith("~   box → two lines: ")


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
