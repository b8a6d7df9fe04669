"""Words of a place that do not go together are located errors with the way out; the others are left alone."""

import pytest

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.models.placement import RELATIONS, Place
from text2sim.spec_schema.names.references import check_references

BALL = "/bodies/ball"


def problems_of(stage, place, repeat=None):
    edits = {f"{BALL}/pose": None, f"{BALL}/place": place, "/actions": {}}
    return check_references(stage(edits | ({f"{BALL}/repeat": repeat} if repeat else {})))


FIRING = [
    # relation, other words, key, what is said
    ("left_of", {"at": [0, 0]}, "at", "`at` has no effect with `left_of`; use `align` and `offset`"),
    ("around", {"at": {"edge": "left"}}, "at", "`at` has no effect with `around`"),
    ("touching", {"at": [0, 0]}, "at", "give a region of the other, such as `{face: top}`"),
    ("on", {"inset": 0.1}, "inset", "`inset` needs a side, an edge or a corner"),
    ("on", {"at": [0, 0], "inset": 0.1}, "inset", "`inset` needs"),
    ("on", {"at": {"nearest": [0, 0, 0]}, "inset": 0.1}, "inset", "`inset` needs"),
    ("touching", {"at": {"edge": "left"}, "inset": 0.1}, "inset", "`inset` needs"),
    ("on", {"direction": "x"}, "direction", "it belongs to beside and touching"),
    ("left_of", {"direction": "x"}, "direction", "it belongs to beside and touching"),
    ("beside", {"direction": "z"}, "direction", "use `above` or `below` for other heights"),
    ("beside", {"direction": [1, 0, 0.1]}, "direction", "z of `direction` must be 0"),
    ("on", {"align": "top"}, "align", "`on` already determines the height"),
    ("below", {"align": "top"}, "align", "use `clearance` or `offset` for a gap"),
    ("above", {"align": {"z": "min"}}, "align", "`above` already determines the height"),
    ("on", {"at": [0, 0], "align": {"x": "min"}}, "align", "`at` already determines x"),
    ("on", {"at": {"edge": "left"}, "align": {"y": "min"}}, "align", "`at` already determines y"),
    ("right_of", {"align": {"x": "min"}}, "align", "`right_of` already determines x"),
    ("behind", {"align": {"x": "min", "y": "max"}}, "align", "`behind` already determines y"),
    (
        "beside",
        {"direction": [1, 1, 0], "align": {"y": "max"}},
        "align",
        "`beside` already determines y by its direction",
    ),
    ("touching", {"align": "top"}, "align", "`touching` already determines the height"),
    (
        "touching",
        {"direction": "x", "at": {"face": "top"}, "align": "top"},
        "align",
        "`at` already determines the height",
    ),
    ("around", {"align": {"x": "center"}}, "align", "`around` already determines x"),
    ("right_of", {"align": {}}, "align", "is empty"),
]
SILENT = [
    ("on", {"at": {"corner": ["left", "front"]}, "inset": 0.1, "offset": [0, 0, 1], "clearance": 0.1}),
    ("on", {"align": {"x": "min", "y": "max"}}),
    ("inside", {"at": {"edge": "left"}, "inset": 0.01}),
    ("left_of", {"align": {"y": "min", "z": "max"}}),
    ("beside", {"direction": "y", "align": {"x": "max", "z": "center"}}),
    ("beside", {"direction": [-1, 2, 0], "align": "top"}),
    ("touching", {"direction": "y", "align": {"x": "max", "z": "center"}}),
    ("touching", {"direction": [1, 1, 1], "at": {"edge": ["left", "top"]}}),
    ("around", {"align": "bottom"}),
    ("around", {"facing": "drum"}),
]


@pytest.mark.parametrize(("relation", "words", "key", "said"), FIRING)
def test_what_does_not_go_together_is_located(stage, relation, words, key, said):
    (problem,) = problems_of(stage, {relation: "drum", **words})
    assert (problem.path, problem.rule) == (f"{BALL}/place/{key}", "placement")
    assert said in problem.message


@pytest.mark.parametrize(("relation", "words"), SILENT)
def test_what_goes_together_is_left_alone(stage, relation, words):
    assert problems_of(stage, {relation: "drum", **words}) == []


def test_all_contradictions_are_said_at_once(stage):
    found = problems_of(stage, {"left_of": "drum", "at": [0, 0], "direction": "x", "align": {"x": "min"}, "inset": 1})
    assert [problem.path.rsplit("/")[-1] for problem in found] == ["at", "inset", "direction", "align"]


def test_two_relations_are_one_too_many(stage):
    with pytest.raises(SpecError) as caught:
        stage({f"{BALL}/pose": None, f"{BALL}/place": {"on": "floor", "left_of": "drum"}})
    (problem,) = caught.value.problems
    assert problem.path == f"{BALL}/place"
    assert "is needed (got on, left_of); align, at and offset refine it" in problem.message


@pytest.mark.parametrize("relation", RELATIONS)
def test_every_relation_takes_a_name_and_offers_the_nearest(stage, relation):
    (problem,) = problems_of(stage, {relation: "drun"})
    assert (problem.path, problem.hint) == (f"{BALL}/place/{relation}", "drum")


def test_what_it_faces_is_there_and_is_another(stage):
    (problem,) = problems_of(stage, {"on": "floor", "facing": "drun"})
    assert (problem.path, problem.hint) == (f"{BALL}/place/facing", "drum")
    (problem,) = problems_of(stage, {"on": "floor", "facing": "ball"})
    assert problem.rule == "itself"


def test_partners_are_counted(stage):
    eight = {"kind": "line", "count": 8, "step": [1, 0, 0]}
    assert problems_of(stage, {"on": "hook[*]"}, eight) == []
    assert problems_of(stage, {"on": "brick[4:12]"}, eight) == []
    assert problems_of(stage, {"on": "brick"}, eight) == []
    assert problems_of(stage, {"on": "brick[3]"}, eight) == []
    assert problems_of(stage, {"on": "brick[*]"}) == []  # one ball on all of them
    (problem,) = problems_of(stage, {"on": "brick[*]"}, eight)
    assert (problem.rule, problem.path, problem.hint) == ("pairs", f"{BALL}/place/on", "brick")
    assert "`brick[*]` selects 12 and `ball` has 8; `brick` means all of them together" in problem.message


def test_heights_have_words_of_their_own():
    ends = [Place.model_validate({"right_of": "a", "align": word}).alignment(2) for word in ("top", "center", "bottom")]
    assert ends == ["max", "center", "min"]
    assert Place.model_validate({"right_of": "a", "align": "top"}).alignment(0) is None
