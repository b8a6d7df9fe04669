"""Driven joints in LeRobot 3.0: layout of files, recorded values."""

import json
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pyarrow.parquet as pq
import pytest

from text2sim.dataset.build import Writer
from text2sim.dataset.check import check_dataset
from text2sim.dataset.item import Item
from text2sim.dataset.lerobot import VIDEO, RobotWriter, episodes_of, robot_form
from text2sim.dataset.recipe import Recipe

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


def test_episodes_are_where_the_metadata_point(tmp_path: Path) -> None:
    out = tmp_path / "robots"
    items = episode(tmp_path / "a", "a"), episode(tmp_path / "b", "b", force=4.0)
    form = robot_form(items[0])
    assert form is not None and form == robot_form(items[1]) == (("arm.elbow",), 5.0, 64, 36)
    assert robot_form(episode(tmp_path / "c", "c", force=0.0)) is None, "nothing drives it"
    writer = RobotWriter(out, form)
    for item in items:
        writer.add(item)
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
        assert table["simulated_time"].to_pylist() == pytest.approx([0, 0.2, 0.4, 0.6])
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


def test_films_of_another_rate_are_another_dataset(recipe: Recipe, tmp_path: Path) -> None:
    writer = Writer(recipe, tmp_path / "d", {"one": "train"})
    first = [episode(tmp_path / key, key, fps=fps) for key, fps in (("a", 5.0), ("b", 6.0), ("c", 5.0))]
    for item in first:
        form = robot_form(item)
        assert form is not None
        writer._robot("train-one-arm", form).add(item)
    writer.close()
    found = {path.name: [key for key, _ in episodes_of(path)] for path in (tmp_path / "d" / "lerobot").iterdir()}
    assert found == {"train-one-arm": ["a", "c"], "train-one-arm-2": ["b"]}


def test_a_leak_among_the_episodes_is_reported(dataset: Path, tmp_path: Path) -> None:
    item = episode(tmp_path / "item", "a")
    form = robot_form(item)
    assert form is not None
    with tarfile.open(dataset / "shards" / "train-00000.tar") as shard:
        (item.folder / "film.mp4").write_bytes(shard.extractfile("a.film.mp4").read())  # type: ignore[union-attr]
    writer = RobotWriter(dataset / "lerobot" / "train-one-arm", form)
    writer.add(item)
    writer.close()
    assert check_dataset(dataset) == []
    (dataset / "lerobot" / "train-one-arm").rename(dataset / "lerobot" / "test-one-arm")
    assert check_dataset(dataset) == ["leak: lerobot/test-one-arm has a, which is not an item of test"]
    (dataset / "lerobot" / "test-one-arm").rename(dataset / "lerobot" / "train-one-arm")
    _, film = episodes_of(dataset / "lerobot" / "train-one-arm")[0]
    film.write_bytes(b"another")
    film.with_name("file-001.mp4").write_bytes(b"a further one")
    assert check_dataset(dataset) == [
        "lerobot/train-one-arm: the film of a is not that of the item",
        "lerobot/train-one-arm: file-001.mp4 belongs to no episode",
    ]
    (dataset / "lerobot" / "train-one-arm" / "meta" / "episodes" / "chunk-000" / "file-000.parquet").write_bytes(b"no")
    assert any(words.startswith("lerobot/train-one-arm: cannot be read") for words in check_dataset(dataset))


def test_a_case_without_driven_joints_leaves_nothing(dataset: Path) -> None:
    assert not (dataset / "lerobot").exists()
