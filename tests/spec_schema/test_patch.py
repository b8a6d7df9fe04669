"""JSON Patch: what each operation does, what is refused and why, and that a patch can be undone."""

import copy
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from patch_strategies import VALUES, op, patches

from text2sim.spec_schema.changes.operation import split_pointer
from text2sim.spec_schema.changes.patch import (
    MAX_OPERATIONS,
    PatchError,
    apply_operations,
    inverse,
    same,
)

LAX = settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))


# The rules of RFC 6902 and 6901, one or two rows for each: document, patch, result.
DONE = [
    ("nothing to do", {"a": 1}, [], {"a": 1}),
    ("a new key", {"a": 1}, [op("add", "/b", [1, {"c": 2}])], {"a": 1, "b": [1, {"c": 2}]}),
    ("add takes the place of what is there", {"a": None}, [op("add", "/a", 1)], {"a": 1}),
    ("add null", {}, [op("add", "/a", None)], {"a": None}),
    ("add to the document itself", {"a": 1}, [op("add", "", [])], []),
    ("an empty key", {}, [op("add", "/", 1)], {"": 1}),
    ("an empty key inside", {"a": {}}, [op("add", "/a/", 1)], {"a": {"": 1}}),
    ("digits are a key of a mapping", {"a": 1}, [op("add", "/0", "x")], {"a": 1, "0": "x"}),
    ("before an item", ["a", "c"], [op("add", "/1", "b")], ["a", "b", "c"]),
    ("after the last item", ["a"], [op("add", "/1", "b")], ["a", "b"]),
    ("at the end", [1, [2, [3]]], [op("add", "/1/1/-", 4)], [1, [2, [3, 4]]]),
    ("a list is one item", ["a"], [op("add", "/0", ["b"])], [["b"], "a"]),
    ("remove a key", {"a": 1, "b": 2}, [op("remove", "/b")], {"a": 1}),
    ("remove shifts", [1, 2, 3, 4], [op("remove", "/1"), op("remove", "/2")], [1, 3]),
    ("replace by another type", {"a": [{"b": 1}]}, [op("replace", "/a/0/b", {"c": []})], {"a": [{"b": {"c": []}}]}),
    ("replace null", {"a": None}, [op("replace", "/a", "x")], {"a": "x"}),
    ("replace the document", {"a": 1}, [op("replace", "", {"b": 2})], {"b": 2}),
    ("move", {"a": {"x": 1}, "b": {}}, [op("move", "/b/y", source="/a/x")], {"a": {}, "b": {"y": 1}}),
    ("move over something", {"a": 1, "b": 2}, [op("move", "/b", source="/a")], {"b": 1}),
    ("move up", {"a": {"b": 1}}, [op("move", "/a", source="/a/b")], {"a": 1}),
    ("move inside a list", [1, 2, 3], [op("move", "/2", source="/0")], [2, 3, 1]),
    ("move from an item that goes", [{"q": 1}], [op("move", "/1", source="/0/q")], [{}, 1]),
    ("move to where it is", {"a": 1}, [op("move", "/a", source="/a")], {"a": 1}),
    ("move null", {"a": None}, [op("move", "/b", source="/a")], {"b": None}),
    ("copy", {"a": [1]}, [op("copy", "/b", source="/a")], {"a": [1], "b": [1]}),
    ("a copy is another thing", {"a": [1]}, [op("copy", "/b", source="/a"), op("add", "/a/-", 2)], {"a": [1, 2], "b": [1]}),
    ("so is a value", {}, [op("add", "/a", [1]), op("copy", "/b", source="/a"), op("remove", "/b/0")], {"a": [1], "b": []}),
    ("test", {"a": {"b": [1, {"c": None}]}}, [op("test", "/a", {"b": [1.0, {"c": None}]})], {"a": {"b": [1, {"c": None}]}}),
    ("test forgets the order", {"a": {"x": 1, "y": 2}}, [op("test", "", {"a": {"y": 2, "x": 1}})], {"a": {"y": 2, "x": 1}}),
    ("escapes", {"a/b": 1, "m~n": 2, "~1": 3}, [op("remove", "/a~1b"), op("remove", "/m~0n"), op("remove", "/~01")], {}),
    ("signs that mean nothing", {"c%d": 1, "e^f": 2, " ": 3, 'k"l': 4}, [op("remove", "/c%d"), op("remove", "/ ")], {"e^f": 2, 'k"l': 4}),
    ("what looks like a number", {"1e0": 1}, [op("test", "/1e0", 1)], {"1e0": 1}),
]  # fmt: skip

REFUSED = [
    ("not a mapping", {}, ["remove"], "an operation is a mapping"),
    ("no op", {}, [{"path": "/a"}], "`op` is missing"),
    ("unknown op", {}, [op("replce", "/a", 1)], "did you mean `replace`?"),
    ("an op that is no text", {}, [{"op": ["add"], "path": "/a"}], "unknown op"),
    ("no path", {}, [{"op": "remove"}], "`path` is missing"),
    ("no value", [1], [op("add", "/-")], "`value` is missing"),
    ("no from", [1], [op("move", "/-")], "`from` is missing"),
    ("a member too many", {"a": 1}, [{**op("remove", "/a"), "value": 1}], "unknown member `value`; `remove` takes op, path"),
    ("a misspelt member", {"a": 1}, [{"op": "move", "fro": "/a", "path": "/b"}], "did you mean `from`?"),
    ("a path that is none", {"a": 1}, [op("remove", "a")], "a path starts with `/`: `/a`"),
    ("dots", {"a": {"b": 1}}, [op("remove", "a.b")], "`/a/b`"),
    ("null for a path", {}, [{"op": "add", "path": None, "value": 1}], "a path is a text"),
    ("a bad escape", {"a": 1}, [op("remove", "/a~2")], "`~0`"),
    ("a tilde at the end", {"a": 1}, [op("remove", "/~")], "`~0`"),
    ("not there", {"radius": 1}, [op("remove", "/radus")], "there is no `radus` in the document; did you mean `radius`?"),
    ("replace what is not there", {}, [op("replace", "/a", 1)], "there is no `a`"),
    ("no way to it", {"q": {}}, [op("add", "/a/b", 1)], "there is no `a` in the document"),
    ("into a scalar", {"a": 1}, [op("add", "/a/b", 1)], "/a is neither a mapping nor a list"),
    ("beyond the end", {"a": [1, 2]}, [op("add", "/a/3", 1)], "/a has 2 items"),
    ("an item that is not there", [1], [op("remove", "/1")], "the document has 1 item,"),
    ("of an empty list", [], [op("remove", "/0")], "the document is empty"),
    ("a huge index", [1], [op("remove", "/" + "9" * 500)], "no item 999999999"),
    ("a negative index", [1], [op("add", "/-1", 1)], "counted from 0"),
    ("a leading zero", ["a", "b"], [op("test", "/01", "b")], "without leading zeros"),
    ("a float for an index", ["a", "b"], [op("test", "/1e0", "b")], "counted from 0"),
    ("digits of another script", ["a", "b"], [op("test", "/\u0661", "b")], "counted from 0"),
    ("a key for an index", [1], [op("add", "/a", 1)], "is a list"),
    ("the end is no item", [1], [op("remove", "/-")], "means an item to add"),
    ("copy from the end", [1], [op("copy", "/0", source="/-")], "means an item to add"),
    ("into itself", {"a": {"b": {}}}, [op("move", "/a/b/c", source="/a")], "into itself"),
    ("the document", {"a": 1}, [op("remove", "")], "the whole document"),
    ("another value", {"a": 7800}, [op("test", "/a", 500)], "/a is 7800, not 500"),
    ("text is no number", {"a": 10}, [op("test", "/a", "10")], "the text '10'"),
    ("true is not 1", {"a": True}, [op("test", "/a", 1)], "/a is true, not 1"),
    ("not a number", {}, [op("add", "/a", [float("nan")])], "nan is not a finite number"),
    ("infinite", {}, [op("add", "/a", {"b": float("-inf")})], "-inf is not a finite number"),
    ("too large", {}, [op("add", "/a", 10**16)], "too large"),
    ("not plain data", {}, [op("add", "/a", {1, 2})], "a case cannot contain set"),
    ("a key that is no text", {}, [op("add", "/a", {1: 2})], "a key is a text"),
    ("control characters", {}, [op("add", "/a", "\x1b[31m")], "U+001B is not allowed"),
    ("in a key", {}, [op("add", "/\x00", 1)], "U+0000 is not allowed"),
    ("a long text", {}, [op("add", "/a", "x" * 20_001)], "longer than 20000"),
]  # fmt: skip


@pytest.mark.parametrize(("document", "patch", "result"), [row[1:] for row in DONE], ids=[row[0] for row in DONE])
def test_what_operations_do(document: Any, patch: list[dict[str, Any]], result: Any):
    before = copy.deepcopy(document)
    assert same(apply_operations(document, patch), result)
    assert document == before
    assert same(apply_operations(result, inverse(document, patch)), document)


@pytest.mark.parametrize(("document", "patch", "reason"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED])
def test_what_is_refused(document: Any, patch: list[Any], reason: str):
    before = copy.deepcopy(document)
    first = [op("test", "", document)]
    with pytest.raises(PatchError) as refused:
        apply_operations(document, [*first, *patch])
    assert reason in str(refused.value)
    assert refused.value.index == 1
    assert str(refused.value).startswith("operation 2")
    assert document == before


def test_a_patch_is_a_list_of_no_more_than_so_many():
    with pytest.raises(PatchError, match="a list of operations"):
        apply_operations({}, {"op": "remove", "path": "/a"})  # type: ignore[arg-type]
    with pytest.raises(PatchError, match=f"more than {MAX_OPERATIONS}"):
        apply_operations({}, [op("add", "/a", 1)] * (MAX_OPERATIONS + 1))


def test_a_document_cannot_grow_without_end():
    with pytest.raises(PatchError, match="more than 300000 values"):
        apply_operations({"a": [0] * 10}, [op("copy", "/a/-", source="/a")] * 40)
    deep: Any = 1
    for _ in range(30):
        deep = [deep]
    assert apply_operations({"a": 1}, [op("replace", "/a", deep)])
    with pytest.raises(PatchError, match="nested more than 40 deep"):
        apply_operations({"a": deep}, [op("copy", "/a" + "/0" * 15, source="/a")])
    with pytest.raises(PatchError, match="nested more than 40 deep"):
        apply_operations({"a": deep, "b": deep}, [op("move", "/a" + "/0" * 15, source="/b")])


def test_nothing_is_done_if_one_operation_cannot_be():
    data = {"a": {"b": [1]}}
    with pytest.raises(PatchError):
        apply_operations(data, [op("add", "/a/b/-", 2), op("remove", "/a/c")])
    assert data == {"a": {"b": [1]}}


def test_a_pointer_taken_apart():
    assert split_pointer("") == ()
    assert split_pointer("/") == ("",)
    assert split_pointer("/a~1b/~01//x") == ("a/b", "~1", "", "x")


@LAX
@given(st.data())
def test_a_patch_and_then_its_inverse_change_nothing(data: st.DataObject):
    document = data.draw(VALUES)
    patch = data.draw(patches(document, most=6))
    result = apply_operations(document, patch)
    back = inverse(document, patch)
    assert same(apply_operations(result, back), document)
    assert same(apply_operations(document, inverse(result, back)), result)
