"""Tool that reports the evidence of a run: a summary, and pages of each part."""

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from text2sim.mcp_server.answers import ToolAnswer, clipped, paged, refusal, text_page
from text2sim.mcp_server.running import expectation
from text2sim.mcp_server.workspace import Workspace, read_file
from text2sim.recording.record import RunRecord
from text2sim.spec_schema.errors import RunError, did_you_mean

MAX_BYTES = 40_000_000
"""Size of a file of a run."""
SERIES_ROWS = 60
"""Rows of a series."""
DIAGNOSTICS = (
    "energy",
    "penetration",
    "non_finite",
    "speeds",
    "joint_limits",
    "deformables",
    "contacts",
    "driven",
    "off_path",
    "motors_at_limit",
)

Part = Callable[[Path, int], ToolAnswer]


def evidence(workspace: Workspace, run: str, part: str, offset: int) -> ToolAnswer:
    """Report the evidence of a run.

    Args:
        workspace: The workspace.
        run: The run, or a case, for its newest run.
        part: A key of `PARTS`, `series:MEASURE`, or nothing for the summary.
        offset: Beginning of the page.
    """
    folder = workspace.run_folder(run)
    if part.startswith("series:"):
        return _series(folder, part.removeprefix("series:").strip())
    known = PARTS.get(part or "summary")
    if known is None:
        return refusal(f"`part` is one of {', '.join(PARTS)}, or series:MEASURE{did_you_mean(part, PARTS)}")
    return known(folder, offset)


def _summary(folder: Path, offset: int) -> ToolAnswer:
    found, record = _evidence(folder), RunRecord.read(folder)
    time = found["time"] if isinstance(found.get("time"), dict) else {}
    document = {
        "run": folder.name,
        "verdict": found.get("verdict"),
        "why": found.get("why"),
        "state": found.get("state"),
        "message": found.get("message"),
        "reached": f"{time.get('reached')} of {time.get('duration')} s",
        "variants": record.variants if record else [],
        "sets": record.sets if record else [],
        "expect": {name: expectation(row) for name, row in _rows(found, "expect").items()},
        "events": {name: _event(row) for name, row in _rows(found, "events").items()},
        "measures": {name: _measure(row) for name, row in _rows(found, "measures").items()},
        "suspicions": found.get("suspicions"),
        "never_seen_by_a_camera": _unseen(found),
        "lint": [f"{row.get('rule')} {row.get('path')}" for row in (record.lint if record else [])],
        "parts": [*PARTS, "series:MEASURE"],
    }
    return ToolAnswer(clipped({key: value for key, value in document.items() if value not in (None, "", [], {})}))


def _event(row: dict[str, Any]) -> str:
    if row.get("problem"):
        return str(row["problem"])
    return f"{row.get('count')} times, first at {row.get('first')} s" if row.get("count") else "never"


def _measure(row: dict[str, Any]) -> str:
    if row.get("problem"):
        return str(row["problem"])
    unit = row.get("unit") or ""

    def text(key: str) -> str:
        value = row.get(key)
        # A forged integer may be larger than any float.
        return f"{value:.4g}" if isinstance(value, int | float) and abs(value) < 1e300 else "none"

    ends = f"first {text('first')}, last {text('last')}"
    return f"{ends}, min {text('min')} at {text('min_at')} s, max {text('max')} at {text('max_at')} s [{unit}]"


def _unseen(found: dict[str, Any]) -> dict[str, Any]:
    views = _rows(found, "visibility")
    return {name: view["never_seen"] for name, view in views.items() if view.get("never_seen")}


def _diagnostics(folder: Path, offset: int) -> ToolAnswer:
    found = _evidence(folder)
    return ToolAnswer({"run": folder.name, **{key: clipped(found.get(key), 12) for key in DIAGNOSTICS}})


def _table(key: str) -> Part:
    """A part that is a mapping of the evidence, with a row for each key."""

    def part(folder: Path, offset: int) -> ToolAnswer:
        rows = [{name: row} for name, row in _rows(_evidence(folder), key).items()]
        return ToolAnswer({"run": folder.name, "part": key, **paged(rows, offset)})

    return part


def _timeline(folder: Path, offset: int) -> ToolAnswer:
    rows = []
    for line in _text(folder, "events.jsonl").splitlines():
        try:
            rows.append(json.loads(line))
        except (ValueError, RecursionError):
            continue  # a line that was cut off
    return ToolAnswer({"run": folder.name, "part": "timeline", **paged(rows, offset)})


def _log(folder: Path, offset: int) -> ToolAnswer:
    """The log, from its end backwards, because errors are at its end."""
    text = _text(folder, "log.txt")
    end = max(0, len(text) - offset)
    piece, _ = text_page(text[max(0, end - 5_000) : end], 0)
    more = {"next_offset": offset + 5_000, "note": "earlier lines"} if end > 5_000 else {}
    return ToolAnswer({"run": folder.name, "part": "log", "characters": len(text), **more}, piece)


def _lint(folder: Path, offset: int) -> ToolAnswer:
    record = RunRecord.read(folder)
    return ToolAnswer({"run": folder.name, "part": "lint", **paged(record.lint if record else [], offset)})


def _settings(folder: Path, offset: int) -> ToolAnswer:
    record = RunRecord.read(folder)
    return ToolAnswer({"run": folder.name, "part": "settings", **paged(record.notes if record else [], offset)})


def _case(folder: Path, offset: int) -> ToolAnswer:
    piece, page = text_page(_text(folder, "expanded.yaml") or _text(folder, "case.yaml"), offset)
    return ToolAnswer({"run": folder.name, "part": "case", **page}, piece)


def _series(folder: Path, measure: str) -> ToolAnswer:
    """A measure over time, thinned out, with its extremes."""
    try:
        table = list(csv.reader(io.StringIO(_text(folder, "measures.csv"))))
    except csv.Error:
        raise RunError(f"{folder / 'measures.csv'} is damaged; run the case again") from None
    names = table[0] if table else []
    if measure not in names[1:]:
        return refusal(f"there is no measure `{measure[:80]}`; there are {', '.join(names[1:]) or 'none'}")
    column = names.index(measure)
    points = [(row[0], row[column]) for row in table[1:] if len(row) == len(names)]
    every = max(1, -(-len(points) // SERIES_ROWS))
    kept = {*range(0, len(points), every), len(points) - 1}
    values = {index: value for index, (_, text) in enumerate(points) if (value := _number(text)) is not None}
    if values:
        kept |= {min(values, key=values.__getitem__), max(values, key=values.__getitem__)}
    document = {"run": folder.name, "measure": measure, "recorded": len(points), "columns": "time [s], value"}
    return ToolAnswer(document, "\n".join(f"{points[i][0]}, {points[i][1]}" for i in sorted(kept) if i >= 0))


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:  # the cell is empty where a measure has no value
        return None


def _evidence(folder: Path) -> dict[str, Any]:
    text = _text(folder, "evidence.json")
    if not text:
        raise RunError(f"{folder} has no evidence: nothing was recorded, or the run has not ended; see part: log")
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise RunError(f"{folder / 'evidence.json'} is damaged; run the case again")
    return found


def _rows(found: dict[str, Any], key: str) -> dict[str, dict[str, Any]]:
    """A mapping of the evidence; what is not one is left out, because the file is untrusted."""
    rows = found.get(key)
    return {str(name): row for name, row in rows.items() if isinstance(row, dict)} if isinstance(rows, dict) else {}


def _text(folder: Path, name: str) -> str:
    return (read_file(folder / name, MAX_BYTES) or b"").decode("utf-8", "replace")


PARTS: dict[str, Part] = {
    "summary": _summary,
    "expect": _table("expect"),
    "measures": _table("measures"),
    "events": _table("events"),
    "timeline": _timeline,
    "diagnostics": _diagnostics,
    "visibility": _table("visibility"),
    "lint": _lint,
    "settings": _settings,
    "case": _case,
    "log": _log,
}
