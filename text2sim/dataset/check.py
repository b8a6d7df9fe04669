"""Checks of a dataset on disk: whether its files agree, and whether its splits leak."""

import io
import json
import tarfile
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml

from text2sim.dataset.curation import annotation_faults, fingerprint, is_alike, thumbnail_colors
from text2sim.dataset.lerobot import episodes_of
from text2sim.dataset.recipe import ItemLimits
from text2sim.dataset.shards import read_shard
from text2sim.dataset.splits import LINKS, TOGETHER, leaks
from text2sim.dataset.tables import SCHEMAS, read_rows, split_of, want_dataset
from text2sim.recording.inventory import sha256_of
from text2sim.spec_schema.errors import RunError

SPLIT_TABLES = ("items", "frames", "questions")
METADATA = ("README.md", "recipe.json", "refused.jsonl", "croissant.json")
ITEM_FILES = ("film.mp4", "states.npz", "layout.json", "case.yaml", "program.zip", "evidence.json", "json")
"""Files that every item has."""
UNREADABLE = (
    LookupError,
    ValueError,
    TypeError,
    AttributeError,
    OSError,
    EOFError,
    BadZipFile,
    zlib.error,
    yaml.YAMLError,
)
"""Exceptions that reading an edited file may raise."""


def check_dataset(folder: Path) -> list[str]:
    """Return the problems of a dataset in words.

    Tables are compared with shards, and both are searched for leaks: moved files or edited columns change only one
    of them.

    Raises:
        RunError: if the folder has no dataset.
    """
    want_dataset(folder)
    if faults := [*_schemas(folder)]:
        return faults
    rows = [*read_rows(folder, "items", ["key", "split", "shard", "frames", *TOGETHER, *LINKS])]
    found = leaks(rows)
    table = {row["key"]: row for _, row in rows}
    found += [f"{key} is in the table {count} times" for key, count in _count(rows).items() if count > 1]
    found += _shards(folder, table)
    pictures = _count(read_rows(folder, "frames", ["key"]))
    found += [
        f"frames: {key} has {pictures[key]} of {row['frames']} pictures"
        for key, row in table.items()
        if pictures[key] != row["frames"]
    ]
    for name in ("frames", "questions"):
        columns = ["key"] if name == "frames" else None
        for split, row in read_rows(folder, name, columns):
            item = table.get(row["key"])
            if item is None or item["split"] != split:
                found.append(f"{name}: {row['key']} is not an item of {split}")
            elif name == "questions" and not _is_sound(row, table):
                found.append(f"questions: {row['question_id']} has no answer or no evidence")
    for path in sorted((folder / "lerobot").glob("*")):
        try:
            found += _robot(path, table)
        except (*UNREADABLE, pa.ArrowException) as error:
            found.append(f"lerobot/{path.name}: cannot be read ({error})")
    found += _digests(folder)
    return list(dict.fromkeys(found))


def want_tables(folder: Path) -> None:
    """Check that a folder has a dataset whose tables can be read.

    Raises:
        RunError: if it has none, or a table is damaged.
    """
    want_dataset(folder)
    for fault in _schemas(folder):
        raise RunError(f"{folder}: {fault}")


def _count(rows: Iterable[tuple[str, dict[str, Any]]]) -> Counter[str]:
    return Counter(row["key"] for _, row in rows)


def _digests(folder: Path) -> Iterator[str]:
    """Compare files with their digests in the metadata."""
    yield from (f"{name}: is missing" for name in METADATA if not (folder / name).is_file())
    try:
        data = json.loads((folder / "croissant.json").read_text("utf-8"))
        digests = {row["contentUrl"]: row["sha256"] for row in data["distribution"]}
    except FileNotFoundError:
        return
    except UNREADABLE as error:
        yield f"croissant.json: cannot be read ({error})"
        return
    paths = [path for table in SPLIT_TABLES for path in sorted((folder / table).glob("*.parquet"))]
    paths += sorted((folder / "shards").glob("*.tar"))
    names = {path.relative_to(folder).as_posix(): path for path in paths}
    yield from (f"{name}: is missing; croissant.json lists it" for name in digests if name not in names)
    for name, path in names.items():
        if sha256_of(path) != digests.get(name):
            yield f"{name}: was changed after the build: its digest is not that in croissant.json"


def _schemas(folder: Path) -> Iterator[str]:
    for table in SPLIT_TABLES:
        for path in sorted((folder / table).glob("*.parquet")):
            try:
                schema = pq.read_schema(path)
            except (pa.ArrowException, OSError) as error:
                yield f"{path.name}: is not a Parquet file ({type(error).__name__})"
                continue
            types = {column.name: column.type for column in schema}
            wrong = [column.name for column in SCHEMAS[table] if types.get(column.name) != column.type]
            if wrong:
                yield f"{table}/{path.name}: the columns {', '.join(wrong)} are missing or have other types"


def _shards(folder: Path, table: dict[str, dict[str, Any]]) -> Iterator[str]:
    """Compare shards with the table of items; find cases and runs that are in two splits from the shards alone."""
    paths = sorted((folder / "items").glob("*.parquet"))
    # Kept as an Arrow table: a million rows as dictionaries do not fit into memory.
    items = pa.concat_tables([pq.read_table(path, columns=SCHEMAS["items"].names) for path in paths])
    rows = {key: n for n, key in enumerate(items["key"].to_pylist())}
    seen: set[str] = set()
    cases: dict[str, str] = {}
    known: list[tuple[str, str, Any]] = []
    for path in sorted((folder / "shards").glob("*.tar")):
        split = split_of(path)
        try:
            for key, files in read_shard(path):
                row = table.get(key)
                if key in seen:
                    yield f"{key}: is in two shards"
                seen.add(key)
                if row is None or row["shard"] != path.name:
                    yield f"{path.name}: has {key}, which the table does not list there"
                    continue
                if missing := [name for name in ITEM_FILES if name not in files]:
                    yield f"{key}: lacks {', '.join(missing)}"
                    continue
                try:
                    yield from _item(key, files, items.slice(rows[key], 1).to_pylist()[0])
                    case, motion = _case_of(files), fingerprint(io.BytesIO(files["states.npz"]))
                except UNREADABLE as error:
                    yield f"{key}: has files in {path.name} that cannot be read ({error})"
                    continue
                if cases.setdefault(case, split) != split:
                    yield f"leak: the case {case} of {key} is in {split} and in {cases[case]}"
                for other, home, its_motion in known:
                    if home != split and is_alike(motion, its_motion, ItemLimits().alike):
                        yield f"leak: {key} in {split} moves like {other} in {home}"
                known.append((key, split, motion))
        except (tarfile.TarError, EOFError, OSError) as error:
            yield f"{path.name}: is damaged ({error})"
    yield from (f"{key}: is in the table, but in no shard" for key in table if key not in seen)


def _item(key: str, files: dict[str, bytes], row: dict[str, Any]) -> Iterator[str]:
    for name, column in (("film.mp4", "film_digest"), ("states.npz", "states_digest")):
        if sha256(files[name]).hexdigest() != row[column]:
            yield f"{key}: the digest of {name} is not that in the table"
    own = pa.Table.from_pylist([json.loads(files["json"])], schema=SCHEMAS["items"]).to_pylist()[0]
    yield from (
        f"{key}: the table says {column} {_brief(row[column])}, the shard {_brief(own[column])}"
        for column in own
        if column != "shard" and own[column] != row[column]  # the row in a shard does not name the shard
    )
    verdict = json.loads(files["evidence.json"])["verdict"]
    if verdict != row["verdict"]:
        yield f"{key}: the table says verdict {row['verdict']}, evidence.json {verdict}"
    pictures = len(thumbnail_colors(io.BytesIO(files["film.mp4"]), (row["width"], row["height"])))
    if pictures != row["frames"]:
        yield f"{key}: {pictures} of {row['frames']} pictures of the film can be decoded"
    with np.load(io.BytesIO(files["states.npz"])) as arrays:
        yield from (f"{key}: {name} is not finite" for name in arrays if not np.isfinite(arrays[name]).all())
        if len({len(arrays[name]) for name in ("time", "pos", "quat")}) > 1 or not len(arrays["time"]):
            yield f"{key}: time, pos and quat of states.npz do not have the same number of frames"
    if "annotations.npz" in files:
        yield from (f"{key}: {fault}" for fault in annotation_faults(io.BytesIO(files["annotations.npz"]), row, []))


def _robot(folder: Path, table: dict[str, dict[str, Any]]) -> Iterator[str]:
    """Compare the episodes of a LeRobot dataset with the items; the name of its folder begins with its split."""
    split, films = folder.name.partition("-")[0], {*folder.glob("videos/**/*.mp4")}
    for key, film in episodes_of(folder):
        films.discard(film)
        item = table.get(key)
        if item is None or item["split"] != split:
            yield f"leak: lerobot/{folder.name} has {key}, which is not an item of {split}"
        elif sha256(film.read_bytes()).hexdigest() != item["film_digest"]:
            yield f"lerobot/{folder.name}: the film of {key} is not that of the item"
    yield from (f"lerobot/{folder.name}: {film.name} belongs to no episode" for film in sorted(films))


def _brief(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 60 else f"{text[:60]}…"


def _case_of(files: dict[str, bytes]) -> str:
    """Name of the case in its YAML."""
    data = yaml.safe_load(files["case.yaml"])
    return str(data.get("name")) if isinstance(data, dict) else ""


def _is_sound(row: dict[str, Any], table: dict[str, Any]) -> bool:
    """Whether the answer of a question is one of its choices, and its evidence is about an item of the dataset."""
    try:
        evidence = json.loads(row["evidence"])
    except (TypeError, ValueError):
        return False
    choices, answer = row["choices"] or [], row["answer"]
    if len(choices) < 2 or len({*choices}) < len(choices) or answer is None or not 0 <= answer < len(choices):
        return False
    return isinstance(evidence, dict) and bool(evidence) and evidence.get("item", row["key"]) in table
