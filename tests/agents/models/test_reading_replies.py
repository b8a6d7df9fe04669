"""What a reply says is data, wherever it stands in it; everything else is told in a line."""

import time
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from text2sim.agents.models.fences import with_last_fence
from text2sim.agents.models.parsing import MAX_REPLY_LENGTH, ReplyError, read_reply

FENCE = "```"


def fenced(text: str, mark: str = "yaml") -> str:
    return f"{FENCE}{mark}\n{text}\n{FENCE}\n"


@pytest.mark.parametrize(
    ("reply", "data"),
    [
        (fenced("a: 1\nb: [x, no]"), {"a": 1, "b": ["x", "no"]}),
        (f"Sure!\n\n{fenced('a: 1')}\nThat is it.", {"a": 1}),
        (fenced("a: 1") + "or rather\n" + fenced("a: 2"), {"a": 2}),
        (fenced("a: 1") + "or rather\n```yaml\na: [", {"a": 1}),
        (fenced("print(1)", "python") + fenced("a: 1", "") + fenced("ls", "sh"), {"a": 1}),
        (fenced("b: 2", "") + fenced("a: 1") + fenced("c: 3", ""), {"a": 1}),
        ("~~~yaml\na: 1\n~~~", {"a": 1}),
        ("````yaml\na: |\n  x\n```\n````".replace("\n```\n", "\n"), {"a": "x\n"}),
        ("```YAML title=case\r\na: 1\r\n```\r\n", {"a": 1}),
        (f"1. Do this:\n   {FENCE}yaml\n   a:\n     b: 1\n   {FENCE}\n", {"a": {"b": 1}}),
        (fenced("a: |\n  ```sh\n  ls\n  ```\nb: 1"), {"a": "```sh\nls\n```\n", "b": 1}),
        ("a: 1\nb:\n  - c\n", {"a": 1, "b": ["c"]}),
        ("Here you go:\n\na: 1\nb:\n  - c\n\nHope it helps!\n", {"a": 1, "b": ["c"]}),
        ("- op: add\n  path: /a\n", [{"op": "add", "path": "/a"}]),
        ('{"a": {"b": "}"}}', {"a": {"b": "}"}}),
        ('I would say {"a": [1, 2]} here.', {"a": [1, 2]}),
        ('Well:\n[{"op": "remove", "path": "/x"}]\nas above', [{"op": "remove", "path": "/x"}]),
        (fenced('{"a": 1, // one\n "b": [1, 2,], /* two\n lines */ "u": "http://x//y",}', "json"),
         {"a": 1, "b": [1, 2], "u": "http://x//y"}),
        (fenced("{kind: box, url: http://x.y/z, size: [1, 2]}"), {"kind": "box", "url": "http://x.y/z", "size": [1, 2]}),
        (r'{"a": "\ud83d\ude00 \u00e9 \/ \\ud83d"}', {"a": "😀 é / \\ud83d"}),
        (fenced('{"p": "${rows * 2}", "of": "brick[*]"}', "json"), {"p": "${rows * 2}", "of": "brick[*]"}),
        ("<think>\n```yaml\na: 0\n```\n</think>\n\nb: 1", {"b": 1}),
        ("\ufeffa: 1", {"a": 1}),
        (fenced("a: {what: red, blue, sort: x}\nb: [{c: rgb(1, 2, 3), d: ${max(1, 2)}, e: }]\nf:"),
         {"a": {"what": "red, blue", "sort": "x"}, "b": [{"c": "rgb(1, 2, 3)", "d": "${max(1, 2)}", "e": None}],
          "f": None}),
        (fenced('a: {what: it says "no",\n  and \\ goes, sort: x}'), {"a": {"what": 'it says "no", and \\ goes', "sort": "x"}}),
        (fenced("a: on\nn: 010\nt: 12:30\nx: 1e-3"), {"a": "on", "n": 10, "t": "12:30", "x": 0.001}),
    ],
)  # fmt: skip
def test_data_is_found(reply: str, data: object) -> None:
    assert read_reply(reply).data == data


def test_the_block_comes_along_as_it_was_written() -> None:
    assert read_reply(f"x\n{fenced('a: 1  # why')}y").text == "a: 1  # why"


def test_what_is_written_once_and_meant_several_times_is_read() -> None:
    text = """
bodies:
  one: &one {kind: rigid, shape: &stick {kind: box, size: [1, 2, 3]}, friction: 0.5}
  two: {<<: *one, friction: 0.8}
  three: {shape: *stick, size: &n 4, more: [*n, *n]}
  four: *one
"""
    bodies = read_reply(fenced(text)).data["bodies"]
    stick = {"kind": "box", "size": [1, 2, 3]}
    assert bodies["two"] == {"kind": "rigid", "shape": stick, "friction": 0.8}
    assert bodies["three"] == {"shape": stick, "size": 4, "more": [4, 4]}
    assert bodies["four"] == bodies["one"] == {"kind": "rigid", "shape": stick, "friction": 0.5}
    assert bodies["four"]["shape"] is not bodies["one"]["shape"], "a change of one is none of the other"


@pytest.mark.parametrize(
    ("reply", "line", "words"),
    [
        ("", 1, "the reply is empty"),
        ("I cannot do that.", 1, "no block of data"),
        (fenced("import os\nos.system('x')", "python"), 1, "no block of data"),
        ("so:\n```yaml\na: 1\nb:", 2, "not closed"),
        ('so\n\n{"a": 1', 3, "not closed"),
        (fenced("just words"), 2, "no mapping and no list"),
        ("hm\n" + fenced("a: 1\nb: 2\na: 3"), 5, "the key `a` is already in line 3"),
        (fenced("a: *x"), 2, "no value before is marked as `&x`"),
        (fenced("a: &x [1, *x]"), 2, "no value before is marked as `&x`"),
        (fenced("a: !!python/object/apply:os.system ['echo hi']"), 2, "tags"),
        (fenced("a: .nan"), 2, "not a finite number"),
        (fenced("a: 1e999"), 2, "too large"),
        (fenced("a: " + "[" * 61 + "]" * 61), 2, "nested more than"),
        ("[" * 61 + "]" * 61, 1, "nested more than"),
        (fenced('{"a": "\\u0000"}', "json"), 2, "not allowed"),
        (fenced("a: \x07"), 2, "not allowed"),
        (fenced("a: 1\n---\nb: 2"), 3, "one document"),
        ("<think>\n\n</think>\n" + fenced("a: [1"), 6, "opened in line 5"),
        (fenced("a: " + "${" * 600), 2, "expressions"),
        (fenced('a: 1\nb: {what: "a, b", c, sort: x}'), 3, "`c` has no value"),
        (fenced("a: {what: red, # the ball\n  blue, sort: x}"), 3, "`blue` has no value"),
        (" " * (MAX_REPLY_LENGTH + 1), 1, "characters"),
    ],
)
def test_what_is_no_data_is_told_with_its_line(reply: str, line: int, words: str) -> None:
    with pytest.raises(ReplyError, match=words) as caught:
        read_reply(reply)
    assert caught.value.problems[0].line == line
    assert str(caught.value).startswith(f"reply:{line}:")
    assert len(str(caught.value)) < 3_000


def test_many_problems_end_in_a_short_text() -> None:
    with pytest.raises(ReplyError, match="more problems") as caught:
        read_reply("a: 1\n" * 5_000)
    assert len(str(caught.value)) < 3_000


HOSTILE = {
    "brackets": "[" * 900_000,
    "braces": "{ " * 499_999,
    "fences": "```\n" * 240_000,
    "quotes": '{"' * 400_000,
    "backslashes": '{"a' + "\\" * 900_000,
    "comments": "{/*" * 300_000,
    "thoughts": "<think>" * 140_000,
    "blanks": " " * 900_000 + "x",
    "ticks": "`" * 990_000,
    "mark": "``` " + " " * 900_000 + "`",
    "expressions": fenced(("a: " + "${" * 400 + "\n") * 1_000),
    "laughs": fenced("b0: &b0 [x, x]\n" + "".join(f"b{i + 1}: &b{i + 1} [*b{i}, *b{i}]\n" for i in range(50))),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_replies_cost_little_time(name: str) -> None:
    start = time.process_time()
    with pytest.raises(ReplyError):
        read_reply(HOSTILE[name])
    assert time.process_time() - start < 5


PIECES = [
    "```",
    "```yaml\n",
    "\n",
    "a: ",
    "{",
    "}",
    "[",
    "]",
    '"',
    "'",
    "\\",
    "//",
    "/*",
    "- ",
    "${",
    "<think>",
    "\t",
    ":",
]


@settings(max_examples=150, deadline=None)
@given(st.lists(st.sampled_from(PIECES) | st.text(max_size=4), max_size=25).map("".join))
def test_whatever_comes_is_data_or_a_reply_error(text: str) -> None:
    data: object = []
    with suppress(ReplyError):
        data = read_reply(text).data
    assert isinstance(data, dict | list)


@pytest.mark.parametrize("fence", ["```", "~~~~", "  ```"])
def test_a_complete_reply_may_lack_its_last_fence(fence: str) -> None:
    before = f"So.\n```yaml\na: 0\n```\nNo, so:\n{fence}yaml\na: 1"
    assert with_last_fence(before) == f"{before}\n{fence}"
    assert read_reply(with_last_fence(before))[0] == {"a": 1}
    for whole in ("no block", f"{before}\n{fence}", f"<think>\n```\n</think>\n{before}\n{fence}"):
        assert with_last_fence(whole) == whole
