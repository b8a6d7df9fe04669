"""Run folders that something happened to: nothing is judged from what is no longer there, and nothing is a bug."""

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from text2sim.evidence.evidence import judge
from text2sim.harness.rescue import rescue
from text2sim.recording.geometry import Geometry
from text2sim.recording.inventory import RECORDED, first_fault, list_files
from text2sim.recording.record import RunRecord
from text2sim.recording.run_files import read_events, read_measures

EXPECT = {
    "always": {"measure": "height", "during": "all", "above": -1.0},
    "late": {"measure": "height", "at": 0.9, "above": -1.0},
    "last": {"measure": "height", "at": "end", "above": -1.0},
}


@pytest.fixture
def run(new_run: Callable[..., Any]) -> Path:
    """A finished run of 101 frames in three chunks, with the record of what it wrote."""
    recording = new_run()
    t = recording.time
    recording.add_link("ball", pos=np.stack([0 * t, 0 * t, 5 - 4.905 * t**2], axis=1))
    folder = recording.write(chunk=40)
    (folder / "geometry").mkdir()
    (folder / "geometry" / "index.json").write_text("{}")
    RunRecord("case", "finished", {"sim": "1"}, recorded=list_files(folder, RECORDED)).write(folder)
    return folder


@pytest.fixture
def case(make_case: Callable[..., Any]) -> Any:
    return make_case(measures={"height": {"kind": "position", "of": "ball", "axis": "z"}}, expect=EXPECT)


def test_a_whole_run_is_judged_to_its_end(run: Path, case: Any):
    evidence = judge(run, case)
    assert evidence["verdict"] == "passed", evidence["why"]


@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_missing_chunk_makes_the_evidence_incomplete(run: Path, case: Any, number: int):
    (run / "states" / f"chunk_{number:05d}.npz").unlink()
    evidence = judge(run, case)
    assert evidence["verdict"] == "incomplete"
    assert "chunk_0000" in evidence["why"]
    assert not any(row["ok"] for row in evidence["expect"].values())


def test_a_chunk_of_another_length_makes_the_evidence_incomplete(run: Path, case: Any):
    path = run / "states" / "chunk_00002.npz"
    with np.load(path) as chunk:
        arrays = {name: a[:5] if len(a) == 21 else a for name, a in chunk.items()}
    np.savez(path, **arrays)  # type: ignore[arg-type]
    evidence = judge(run, case)
    assert (evidence["verdict"], evidence["time"]["frames"]) == ("incomplete", 85)
    assert "bytes" in evidence["why"]


def test_the_count_of_frames_is_known_without_a_record(run: Path, case: Any):
    (run / "run.json").unlink()
    layout = json.loads((run / "states" / "layout.json").read_text())
    (run / "states" / "layout.json").write_text(json.dumps(layout | {"n_frames": 101}))
    assert judge(run, case)["verdict"] == "passed"
    (run / "states" / "chunk_00002.npz").unlink()
    evidence = judge(run, case)
    assert (evidence["verdict"], evidence["expect"]["last"]["ok"]) == ("incomplete", None)
    assert "21 of 101 frames are missing" in evidence["why"]


def test_a_chunk_of_another_run_is_noticed_by_its_digest(run: Path):
    record = RunRecord.read(run)
    assert record is not None
    assert first_fault(run, record.recorded) == ""
    path = run / "states" / "chunk_00001.npz"
    data = bytearray(path.read_bytes())
    data[-200] ^= 1
    path.write_bytes(data)
    assert first_fault(run, record.recorded, content=False) == ""
    assert first_fault(run, record.recorded) == "states/chunk_00001.npz is not the file that the run wrote"


@pytest.mark.parametrize(
    ("change", "state"),
    [
        ("", "finished"),
        ("no status", "running"),
        ("a gap", "running"),
        ("too few", "running"),
        ("another case", "running"),
    ],
)
def test_a_simulation_that_ended_is_kept_although_its_parent_was_killed(run: Path, change: str, state: str):
    layout = json.loads((run / "states" / "layout.json").read_text())
    (run / "states" / "layout.json").write_text(json.dumps(layout | {"n_frames": 101}))
    RunRecord("case", "running", {"sim": "2" if change == "another case" else "1"}).write(run)
    if change == "no status":
        (run / "status.json").unlink()
    if change == "a gap":
        (run / "states" / "chunk_00001.npz").unlink()
    if change == "too few":
        (run / "states" / "chunk_00002.npz").unlink()
    rescue(run, {"sim": "1"})
    record = RunRecord.read(run)
    assert record is not None
    assert record.state == state
    assert bool(record.recorded) == (state == "finished")


@pytest.mark.parametrize(
    "change",
    [
        {"time": "x"},
        {"wall": math.nan},
        {"notes": [1]},
        {"lint": [1]},
        {"timings": {"simulate": "x"}},
        {"versions": []},
        {"where": 5},
        {"state": "done"},
        {"recorded": {"a": 1}},
    ],
)
def test_a_record_with_values_of_other_types_is_none(run: Path, change: dict[str, Any]):
    data = json.loads((run / "run.json").read_text())
    (run / "run.json").write_text(json.dumps(data | change))
    assert RunRecord.read(run) is None


def test_copies_of_a_run_hold_the_same_files(run: Path, tmp_path: Path):
    shutil.copytree(run, tmp_path / "copy")
    assert list_files(tmp_path / "copy", RECORDED) == list_files(run, RECORDED)


@pytest.mark.parametrize("damage", [b"", b"\x80\x04K\x01.", b"PK\x03\x04" + bytes(60), "[1]", "{}", '{"0": [3]}'])
def test_shapes_that_cannot_be_read_have_no_corners(damage: bytes | str, tmp_path: Path) -> None:
    (tmp_path / "geometry").mkdir()
    (tmp_path / "geometry/index.json").write_text(damage if isinstance(damage, str) else '{"0": [{"mesh": "a.npz"}]}')
    (tmp_path / "geometry/a.npz").write_bytes(damage if isinstance(damage, bytes) else b"")
    assert Geometry.load(tmp_path).corners(0).shape == (0, 3)


@pytest.mark.parametrize(
    "text",
    ["", "\n", "time,x\n0", "time,x\n0," + "1" * 200_000, "[" * 100_000, '{"name": "x", "time": ' + "1" * 400 + "}"],
)
def test_files_that_cannot_be_read_are_empty(text: str, tmp_path: Path) -> None:
    (tmp_path / "measures.csv").write_text(text)
    (tmp_path / "events.jsonl").write_text(text)
    times, measures = read_measures(tmp_path)
    assert times.size == 0 and not any(values.size for values in measures.values())
    assert read_events(tmp_path) == []
