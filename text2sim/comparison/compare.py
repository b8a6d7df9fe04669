"""Comparison as plain data: one row for each quantity that can differ, one cell for each run."""

from dataclasses import dataclass
from typing import Any

from text2sim.comparison.runs import Run, are_equal, differing_paths
from text2sim.spec_schema.paths import dotted


@dataclass(frozen=True)
class RunComparison:
    """Rows with one cell for each run, in their order; None where a run has no value."""

    runs: list[Run]
    spec: list[dict[str, Any]]
    """`path`, `values`: the differences between the cases."""
    expectations: list[dict[str, Any]]
    """`name`, `cells` with `ok`, `value`, `unit`, `why`."""
    measures: list[dict[str, Any]]
    """`name`, `unit`, `cells` with `last`, `min`, `max` …"""
    events: list[dict[str, Any]]
    """`name`, `cells` with `count`, `first`, `last`."""
    diagnostics: list[dict[str, Any]]
    """`name`, `values`: final state, wall time, energies, engine and device."""

    def as_dict(self) -> dict[str, Any]:
        """Return the comparison as JSON data."""
        return {
            "runs": [{"label": run.label, "folder": str(run.folder), "verdict": run.verdict} for run in self.runs],
            "spec": self.spec,
            "expectations": self.expectations,
            "measures": self.measures,
            "events": self.events,
            "diagnostics": self.diagnostics,
        }


def compare(runs: list[Run]) -> RunComparison:
    """Compare runs."""
    return RunComparison(
        runs,
        [{"path": dotted(path), "values": [run.leaves.get(path) for run in runs]} for path in differing_paths(runs)],
        _rows(runs, "expect"),
        _measures(runs),
        _rows(runs, "events"),
        _diagnostics(runs),
    )


def _rows(runs: list[Run], key: str) -> list[dict[str, Any]]:
    names: dict[str, None] = {}
    for run in runs:
        names |= dict.fromkeys(run.evidence.get(key, {}))
    return [{"name": name, "cells": [run.evidence.get(key, {}).get(name) for run in runs]} for name in names]


def _measures(runs: list[Run]) -> list[dict[str, Any]]:
    rows = _rows(runs, "measures")
    for row in rows:
        row["unit"] = next((cell["unit"] for cell in row["cells"] if cell), "")
    return rows


def _deformables(runs: list[Run]) -> dict[str, list[Any]]:
    """Worst values of each deformable body, by row name."""
    rows: dict[str, list[Any]] = {}
    for number, run in enumerate(runs):
        for body, found in (run.evidence.get("deformables") or {}).items():
            for quantity, row in found.items():
                if isinstance(row, dict):
                    unit = f" [{row['unit']}]" if row.get("unit") else ""
                    name = f"{body}: worst {quantity.replace('_', ' ')}{unit}"
                    rows.setdefault(name, [None] * len(runs))[number] = row.get("value")
    return rows


def _diagnostics(runs: list[Run]) -> list[dict[str, Any]]:
    rows = {
        "state": [run.record.state for run in runs],
        "simulated [s]": [run.record.time for run in runs],
        "wall time [s]": [run.record.wall for run in runs],
        "deepest overlap [m]": [(run.evidence.get("penetration") or {}).get("value") for run in runs],
        "energy at the start [J]": [(run.evidence.get("energy") or {}).get("start") for run in runs],
        "energy at the end [J]": [(run.evidence.get("energy") or {}).get("end") for run in runs],
        **_deformables(runs),
        "engine": [run.record.key.get("genesis") for run in runs],
        "device": [run.record.key.get("device") for run in runs],
    }
    kept = ("state", "wall time [s]", "deepest overlap [m]")
    return [
        {"name": name, "values": values}
        for name, values in rows.items()
        if any(value is not None for value in values) and (name in kept or not are_equal(values))
    ]
