"""What the request asks for cannot be made easier, by whatever way."""

import pytest
import yaml

from text2sim.agents.contract import Contract, weakened_bounds
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: drop
params: {bound: 0.3}
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}
  other: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, 1]}}
actions:
  measures:
    height: {kind: position, of: ball, axis: z}
    own: {kind: position, of: other, axis: z}
  events:
    touch: {kind: contact, between: [ball, floor]}
  expect:
    lands: {event: touch, within: [0.1, 0.9]}
    low: {measure: height, at: end, below: "${bound}"}
    mine: {measure: own, at: end, below: 5}
"""


@pytest.fixture
def contract() -> Contract:
    return Contract.of(load_text(CASE), ("lands", "low"))


def test_it_holds_expectations_and_all_they_lead_to(contract: Contract) -> None:
    assert set(contract.values["expect"]) == {"lands", "low"}
    assert set(contract.values["measures"]) == {"height"}
    assert set(contract.values["events"]) == {"touch"}
    assert contract.subjects == {"ball"}
    assert "/actions/expect/low" in contract.pointers
    assert contract.breaches(load_text(CASE)) == []


@pytest.mark.parametrize(
    ("old", "new", "about"),
    [
        ("within: [0.1, 0.9]", "within: [0.0, 1.0]", "/actions/expect/lands"),
        ("bound: 0.3", "bound: 3", "/actions/expect/low"),  # by way of a parameter
        ("height: {kind: position, of: ball, axis: z}", "height: {kind: position, of: ball, axis: x}", "/actions/measures/height"),
        ("between: [ball, floor]", "between: [other, floor]", "/actions/events/touch"),
        ("    low: {measure: height, at: end, below: \"${bound}\"}\n", "", "/actions/expect/low"),
    ],
)  # fmt: skip
def test_nothing_of_it_can_be_changed(contract: Contract, old: str, new: str, about: str) -> None:
    assert old in CASE
    assert about in [pointer for pointer, _ in contract.breaches(load_text(CASE.replace(old, new)))]


def test_what_is_not_in_it_can_be_changed(contract: Contract) -> None:
    changed = CASE.replace("below: 5", "below: 50").replace(
        "radius: 0.1}, pose: {pos: [1", "radius: 0.2}, pose: {pos: [1"
    )
    assert contract.breaches(load_text(changed)) == []


def test_its_subject_cannot_be_moved_by_decree(contract: Contract) -> None:
    driven = "{kind: driven, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}, motion: {kind: spin, axis: z, speed: 1}}"
    ball = "{kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}"
    text = CASE.replace(f"ball: {ball}", f"ball: {driven}")
    assert any(
        pointer == "/bodies/ball" and "cannot be `driven`" in message
        for pointer, message in contract.breaches(load_text(text))
    )


def test_a_restatement_keeps_a_bound() -> None:
    old = {"low": {"measure": "height", "at": "end", "below": 0.3}}
    assert weakened_bounds(old, {"low": {"measure": "height", "at": "end", "below": 0.25}}) == []
    assert weakened_bounds(old, {"low": {"measure": "height", "at": "end"}})
    assert weakened_bounds(old, {"new": {"measure": "height", "at": "end", "below": 1}})


@pytest.mark.parametrize(
    ("old", "new", "about"),
    [
        ("measure: h, at: 1, equals: 1, tolerance: 0.01", "measure: h, at: 1, equals: 1, tolerance: 100", "tolerance"),
        ("measure: h, at: 1, equals: 1, tolerance: 0.01", "measure: h, at: 2, equals: 2, tolerance: 0.012", ""),
        ("event: hit, count: 3", "event: hit, count: [1, 1000]", "count"),
        ("event: hit, count: [2, 4]", "event: hit, count: [0, 4]", "count"),
        ("event: hit, count: 4", "event: hit, count: [3, 5]", ""),
        ("event: hit, count: 3", "event: hit, count: 6", ""),  # another number, as exact
        ("event: hit, within: [0.1, 0.9]", "event: hit, within: [2, 2.8]", ""),  # another time, as exact
    ],
)  # fmt: skip
def test_a_restatement_is_not_wider(old: str, new: str, about: str) -> None:
    before, after = (yaml.safe_load(f"{{e: {{{text}}}}}") for text in (old, new))
    faults = weakened_bounds(before, after)
    assert ([f"`{about}` may" in fault for fault in faults] == [True]) if about else (faults == [])


def test_what_stands_for_several_goes_on_doing_so() -> None:
    old = {"low": {"measure": "height_${k}", "at": "end", "below": 0.3, "repeat": 3}}
    assert "stands for 3" in weakened_bounds(old, {"low": old["low"] | {"repeat": 2}})[0]
    several = CASE.replace(
        'low: {measure: height, at: end, below: "${bound}"}',
        'low: {measure: height, at: end, below: "${bound + k}", repeat: 2}',
    )
    held = Contract.of(load_text(several), ("lands", "low"))
    assert set(held.values["expect"]) == {"lands", "low_0", "low_1"}
    assert held.breaches(load_text(several)) == []
    assert held.breaches(load_text(CASE))
