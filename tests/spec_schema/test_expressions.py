"""The arithmetic of `${…}`: what it computes, and that nothing else can be done with it."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_case import only_problem, problems_of, small

from text2sim.spec_schema.arithmetic.expressions import parse_expression
from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.load import load_text

NAMES = {
    "rows": 8,
    "brick": [0.24, 0.11, 0.07],
    "speed": 12.5,
    "color": "red",
    "flag": True,
    "table": [[1, 2], [3, 4]],
}


def evaluate(text: str):
    return parse_expression(text).evaluate(NAMES)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7), ("-2 ** 2", -4), ("2 ** -1", 0.5), ("7 // 2", 3), ("-7 % 3", 2), ("rows / 2", 4),
        ("rows / 3", 8 / 3), ("rows * brick[2] - 0.05", 8 * 0.07 - 0.05), ("brick[-1]", 0.07),
        ("table[1][0]", 3), ("sin(pi / 2)", 1.0), ("atan2(1, 1)", math.pi / 4), ("hypot(3, 4)", 5.0),
        ("clamp(7, 0, 5)", 5), ("min(3, 1, 2)", 1), ("max(brick)", 0.24), ("sum(brick)", 0.42),
        ("len(brick)", 3), ("round(2.5)", 2), ("round(pi, 2)", 3.14), ("floor(-0.5)", -1), ("ceil(0.2)", 1),
        ("radians(180)", math.pi), ("log(8, 2)", 3.0), ("rows > 3 and not flag", False), ("1 < 2 < 3", True),
        ("0.1 if rows % 2 == 0 else 0.2", 0.1), ("'a' if color == 'red' else 'b'", "a"),
        ("[1, rows, brick[0]]", [1, 8, 0.24]), ("true or false", True), ("brick", [0.24, 0.11, 0.07]),
        ("tau - 2 * pi", 0.0), ("1e-3", 0.001), ("abs(-3)", 3), ("(1 +\n 2)", 3),
    ],
)  # fmt: skip
def test_values(text, value):
    found = evaluate(text)
    assert found == pytest.approx(value) if isinstance(value, float) else found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1 / 0", "division by zero"), ("5 % 0", "division by zero"), ("0 ** -1", "division by zero"),
        ("sqrt(-1)", "no value"), ("log(0)", "no value"), ("acos(2)", "no value"),
        ("(-8) ** 0.5", "fractional"), ("(9**9)**9", "larger than"), ("9**9**9**9", "larger than"),
        ("exp(1000)", "larger than"), ("1e16", "larger than"), ("10**15 * 10", "larger than"),
        ("brick * 2", "not on lists"), ("brick + brick", "not on lists"),
        ("flag + 1", "true is not a number"), ("color + 'x'", "is not a number"),
        ("'x' * 1000000000", "is not a number"), ("speeed", "unknown name `speeed`"),
        ("brick[3]", "no item 3"), ("brick[0.5]", "whole number"), ("rows[0]", "only lists"),
        ("min()", "takes"), ("min([])", "empty"), ("sin(1, 2)", "takes 1 argument "),
        ("clamp(1, 3, 2)", "lower bound first"), ("sin", "is a function"), ("round(1, 99)", "digits"),
        ("color and flag", "neither true nor false"), ("rows < color", "is not a number"),
    ],
)  # fmt: skip
def test_what_has_no_value_says_why(text, says):
    with pytest.raises(ExpressionError, match=".*") as caught:
        evaluate(text)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')", "().__class__", "open('x')", "rows.real", "lambda: 1",
        "[x for x in brick]", "{1: 2}", "{1, 2}", "(1, 2)", "brick[0:2]", "f'{rows}'", "rows := 3", "1 if",
        "", "   ", "print(1)", "1j", "b'x'", "...", "rows is rows", "1 in brick", "sin(x=1)", "max(*brick)",
        "await rows", "1; 2", "rows = 2", "~1", "1 << 2", "brick @ brick", "sin(1)(2)", "'a' 'b' if", "\x00",
        "ｐｉ", "None", "rows\\\n+1",
    ],
)  # fmt: skip
def test_nothing_but_arithmetic_is_understood(text):
    with pytest.raises(ExpressionError):
        evaluate(text)


def test_parameters_that_are_no_mapping_are_said_to_be_none():
    assert only_problem(small(top="params: ['${d}', 1]", radius="0.1")).path in ("/params", "/params/0")


def test_limits():
    with pytest.raises(ExpressionError, match="longer than"):
        evaluate("1+" * 300 + "1")
    with pytest.raises(ExpressionError, match=r"nested|not arithmetic"):
        evaluate("-" * 400 + "1")
    with pytest.raises(ExpressionError, match=r"nested|not arithmetic"):
        evaluate("(" * 240 + "1" + ")" * 240)
    with pytest.raises(ExpressionError, match=r"not arithmetic|larger than"):
        evaluate("9" * 499)


@given(st.text(alphabet="0123456789.+-*/%()[], <>=!abcdefilnorstx_'\"", max_size=40))
@settings(max_examples=300, deadline=None)
def test_any_text_is_a_small_finite_value_or_is_refused(text):
    try:
        value = evaluate(text)
    except ExpressionError:
        return
    if isinstance(value, int | float):
        assert abs(value) <= 1e15


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("${rows}", 8), ("${brick}", [0.24, 0.11, 0.07]), ("hook[${rows / 2}]", "hook[4]"),
        ("${speed} m", "12.5 m"), ("${flag}!", "true!"), ("a${rows}b${color}", "a8bred"),
        ("$${rows}", "${rows}"), ("$${${rows}}", "${8}"), ("$ {rows}", "$ {rows}"), (" ${rows}", " 8"),
    ],
)  # fmt: skip
def test_whole_expressions_keep_their_type_and_others_become_text(text, value):
    assert parse_interpolation(text).evaluate(NAMES) == value


def test_an_expression_has_to_be_closed():
    with pytest.raises(ExpressionError, match="no closing brace"):
        parse_interpolation("${rows")
    with pytest.raises(ExpressionError, match="cannot be part of a text"):
        parse_interpolation("a ${brick}").evaluate(NAMES)


@pytest.mark.parametrize(
    ("text", "rule", "path", "place", "hint"),
    [
        (
            small(top="params: {a: 1}", radius="${b}"),
            "unknown-name",
            "/bodies/ball/shape/radius",
            (6, 53),
            None,
        ),
        (
            small(top="params: {rows: 1}", radius="${rowz}"),
            "unknown-name",
            "/bodies/ball/shape/radius",
            (6, 53),
            "rows",
        ),
        (small(radius="${sn(1)}"), "unknown-function", "/bodies/ball/shape/radius", (6, 53), "sin"),
        (small(top='params: {a: "${b}", b: "${c}", c: "${a}"}'), "cycle", "/params/a", (3, 13), None),
        (
            small(top='params: {a: "${1/0}", b: "${a}"}', radius="${b}"),
            "expression",
            "/params/a",
            (3, 13),
            None,
        ),
        (small(top="params: {sin: 1}"), "taken-name", "/params/sin", (3, 10), None),
        (small(top="params: {row: 1}"), "taken-name", "/params/row", (3, 10), None),
        (small(top="params: {a: {b: 1}}"), "parameter", "/params/a", (3, 13), None),
        (small(top="params: {a: [1, null]}"), "parameter", "/params/a/1", (3, 17), None),
        (small(radius="${i}"), "copy-variable", "/bodies/ball/shape/radius", (6, 53), None),
        (small(radius="${row + 1}"), "copy-variable", "/bodies/ball/shape/radius", (6, 53), None),
        ("a: [${b, 1]\n", "expression", "", (1, 5), None),
        (small(top="prompt: costs ${ much"), "expression", "/prompt", (3, 9), None),
    ],
)
def test_problems_are_located_and_not_repeated(text, rule, path, place, hint):
    problem = only_problem(text)
    assert (problem.rule, problem.path, (problem.line, problem.column), problem.hint) == (
        rule,
        path,
        place,
        hint,
    )


def test_params_may_use_each_other_in_any_order():
    loaded = load_text(small(top='params: {a: "${b + 1}", b: "${c[0]}", c: [2, "${d}"], d: x}', radius="${a / 10}"))
    assert loaded.data["params"] == {"a": 3, "b": 2, "c": [2, "x"], "d": "x"}
    assert loaded.case.bodies["ball"].shape.radius == 0.3
    assert loaded.raw["params"]["a"] == "${b + 1}"


def test_a_long_chain_of_params_is_no_problem():
    rows = ", ".join(f'a{i}: "${{a{i + 1}}}"' for i in range(400))
    assert load_text(small(top=f"params: {{{rows}, a400: 7}}")).data["params"]["a0"] == 7


def test_every_circle_is_reported_once():
    text = small(top='params: {a: "${b}", b: "${a}", c: "${c}", d: "${a + c}"}')
    assert [(p.rule, p.path) for p in problems_of(text)] == [("cycle", "/params/a"), ("cycle", "/params/c")]


def test_lists_and_texts_that_grow_without_bound_are_refused():
    def grown(first: str, more: str) -> str:
        rows = ", ".join(f'a{i + 1}: "{more.replace("a", f"a{i}")}"' for i in range(20))
        return small(top=f"params: {{a0: {first}, {rows}}}")

    assert only_problem(
        grown(
            "[1, 2]",
            "${["
            + ", ".join(
                [
                    "a",
                ]
                * 100
            )
            + "]}",
        )
    ).message.startswith("the list has more than")
    assert only_problem(grown("xy", "${a}" * 100)).message.startswith("the text is longer than")
    uses = ", ".join(f'b{i}: "${{a}}"' for i in range(300))
    many = small(top=f"params: {{a: [{', '.join(['1'] * 2000)}], {uses}}}")
    assert problems_of(many)[0].rule == "too-large"
