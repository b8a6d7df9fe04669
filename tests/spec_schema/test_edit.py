"""Patches on the text: what is not touched stays byte for byte."""

import difflib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from patch_strategies import patches

from text2sim.spec_schema.changes.amendment import Amendment
from text2sim.spec_schema.changes.edit import edit_text, identical
from text2sim.spec_schema.changes.patch import PatchError, apply_operations, inverse
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.text.canonical import format_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

HERE = Path(__file__).parent
STYLE = (HERE / "own_style.yaml").read_text()
ODD = (HERE / "odd.yaml").read_text()
CASES = [(HERE / "stage.yaml").read_text()]
CASES += [path.read_text() for path in sorted((HERE.parents[1] / "cases").glob("*/case.yaml"))]
LAX = settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))


def op(name: str, path: str, value: Any = ..., *, source: str | None = None) -> dict[str, Any]:
    row: dict[str, Any] = {"op": name, "path": path}
    if value is not ...:
        row["value"] = value
    if source is not None:
        row["from"] = source
    return row


def changed(text: str, *operations: dict[str, Any]) -> list[str]:
    """Lines that a patch takes away and adds."""
    new = edit_text(text, list(operations))
    rows = list(difflib.unified_diff(text.splitlines(), new.splitlines(), n=0, lineterm=""))
    return [row for row in rows[2:] if not row.startswith("@@")]


EDITS = [
    ("a number", [op("replace", "/params/speed", 6)], ["-    speed:   12.0     # m/s", "+    speed:   6     # m/s"]),
    ("in brackets", [op("replace", "/bodies/ball/pose/pos/2", 0.7)],
     ["-            pos: [ -2, 0, 0.5 ]   # left", "+            pos: [ -2, 0, 0.7 ]   # left"]),
    ("a whole list", [op("replace", "/bodies/ball/pose/pos", [-2, 1, 0.5])],
     ["-            pos: [ -2, 0, 0.5 ]   # left", "+            pos: [ -2, 1, 0.5 ]   # left"]),
    ("a mapping: only what differs", [op("replace", "/bodies/ball/shape", {"radius": 0.2, "kind": "sphere"})],
     ["-        shape:    { kind: sphere, radius: 0.15 }   # m", "+        shape:    { kind: sphere, radius: 0.2 }   # m"]),
    ("another kind", [op("replace", "/bodies/ball/shape", {"kind": "box", "size": [1, 1, 1]})],
     ["-        shape:    { kind: sphere, radius: 0.15 }   # m", "+        shape:    { kind: box, size: [1, 1, 1] }   # m"]),
    ("a key, in the order of the language", [op("add", "/bodies/ball/look", {"color": "red"}), op("add", "/bodies/ball/mount", {"kind": "fixed"})],
     ["+        mount: {kind: fixed}", "+        look: {color: red}"]),
    ("a key in brackets", [op("add", "/bodies/ball/material/friction", 0.5)],
     ["-        material: { density: 7800 }", "+        material: { density: 7800, friction: 0.5 }"]),
    ("a body, apart from the others as they are", [op("add", "/bodies/cup", {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}})],
     ["+    cup:", "+      kind: rigid", "+      shape: {kind: sphere, radius: 0.1}", "+"]),
    ("a section", [op("add", "/waive", {"overlap": "it is meant to be so"})], ["+", "+waive:", "+  overlap: it is meant to be so"]),
    ("into empty brackets", [op("add", "/actions/expect/hits", {"event": "impact", "never": True})],
     ["-    expect: {}", "+    expect:", "+      hits: {event: impact, never: true}"]),
    ("the last one", [op("remove", "/actions/events/impact")],
     ["-    events:", "-        impact: {kind: contact, between: [ball, brick]}", "+    events: {}"]),
    ("away, with its comments", [op("remove", "/bodies/ball")],
     ["-    # the ball", "-    # (heavy)", "-    ball:", "-        kind:     rigid",
      "-        shape:    { kind: sphere, radius: 0.15 }   # m", "-        material: { density: 7800 }", "-",
      "-        pose:", "-            pos: [ -2, 0, 0.5 ]   # left", "-            # end of pose", "-"]),
    ("away from brackets", [op("remove", "/scene/statics/floor/material")],
     ["-            floor: { shape: {kind: plane} , material: { friction: 0.8 } },", "+            floor: { shape: {kind: plane} },"]),
    ("another name", [op("move", "/bodies/sphere", source="/bodies/ball"), op("replace", "/actions/measures/ball_speed/of", "sphere")],
     ["-    ball:", "+    sphere:", "-            of: ball", "+            of: sphere"]),
    ("moved, with its comments", [op("move", "/bodies/brick/pose", source="/bodies/ball/pose")],
     ["-        pose:", "-            pos: [ -2, 0, 0.5 ]   # left", "-            # end of pose", "-",
      "+        pose:", "+          pos: [-2, 0, 0.5]  # left", "+          # end of pose"]),
    ("items", [op("remove", "/params/brick/1"), op("add", "/params/brick/0", 1.5), op("add", "/params/brick/-", "${speed}")],
     ["+    - 1.5", "-    - 0.11     # deep", '+    - "${speed}"']),
    ("text for text on lines", [op("replace", "/prompt", "short")], ["-prompt: |", "-    Two lines", "-    of text.", "+prompt: short"]),
    ("words that would be something else", [op("replace", "/name", "yes"), op("add", "/params/word", "1.5 # x")],
     ["-'name': \"own_style\"   # the name", "+'name': \"yes\"   # the name", '+    word: "1.5 # x"']),
    ("nothing", [op("test", "/params/rows", 8), op("replace", "/params/rows", 8)], []),
]  # fmt: skip


@pytest.mark.parametrize(("operations", "lines"), [row[1:] for row in EDITS], ids=[row[0] for row in EDITS])
def test_only_what_is_touched_is_written_anew(operations: list[dict[str, Any]], lines: list[str]):
    assert changed(STYLE, *operations) == lines


def test_a_line_that_would_get_too_long_is_written_line_by_line():
    look = {"color": "red", "finish": "metal", "vary": {"hue": 0.01, "value": 0.05, "seed": 3}}
    text = "bodies:\n    a: {kind: rigid,  shape: {kind: sphere, radius: 0.1}}  # round\n    b: 1\n"
    assert edit_text(text, [op("add", "/bodies/a/look", look)]) == (
        "bodies:\n    a:  # round\n      kind: rigid\n      shape: {kind: sphere, radius: 0.1}\n"
        "      look: {color: red, finish: metal, vary: {hue: 0.01, value: 0.05, seed: 3}}\n    b: 1\n"
    )


def test_ends_of_lines_stay_as_they_are():
    text = STYLE.replace("\n", "\r\n")
    new = edit_text(text, [op("add", "/bodies/cup", {"kind": "rigid"}), op("remove", "/params/rows")])
    assert new.count("\r\n") == new.count("\n")
    assert edit_text("a: 1\nb: 2", [op("replace", "/b", 3)]) == "a: 1\nb: 3\n"


def test_a_comment_is_lost_only_with_what_it_is_about():
    new = edit_text(STYLE, [op("replace", "/bodies/ball", {"kind": "rigid", "shape": {"kind": "cup"}})])
    gone = {line.split("#")[1] for line in STYLE.splitlines() if "#" in line and line.split("#")[1] not in new}
    assert gone == {" left", " end of pose"}


def test_what_cannot_be_done_changes_nothing():
    with pytest.raises(PatchError, match="operation 2"):
        edit_text(STYLE, [op("remove", "/bodies/ball"), op("remove", "/bodies/ball")])
    with pytest.raises(SpecError):
        edit_text("a: [1", [])


@pytest.mark.parametrize("text", CASES, ids=lambda text: text.split("name: ")[1].split()[0])
def test_canonical_text_stays_canonical(text: str):
    # `stage.yaml` is not canonical, and is made so first.
    text = format_text(text)
    body = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}, "look": {"color": "red"}}
    data = parse_document(Source(text)).data
    first = next(iter(data["bodies"]))
    operations = [
        op("add", "/bodies/extra", body),
        op("add", f"/bodies/{first}/place", {"on": "floor"}),
        op("move", "/bodies/other", source=f"/bodies/{first}"),
        op("remove", "/render/cameras"),
        op("add", "/prompt", "A long text. " * 20),
    ]
    new = edit_text(text, operations)
    assert format_text(new) == new
    assert edit_text(new, inverse(data, operations)) != ""


@LAX
@given(st.data())
def test_the_text_says_what_the_patched_data_says(data: st.DataObject):
    text = data.draw(st.sampled_from([*CASES, STYLE, ODD, ODD.replace("\n", "\r\n"), '{"a": {"b": [1, 2]}, "c": 3}\n']))
    before = parse_document(Source(text)).data
    patch = data.draw(patches(before))
    new = edit_text(text, patch)
    assert identical(parse_document(Source(new)).data, apply_operations(before, patch))
    if format_text(text) == text:
        assert format_text(new) == new


@LAX
@given(st.data())
def test_splicing_knows_every_usual_way_of_writing(data: st.DataObject):
    """The case is never written anew as a whole, which would lose the author's style."""
    text = data.draw(st.sampled_from([*CASES, STYLE]))
    before = parse_document(Source(text)).data
    patch = [row for row in data.draw(patches(before)) if row["path"] and isinstance(before, dict)]
    try:
        wanted = apply_operations(before, patch)
    except PatchError:
        return
    if not isinstance(wanted, dict) or not wanted.keys() & before.keys():
        return
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Amendment, "dump", lambda _: "")
        edit_text(text, patch)


def test_a_number_of_another_type_is_written():
    assert edit_text("a: [0, 1]\n", [{"op": "replace", "path": "/a", "value": [0.0, 1]}]) == "a: [0.0, 1]\n"
