"""Evidence of a run for the page: measures with bounds, events, expectations."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.evidence.report import bound_of
from text2sim.recording.run_files import read_events, read_evidence, read_measures
from text2sim.replay.packing import Blob
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.expectations import Expect

MAX_ROWS = 1500
"""Largest number of values of a measure."""
MAX_MEASURES = 60
MAX_EVENTS = 600
"""Largest number of declared events."""


def pack_findings(folder: Path, case: Case, blob: Blob, notes: list[str]) -> dict[str, Any]:
    """Pack measures, events and expectations, as far as there is evidence.

    Args:
        folder: The run folder.
        case: The case.
        blob: Collects the arrays.
        notes: Collects notes about omissions.
    """
    evidence = read_evidence(folder) or {}
    time, columns = read_measures(folder)
    every = math.ceil(max(len(time), 1) / MAX_ROWS)
    measures = []
    for name, values in list(columns.items())[:MAX_MEASURES]:
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
    if len(declared) > MAX_EVENTS:
        notes.append(f"the first {MAX_EVENTS} of {len(declared)} events are listed")
    events = [
        {"name": str(row["name"]), "time": float(row["time"]), "of": ", ".join(map(str, _participants(row)))}
        for row in sorted(declared, key=lambda row: row["time"])[:MAX_EVENTS]
    ]
    return {
        "measure_times": blob.add(time[::every].astype(np.float32)),
        "measures": measures,
        "events": events,
        "expect": [
            _expectation(name, row, case.actions.expect[name])
            for name in case.actions.expect
            if (row := evidence.get("expect", {}).get(name)) is not None
        ],
    }


def _expectation(name: str, row: dict[str, Any], expect: Expect) -> dict[str, Any]:
    found = {"name": name, "ok": row.get("ok"), "wanted": row.get("wanted", ""), "why": row.get("why", "")}
    found |= {"event": expect.event} if expect.event is not None else {}
    return found | ({"measure": expect.measure} if expect.measure is not None else {})


def _participants(row: dict[str, Any]) -> list[Any]:
    return row.get("between") or [row.get("of") or row.get("measure") or ""]
