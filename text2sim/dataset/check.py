"""Whether a dataset's folder holds together, and whether its splits leak; also after somebody edited it."""

import io
import json
import tarfile
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import yaml

from text2sim.dataset.curation import annotation_faults, fingerprint
from text2sim.dataset.recipe import Limits
from text2sim.dataset.shards import read_shard
from text2sim.dataset.splits import LINKS, TOGETHER, leaks
from text2sim.dataset.tables import SCHEMAS, read_rows, split_of, want_dataset

SPLIT_TABLES = ("items", "frames", "questions")


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
    columns = ["key", "split", "shard", *TOGETHER, *LINKS, "frames", "width", "height", "things"]
    rows = [*read_rows(folder, "items", columns)]
    found += leaks(rows)
    table = {row["key"]: row for _, row in rows}
    found += _shards(folder, table)
    for name in ("frames", "questions"):
        for split, row in read_rows(folder, name):
            item = table.get(row["key"])
            if item is None or item["split"] != split:
                found.append(f"{name}: {row['key']} is no item of {split}")
            elif name == "questions" and not _is_sound(row, table):
                found.append(f"questions: {row['question_id']} has no answer or no evidence")
    return list(dict.fromkeys(found))


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
                yield from _item(key, files, row)
                case = _case_of(files)
                if cases.setdefault(case, split) != split:
                    yield f"leak: the case {case} of {key} is in {split} and in {cases[case]}"
                places = fingerprint(io.BytesIO(files.get("states.npz", b"")))
                for other, home, there in known:
                    if home != split and _alike(places, there):
                        yield f"leak: {key} in {split} moves as {other} in {home}"
                known.append((key, split, places))
        except (tarfile.TarError, EOFError) as error:
            yield f"{path.name}: is damaged ({error})"
        except (KeyError, ValueError, OSError) as error:
            yield f"{path.name}: holds files that cannot be read ({error})"
    yield from (f"{key}: is in the table, and in no shard" for key in table if key not in seen)


def _item(key: str, files: dict[str, bytes], row: dict[str, Any]) -> Iterator[str]:
    for name, column in (("film.mp4", "film_digest"), ("states.npz", "states_digest")):
        if sha256(files.get(name, b"")).hexdigest() != row[column]:
            yield f"{key}: {name} is not the one that the table tells of"
    own = json.loads(files.get("json", b"{}"))
    yield from (
        f"{key}: the table says {column} {row[column]}, and the shard {own.get(column)}"
        for column in ("split", *TOGETHER, *LINKS)
        if own.get(column) != row[column]
    )
    if "annotations.npz" in files:
        yield from (f"{key}: {fault}" for fault in annotation_faults(io.BytesIO(files["annotations.npz"]), row, []))


def _case_of(files: dict[str, bytes]) -> str:
    """Name of the case as its own text says it."""
    data = yaml.safe_load(files["case.yaml"])
    return str(data.get("name")) if isinstance(data, dict) else ""


def _alike(one: Any, other: Any) -> bool:
    if one.shape != other.shape or not one.size:
        return False
    room = float(np.ptp(one.reshape(-1, 3), axis=0).max())
    return bool(np.linalg.norm(one - other, axis=-1).mean() < Limits().alike * max(room, 1e-9))


def _is_sound(row: dict[str, Any], table: dict[str, Any]) -> bool:
    """Whether a question has one of its choices as answer, and evidence that is about an item that is there."""
    try:
        evidence = json.loads(row["evidence"])
    except ValueError:
        return False
    choices = row["choices"]
    sound = 0 <= row["answer"] < len(choices) and len({*choices}) == len(choices) > 1
    return sound and isinstance(evidence, dict) and bool(evidence) and evidence.get("item", row["key"]) in table
