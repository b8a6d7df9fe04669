"""Numbers that nobody means, in every field: each is refused in words, or carried. `extremes.py` tries all of them."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from text2sim.spec_schema.changes.patch import PatchError, apply_operations
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text

HEAD = """\
text2sim: 2
name: odd
prompt: Something falls.
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  it: """


def test_one_in_a_hundred_and_one_of_all_extremes():
    done = subprocess.run(
        [sys.executable, Path(__file__).with_name("extremes.py"), "--every", "101", "--json"],
        capture_output=True, text=True, check=False, timeout=400,
    )  # fmt: skip
    assert done.stdout, done.stderr[-3000:]
    found = json.loads(done.stdout)
    assert found["wrong"] == []
    assert found["missed"] == []
    assert found["memory"] < 1e9
    assert min(found["seen"].values()) > 10


@pytest.mark.parametrize("number", ["1e-320", "5e-324", "-1e-100", "1e-400", "1e-31"])
def test_numbers_that_are_nothing_are_to_be_written_as_zero(number: str):
    with pytest.raises(SpecError, match=f"{number} is too small: write 0"):
        load_text(HEAD + f"{{kind: rigid, shape: {{kind: sphere, radius: 1}}, pose: {{pos: [0, 0, {number}]}}}}\n")
    with pytest.raises(PatchError, match=r"document cannot be patched|too small"):
        apply_operations({"a": 1}, [{"op": "replace", "path": "/a", "value": float(number) or 5e-324}])


@pytest.mark.parametrize("number", ["1e100", "1e308", "1e16", "1e999"])
def test_numbers_that_are_too_large_are_refused(number: str):
    with pytest.raises(SpecError, match="too large"):
        load_text(HEAD + f"{{kind: rigid, shape: {{kind: sphere, radius: {number}}}}}\n")


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("{kind: rope, length: 1, radius: 1e-20}", "must be from 1e-06 to 1e+06 m (got 1e-20)"),
        ("{kind: rigid, shape: {kind: sphere, radius: -1}}", "must be greater than 0 (got -1)"),
        ("{kind: cloth, shape: {kind: sheet, size: [1e-15, 0.9]}}", "must be from 1e-06 to 1e+06 m (got 1e-15)"),
        ("{kind: cloth, shape: {kind: sheet, size: [1e11, 0.9]}}", "must be from 1e-06 to 1e+06 m"),
        ("{kind: rigid, shape: {kind: sphere, radius: 1}, material: {mass: 1e13}}", "from 1e-12 to 1e+12 kg"),
        ("{kind: rigid, shape: {kind: sphere, radius: 1}, material: {density: 1e-9}}", "from 1e-06 to 1e+09 kg/m3"),
        (
            "{kind: rigid, shape: {kind: sphere, radius: 1}, repeat: {kind: grid, counts: [2, 2], spacing: 1e-9}}",
            "must be from 1e-06 to 1e+06 m (got 1e-09)",
        ),
    ],
)
def test_a_quantity_has_a_range_and_its_unit(body: str, words: str):
    with pytest.raises(SpecError) as raised:
        load_text(HEAD + body + "\n")
    assert words in str(raised.value)
    assert len(raised.value.problems) == 1
