"""Patches on the text: it is in canonical form, and comments stay with what they are about."""

import difflib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from patch_strategies import op, patches

from text2sim.spec_schema.changes.amendment import identical
from text2sim.spec_schema.changes.edit import edit_text
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


def changed(text: str, *operations: dict[str, Any]) -> list[str]:
    """Lines that a patch takes away and adds."""
    new = edit_text(text, list(operations))
    rows = list(difflib.unified_diff(text.splitlines(), new.splitlines(), n=0, lineterm=""))
    return [row for row in rows[2:] if not row.startswith("@@")]


EDITS = [
    ("a number", [op("replace", "/params/speed", 6)], ["-  speed: 12.0  # m/s", "+  speed: 6  # m/s"]),
    ("in brackets", [op("replace", "/bodies/ball/pose/pos/2", 0.7)],
     ["-      pos: [-2, 0, 0.5]  # left", "+      pos: [-2, 0, 0.7]  # left"]),
    ("another kind", [op("replace", "/bodies/ball/shape", {"kind": "box", "size": [1, 1, 1]})],
     ["-    shape: {kind: sphere, radius: 0.15}  # m", "+    shape: {kind: box, size: [1, 1, 1]}  # m"]),
    ("a key in brackets", [op("add", "/bodies/ball/material/friction", 0.5)],
     ["-    material: {density: 7800}", "+    material: {density: 7800, friction: 0.5}"]),
    ("a section", [op("add", "/waive", {"overlap": "it is meant to be so"})], ["+waive:", "+  overlap: it is meant to be so", "+"]),
    ("another name", [op("move", "/bodies/sphere", source="/bodies/ball"), op("replace", "/actions/measures/ball_speed/of", "sphere")],
     ["-  ball:", "+  sphere:", "-    ball_speed: {kind: speed, of: ball}", "+    ball_speed: {kind: speed, of: sphere}"]),
    ("items", [op("remove", "/params/rows"), op("add", "/params/brick/0", 1.5)], ["-  rows: 8", "+    - 1.5"]),
    ("nothing", [op("test", "/params/rows", 8), op("replace", "/params/rows", 8)], []),
]  # fmt: skip


@pytest.mark.parametrize(("operations", "lines"), [row[1:] for row in EDITS], ids=[row[0] for row in EDITS])
def test_only_what_is_touched_is_another(operations: list[dict[str, Any]], lines: list[str]):
    assert changed(format_text(STYLE), *operations) == lines


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
    if patch and isinstance(parse_document(Source(new)).data, dict):
        assert format_text(new) == new


def test_a_number_of_another_type_is_written():
    assert edit_text("a: [0, 1]\n", [{"op": "replace", "path": "/a", "value": [0.0, 1]}]) == "a: [0.0, 1]\n"


def test_shots_that_are_replaced_come_in_their_new_order() -> None:
    text = "text2sim: 2\nrender:\n  shots:\n    # the end\n    last: {camera: b}\n    first: {camera: a}\n"
    shots = {"first": {"camera": "a"}, "middle": {"camera": "b"}, "last": {"camera": "b"}}
    made = edit_text(text, [{"op": "replace", "path": "/render/shots", "value": shots}])
    assert list(parse_document(Source(made, "case.yaml")).data["render"]["shots"]) == list(shots)
    assert "# the end\n    last" in made
