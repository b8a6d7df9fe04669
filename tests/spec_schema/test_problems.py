"""How problems are shown and sorted."""

import json

from small_case import problems_of, small

from text2sim.spec_schema.errors import MAX_SHOWN_PROBLEMS, Problem, SpecError, format_problems, nearest


def test_a_problem_is_shown_with_its_line_and_a_caret():
    text = small(radius="-1")
    assert format_problems(problems_of(text), text).splitlines() == [
        "case.yaml:6:53: error: must be greater than 0 (got -1) [range]",
        "      ball: {kind: rigid, shape: {kind: sphere, radius: -1}}",
        "                                                        ^  at /bodies/ball/shape/radius",
    ]


def test_the_nearest_word_is_named():
    text = small(ball=", materal: {}")
    assert "did you mean `material`? [unknown-key]" in format_problems(problems_of(text), {"case.yaml": text})


def test_long_lines_are_cut_around_the_place():
    text = small(top="prompt: ''", ball=f", look: {{color: {'x' * 300}}}")
    shown = format_problems(problems_of(text), text).splitlines()
    assert max(map(len, shown[1:])) < 160
    assert shown[1][shown[2].index("^") :].startswith("xxx")


def test_of_thousands_of_problems_the_first_are_shown():
    text = small(top="\n".join(f"k{i}: 1" for i in range(5000)))
    shown = format_problems(problems_of(text), text).splitlines()
    assert len(shown) == 3 * MAX_SHOWN_PROBLEMS + 1
    assert shown[-1] == f"… and {5000 - MAX_SHOWN_PROBLEMS} more problems"


def test_without_a_source_there_is_no_excerpt():
    assert len(format_problems(problems_of(small(radius="-1"))).splitlines()) == 1


def test_problems_are_sorted_by_place_and_said_once():
    late, early = Problem("/b", "x", 2, 1), Problem("/a", "y", 1, 7)
    assert SpecError([late, early, late]).problems == [early, late]


def test_a_problem_is_plain_data_for_machines():
    problem = Problem("/a", "x", 2, 1, "f.yaml", "b", "rule")
    assert json.loads(json.dumps(problem.as_dict())) == {
        "path": "/a",
        "message": "x",
        "line": 2,
        "column": 1,
        "file": "f.yaml",
        "hint": "b",
        "rule": "rule",
        "severity": "error",
    }


def test_nearest_words():
    assert nearest("radious", ["radius", "height"]) == "radius"
    assert nearest("Sphere", ["sphere", "box"]) == "sphere"
    assert nearest("zzz", ["sphere", "box"]) is None
    assert nearest(None, ["sphere"]) is None


def test_bounds_that_are_open_are_named():
    jelly = "{kind: soft, shape: {kind: sphere, radius: 0.1}, material: {poisson_ratio: 0.5}}"
    (problem,) = problems_of(small().rstrip() + f"\n  a: {jelly}\n")
    assert problem.message == "must be at least 0, and less than 0.5 (got 0.5)"


def test_kinds_go_by_other_names():
    (problem,) = problems_of(small().rstrip() + "\n  a: {kind: sand, shape: {kind: sphere, radius: 0.1}}\n")
    assert problem.hint == "granular"
    (problem,) = problems_of(small().rstrip() + "\n  a: {kind: soft, shape: {kind: sheet, size: [1, 1]}}\n")
    assert (problem.hint, problem.message.endswith("only a cloth can be a sheet")) == (None, True)


def test_text_that_only_looks_like_a_mapping_is_told_why():
    for character, called in (("\u00a0", "NO-BREAK SPACE"), ("\uff1a", "FULLWIDTH COLON")):
        text = f"text2sim: 2\nname: x\nscene:\n  duration{':' if called[0] == 'N' else ''}{character}1\nbodies: {{}}\n"
        assert called in format_problems(problems_of(text), text)
