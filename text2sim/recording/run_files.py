"""Tolerant readers of the files of a run folder: missing or broken ones read as empty."""

import csv
import json
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.recording.states import Array


def read_measures(run_dir: Path) -> tuple[Array, dict[str, Array]]:
    """Return times [s], shape (F,), and a series of that shape for each measure."""
    try:
        rows = list(csv.reader((run_dir / "measures.csv").read_text("utf-8").splitlines()))
        table = np.array([[float(x or "nan") for x in row] for row in rows[1:]]).reshape(-1, len(rows[0]))
    except (OSError, ValueError, IndexError, csv.Error):
        return np.zeros(0), {}
    return table[:, 0], {name: table[:, i] for i, name in enumerate(rows[0]) if i}


def read_events(run_dir: Path) -> list[dict[str, Any]]:
    """Return the occurrences in `events.jsonl`; touches that belong to no event of the case have the name None."""
    rows = []
    for line in read_text(run_dir / "events.jsonl").splitlines():
        try:
            rows.append(json.loads(line))
        except (ValueError, RecursionError):
            continue
    return [row for row in rows if isinstance(row, dict) and _is_real(row.get("time")) and "name" in row]


def read_evidence(run_dir: Path) -> dict[str, Any] | None:
    """Return what `evidence.json` holds; None if it is missing or not as this version writes it."""
    found = read_json(run_dir / "evidence.json")
    if not isinstance(found, dict) or found.get("verdict") not in ("passed", "failed", "incomplete"):
        return None
    tables = [found.get(name) for name in ("expect", "measures", "events")]
    if not all(isinstance(table, dict) and all(isinstance(row, dict) for row in table.values()) for table in tables):
        return None
    expect, measures, events = (list(table.values()) for table in tables if table is not None)
    time = found.get("time")
    sound = (
        all(row.get("ok", "") in (True, False, None) and {"wanted", "why"} <= row.keys() for row in expect)
        and all("unit" in row for row in measures)
        and all({"count", "first"} <= row.keys() for row in events)
        and all(isinstance(found.get(name) or {}, dict) for name in ("energy", "penetration", "deformables"))
        and isinstance(found.get("suspicions", []), list)
        and isinstance(time, dict)
        and _is_real(time.get("reached"))
    )
    return found if sound else None


def _is_real(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return isfinite(value)
    except OverflowError:  # an integer that no float can hold
        return False


def read_json(path: Path) -> Any:
    """Return what a JSON file holds; None if it is missing or broken."""
    try:
        return json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def read_text(path: Path) -> str:
    """Return the text of a file; empty if it cannot be read."""
    try:
        return path.read_text("utf-8", "replace")
    except OSError:
        return ""
