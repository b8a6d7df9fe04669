"""Leaks that are planted in a dataset by moving rows, moving files, and editing columns."""

import io
import json
import shutil
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from crates import Take

from text2sim.dataset.build import Writer
from text2sim.dataset.card import write_card
from text2sim.dataset.check import check_dataset
from text2sim.dataset.curation import Likeness
from text2sim.dataset.recipe import Recipe, parse_recipe
from text2sim.dataset.simulate import DrawResult
from text2sim.dataset.splits import deal_splits
from text2sim.dataset.tables import SCHEMAS
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.text.source import Source


def edit(path: Path, change: Any) -> None:
    rows = pq.read_table(path).to_pylist()
    pq.write_table(pa.Table.from_pylist(change(rows), schema=SCHEMAS[path.parent.name]), path)


def repack(path: Path, change: Any) -> None:
    """Write a shard anew, with the content that `change` returns for each member; None leaves it out."""
    with tarfile.open(path) as old:
        files = {info.name: old.extractfile(info).read() for info in old}  # type: ignore[union-attr]
    with tarfile.open(path, "w") as new:
        for name, content in files.items():
            if (content := change(name, content)) is not None:
                info = tarfile.TarInfo(name)
                info.size = len(content)
                new.addfile(info, io.BytesIO(content))


def in_shard(name: str, change: Any) -> Any:
    """Change the files of this name in a shard."""
    return lambda d: repack(d / "shards" / "test-00000.tar", lambda n, c: change(c) if n == f"b.{name}" else c)


def no_number(content: bytes) -> bytes:
    """States with a place that is none."""
    with np.load(io.BytesIO(content)) as arrays:
        states = {name: arrays[name] for name in arrays}
    states["pos"][0] = np.nan
    np.savez(made := io.BytesIO(), allow_pickle=False, **states)
    return made.getvalue()


def first(table: str, **columns: Any) -> Any:
    """Change the first row of a table."""
    path = f"{table}/test-00000.parquet"
    return lambda d: edit(d / path, lambda rows: [rows[0] | columns, *rows[1:]])


def test_a_built_dataset_is_sound(dataset: Path) -> None:
    assert check_dataset(dataset) == []


def test_a_film_of_the_same_simulation_in_another_split_is_a_leak(dataset: Path) -> None:
    train, test = (dataset / "items" / f"{split}-00000.parquet" for split in ("train", "test"))
    row = pq.read_table(train).to_pylist()[1]
    edit(train, lambda rows: rows[:1])
    edit(test, lambda rows: [*rows, row | {"split": "test"}])
    found = "\n".join(check_dataset(dataset))
    assert "a-film1 in test is same physics as a in train" in found
    assert "one source, one: a-film1 in test and a in train" in found
    assert "frames: a-film1 is not an item of train" in found


def test_renaming_does_not_hide_a_leak(dataset: Path) -> None:
    """A shard of one split is copied to another one, and its rows get new names for everything."""
    shard = dataset / "shards" / "test-00001.tar"
    names = {column: "new" for column in ("source", "case", "case_digest", "sim_digest", "states_digest")}
    with tarfile.open(dataset / "shards" / "train-00000.tar") as old, tarfile.open(shard, "w") as new:
        for info in old:
            if info.name.startswith("a."):
                content = old.extractfile(info).read()  # type: ignore[union-attr]
                info.name = info.name.replace("a.", "c.", 1)
                if info.name == "c.json":
                    content = json.dumps(json.loads(content) | names | {"key": "c", "split": "test"}).encode()
                if info.name == "c.case.yaml":
                    content = content.replace(b"case_one", b"case_three")
                info.size = len(content)
                new.addfile(info, io.BytesIO(content))
    first = pq.read_table(dataset / "items" / "train-00000.parquet").to_pylist()[0]
    row = first | names | {"key": "c", "split": "test", "shard": shard.name}
    edit(dataset / "items" / "test-00000.parquet", lambda rows: [*rows, row])
    found = check_dataset(dataset)
    assert any(words.startswith("leak: ") and "moves like" in words for words in found), found
    assert any("one film digest" in words for words in found)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda d: (d / "shards" / "test-00000.tar").unlink(), "b: is in the table, but in no shard"),
        (lambda d: shutil.copy(d / "shards" / "train-00000.tar", d / "shards" / "train-00001.tar"), "is in two shards"),
        (lambda d: (d / "shards" / "test-00000.tar").write_bytes(b"x" * 2000), "test-00000.tar: is damaged"),
        (
            lambda d: (d / "frames" / "test-00000.parquet").write_bytes(b"x"),
            "test-00000.parquet: is not a Parquet file",
        ),
        (
            lambda d: edit(d / "items" / "test-00000.parquet", lambda r: [r[0] | {"film_digest": "0"}]),
            "the digest of film.mp4 is not",
        ),
        (first("items", verdict="wonderful"), "b: the table says verdict wonderful, the shard passed"),
        (first("items", prompt="something else"), "b: the table says prompt something else, the shard "),
        (first("items", things=None), "b: the table says things None, the shard "),
        (lambda d: edit(d / "items" / "test-00000.parquet", lambda r: [*r, *r]), "b is in the table 2 times"),
        (in_shard("evidence.json", lambda c: c.replace(b'"passed"', b'"failed"')), "evidence.json failed"),
        (in_shard("evidence.json", lambda _: None), "b: lacks evidence.json"),
        (in_shard("film.mp4", lambda c: c[: len(c) // 2]), "b: 0 of 8 pictures of the film can be decoded"),
        (in_shard("case.yaml", lambda _: b"{[:"), "b: has files in test-00000.tar that cannot be read"),
        (in_shard("annotations.npz", lambda c: c[:400] + bytes(99) + c[499:]), "b: has files in test-00000.tar that"),
        (in_shard("states.npz", lambda c: no_number(c)), "b: pos is not finite"),
        (in_shard("layout.json", lambda c: c + b" "), "shards/test-00000.tar: was changed after the build"),
        (lambda d: edit(d / "frames" / "test-00000.parquet", lambda r: r[1:]), "frames: b has 7 of 8 pictures"),
        (first("frames", time=5.0), "frames/test-00000.parquet: was changed after the build"),
        (lambda d: (d / "frames" / "test-00000.parquet").unlink(), "frames/test-00000.parquet: is missing"),
        (lambda d: (d / "README.md").unlink(), "README.md: is missing"),
        (lambda d: (d / "croissant.json").write_text("[]"), "croissant.json: cannot be read"),
    ],
)
def test_damage_is_reported(dataset: Path, spoil: Any, said: str) -> None:
    spoil(dataset)
    assert any(said in words for words in check_dataset(dataset))


def test_sources_are_dealt_as_wholes_near_their_shares() -> None:
    rows = "".join(f"  s{k}: {{cases: [c]}}\n" for k in range(9)) + "  fixed: {cases: [c], split: test}\n"
    recipe = parse_recipe(Source(f"text2sim_dataset: 1\nname: x\nsources:\n{rows}", "r.yaml"))
    sizes = {f"s{k}": 10 + k for k in range(9)} | {"fixed": 15}
    jobs = [(name, f"case_{name}") for name, size in sizes.items() for _ in range(size)]
    splits = deal_splits(recipe, jobs)
    assert splits["fixed"] == "test"
    share = {name: sum(sizes[s] for s in splits if splits[s] == name) / sum(sizes.values()) for name in recipe.splits}
    assert share["train"] == pytest.approx(0.7, abs=0.1)
    assert share["validation"] > 0.05


def test_sources_are_dealt_by_their_numbers_of_items() -> None:
    """12, 4 and 2 items: with any two of them together in train, the others would lack more."""
    rows = "a: {cases: [c], films: 2, looks: {x: {choice: [1]}}, counterfactuals: {d: {y: {choice: [1]}}}}"
    text = f"text2sim_dataset: 1\nname: x\nsources: {{{rows}, b: {{cases: [c]}}, c: {{cases: [c]}}}}\n"
    recipe = parse_recipe(Source(text.replace("{x:", "{bodies.b.look.color:").replace("{y:", "{params.y:"), "r.yaml"))
    jobs = [("a", "one")] * 3 + [("b", "two")] * 4 + [("c", "three")] * 2
    assert deal_splits(recipe, jobs) == {"a": "train", "b": "validation", "c": "test"}


def test_sources_with_a_case_in_common_stay_together() -> None:
    rows = "a: {cases: [c], split: test}, b: {cases: [c]}, c: {cases: [c]}, d: {cases: [c]}"
    recipe = parse_recipe(Source(f"text2sim_dataset: 1\nname: x\nsources: {{{rows}}}\n", "r.yaml"))
    jobs = [("a", "one"), ("b", "one"), ("b", "two"), ("c", "two"), *[("d", "three")] * 9]
    assert deal_splits(recipe, jobs) == {"a": "test", "b": "test", "c": "test", "d": "train"}
    apart = parse_recipe(
        Source(
            f"text2sim_dataset: 1\nname: x\nsources: {{{rows.replace('b: {cases: [c]', 'b: {cases: [c], split: train')}}}\n",
            "r.yaml",
        )
    )
    with pytest.raises(RunError, match="shares a case"):
        deal_splits(apart, jobs)


def test_duplicates_and_their_dependents_are_refused(take: Take, recipe: Recipe, tmp_path: Path) -> None:
    writer = Writer(recipe, tmp_path / "d", {"one": "train"}, {"e": "ugly"})
    writer.add(DrawResult([take("a"), take("a-film1", same_physics_as="a")], []))
    writer.add(DrawResult([take("c"), take("c-film1", same_physics_as="c")], []))
    writer.add(DrawResult([take("d", speed=1.4), take("d-same", speed=1.4, counterfactual_of="d")], []))
    writer.add(DrawResult([take("e", speed=2.0)], []))
    writer.close()
    refused = [json.loads(line) for line in (tmp_path / "d" / "refused.jsonl").read_text().splitlines()]
    assert {row["key"]: row["why"] for row in refused} == {
        "a-film1": ["duplicate: looks like a"],
        "c": ["duplicate: moves like a"],
        "c-film1": ["pair: the item that it belongs to is refused"],
        "e": ["review: ugly"],
    }
    assert writer.tally.items == {"train": 3}, "a cause without an effect is no duplicate"


def test_a_run_that_repeats_one_of_another_split_is_refused(take: Take, recipe: Recipe, tmp_path: Path) -> None:
    """One case under two names: what the build accepts, the check must not call a leak."""
    folder, limits = tmp_path / "d", recipe.limits.model_copy(update={"alike": 0.0})
    recipe = recipe.model_copy(update={"limits": limits})
    writer = Writer(recipe, folder, {"one": "train", "two": "test", "three": "train"})
    writer.add(DrawResult([take("a"), take("a-same", counterfactual_of="a")], []))
    writer.add(DrawResult([take("b", "two"), take("b-film1", "two", same_physics_as="b")], []))
    writer.add(DrawResult([take("c", "three"), take("d", "two", speed=1.5)], []))
    writer.close()
    write_card(folder, recipe, writer.tally.tables)
    refused = [json.loads(line) for line in (folder / "refused.jsonl").read_text().splitlines()]
    assert {row["key"]: row["why"] for row in refused} == {
        "b": ["duplicate: moves like a"],
        "b-film1": ["pair: the item that it belongs to is refused"],
    }
    assert writer.tally.items == {"train": 3, "test": 1}, "in one split, cases may look like each other"
    assert check_dataset(folder) == []


def test_runs_with_other_rotations_are_no_duplicates(tmp_path: Path) -> None:
    likeness, found = Likeness(0.002), []
    for name, speed in (("slow", 1.0), ("fast", 2.0), ("again", 1.0)):
        angle = speed * np.linspace(0, 1, 13)[:, None] / 2
        quat = np.stack([np.cos(angle), 0 * angle, np.sin(angle), 0 * angle], axis=-1)
        np.savez(tmp_path / f"{name}.npz", pos=np.zeros((13, 1, 3)), quat=quat)
        found.append(likeness.twin(name, "arm", "train", tmp_path / f"{name}.npz"))
    assert found == [None, None, "slow"]
