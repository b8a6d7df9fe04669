"""The files of a run folder, read with patience: what is missing or broken reads as nothing."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.harness.page import data_uri
from text2sim.harness.states import Array

EMBEDDED = 30_000_000
"""Films of this size [bytes] in all are put into the page; larger ones are linked."""


def read_measures(run_dir: Path) -> tuple[Array, dict[str, Array]]:
    """Return times [s], shape (F,), and a series of that shape for each measure."""
    try:
        rows = list(csv.reader((run_dir / "measures.csv").read_text("utf-8").splitlines()))
        table = np.array([[float(x or "nan") for x in row] for row in rows[1:]]).reshape(-1, len(rows[0]))
    except (OSError, ValueError, IndexError):
        return np.zeros(0), {}
    return table[:, 0], {name: table[:, i] for i, name in enumerate(rows[0]) if i}


def read_events(run_dir: Path) -> list[dict[str, Any]]:
    """Return the occurrences in `events.jsonl`; touches that no event of the case names have the name None."""
    rows = []
    for line in read_text(run_dir / "events.jsonl").splitlines():
        try:
            rows.append(json.loads(line))
        except ValueError:
            continue
    return [row for row in rows if isinstance(row, dict) and "time" in row and "name" in row]


def read_json(path: Path) -> Any:
    """Return what a JSON file holds, or None."""
    try:
        return json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def read_text(path: Path) -> str:
    """Return a text file, or nothing."""
    try:
        return path.read_text("utf-8", "replace")
    except OSError:
        return ""


def read_films(run_dir: Path, room: int | None = None) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
    """Return films as (name, data URI), and those that find no room [bytes] in a page as (name, file)."""
    room = EMBEDDED if room is None else room
    paths = [run_dir / "video.mp4", *sorted(run_dir.glob("video_*.mp4"))]
    found, linked = [], []
    for path in paths:
        if not path.is_file():
            continue
        name, size = path.stem.removeprefix("video").lstrip("_"), path.stat().st_size
        if size < room:
            room -= size
            found.append((name, data_uri(path, "video/mp4") or ""))
        else:
            linked.append((name, path.name))
    return found, linked
