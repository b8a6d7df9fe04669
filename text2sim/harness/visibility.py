"""Visibility: which bodies each camera saw, and how large."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from text2sim.harness.selection import base_name


def read_samples(run_dir: Path) -> dict[str, list[tuple[float, dict[str, float]]]]:
    """Return for each camera its sampled pictures in order: time [s], and share of the picture by copy.

    Empty where there is no film.
    """
    try:
        data = json.loads((run_dir / "visibility.json").read_text("utf-8"))
        return {
            str(camera): [(float(row["t"]), {str(k): float(v) for k, v in row["shares"].items()}) for row in rows]
            for camera, rows in data.items()
        }
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}


def summarise_visibility(run_dir: Path, bodies: Sequence[str]) -> dict[str, Any] | None:
    """Return for each camera what it saw of each body (all copies together); None without a film.

    Args:
        run_dir: The run folder.
        bodies: Names of the bodies that a camera might see.
    """
    samples = read_samples(run_dir)
    if not samples:
        return None
    return {camera: _camera(rows, bodies) for camera, rows in samples.items()}


def _camera(rows: list[tuple[float, dict[str, float]]], bodies: Sequence[str]) -> dict[str, Any]:
    seen: dict[str, dict[str, Any]] = {}
    for time, shares in rows:
        total: dict[str, float] = {}
        for copy, share in shares.items():
            total[base_name(copy)] = total.get(base_name(copy), 0.0) + share
        for body, share in total.items():
            if body in bodies and share > 0:
                row = seen.setdefault(body, {"largest": 0.0, "at": time, "pictures": 0})
                row["pictures"] += 1
                if share > row["largest"]:
                    row["largest"], row["at"] = share, time
    return {
        "pictures": len(rows),
        "bodies": seen,
        "never_seen": [body for body in bodies if body not in seen],
    }
