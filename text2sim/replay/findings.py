"""Findings of a run's evidence, for the page: measures with their bounds, events, expectations."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.evidence.report import bound_of
from text2sim.recording.run_files import read_events, read_evidence, read_measures
from text2sim.replay.packing import Blob
from text2sim.spec_schema.models.case import Case

ROWS = 1500
"""Values of a measure."""
MEASURES = 60
EVENTS = 600
"""Times of declared events."""


def pack_findings(folder: Path, case: Case, blob: Blob, notes: list[str]) -> dict[str, Any]:
    """Pack what was measured and found; what is missing is left out.

    Args:
        folder: The run folder.
        case: The case.
        blob: Takes the arrays.
        notes: Sentences about what was left out; added to.
    """
    evidence = read_evidence(folder) or {}
    time, columns = read_measures(folder)
    every = math.ceil(max(len(time), 1) / ROWS)
    measures = []
    for name, values in list(columns.items())[:MEASURES]:
        summary = evidence.get("measures", {}).get(name) or {}
        bounds = [b for key, row in case.actions.expect.items() if (b := bound_of(key, row, name, evidence, time))]
        measures.append(
            {
                "name": name, "unit": summary.get("unit") or "", "values": blob.add(values[::every].astype(np.float32)),
                "bounds": [
                    {
                        "name": b.name, "from": b.start, "to": b.end, "low": b.low, "high": b.high, "ok": b.ok,
                        "every": b.every,
                    }
                    for b in bounds
                ],
            }
        )  # fmt: skip
    if every > 1:
        notes.append(f"plots have every {every}th value")
    declared = [row for row in read_events(folder) if row["name"]]
    if len(declared) > EVENTS:
        notes.append(f"the first {EVENTS} of {len(declared)} events are listed")
    events = [
        {"name": str(row["name"]), "time": float(row["time"]), "of": ", ".join(map(str, _participants(row)))}
        for row in sorted(declared, key=lambda row: row["time"])[:EVENTS]
    ]
    return {
        "measure_times": blob.add(time[::every].astype(np.float32)),
        "measures": measures,
        "events": events,
        "expect": [_expectation(case, evidence, name) for name in case.actions.expect if name in _found(evidence)],
    }


def _expectation(case: Case, evidence: dict[str, Any], name: str) -> dict[str, Any]:
    row, expect = _found(evidence)[name], case.actions.expect[name]
    made = {"name": name, "ok": row.get("ok"), "wanted": row.get("wanted", ""), "why": row.get("why", "")}
    if expect.event is not None:
        made["event"] = expect.event
    if expect.measure is not None:
        made["measure"] = expect.measure
    return made


def _found(evidence: dict[str, Any]) -> dict[str, Any]:
    return evidence.get("expect", {})


def _participants(row: dict[str, Any]) -> list[Any]:
    return row.get("between") or [row.get("of") or row.get("measure") or ""]
