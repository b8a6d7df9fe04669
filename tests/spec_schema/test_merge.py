"""Three-way merges of meaning, on data and on texts."""

import copy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from patch_strategies import patches
from staged import STAGE, edited

from text2sim.spec_schema.changes.diff import NOTHING
from text2sim.spec_schema.changes.edit import edit_text
from text2sim.spec_schema.changes.merge import Conflict, merge
from text2sim.spec_schema.changes.merge_text import merge_texts, split_at_markers, with_conflict_markers
from text2sim.spec_schema.changes.patch import apply_operations, same
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.reuse.migration import LATEST
from text2sim.spec_schema.text.canonical import format_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

TEXT = Path(__file__).with_name("stage.yaml").read_text()
STYLE = Path(__file__).with_name("own_style.yaml").read_text()
LAX = settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))


def texts(ours: str, theirs: str, base: str = TEXT) -> Any:
    return merge_texts(Source(base), Source(ours), Source(theirs))


def replaced(text: str, *pairs: tuple[str, str]) -> str:
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new)
    return text


# --- data -----------------------------------------------------------------------------------------------------


def test_different_values_do_not_conflict():
    ours = {"/bodies/ball/material/density": 500, "/bodies/ball/look": {"color": "red"}, "/actions/expect/hits": None}
    theirs = {"/bodies/ball/material/friction": 0.5, "/bodies/cup": {"kind": "rigid"}, "/params/speed": 3}
    merged = merge(STAGE, edited(ours), edited(theirs))
    assert merged.conflicts == []
    assert merged.data == edited(ours | theirs)
    assert same(merge(STAGE, edited(theirs), edited(ours)).data, merged.data)


def test_the_same_change_is_no_conflict():
    both = edited({"/bodies/ball/material/density": 500, "/bodies/cup": {"kind": "rigid"}, "/bodies/nail": None})
    merged = merge(STAGE, both, copy.deepcopy(both))
    assert (merged.data, merged.conflicts) == (both, [])


CONFLICTS = [
    ("two values", {"/bodies/ball/material/density": 500}, {"/bodies/ball/material/density": 900},
     ("bodies", "ball", "material", "density"), 500, 900),
    ("a point is one value", {"/bodies/ball/pose/pos": [-2, 0, 1]}, {"/bodies/ball/pose/pos": [0, 0, 0.5]},
     ("bodies", "ball", "pose", "pos"), [-2, 0, 1], [0, 0, 0.5]),
    ("taken away and changed", {"/bodies/nail": None}, {"/bodies/nail/pose/pos": [0, 0, 4]},
     ("bodies", "nail"), NOTHING, STAGE["bodies"]["nail"] | {"pose": {"pos": [0, 0, 4]}}),
    ("added by both", {"/bodies/ball/look": {"color": "red"}}, {"/bodies/ball/look": {"color": "blue"}},
     ("bodies", "ball", "look"), {"color": "red"}, {"color": "blue"}),
    ("kinds do not mix", {"/bodies/ball/shape": {"kind": "box", "size": [1, 1, 1]}},
     {"/bodies/ball/shape": {"kind": "capsule", "radius": 0.15, "length": 1}},
     ("bodies", "ball", "shape"), {"kind": "box", "size": [1, 1, 1]}, {"kind": "capsule", "radius": 0.15, "length": 1}),
]  # fmt: skip


@pytest.mark.parametrize(("ours", "theirs", "path", "mine", "other"), [row[1:] for row in CONFLICTS], ids=[row[0] for row in CONFLICTS])  # fmt: skip
def test_conflicts(ours: Any, theirs: Any, path: Any, mine: Any, other: Any):
    merged = merge(STAGE, edited(ours), edited(theirs))
    assert merged.conflicts == [Conflict(path, mine, other)]
    assert same(merged.data, edited(ours))


def test_another_name_and_a_change_of_the_same_entry_conflict():
    ours = edited({"/bodies/ball": None, "/bodies/shot": STAGE["bodies"]["ball"]})
    merged = merge(STAGE, ours, edited({"/bodies/ball/material/density": 500}))
    assert [conflict.path for conflict in merged.conflicts] == [("bodies", "ball")]
    assert merged.data["bodies"]["shot"] == STAGE["bodies"]["ball"]


def test_without_an_ancestor_what_both_have_alike_is_kept():
    merged = merge({}, edited({"/params/speed": 1}), edited({"/bodies/cup": {"kind": "rigid"}}))
    assert [conflict.path for conflict in merged.conflicts] == [("params", "speed")]
    assert "cup" in merged.data["bodies"]


@LAX
@given(st.data())
def test_who_changed_nothing_takes_what_the_other_made(data: st.DataObject):
    other = apply_operations(STAGE, data.draw(patches(STAGE)))
    if not isinstance(other, dict):
        return
    for merged in (merge(STAGE, STAGE, other), merge(STAGE, other, STAGE), merge(STAGE, other, other)):
        assert merged.conflicts == []
        assert same(merged.data, other)


@LAX
@given(st.data())
def test_merged_text_says_what_merged_data_says(data: st.DataObject):
    text = data.draw(st.sampled_from([TEXT, STYLE]))
    base = parse_document(Source(text)).data
    ours, theirs = (edit_text(text, data.draw(patches(base))) for _ in range(2))
    mine, others = (parse_document(Source(one)).data for one in (ours, theirs))
    if not (isinstance(mine, dict) and isinstance(others, dict)):
        return
    merged, found = merge(base, mine, others), texts(ours, theirs, text)
    if mine.get("text2sim") != others.get("text2sim"):
        return
    assert found.conflicts == merged.conflicts
    if not found.conflicts:
        assert same(parse_document(Source(found.text)).data, merged.data)
    elif (sides := split_at_markers(found.text)) is not None:
        assert same(parse_document(Source(sides[0])).data, merged.data)


# --- texts ----------------------------------------------------------------------------------------------------


def test_values_on_one_line_merge():
    found = texts(replaced(TEXT, ("density: 7800", "density: 500")), replaced(TEXT, ("radius: 0.15}", "radius: 0.2}")))
    assert found.conflicts == []
    assert found.text == format_text(
        replaced(TEXT, ("density: 7800", "density: 500"), ("radius: 0.15}", "radius: 0.2}"))
    )


def test_comments_of_both_stay():
    ours = replaced(TEXT, ("  ball:\n", "  # ours, above\n  ball:\n"), ("radius: 0.15}", "radius: 0.2}  # ours"))
    theirs = replaced(
        TEXT,
        ("    material: {density: 7800}", "    # theirs, above\n    material: {density: 500}  # theirs"),
        ("  nail:", "  # a cup\n  cup: {kind: rigid, shape: {kind: sphere, radius: 0.1}}  # of theirs\n  nail:"),
        ("  brick:\n", "  # their brick\n  brick:\n"),
    )
    found = texts(ours, theirs)
    assert (found.conflicts, found.lost) == ([], [])
    for comment in (
        "# ours, above",
        "# ours",
        "# theirs, above",
        "# theirs",
        "# a cup",
        "# of theirs",
        "# their brick",
    ):
        assert f"{comment}\n" in found.text
    assert "  # their brick\n  brick:\n" in found.text
    assert "    # theirs, above\n    material: {density: 500}  # theirs\n" in found.text


def test_comments_that_both_changed_stay_both():
    base = replaced(TEXT, ("  ball:\n", "  # a ball\n  ball:  # round\n"))
    ours = replaced(base, ("# a ball", "# our ball"), ("# round", "# quite round"))
    theirs = replaced(base, ("# a ball", "# their ball"), ("# round", "# iron"), ("7800", "500"))
    found = texts(ours, theirs, base)
    assert (found.conflicts, found.lost) == ([], [])
    assert "  # our ball\n  # their ball\n  ball:  # quite round  # iron\n" in found.text
    gone = texts(replaced(base, ("  # a ball\n", "")), theirs, base)
    assert "  # their ball\n  ball:  # iron\n" in gone.text


def test_a_conflict_is_marked_at_the_smallest_entry_and_the_rest_is_merged():
    ours = replaced(TEXT, ("density: 7800", "density: 500"), ("radius: 0.15}", "radius: 0.2}"))
    theirs = replaced(TEXT, ("density: 7800", "density: 900"), ("pos: [-2, 0, 0.5]", "pos: [-3, 0, 0.5]"))
    found = texts(ours, theirs)
    begin = found.text.index("  ball:")
    assert found.text[begin : found.text.index("  brick:", begin)] == (
        "  ball:\n    kind: rigid\n    shape: {kind: sphere, radius: 0.2}\n"
        "<<<<<<< ours\n    material: {density: 500}\n=======\n    material: {density: 900}\n>>>>>>> theirs\n"
        "    pose: {pos: [-3, 0, 0.5]}\n"
    )
    assert found.text.count("<<<<<<<") == 1
    sides = split_at_markers(found.text)
    assert sides is not None
    for text, density in zip(sides, (500, 900), strict=True):
        assert check_references(load_text(text)) == []
        assert load_text(text).data["bodies"]["ball"]["material"]["density"] == density


def test_markers_for_what_one_side_took_away():
    line = "  nail: {kind: rigid, shape: {kind: sphere, radius: 0.01}, mount: {kind: fixed}, pose: {pos: [0, 0, 3]}}\n"
    found = texts(replaced(TEXT, (line, "")), replaced(TEXT, ("pos: [0, 0, 3]", "pos: [0, 0, 4]")))
    assert "<<<<<<< ours\n=======\n" in found.text
    sides = split_at_markers(found.text)
    assert sides is not None
    assert ["nail" in load_text(text).data["bodies"] for text in sides] == [False, True]
    assert load_text(sides[1]).data["bodies"]["nail"]["pose"]["pos"] == [0, 0, 4]


def test_versions_of_the_language_meet():
    old = replaced(TEXT, ("look_at: ball}", "look_at: ball, fov: 40}")).replace(f"text2sim: {LATEST}", "text2sim: 1")
    new = replaced(old, ("text2sim: 1", f"text2sim: {LATEST}"), ("fov: 40", "fov_deg: 40"))
    theirs = replaced(
        old, ("    main: {", "    side: {kind: still, from: [9, 0, 1], look_at: ball, fov: 30}\n    main: {")
    )
    found = texts(new, theirs, old)
    assert found.conflicts == []
    cameras = load_text(found.text).data["render"]["cameras"]
    assert (cameras["main"]["fov_deg"], cameras["side"]["fov_deg"]) == (40, 30)


def test_markers_there_and_back():
    ours, theirs = "a\nb\nc\n", "a\nx\ny\nc\n"
    assert with_conflict_markers(ours, theirs, 7) == "a\n<<<<<<< ours\nb\n=======\nx\ny\n>>>>>>> theirs\nc\n"
    assert split_at_markers(with_conflict_markers(ours, theirs, 9)) == (ours, theirs)
    assert split_at_markers("a\n<<<<<<< x\nb\n||||||| base\nz\n=======\n>>>>>>> y\n") == ("a\nb\n", "a\n")
    assert split_at_markers("a\n=======\nb\n") is None
    assert split_at_markers("<<<<<<< ours\na\n") is None
