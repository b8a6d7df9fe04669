"""Which measures and events fit which bodies, and what the messages offer instead."""

import pytest

from text2sim.spec_schema.names.references import check_references

BODIES = {
    "/bodies/gel": {"kind": "soft", "shape": {"kind": "box", "size": [0.2, 0.2, 0.2]}},
    "/bodies/rag": {"kind": "cloth", "shape": {"kind": "sheet", "size": [0.5, 0.5]}},
    "/bodies/sand": {"kind": "granular", "shape": {"kind": "box", "size": [0.2, 0.2, 0.2]}},
}
BOX = {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}
MEASURE, EVENT = "/actions/measures/it", "/actions/events/it"


def problems(stage, edits):
    return [problem for problem in check_references(stage(BODIES | edits)) if "/it" in problem.path]


@pytest.mark.parametrize(
    ("measure", "rule", "where", "said"),
    [
        ({"kind": "volume", "of": "rag"}, "measure-kind", "of", "stretch"),
        ({"kind": "volume", "of": "sand"}, "measure-kind", "of", "share_in"),
        ({"kind": "volume", "of": "ball"}, "measure-kind", "of", "it needs soft"),
        ({"kind": "strain", "of": "rag"}, "measure-kind", "of", "stretch"),
        ({"kind": "strain", "of": "floor"}, "measure-kind", "of", "static"),
        ({"kind": "stretch", "of": "sand"}, "measure-kind", "of", "extent"),
        ({"kind": "folded_area", "of": "gel"}, "measure-kind", "of", "it needs cloth"),
        ({"kind": "self_penetration", "of": "gel"}, "measure-kind", "of", "it needs cloth"),
        ({"kind": "share_in", "of": "ball", "region": BOX}, "measure-kind", "of", "a deformable body"),
        ({"kind": "tilt", "of": "gel"}, "measure-kind", "of", "two regions"),
        ({"kind": "angular_speed", "of": "rag"}, "measure-kind", "of", "region"),
        ({"kind": "turns", "of": "gel", "axis": "z"}, "measure-kind", "of", "two regions"),
        ({"kind": "wrinkling", "of": "gel"}, "measure-kind", "of", "it needs cloth"),
        ({"kind": "bend", "of": "rag", "stat": "max"}, "measure-kind", "of", "wrinkling"),
        ({"kind": "bend", "of": "ball"}, "measure-kind", "of", "no joints"),
        ({"kind": "contact_force", "of": "gel"}, "contacts-not-recorded", "of", "gap"),
        ({"kind": "contact_count", "of": "ball", "by": "rag"}, "contacts-not-recorded", "by", "contact"),
        ({"kind": "gap", "of": "ball", "to": "floor"}, "measure-kind", "of", "distance"),
        ({"kind": "gap", "of": "gel", "to": "gel"}, "itself", "to", "no gap to itself"),
        ({"kind": "gap", "of": "gel", "to": "flor"}, "unknown-body", "to", "flor"),
        (
            {"kind": "position", "of": "ball", "axis": "z", "region": {"face": "top"}},
            "not-soft",
            "region",
            "leave it out",
        ),
        ({"kind": "joint_position", "of": "gel"}, "no-joint", "of", "soft"),
        ({"kind": "volume", "of": ["gel", "ball"]}, "measure-kind", "of/1", "it needs soft"),
        ({"kind": "tilt", "of": ["ball", "gel"], "stat": "max"}, "measure-kind", "of/1", "two regions"),
        ({"kind": "contact_force", "of": ["ball", "gel"]}, "contacts-not-recorded", "of/1", "gap"),
        ({"kind": "contact_count", "of": "ball", "by": ["brick", "rag"]}, "contacts-not-recorded", "by/1", "contact"),
        ({"kind": "gap", "of": ["gel", "ball"], "to": "floor"}, "measure-kind", "of/1", "all bodies of one side"),
        ({"kind": "gap", "of": ["ball", "brick"], "to": "floor"}, "measure-kind", "of/0", "distance"),
        ({"kind": "gap", "of": ["gel"], "to": "gel"}, "itself", "to", "no gap to itself"),
        ({"kind": "gap", "of": "gel", "to": ["rag", "flor"]}, "unknown-body", "to/1", "flor"),
        ({"kind": "surface_level", "of": "rag"}, "measure-kind", "of", "extent"),
        ({"kind": "surface_level", "of": "ball"}, "measure-kind", "of", "granular or liquid or snow"),
        ({"kind": "submerged", "of": "gel", "by": "sand"}, "measure-kind", "of", "share_in"),
        ({"kind": "submerged", "of": "ball", "by": "brick"}, "measure-kind", "by", "does not flow"),
        ({"kind": "submerged", "of": "ball", "by": ["sand", "gel"]}, "measure-kind", "by/1", "does not flow"),
        ({"kind": "speed", "of": "gel.leg"}, "unknown-link", "of", "links"),
    ],
)
def test_a_measure_that_a_body_has_not(stage, measure, rule, where, said):
    (problem,) = problems(stage, {MEASURE: measure})
    assert (problem.rule, problem.path) == (rule, f"{MEASURE}/{where}")
    assert said in problem.message


@pytest.mark.parametrize(
    "measure",
    [
        {"kind": "volume", "of": "gel"},
        {"kind": "strain", "of": "gel", "stat": "mean"},
        {"kind": "stretch", "of": "rag"},
        {"kind": "stretch", "of": "gel"},
        {"kind": "folded_area", "of": "rag"},
        {"kind": "self_penetration", "of": "rag"},
        {"kind": "share_in", "of": "sand", "region": BOX},
        {"kind": "surface_level", "of": "sand", "region": BOX},
        {"kind": "submerged", "of": ["ball", "brick"], "by": "sand"},
        {"kind": "gap", "of": "gel", "to": "floor"},
        {"kind": "gap", "of": ["gel", "rag"], "to": ["floor", "ball"]},
        {"kind": "gap", "of": ["ball", "brick"], "to": ["gel", "rag"]},
        {"kind": "share_in", "of": ["sand", "gel"], "region": BOX},
        {"kind": "gap", "of": "brick", "to": "rag"},
        {"kind": "gap", "of": "rag", "to": "gel"},
        {"kind": "penetration", "of": "gel"},
        {"kind": "penetration", "of": "ball", "by": "gel"},
        {"kind": "position", "of": "gel", "axis": "z", "region": {"face": "top"}},
        {"kind": "distance", "between": ["gel", "ball"]},
        {"kind": "energy"},
        {"kind": "momentum", "of": "sand", "axis": "x"},
        {"kind": "extent", "of": "sand", "axis": "x", "stat": "max"},
        {"kind": "count_in", "of": "gel", "region": BOX},
    ],
)
def test_a_measure_that_it_has(stage, measure):
    assert problems(stage, {MEASURE: measure}) == []


def test_copies_need_no_stat_where_all_points_are_one_crowd(stage):
    copies = {"/bodies/gel/repeat": {"kind": "line", "count": 3, "step": [1, 0, 0]}}
    assert problems(stage, copies | {MEASURE: {"kind": "strain", "of": "gel"}}) == []
    (problem,) = problems(stage, copies | {MEASURE: {"kind": "speed", "of": "gel"}})
    assert problem.rule == "needs-stat"


@pytest.mark.parametrize("between", [["gel", "floor"], ["rag", "ball"], ["gel", "rag"], ["ball", "gel"]])
@pytest.mark.parametrize("kind", ["contact", "separation"])
def test_touches_of_what_deforms_need_no_recorded_contacts(stage, kind, between):
    quiet = {"/scene/record": {"contacts": False}}
    assert problems(stage, quiet | {EVENT: {"kind": kind, "between": between}}) == []


def test_touches_of_rigid_bodies_do(stage):
    quiet = {"/scene/record": {"contacts": False}}
    (problem,) = problems(stage, quiet | {EVENT: {"kind": "contact", "between": ["ball", "floor"]}})
    assert problem.rule == "contacts-not-recorded"
    (problem,) = problems(stage, quiet | {MEASURE: {"kind": "penetration", "of": "ball"}})
    assert problem.rule == "contacts-not-recorded"
    assert problems(stage, quiet | {MEASURE: {"kind": "penetration", "of": "ball", "by": "gel"}}) == []
    assert problems(stage, quiet | {MEASURE: {"kind": "penetration", "of": ["gel", "rag"]}}) == []
    (problem,) = problems(stage, quiet | {MEASURE: {"kind": "penetration", "of": ["gel", "ball"]}})
    assert problem.rule == "contacts-not-recorded"


def test_no_touch_of_what_deforms_is_chosen_by_its_impulse(stage):
    (problem,) = problems(stage, {EVENT: {"kind": "contact", "between": ["gel", "floor"], "min_impulse": 0.1}})
    assert (problem.rule, problem.path) == ("contacts-not-recorded", f"{EVENT}/min_impulse")
    assert "forces" in problem.message


@pytest.mark.parametrize("kind", ["rest", "left_domain"])
def test_events_of_one_body(stage, kind):
    domain = {"/scene/domain": {"min": [-9, -9, -9], "max": [9, 9, 9]}}
    assert problems(stage, domain | {EVENT: {"kind": kind, "of": "rag"}}) == []
