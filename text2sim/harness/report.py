"""The report: one page with everything that a run showed, which needs no other file."""

import base64
import csv
import json
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.harness.contact_sheet import write_contact_sheet
from text2sim.harness.diagnostics import energy_series
from text2sim.harness.evidence import STOPPED
from text2sim.harness.expectations import moment
from text2sim.harness.outcome import clean, read_end
from text2sim.harness.plots import GREEN, ORANGE, Bound, Line, plot_series
from text2sim.harness.record import RunRecord, write_atomically
from text2sim.harness.recording import Recording
from text2sim.harness.states import Array
from text2sim.spec_schema.case import Case
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.expectations import Expect

EMBEDDED = 30_000_000
"""Films of this size [bytes] in all are put into the page; larger ones are linked."""
TOUCHES = 25
"""Undeclared touches in the table, the hardest."""
OCCURRENCES = 200
"""Times of declared events in the table."""
LOG = 6_000
"""Bytes of the end of the log."""


def write_report(run_dir: Path, case: Case) -> Path:
    """Write `plots/`, `contact_sheet.png` and `report.html` of a run that was judged.

    What is missing is left out of the page: a film, frames, measures, even the evidence itself.
    """
    from jinja2 import Environment, StrictUndefined

    # Strings of a case are not ours: everything is escaped, and the page's policy allows no script at all.
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"number": _number, "seconds": _seconds, "percent": _percent, "prose": _prose}
    template = resources.files("text2sim.harness").joinpath("report.html.j2").read_text("utf-8")
    page = environment.from_string(template).render(_contents(run_dir, case))
    path = run_dir / "report.html"
    write_atomically(path, page)
    return path


def _contents(run_dir: Path, case: Case) -> dict[str, Any]:
    evidence = _read_json(run_dir / "evidence.json") or {}
    record = RunRecord.read(run_dir)
    events = _read_events(run_dir)
    declared = [row for row in events if row["name"]]
    touches = [row for row in events if not row["name"]]
    touches.sort(key=lambda row: -sum(x * x for x in row.get("impulse") or [0.0] if x is not None))
    films, linked = _films(run_dir)
    # What was missed comes first.
    found = [row for name in case.actions.expect if (row := evidence.get("expect", {}).get(name))]
    found.sort(key=lambda row: {False: 0, None: 1, True: 2}[row["ok"]])
    return {
        "case": case,
        "evidence": evidence,
        "record": record,
        "verdict": evidence.get("verdict") or ("failed" if record and record.state not in STOPPED else "incomplete"),
        "why": _sentence(evidence.get("why") or (record.message if record else "") or "there is nothing to judge"),
        "expect": found,
        "declared": declared[:OCCURRENCES],
        "declared_left_out": max(0, len(declared) - OCCURRENCES),
        "touches": touches[:TOUCHES],
        "films": films,
        "linked": linked,
        "first": None if films else _data_uri(run_dir / "first.png", "image/png"),
        "sheet": _data_uri(write_contact_sheet(run_dir), "image/png"),
        "plots": _plots(run_dir, case, evidence, declared),
        "case_text": _read_text(run_dir / "case.yaml"),
        "log": clean(read_end(run_dir / "log.txt", limit=LOG)),
    }


# --- pictures ----------------------------------------------------------------------


def _plots(run_dir: Path, case: Case, evidence: dict[str, Any], events: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """Draw the plots; return (name, data URI) of each."""
    folder = run_dir / "plots"
    folder.mkdir(exist_ok=True)
    for stale in folder.glob("*.png"):
        stale.unlink()
    time, columns = _read_measures(run_dir / "measures.csv")
    found = []
    for name, values in columns.items():
        summary = evidence.get("measures", {}).get(name)
        if summary is None or not np.isfinite(values).any():
            continue
        bounds = [b for key, row in case.actions.expect.items() if (b := _bound(key, row, name, evidence, time))]
        title = f"{name}: {describe(case.actions.measures[name])}" if name in case.actions.measures else name
        plot_series(
            folder / f"{name}.png",
            time,
            [Line(name, values)],
            title=title,
            unit=summary["unit"],
            bounds=bounds,
            events=events,
        )
        found.append(name)
    energy = _energy_lines(run_dir, case)
    if energy is not None:
        # No measure can have this name: a dot is in none.
        plot_series(
            folder / "all.energy.png",
            *energy,
            title="mechanical energy of all bodies that move freely",
            unit="J",
            events=events,
        )
        found.append("all.energy")
    return [(name, _data_uri(folder / f"{name}.png", "image/png") or "") for name in found]


def _energy_lines(run_dir: Path, case: Case) -> tuple[Array, list[Line]] | None:
    try:
        recording = Recording.load(run_dir, case)
        with np.errstate(all="ignore"):
            rows = energy_series(recording)
    except RunError:
        return None
    if not recording.states.frames or not np.isfinite(rows["total"]).any():
        return None
    lines = [
        Line("kinetic", rows["kinetic"], ORANGE, "--"),
        Line("potential", rows["potential"], GREEN, ":"),
        Line("total", rows["total"]),
    ]
    return recording.states.time, lines


def _bound(name: str, expect: Expect, measure: str, evidence: dict[str, Any], time: Array) -> Bound | None:
    # The mean or the range of a measure is no bound on its values.
    if expect.measure != measure or expect.stat in ("mean", "range") or not len(time):
        return None
    if expect.at is not None:
        start = end = moment(expect.at, time)
    else:
        start, end = expect.during if isinstance(expect.during, tuple) else (float(time[0]), float(time[-1]))
    low, high = expect.above, expect.below
    if expect.equals is not None and expect.tolerance is not None:
        low, high = expect.equals - expect.tolerance, expect.equals + expect.tolerance
    some = (expect.stat == "max" and expect.below is None) or (expect.stat == "min" and expect.above is None)
    return Bound(name, start, end, low, high, evidence.get("expect", {}).get(name, {}).get("ok"), every=not some)


def describe(model: Any) -> str:
    """Return a measure as its case says it, on one line."""
    data = model.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    kind = data.pop("kind").replace("_", " ")
    return " ".join([kind, ", ".join(f"{key} {_flat(value)}" for key, value in data.items())])


def _flat(value: Any) -> str:
    if isinstance(value, dict):
        return "(" + ", ".join(f"{key} {_flat(row)}" for key, row in value.items()) + ")"
    if isinstance(value, list | tuple):
        return ", ".join(map(_flat, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _films(run_dir: Path) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
    """Return films as (name, data URI), and those too large for that as (name, file)."""
    paths = [run_dir / "video.mp4", *sorted(run_dir.glob("video_*.mp4"))]
    films, linked, room = [], [], EMBEDDED
    for path in paths:
        if not path.is_file():
            continue
        name, size = path.stem.removeprefix("video").lstrip("_"), path.stat().st_size
        if size < room:
            room -= size
            films.append((name, _data_uri(path, "video/mp4") or ""))
        else:
            linked.append((name, path.name))
    return films, linked


def _data_uri(path: Path | None, kind: str) -> str | None:
    if path is None or not path.is_file():
        return None
    return f"data:{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


# --- files of the run --------------------------------------------------------------


def _read_measures(path: Path) -> tuple[Array, dict[str, Array]]:
    try:
        rows = list(csv.reader(path.read_text("utf-8").splitlines()))
        table = np.array([[float(x or "nan") for x in row] for row in rows[1:]]).reshape(-1, len(rows[0]))
    except (OSError, ValueError, IndexError):
        return np.zeros(0), {}
    return table[:, 0], {name: table[:, i] for i, name in enumerate(rows[0]) if i}


def _read_events(run_dir: Path) -> list[dict[str, Any]]:
    rows = []
    for line in _read_text(run_dir / "events.jsonl").splitlines():
        try:
            rows.append(json.loads(line))
        except ValueError:
            continue
    return [row for row in rows if isinstance(row, dict) and "time" in row and "name" in row]


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def _read_text(path: Path) -> str:
    try:
        return path.read_text("utf-8", "replace")
    except OSError:
        return ""


# --- words -------------------------------------------------------------------------


def _number(value: Any, unit: str = "") -> str:
    """Return a number with four digits and its unit; a dash for none."""
    if value is None:
        return "–"
    if isinstance(value, list | tuple):
        return f"({', '.join(_number(x) for x in value)}) {unit}".rstrip()
    return f"{value:.4g} {unit}".rstrip() if isinstance(value, int | float) else str(value)


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:].rstrip(".") + "."


def _percent(share: Any) -> str:
    return f"{100 * share:.2g} %"


def _prose(text: Any) -> Any:
    """Return text as HTML, with what stands in backticks set as code."""
    from markupsafe import Markup, escape

    parts = str(text).split("`")
    if len(parts) % 2 == 0:  # a stray one means nothing
        return escape(text)
    marked = (escape(p) if i % 2 == 0 else Markup("<code>{}</code>").format(p) for i, p in enumerate(parts))
    return Markup("").join(marked)


def _seconds(value: Any) -> str:
    return "–" if value is None else f"{value:.3f} s"
