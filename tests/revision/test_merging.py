"""The merge driver of git: no change is lost without a conflict marker, whatever the files hold."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from text2sim.revision.merging import MergeResult, merge_files
from text2sim.spec_schema.changes.merge_text import split_at_markers
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references

BASE = """\
text2sim: 2
name: slide
prompt: A crate slides down a ramp.
params: {push: 2}
scene:
  duration: 1
  statics:
    ramp: {shape: {kind: box, size: [2, 1, 0]}, pose: {pos: [0, 0, 0]}}
bodies:
  # of wood
  crate:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    material: {density: 600}
    pose: {pos: [0, 0, 1]}
  stone: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, 1]}}
actions:
  measures:
    fast: {kind: speed, of: crate}
    high: {kind: position, of: stone, axis: z}
  expect:
    moves: {measure: fast, at: end, above: 1}
""".replace("size: [2, 1, 0]", "size: [2, 1, 0.1]")

# What a person does to a text; N stands for a number that nobody else writes.
EDITS: list[tuple[str, str]] = [
    ("duration: 1", "duration: N"),
    ("density: 600", "density: N"),
    ("density: 600", "density: 600.0"),
    ("push: 2", "push: 2.0"),
    ("pos: [0, 0, 1]", "pos: [0, 0, N]"),
    ("pos: [0, 0, 1]", "pos: [0, 0.0, 1]"),
    ("    high: {kind: position, of: stone, axis: z}\n", ""),
    ("    fast: {kind: speed, of: crate}\n", ""),
    ("  stone: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [1, 0, 1]}}\n", ""),
    ("    moves:", "    low: {measure: high, at: end, below: N}\n    moves:"),
    ("    moves:", "    slow: {measure: fast, at: end, below: N}\n    moves:"),
    ("crate", "box_N"),
    ("radius: 0.1", "radius: N  # number N"),
    ("  # of wood\n", "  # of N\n"),
    ("params: {push: 2}\n", ""),
    ("  expect:\n    moves: {measure: fast, at: end, above: 1}\n", ""),
    ("kind: rigid\n    shape", "kind: [rigid\n    shape"),
    ("name: slide", "name: slide\nN: 3"),
    ("actions:", "\x00"),
]
RAW: list[Callable[[str], bytes]] = [
    lambda text: text.encode("utf-16"), lambda _: b"", lambda _: b"- 3\n", lambda _: b"\x00\xff", lambda _: b"{",
    lambda text: text.replace("\n", "\r\n").encode(),
]  # fmt: skip

Side = tuple[list[int], int | None]
SIDES = st.tuples(st.lists(st.integers(0, len(EDITS) - 1), max_size=3), st.none() | st.integers(0, len(RAW) - 1))


def made(side: Side, number: int) -> tuple[bytes, list[str]]:
    """The text of a side, and the numbers that stand in it alone."""
    text = BASE
    for at, index in enumerate(side[0]):
        old, new = EDITS[index]
        text = text.replace(old, new.replace("N", f"{number}{at}7"))
    data = text.encode() if side[1] is None else RAW[side[1]](text)
    return data, [token for at in range(3) if (token := f"{number}{at}7").encode() in data]


def merged(folder: Path, base: bytes, ours: bytes, theirs: bytes) -> MergeResult:
    files = [folder / name for name in ("base", "ours", "theirs")]
    for path, data in zip(files, (base, ours, theirs), strict=True):
        path.write_bytes(data)
    return merge_files(files[0], files[1], files[2], "case.yaml", 7)


def is_valid(data: bytes) -> bool:
    try:
        return not check_references(load_text(data.decode()))
    except Exception:
        return False


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True)
@given(SIDES, SIDES, st.none() | st.integers(0, len(RAW) - 1))
@example(([5], None), ([1], None), None)
@example(([2], None), ([3, 1], None), None)
@example(([], 0), ([1], None), None)
@example(([1], None), ([1], None), 3)
@example(([1], None), ([1], None), 1)
@example(([7], None), ([10], None), None)
@example(([8], None), ([9], None), None)
@example(([16], None), ([1], None), None)
def test_no_merge_loses_changes_of_a_side(tmp_path_factory: pytest.TempPathFactory, ours: Side, theirs: Side, raw: int):
    folder = tmp_path_factory.mktemp("merge")
    base = BASE.encode() if raw is None else RAW[raw](BASE)
    (mine, own), (others, foreign) = made(ours, 31), made(theirs, 52)
    result = merged(folder, base, mine, others)
    if b"\x00" in base + mine + others:
        assert not result.clean or others in (base, mine) or mine == base
    if not result.clean and b"\x00" in mine + others:
        assert result.text == mine, "as git leaves what is no text"
        return
    for token in own + foreign:
        assert token.encode() in result.text, (token, result)
    if result.clean and is_valid(mine) and is_valid(others):
        assert is_valid(result.text), result
    if not result.clean:
        assert b"<<<<<<< ours" in result.text, result


def test_a_deleted_measure_and_a_new_expectation_of_it_are_both_marked(tmp_path: Path):
    (ours, _), (theirs, _) = made(([7, 15], None), 31), made(([10], None), 52)
    result = merged(tmp_path, BASE.encode(), ours, theirs)
    assert not result.clean
    sides = split_at_markers(result.text.decode())
    assert sides is not None
    one, other = (load_text(text).data["actions"] for text in sides)
    assert ("fast" in one["measures"], "slow" in one.get("expect", {})) == (False, False)
    assert ("fast" in other["measures"], "slow" in other["expect"]) == (True, True)
    assert all(is_valid(text.encode()) for text in sides)
    assert "there is no measure `fast`" in result.remarks[0]
