"""Tables of a dataset: Arrow schemas, and Parquet files that are written in batches."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from text2sim.spec_schema.errors import RunError

TEXT, REAL, WHOLE, TRUTH = pa.string(), pa.float64(), pa.int64(), pa.bool_()
BATCH_ROWS = 128
"""Rows of a table in memory."""
_list = pa.list_


def _struct(**fields: pa.DataType) -> pa.DataType:
    return pa.struct(fields)


def _table(**fields: tuple[pa.DataType, str]) -> pa.Schema:
    return pa.schema([pa.field(name, kind, metadata={"description": words}) for name, (kind, words) in fields.items()])


SCHEMAS: dict[str, pa.Schema] = {
    "items": _table(
        key=(TEXT, "name of the item: that of its files in the shards"),
        split=(TEXT, "train, validation or test"),
        shard=(TEXT, "file in `shards/` that holds its files"),
        source=(TEXT, "source of the recipe; each source is in one split"),
        case=(TEXT, "name of the case"),
        prompt=(TEXT, "the request, in words"),
        variant=(TEXT, "variant or point of a sweep; empty for the plain case"),
        draw=(WHOLE, "number of the draw"),
        drawn=(_list(_struct(group=TEXT, path=TEXT, value=TEXT)), "drawn values: physics, looks, lights, cameras"),
        same_physics_as=(TEXT, "first item of the same simulation; null if it is this one"),
        counterfactual_of=(TEXT, "item from which this one differs in one cause; null if this is not a counterfactual"),
        cause=(TEXT, "path in the case of the changed cause; null if this is not a counterfactual"),
        params=(TEXT, "parameters of the case, JSON"),
        controls=(TEXT, "controls of the case, JSON"),
        state=(TEXT, "how the simulation ended"),
        duration=(REAL, "simulated time [s]"),
        verdict=(TEXT, "passed, failed or incomplete"),
        expectations=(_list(_struct(name=TEXT, wanted=TEXT, ok=TRUTH, why=TEXT)), "expectations, and which were met"),
        measures=(
            _list(_struct(name=TEXT, unit=TEXT, first=REAL, last=REAL, min=REAL, min_at=REAL, max=REAL, max_at=REAL)),
            "measures; their series are in the shard, `measures.csv`",
        ),
        events=(_list(_struct(name=TEXT, count=WHOLE, first=REAL, last=REAL)), "events; contacts: `events.jsonl`"),
        scores=(_list(_struct(by=TEXT, score=REAL, verdict=TEXT)), "scores of the run by Critic and judges"),
        energy_gain=(REAL, "energy gain without a source, as a part of the largest energy; null if unknown"),
        penetration=(REAL, "deepest penetration [m]; null if there was no contact"),
        suspicions=(_list(TEXT), "what looks wrong in the recording"),
        remarks=(_list(TEXT), "what is hard to see in the film"),
        doubtful=(TRUTH, "whether a person should look at it"),
        things=(_list(_struct(instance=WHOLE, name=TEXT, body=TEXT, static=TRUTH)), "instances of the annotations"),
        parts=(_list(_struct(part=WHOLE, thing=TEXT, link=TEXT)), "parts of the annotations"),
        assets=(
            _list(_struct(name=TEXT, file=TEXT, kind=TEXT, source=TEXT, licence=TEXT, sha256=TEXT)),
            "assets of the case and their licences",
        ),
        quality=(TEXT, "of the film"),
        width=(WHOLE, "of the film [pixels]"),
        height=(WHOLE, "of the film [pixels]"),
        fps=(REAL, "pictures per second of film"),
        frames=(WHOLE, "pictures of the film"),
        versions=(TEXT, "versions of text2sim and of the engine, JSON"),
        case_digest=(TEXT, "SHA-256 of the author's case file, before draws"),
        sim_digest=(TEXT, "digest of all that the simulation depends on"),
        states_digest=(TEXT, "SHA-256 of the recorded states"),
        film_digest=(TEXT, "SHA-256 of the film"),
    ),
    "frames": _table(
        key=(TEXT, "item"),
        frame=(WHOLE, "number of the picture"),
        camera=(TEXT, "name in the case"),
        time=(REAL, "simulated time [s]"),
        speed=(REAL, "simulated seconds per second of film"),
        intrinsics=(_list(REAL), "fx, fy, cx, cy [pixels]"),
        rotation=(_list(REAL), "world to camera, row by row; x right, y down, z ahead"),
        translation=(_list(REAL), "world to camera [m]"),
        objects=(
            _list(
                _struct(
                    instance=WHOLE, name=TEXT, share=REAL, hidden=REAL, inside=REAL, box=_list(WHOLE),
                    whole_box=_list(REAL), center=_list(REAL), size=_list(REAL), quat=_list(REAL),
                    keypoints=_list(REAL), keypoint_pixels=_list(REAL), keypoint_seen=_list(TRUTH),
                )
            ),
            "things: part of the picture, hidden part, boxes [pixels], oriented 3D box [m], eight key points [m], "
            "and whether each is seen, by the depth at the centre of its pixel",
        ),
        contacts=(
            _list(
                _struct(between=_list(TEXT), pos=_list(REAL), force=_list(REAL), penetration=REAL, pixel=_list(REAL))
            ),
            "contacts of rigid bodies at this time [m, N]",
        ),
    ),
    "questions": _table(
        key=(TEXT, "item"),
        question_id=(TEXT, "name of the question"),
        kind=(TEXT, "kind of question"),
        question=(TEXT, "in words"),
        choices=(_list(TEXT), "answers to choose from"),
        answer=(WHOLE, "index of the correct choice"),
        evidence=(TEXT, "proof of the answer, JSON"),
    ),
}  # fmt: skip


class TableWriter:
    """Writes rows to a Parquet file in batches. A file without rows is written, too.

    Args:
        path: The file.
        table: One of `SCHEMAS`.
    """

    def __init__(self, path: Path, table: str):
        path.parent.mkdir(parents=True, exist_ok=True)
        self._schema, self._rows = SCHEMAS[table], list[dict[str, Any]]()
        self._writer = pq.ParquetWriter(path, self._schema, compression="zstd")

    def add(self, rows: Iterable[dict[str, Any]]) -> None:
        """Append rows; missing keys become null."""
        self._rows += rows
        if len(self._rows) >= BATCH_ROWS:
            self._flush()

    def close(self) -> None:
        """Complete the file."""
        self._flush()
        self._writer.close()

    def _flush(self) -> None:
        if self._rows:
            self._writer.write_table(pa.Table.from_pylist(self._rows, schema=self._schema))
            self._rows = []


def read_rows(folder: Path, table: str, columns: list[str] | None = None) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the rows of a table, each with the split of its file; a batch is in memory at a time.

    Args:
        folder: Folder of the dataset.
        table: One of `SCHEMAS`.
        columns: Columns to read; all if left out.
    """
    for path in sorted((folder / table).glob("*.parquet")):
        with pq.ParquetFile(path) as file:
            for batch in file.iter_batches(BATCH_ROWS, columns=columns):
                for row in batch.to_pylist():
                    yield split_of(path), row


def want_dataset(folder: Path) -> None:
    """Check that a folder has a dataset.

    Raises:
        RunError: if it has none.
    """
    if not any((folder / "items").glob("*.parquet")):
        raise RunError(f"{folder} is not a dataset: it has no items/*.parquet")


def split_of(path: Path) -> str:
    """Return the split of a file of a dataset: `train` of `train-00000.tar`."""
    return path.name.partition("-")[0]
