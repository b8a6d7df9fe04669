"""Report of a run: one self-contained HTML page."""

from pathlib import Path
from typing import Any

import numpy as np

from text2sim.evidence.contact_sheet import write_contact_sheet
from text2sim.evidence.diagnostics import energy_series
from text2sim.evidence.evidence import STOPPED_STATES
from text2sim.evidence.expectations import moment, shifted_to
from text2sim.evidence.page import data_uri, read_films, render_page, sentence
from text2sim.evidence.plots import GREEN, ORANGE, PlotBound, PlotLine, plot_series
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.recording.record import RunRecord
from text2sim.recording.run_files import read_events, read_evidence, read_measures, read_text
from text2sim.recording.states import Array
from text2sim.runtime.outcome import printable, read_end
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.whole_files import write_atomically

MAX_LISTED_TOUCHES = 25
"""Most undeclared touches in the table, the hardest ones."""
MAX_LISTED_OCCURRENCES = 200
"""Most times of declared events in the table."""
SOFT_WORDS = {
    "volume": "volume, over that at the start",
    "stretch": "longest edge, over its length at the start",
    "strain": "equivalent strain that 99 of 100 elements stay below",
    "inverted": "part of the volume turned inside out",
    "penetration": "deepest point in something rigid",
    "self_penetration": "nearest to itself, below its thickness",
    "speed": "fastest point",
    "torn": "part that is off the largest piece",
    "against_bounds": "part of the points against the sides of their solver's space",
}
"""Rows of the table of deformable bodies."""
REPLAY = "replay.html"
"""The page in 3D beside the report, if there is one."""
LOG_TAIL = 6_000
"""Bytes shown of the end of the log."""


def write_report(run_dir: Path, case: Case) -> Path:
    """Write `plots/`, `contact_sheet.png` and `report.html` of a run with evidence.

    The page omits what is missing: the film, frames, measures, even the evidence itself.
    """
    page = render_page("evidence", "report.html.j2", _contents(run_dir, case))
    path = run_dir / "report.html"
    write_atomically(path, page)
    return path


def _contents(run_dir: Path, case: Case) -> dict[str, Any]:
    evidence = read_evidence(run_dir) or {}
    record = RunRecord.read(run_dir)
    events = read_events(run_dir)
    declared = [row for row in events if row["name"]]
    touches = [row for row in events if not row["name"]]
    touches.sort(key=lambda row: -sum(x * x for x in row.get("impulse") or [0.0] if x is not None))
    films, linked = read_films(run_dir)
    # Failed expectations come first.
    found = [row for name in case.actions.expect if (row := evidence.get("expect", {}).get(name))]
    found.sort(key=lambda row: {False: 0, None: 1, True: 2}[row["ok"]])
    return {
        "case": case,
        "evidence": evidence,
        "record": record,
        "verdict": evidence.get("verdict")
        or ("failed" if record and record.state not in STOPPED_STATES else "incomplete"),
        "why": sentence(evidence.get("why") or (record.message if record else "") or "there is nothing to judge"),
        "expect": found,
        "soft_words": SOFT_WORDS,
        "declared": declared[:MAX_LISTED_OCCURRENCES],
        "declared_left_out": max(0, len(declared) - MAX_LISTED_OCCURRENCES),
        "touches": touches[:MAX_LISTED_TOUCHES],
        "films": films,
        "linked": linked,
        "replay": REPLAY if (run_dir / REPLAY).is_file() else None,
        "first": None if films else data_uri(run_dir / "first.png", "image/png"),
        "sheet": data_uri(write_contact_sheet(run_dir), "image/png"),
        "plots": _plots(run_dir, case, evidence, declared),
        "case_text": read_text(run_dir / "case.yaml"),
        "log": printable(read_end(run_dir / "log.txt", limit=LOG_TAIL)),
    }


# --- pictures ----------------------------------------------------------------------


def _plots(run_dir: Path, case: Case, evidence: dict[str, Any], events: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """Draw the plots; return (name, data URI) of each."""
    folder = run_dir / "plots"
    folder.mkdir(exist_ok=True)
    for stale in folder.glob("*.png"):
        stale.unlink()
    time, columns = read_measures(run_dir)
    found = []
    for name, values in columns.items():
        summary = evidence.get("measures", {}).get(name)
        if summary is None or not np.isfinite(values).any():
            continue
        bounds = [b for key, row in case.actions.expect.items() if (b := bound_of(key, row, name, evidence, time))]
        title = f"{name}: {describe(case.actions.measures[name])}" if name in case.actions.measures else name
        plot_series(
            folder / f"{name}.png",
            time,
            [PlotLine(name, values)],
            title=title,
            unit=summary["unit"],
            bounds=bounds,
            events=events,
        )
        found.append(name)
    energy = _energy_lines(run_dir, case)
    if energy is not None:
        # The names of measures have no dots.
        plot_series(
            folder / "all.energy.png",
            *energy,
            title="mechanical energy of all bodies that move freely",
            unit="J",
            events=events,
        )
        found.append("all.energy")
    return [(name, data_uri(folder / f"{name}.png", "image/png") or "") for name in found]


def _energy_lines(run_dir: Path, case: Case) -> tuple[Array, list[PlotLine]] | None:
    try:
        recording = RecordedCase.load(run_dir, case)
        with np.errstate(all="ignore"):
            rows = energy_series(recording)
    except RunError:
        return None
    if not recording.states.frames or not np.isfinite(rows["total"]).any():
        return None
    lines = [
        PlotLine("kinetic", rows["kinetic"], ORANGE, "--"),
        PlotLine("potential", rows["potential"], GREEN, ":"),
        PlotLine("total", rows["total"]),
    ]
    return recording.states.time, lines


def bound_of(name: str, expect: Expect, measure: str, evidence: dict[str, Any], time: Array) -> PlotBound | None:
    """Return the bound that an expectation puts on the values of a measure; None if it puts none.

    Args:
        name: Name of the expectation.
        expect: The expectation.
        measure: Name of the measure.
        evidence: Content of `evidence.json`.
        time: Times of the measure [s].
    """
    # A bound on another statistic of a measure does not bound its values.
    if expect.measure != measure or expect.stat not in (None, "max", "min") or not len(time):
        return None
    if expect.on is not None:
        started = evidence.get("events", {}).get(expect.on, {}).get("first")
        if started is None:
            return None
        expect = shifted_to(expect, started)
    if expect.at is not None:
        start = end = moment(expect.at, time)
    else:
        window = expect.during if isinstance(expect.during, tuple) else (float(time[0]), float(time[-1]))
        start, end = span_of(window, float(time[-1]))
    low, high = expect.above, expect.below
    if expect.equals is not None and expect.tolerance is not None:
        low, high = expect.equals - expect.tolerance, expect.equals + expect.tolerance
    some = (expect.stat == "max" and expect.below is None) or (expect.stat == "min" and expect.above is None)
    return PlotBound(name, start, end, low, high, evidence.get("expect", {}).get(name, {}).get("ok"), every=not some)


def describe(model: Any) -> str:
    """Return the definition of a measure on one line."""
    data = model.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    kind = data.pop("kind").replace("_", " ")
    return " ".join([kind, ", ".join(f"{key} {_flat(value)}" for key, value in data.items())])


def _flat(value: Any) -> str:
    if isinstance(value, dict):
        return "(" + ", ".join(f"{key} {_flat(row)}" for key, row in value.items()) + ")"
    if isinstance(value, list | tuple):
        return ", ".join(map(_flat, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
