"""Whether a dataset's folder holds together, and whether its splits leak; also after somebody edited it."""

import io
import json
import tarfile
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml

from text2sim.dataset.curation import annotation_faults, decoded, fingerprint
from text2sim.dataset.lerobot import episodes_of
from text2sim.dataset.recipe import ItemLimits
from text2sim.dataset.shards import read_shard
from text2sim.dataset.splits import LINKS, TOGETHER, leaks
from text2sim.dataset.tables import SCHEMAS, read_rows, split_of, want_dataset

SPLIT_TABLES = ("items", "frames", "questions")
TOLD = ("README.md", "recipe.json", "refused.jsonl", "croissant.json")
KEPT = ("film.mp4", "states.npz", "layout.json", "case.yaml", "program.zip", "evidence.json", "json")
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
"""What reading a file raises that somebody edited."""


def check_dataset(folder: Path) -> list[str]:
    """Return what is wrong with a dataset, in words; nothing if it is sound.

    What the tables say is compared with the shards, and leaks are looked for in both: who moves files or changes
    columns changes one of them.

    Raises:
        RunError: if the folder holds no dataset.
    """
    want_dataset(folder)
    found = [*_schemas(folder)]
    if found:
        return found
    rows = [*read_rows(folder, "items", ["key", "split", "shard", "frames", *TOGETHER, *LINKS])]
    found += leaks(rows)
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
                found.append(f"{name}: {row['key']} is no item of {split}")
            elif name == "questions" and not _is_sound(row, table):
                found.append(f"questions: {row['question_id']} has no answer or no evidence")
    for path in sorted((folder / "lerobot").glob("*")):
        try:
            found += _robot(path, table)
        except (*UNREADABLE, pa.ArrowException) as error:
            found.append(f"lerobot/{path.name}: cannot be read ({error})")
    found += _digests(folder)
    return list(dict.fromkeys(found))


def _count(rows: Iterable[tuple[str, dict[str, Any]]]) -> Counter[str]:
    return Counter(row["key"] for _, row in rows)


def _digests(folder: Path) -> Iterator[str]:
    """Compare files with what the metadata say of them."""
    yield from (f"{name}: is missing" for name in TOLD if not (folder / name).is_file())
    told: dict[str, str] = {}
    try:
        data = json.loads((folder / "croissant.json").read_text("utf-8"))
        told = {row["contentUrl"]: row["sha256"] for row in data["distribution"]}
    except FileNotFoundError:
        return
    except UNREADABLE as error:
        yield f"croissant.json: cannot be read ({error})"
        return
    there = [path for table in SPLIT_TABLES for path in sorted((folder / table).glob("*.parquet"))]
    there += sorted((folder / "shards").glob("*.tar"))
    names = {path.relative_to(folder).as_posix(): path for path in there}
    yield from (f"{name}: is missing; croissant.json lists it" for name in told if name not in names)
    for name, path in names.items():
        with path.open("rb") as file:
            if file_digest(file, "sha256").hexdigest() != told.get(name):
                yield f"{name}: was changed after the build, for croissant.json has another digest of it"


def _schemas(folder: Path) -> Iterator[str]:
    for table in SPLIT_TABLES:
        for path in sorted((folder / table).glob("*.parquet")):
            try:
                there = pq.read_schema(path)
            except (pa.ArrowException, OSError) as error:
                yield f"{path.name}: is no Parquet file ({type(error).__name__})"
                continue
            kinds = {one.name: one.type for one in there}
            lacking = [one.name for one in SCHEMAS[table] if kinds.get(one.name) != one.type]
            if lacking:
                yield f"{table}/{path.name}: lacks the columns {', '.join(lacking)}, or has others of these names"


def _shards(folder: Path, table: dict[str, dict[str, Any]]) -> Iterator[str]:
    """Compare shards with the table; look for cases and runs that lie in two splits, whatever the table says."""
    paths = sorted((folder / "items").glob("*.parquet"))
    # As Arrow has them: a million rows as dictionaries do not fit into memory.
    whole = pa.concat_tables([pq.read_table(path, columns=SCHEMAS["items"].names) for path in paths])
    rows = {key: n for n, key in enumerate(whole["key"].to_pylist())}
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
                    yield f"{path.name}: {key} is there, and not in the table"
                    continue
                if lacking := [name for name in KEPT if name not in files]:
                    yield f"{key}: lacks {', '.join(lacking)}"
                    continue
                try:
                    yield from _item(key, files, whole.slice(rows[key], 1).to_pylist()[0])
                    case, places = _case_of(files), fingerprint(io.BytesIO(files["states.npz"]))
                except UNREADABLE as error:
                    yield f"{key}: has files in {path.name} that cannot be read ({error})"
                    continue
                if cases.setdefault(case, split) != split:
                    yield f"leak: the case {case} of {key} is in {split} and in {cases[case]}"
                for other, home, there in known:
                    if home != split and _alike(places, there):
                        yield f"leak: {key} in {split} moves as {other} in {home}"
                known.append((key, split, places))
        except (tarfile.TarError, EOFError, OSError) as error:
            yield f"{path.name}: is damaged ({error})"
    yield from (f"{key}: is in the table, and in no shard" for key in table if key not in seen)


def _item(key: str, files: dict[str, bytes], row: dict[str, Any]) -> Iterator[str]:
    for name, column in (("film.mp4", "film_digest"), ("states.npz", "states_digest")):
        if sha256(files[name]).hexdigest() != row[column]:
            yield f"{key}: {name} is not the one that the table tells of"
    own = pa.Table.from_pylist([json.loads(files["json"])], schema=SCHEMAS["items"]).to_pylist()[0]
    yield from (
        f"{key}: the table says {column} {_brief(row[column])}, and the shard {_brief(own[column])}"
        for column in own
        if column != "shard" and own[column] != row[column]  # the item's own row does not say where it lies
    )
    judged = json.loads(files["evidence.json"])["verdict"]
    if judged != row["verdict"]:
        yield f"{key}: the table says verdict {row['verdict']}, and evidence.json {judged}"
    pictures = len(decoded(io.BytesIO(files["film.mp4"]), (row["width"], row["height"])))
    if pictures != row["frames"]:
        yield f"{key}: {pictures} of {row['frames']} pictures of the film can be decoded"
    with np.load(io.BytesIO(files["states.npz"])) as arrays:
        yield from (f"{key}: {name} is not finite" for name in arrays if not np.isfinite(arrays[name]).all())
        if len({len(arrays[name]) for name in ("time", "pos", "quat")}) > 1 or not len(arrays["time"]):
            yield f"{key}: time, pos and quat of states.npz do not have the same number of frames"
    if "annotations.npz" in files:
        yield from (f"{key}: {fault}" for fault in annotation_faults(io.BytesIO(files["annotations.npz"]), row, []))


def _robot(folder: Path, table: dict[str, dict[str, Any]]) -> Iterator[str]:
    """Compare the episodes of a LeRobot dataset, whose name begins with its split, with the items."""
    split, films = folder.name.partition("-")[0], {*folder.glob("videos/**/*.mp4")}
    for key, film in episodes_of(folder):
        films.discard(film)
        item = table.get(key)
        if item is None or item["split"] != split:
            yield f"leak: lerobot/{folder.name} has {key}, which is no item of {split}"
        elif sha256(film.read_bytes()).hexdigest() != item["film_digest"]:
            yield f"lerobot/{folder.name}: the film of {key} is not that of the item"
    yield from (f"lerobot/{folder.name}: {film.name} is the film of no episode" for film in sorted(films))


def _brief(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 60 else f"{text[:60]}…"


def _case_of(files: dict[str, bytes]) -> str:
    """Name of the case as its own text says it."""
    data = yaml.safe_load(files["case.yaml"])
    return str(data.get("name")) if isinstance(data, dict) else ""


def _alike(one: Any, other: Any) -> bool:
    if one.shape != other.shape or not one.size:
        return False
    room = float(np.ptp(one.reshape(-1, 3), axis=0).max())
    return bool(np.linalg.norm(one - other, axis=-1).mean() < ItemLimits().alike * max(room, 1e-9))


def _is_sound(row: dict[str, Any], table: dict[str, Any]) -> bool:
    """Whether a question has one of its choices as answer, and evidence that is about an item that is there."""
    try:
        evidence = json.loads(row["evidence"])
    except (TypeError, ValueError):
        return False
    choices = row["choices"] or []
    sound = 0 <= (-1 if row["answer"] is None else row["answer"]) < len(choices) and len({*choices}) == len(choices) > 1
    return sound and isinstance(evidence, dict) and bool(evidence) and evidence.get("item", row["key"]) in table
