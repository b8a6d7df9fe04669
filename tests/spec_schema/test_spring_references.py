"""Springs: what they can join, which copies they pair, and which of them a measure may name."""

import pytest

from text2sim.spec_schema.names.references import check_references

CONTROL, MEASURE = "/actions/controls/it", "/actions/measures/it"
SPRING = {"kind": "spring", "body": "ball", "to": "floor", "stiffness": 20}


@pytest.mark.parametrize(
    ("rule", "field", "other"),
    [
        ("not-dynamic", "body", {"body": "floor", "to": "post[0]"}),
        ("itself", "to", {"to": "ball"}),
        ("pairs", "to", {"body": "brick", "to": "hook"}),
        ("no-world", "to", {"to": "world"}),
        ("soft-spring", "body", {"body": "curtain"}),
        ("no-such-copy", "to", {"body": "brick", "to": "brick[${i + 1}]"}),
    ],
)
def test_what_cannot_be_joined_is_reported(stage, rule, field, other):
    (problem,) = check_references(stage({CONTROL: SPRING | other}))
    assert (problem.rule, problem.path) == (rule, f"{CONTROL}/{field}")


@pytest.mark.parametrize(
    "other",
    [
        {"body": "arm.hand", "to": "arm.base"},
        {"body": "brick", "to": "brick[${(i + 1) % n}]"},
        {"body": "brick[0:11]", "to": "brick[${i + 1}]"},  # the last one needs no partner
    ],
)
def test_links_and_copies_can_be_joined(stage, other):
    assert check_references(stage({CONTROL: SPRING | other})) == []


@pytest.mark.parametrize(("name", "hint"), [("bunge", "bungee"), ("grip", None)])
def test_a_measure_names_a_spring(stage, name, hint):
    (problem,) = check_references(stage({MEASURE: {"kind": "spring_force", "spring": name}}))
    assert (problem.rule, problem.path, problem.hint) == ("unknown-spring", f"{MEASURE}/spring", hint)
