"""What the language takes of YAML, and that hostile text ends in one located message."""

import os
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_case import only_problem, problems_of, small

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.canonical import format_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import MAX_BYTES, Source, check_source, decode_source, read_source


def value_of(text: str):
    """What one plain scalar means."""
    return parse_document(Source(f"x: {text}")).data["x"]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("no", "no"), ("yes", "yes"), ("on", "on"), ("y", "y"), ("True", True), ("false", False),
        ("null", None), ("~", None), ("", None), ("010", 10), ("0o10", 8), ("0x1F", 31), ("+7", 7), ("-0", 0),
        ("1e-3", 0.001), ("1E5", 1e5), (".5", 0.5), ("7.", 7.0), ("12:30", "12:30"), ("1_000", "1_000"),
        ("2001-01-01", "2001-01-01"), ("1.2.3", "1.2.3"), ("'1'", "1"), ('"true"', "true"), ("=", "="),
        ("0b11", "0b11"),
    ],
)  # fmt: skip
def test_scalars_are_those_of_the_core_schema(text, value):
    found = value_of(text)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize("text", [".nan", "-.inf", ".INF", "1e999", "1" + "0" * 5000])
def test_numbers_are_finite(text):
    problem = only_problem(small(radius=text))
    assert (problem.rule, problem.line, problem.column) == ("number", 6, 53)


def test_a_key_is_given_once():
    problem = only_problem("text2sim: 1\nname: a\nscene:\n  dt: 1\n  duration: 2\n  dt: 2\n")
    assert (problem.rule, problem.path, problem.line, problem.column) == ("duplicate-key", "/scene/dt", 6, 3)
    assert "line 4" in problem.message


@pytest.mark.parametrize(
    ("text", "rule", "line", "column"),
    [
        ("a: &x 1\nb: *x\n", "alias", 1, 4),
        ("a: [*x]\n", "alias", 1, 5),
        ("a: 1\n<<: *x\n", "alias", 2, 5),
        ("a: !!python/object:os.system 1\n", "tag", 1, 4),
        ("a: !include x\n", "tag", 1, 4),
        ("a: 1\n---\nb: 2\n", "documents", 2, 1),
        ("a: 1\n? [b]\n: 2\n", "key", 2, 3),
        ("a: {b: 1\n", "syntax", 2, 1),
        ("a: 'b\nc: 1\n", "syntax", 1, 4),
        ("a:\n\tb: 1\n", "syntax", 2, 1),
        ("a: @b\n", "syntax", 1, 4),
        ("a: b: c\n", "syntax", 1, 5),
        ("a:\n  b: 1\n c: 2\n", "syntax", 3, 2),
        ('a: "\\0"\n', "character", 1, 4),
        ('a: "\\u202e"\n', "character", 1, 4),
        ('a: "\\ue000"\n', "character", 1, 4),
        ("", "empty", 1, 1),
        ("# nothing\n", "empty", 1, 1),
        ("- 1\n", "type", 1, 1),
        ("just text\n", "type", 1, 1),
    ],
)
def test_what_is_left_out_of_yaml_is_refused_where_it_stands(text, rule, line, column):
    problem = only_problem(text)
    assert (problem.rule, problem.line, problem.column) == (rule, line, column), problem


@pytest.mark.parametrize(
    ("data", "rule", "line", "column"),
    [
        (b"a: 1\nb: \xff\n", "encoding", 2, 4),
        ("a: 1".encode("utf-16"), "encoding", 1, 1),
        (b"a: 1\nb: x\x00y\n", "character", 2, 5),
        ("a: x\u202ey\n".encode(), "character", 1, 5),
        ("a: \ue001\n".encode(), "character", 1, 4),
        (b"a: 1\n" * 400_001, "too-large", 1, 1),
    ],
)
def test_bytes_that_are_not_plain_text_are_refused(data, rule, line, column):
    with pytest.raises(SpecError) as caught:
        check_source(decode_source(data))
    (problem,) = caught.value.problems
    assert (problem.rule, problem.line, problem.column) == (rule, line, column)


def test_a_byte_order_mark_at_the_start_and_windows_line_ends_are_accepted():
    text = small().replace("\n", "\r\n")
    source = check_source(decode_source(b"\xef\xbb\xbf" + text.encode()))
    loaded = load_text(source.text)
    assert loaded.line("/bodies/ball") == 6


def test_separators_of_unicode_are_no_line_ends():
    loaded = load_text(small(top="prompt: one\u2028two\x85three"))
    assert loaded.case.prompt == "one\u2028two\x85three"
    assert loaded.line("/bodies/ball") == 6


def test_an_alias_bomb_costs_nothing():
    rows = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    rows += [f"a{i}: &a{i} [{', '.join(f'*a{i - 1}' for _ in range(9))}]" for i in range(1, 30)]
    assert only_problem("\n".join(rows)).rule == "alias"


def test_size_depth_and_length_are_bounded():
    assert only_problem("a: " + "[" * 900 + "]" * 900).rule == "too-deep"
    assert only_problem("a: " + "[" * 100_000).rule in ("too-deep", "syntax")
    assert only_problem("a: " + "{a: " * 45 + "1" + "}" * 45).rule == "too-deep"
    assert only_problem("a: " + "x" * 20_001).rule == "too-large"
    assert only_problem("a: [" + "1," * 300_001 + "]").rule == "too-large"
    assert only_problem("#" + "x" * MAX_BYTES).rule == "too-large"


def test_a_missing_file_is_a_problem_of_the_case(tmp_path):
    for path in (tmp_path / "no.yaml", tmp_path):
        with pytest.raises(SpecError) as caught:
            read_source(path)
        assert caught.value.problems[0].rule == "unreadable"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system")
def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "case.yaml")
    with pytest.raises(SpecError, match="regular file"):
        read_source(tmp_path / "case.yaml")


def test_expressions_and_selectors_need_no_quotes():
    data = parse_document(Source("a: {b: ${x[0]}, c: [${y, 1}, brick[*], arm[1].hand, hook[${i + 1}]]}\n")).data
    assert data == {"a": {"b": "${x[0]}", "c": ["${y, 1}", "brick[*]", "arm[1].hand", "hook[${i + 1}]"]}}


def test_quotes_inside_a_quoted_expression():
    text = """a: "${'x' if i else \\"y\\"}"\nb: '${''x'' if i else "y"}'\n"""
    assert parse_document(Source(text)).data == {"a": "${'x' if i else \"y\"}", "b": "${'x' if i else \"y\"}"}


def test_masking_moves_nothing():
    text = "a: {b: ${x: {}, #!&*}, c: [1, 2}\n"
    (problem,) = problems_of(text)
    assert (problem.line, problem.column) == (1, text.index("}\n") + 1)


@given(st.text(alphabet=" \n\t#:-?[]{},&*!|>'\"%@`ab0$\\", max_size=60))
@settings(max_examples=150, deadline=None)
def test_any_text_loads_or_is_refused_with_places_inside_it(text):
    lines = re.split(r"\r\n|\r|\n", text)
    for problem in problems_of(text):
        assert 1 <= problem.line <= len(lines) + 1
        assert problem.column >= 1
        assert problem.message


@pytest.mark.parametrize(
    ("line", "at", "words"),
    [
        ("prompt:what falls", 0, "a key needs a colon and a space after it"),
        ("prompt what falls", 0, "a key needs a colon and a space after it"),
        ("params: {color: #ff8800}", 16, "`#` begins a comment; put the colour in quotes"),
        ('params: {a: "${pi}, b: {c: 1}}', 12, "the quote that starts here is never closed"),
        ("params: {a: ${pi", 12, "`${` has no closing brace"),
    ],
)
def test_slips_are_blamed_where_they_are(line, at, words):
    text = f"text2sim: 2\n{line}\nname: x\n"
    with pytest.raises(SpecError) as caught:
        load_text(text)
    (problem,) = caught.value.problems
    assert words in problem.message
    assert (problem.line, problem.column) == (2, at + 1)


@pytest.mark.parametrize("quote", ['"', "'"])
def test_an_expression_that_is_not_closed_ends_with_its_quotes(quote):
    """The brace behind the quote is that of the mapping: the file is YAML, and everything in it is looked at."""
    text = f"text2sim: 2\nname: x\nparams: {{a: {{h: {quote}${{pi{quote}}}, b: 1}}\nscene: {{duration: -1}}\n"
    assert parse_document(Source(text)).data["params"] == {"a": {"h": "${pi"}, "b": 1}
    assert f"h: {quote}${{pi{quote}" in format_text(text).replace('"', quote)
    found = {(problem.line, problem.column): problem.message for problem in problems_of(text)}
    assert "`${` has no closing brace" in found[3, 17]
    assert (4, 19) in found


def test_a_brace_that_is_not_closed_says_where_it_was_opened():
    with pytest.raises(SpecError) as caught:
        load_text("text2sim: 2\nname: x\nparams: {a: 1\nscene: {}\n")
    assert "a comma or a closing `}` is missing (opened in line 3, column 9)" in caught.value.problems[0].message


@pytest.mark.parametrize(
    ("radius", "words"),
    [
        ("10cm", "leave out the unit"),
        ("'0.1'", "leave out the quotes"),
        ("$r", "write an expression as ${…}"),
        ("0 1", "put commas between numbers"),
        ("large", "needs a number greater than 0 (got the text 'large')"),
    ],
)
def test_text_where_a_number_is_needed(radius, words):
    assert words in only_problem(small(radius=radius)).message
