"""Datasets as other programs load them: pyarrow, `datasets`, `webdataset`, mlcroissant."""

import gc
import io
import json
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from crates import Take

from text2sim.dataset.build import Writer
from text2sim.dataset.item import film_of
from text2sim.dataset.recipe import Film, Recipe
from text2sim.dataset.simulate import DrawResult
from text2sim.dataset.tables import BATCH_ROWS
from text2sim.recording.film_record import read_recording


def test_tables_are_read_with_pyarrow_alone(dataset: Path) -> None:
    items = pq.read_table(dataset / "items").to_pylist()
    assert [(row["key"], row["split"], row["same_physics_as"]) for row in items] == [
        ("b", "test", None), ("a", "train", None), ("a-film1", "train", "a")
    ]  # fmt: skip
    frames = pq.read_table(dataset / "frames", filters=[("key", "=", "a")])
    assert frames.num_rows == items[1]["frames"] == 8
    assert frames.schema.field("rotation").metadata[b"description"].startswith(b"world to camera")
    assert items[1]["things"][1] == {"instance": 2, "name": "crate", "body": "crate", "static": False}


def test_shards_are_read_with_webdataset(dataset: Path) -> None:
    import webdataset as wds

    rows = pq.read_table(dataset / "items").to_pylist()
    for split in ("train", "test"):
        loaded = wds.WebDataset(str(dataset / "shards" / f"{split}-00000.tar"), shardshuffle=False).decode()
        samples = {sample["__key__"]: sample for sample in loaded}
        assert {*samples} == {row["key"] for row in rows if row["split"] == split}
        for key, sample in samples.items():
            assert sample["json"]["key"] == key
            assert dict(sample["annotations.npz"])["depth"].shape == (8, 36, 64)
            assert dict(sample["states.npz"])["pos"].shape == (9, 3, 3)
            assert b"ftyp" in sample["film.mp4"][:16]
            assert b"text2sim: 2" in (text if isinstance(text := sample["case.yaml"], bytes) else text.encode())


@pytest.mark.parametrize("table", ["items", "frames"])
def test_the_folder_is_loaded_with_datasets(
    dataset: Path, table: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    import datasets

    loaded = datasets.load_dataset(str(dataset), table, cache_dir=str(tmp_path / "cache"))
    assert {split: loaded[split].num_rows for split in loaded} == {
        "items": {"train": 2, "test": 1}, "frames": {"train": 16, "test": 8}
    }[table]  # fmt: skip
    assert loaded["train"][0]["key"] == "a"


def test_the_metadata_are_read_with_mlcroissant(dataset: Path) -> None:
    import mlcroissant

    found = mlcroissant.Dataset(jsonld=str(dataset / "croissant.json"))
    assert not found.metadata.ctx.issues.errors
    rows = [*found.records("items-train-rows")]
    assert [row["items-train/key"] for row in rows] == [b"a", b"a-film1"]


def test_the_card_describes_the_files(dataset: Path) -> None:
    _, head, words = (dataset / "README.md").read_text().split("---\n", 2)
    assert yaml.safe_load(head)["license"] == "cc0-1.0"
    assert "| `items` | 2 | 0 | 1 |" in words
    assert "`flow`: float32" in words
    refused = [json.loads(line) for line in (dataset / "refused.jsonl").read_text().splitlines()]
    assert [(row["key"], row["why"]) for row in refused] == [("b", ["overlap"])]


def test_files_of_an_item_belong_together(dataset: Path) -> None:
    from text2sim.dataset.shards import read_shard

    (key, files), _ = read_shard(dataset / "shards" / "train-00000.tar")
    with np.load(io.BytesIO(files["states.npz"])) as states:
        assert states["pos"][-1, 1, 0] == pytest.approx(0.2)
    assert key == "a" and json.loads(files["layout.json"])["dt"] == 0.1


def test_memory_does_not_grow_with_the_items(recipe: Recipe, take: Take, tmp_path: Path) -> None:
    item, peaks = take("a"), []
    for count in (4, 40, 120):  # the first imports what there is to import
        writer = Writer(recipe, tmp_path / str(count), {"one": "train"})
        gc.collect()
        tracemalloc.start()
        for k in range(count):
            row = item.row | {"key": f"a{k}", "case": f"case{k}"}
            frames = [frame | {"key": f"a{k}"} for frame in item.frames]
            writer.add(DrawResult([replace(item, key=f"a{k}", row=row, frames=frames)], []))
        writer.close()
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert pq.read_table(tmp_path / "120/frames").num_rows == 960
    (table,) = (tmp_path / "120/frames").glob("*.parquet")
    assert pq.ParquetFile(table).num_row_groups == 960 // BATCH_ROWS + 1, "rows are written before there are many"
    assert peaks[2] - peaks[1] < 80 * 20_000, "what is known of each is a note of how it moves"


def test_the_loader_of_the_documentation_runs_as_it_stands(
    dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    words = (Path(__file__).parents[2] / "docs" / "dataset.md").read_text()
    code = words.split("```python\n")[1].split("```")[0]
    assert code.count("\n") <= 12
    exec(code.replace("datasets/mine", str(dataset)), {})
    assert "A crate slides. passed" in (said := capsys.readouterr().out)
    assert "a-film1 (8, 36, 64) (9, 3, 3)" in said


def test_a_film_of_many_shots_is_shown_to_its_end(take: Take, tmp_path: Path) -> None:
    """Six shots of 0.1 s, four pictures each: a share of 10 rounds up to two for each, which is too much."""
    take("a")
    recording = read_recording(tmp_path / "a" / "case_one", None)
    shots = [{"camera": "main", "from": k / 10, "to": (k + 1) / 10, "speed": 1.0, "hold": 0.0} for k in range(6)]
    recording.film["shots"] = shots
    for most, made in ((10, 6), (6, 6), (4, 4), (100, 24)):
        told, pictures = film_of(recording, Film(fps=40, frames=most))
        assert len(pictures) == made and told.film["fps"] <= 40
        assert made < 6 or pictures[-1].t >= 0.5, "the last shot is there"


def test_scores_of_critic_and_judges_are_in_the_items_of_the_same_simulation(
    take: Take, recipe: Recipe, tmp_path: Path
) -> None:
    """The crate's simulation has the digest `case_one1.0`; the Critic has seen another version, too."""
    for number, run, score in (("01", "case_one-0123456789", 20.0), ("02", "case_one-speed_1-case_one1.", 81.5)):
        folder = tmp_path / "generation/attempts" / number
        folder.mkdir(parents=True)
        critique = {"score": score, "verdict": "pass", "failures": []}
        (folder / "attempt.json").write_text(json.dumps({"run": run, "critique": critique}))
    (tmp_path / "generation/attempts/03").mkdir()
    (tmp_path / "generation/attempts/03/attempt.json").write_text('{"run": null, "critique": null}')
    given = {"case_one1.0": [{"by": "visual judge 1, 2", "score": 66.0, "verdict": None}]}
    writer = Writer(recipe, tmp_path / "dataset", {"one": "train", "two": "test"}, scores=given)
    writer.add(DrawResult([take("a"), take("b", speed=2.0)], []))
    writer.close()
    critic = {"by": "critic", "score": 81.5, "verdict": "pass"}
    rows = pq.read_table(tmp_path / "dataset/items").to_pylist()
    assert [row["scores"] for row in rows] == [[critic, given["case_one1.0"][0]], []]
