"""Driven joints as LeRobot 3.0 has them: files where its metadata say, numbers as they were recorded."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pyarrow.parquet as pq
import pytest

from text2sim.dataset.item import Item
from text2sim.dataset.lerobot import VIDEO, RobotWriter

TIME = np.linspace(0, 1, 11)


def episode(folder: Path, key: str, force: float = 2.0, fps: float = 5.0) -> Item:
    """An arm of two hinges, of which a motor turns the second, and a loose box."""
    folder.mkdir()
    joints = [
        {"body": "box", "joint": "free", "kind": "free", "q": [0, 7], "dofs": [0, 6]},
        {"body": "arm", "joint": "shoulder", "kind": "hinge", "q": [7, 8], "dofs": [6, 7]},
        {"body": "arm", "joint": "elbow", "kind": "hinge", "q": [8, 9], "dofs": [7, 8]},
    ]
    (folder / "layout.json").write_text(json.dumps({"joints": joints}))
    qpos, speed, forces = np.zeros((11, 9)), np.zeros((11, 8)), np.zeros((11, 8))
    qpos[:, 8], speed[:, 7], forces[:, 7] = 3 * TIME, 3, force * TIME
    np.savez(folder / "states.npz", time=TIME, qpos=qpos, dofs_velocity=speed, dofs_force=forces)
    (folder / "film.mp4").write_bytes(key.encode())
    row: dict[str, Any] = {"key": key, "prompt": "Turn.", "case": "arm", "fps": fps, "width": 64, "height": 36}
    return Item(key, folder, row, [{"time": t} for t in (0.0, 0.2, 0.4, 0.6)])


def test_episodes_lie_where_the_metadata_say(tmp_path: Path) -> None:
    out = tmp_path / "robots"
    writer = RobotWriter(out)
    assert writer.add(episode(tmp_path / "a", "a"))
    assert writer.add(episode(tmp_path / "b", "b", force=4.0))
    assert not writer.add(episode(tmp_path / "c", "c", force=0.0)), "nothing drives it"
    assert not writer.add(episode(tmp_path / "d", "d", fps=6.0)), "one dataset has one rate"
    writer.close()
    info = json.loads((out / "meta" / "info.json").read_text())
    assert (info["codebase_version"], info["total_episodes"], info["total_frames"], info["fps"]) == ("v3.0", 2, 8, 5.0)
    assert info["features"]["observation.state"]["names"] == ["arm.elbow.position", "arm.elbow.velocity"]
    assert info["features"]["action"]["names"] == ["arm.elbow.force"]
    assert list(pandas.read_parquet(out / "meta" / "tasks.parquet").index) == ["Turn."]
    rows = pq.read_table(out / "meta" / "episodes").to_pylist()
    for number, (row, key) in enumerate(zip(rows, "ab", strict=True)):
        place = {"chunk_index": row["data/chunk_index"], "file_index": row["data/file_index"]}
        table = pq.read_table(out / info["data_path"].format(**place))
        assert {*table.column_names} == {*info["features"]} - {VIDEO}
        assert table["index"].to_pylist() == list(range(row["dataset_from_index"], row["dataset_to_index"]))
        assert table["timestamp"].to_pylist() == pytest.approx([0, 0.2, 0.4, 0.6])
        assert np.array(table["observation.state"].to_pylist()) == pytest.approx(
            np.column_stack([[0, 0.6, 1.2, 1.8], [3] * 4])
        )
        assert table["action"].to_pylist() == pytest.approx(
            [0, 0.4 * (number + 1), 0.8 * (number + 1), 1.2 * (number + 1)]
        )
        assert (out / info["video_path"].format(video_key=VIDEO, **place)).read_bytes() == key.encode()
    stats = json.loads((out / "meta" / "stats.json").read_text())["action"]
    both = np.array([0, 0.4, 0.8, 1.2, 0, 0.8, 1.6, 2.4])
    assert (stats["mean"], stats["std"], stats["count"]) == ([pytest.approx(0.9)], [pytest.approx(both.std())], [8])


def test_a_case_without_driven_joints_leaves_nothing(dataset: Path) -> None:
    assert not (dataset / "lerobot").exists()
