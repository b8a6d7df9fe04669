"""Evidence of a recorded run: measures, events, diagnostics, and the verdict on expectations.

A pure function of the recorded states and the case: judging again needs no simulation and yields identical bytes.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.evidence import bonds, diagnostics
from text2sim.evidence.contact_events import Occurrence, episode_rows
from text2sim.evidence.contacts import choose
from text2sim.evidence.deep_contacts import deepest_contact
from text2sim.evidence.events import EventLog, find_events
from text2sim.evidence.expectations import Ending, Finding, judge_expectations
from text2sim.evidence.gone_through import gone_through
from text2sim.evidence.measures import Series, evaluate
from text2sim.evidence.motors_at_limit import motors_at_limit, overloaded
from text2sim.evidence.off_path import held_up, off_path
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.soft_diagnostics import soft_diagnostics
from text2sim.evidence.suspicions import suspicions
from text2sim.evidence.visibility import summarise_legibility, summarise_visibility
from text2sim.recording.record import RunRecord
from text2sim.recording.states import Array
from text2sim.runtime.outcome import read_status
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.events import ContactEvent, SeparationEvent
from text2sim.spec_schema.models.measures import ContactCount, ContactForce, Penetration
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.whole_files import write_atomically

MAX_LISTED_EPISODES = 5_000
"""Most undeclared touches that `events.jsonl` lists."""
MAX_LISTED_OVERSHOOTS = 50
"""Most joint overshoots that the evidence lists."""
STOPPED_STATES = ("interrupted", "running")
"""States of a run that someone stopped: what it did not reach is open. In other states, it counts as missed."""


def judge(run_dir: Path, case: Case, loaded: LoadedCase | None = None) -> dict[str, Any]:
    """Judge a recorded run; write `events.jsonl`, `measures.csv` and `evidence.json`.

    Args:
        run_dir: The run folder.
        case: The case, whose measures, events and expectations may have changed since the run.
        loaded: The case as it was read, for driven bodies whose copies differ.

    Returns:
        Content of `evidence.json`.

    Raises:
        RunError: if nothing readable was recorded.
    """
    recording = RecordedCase.load(run_dir, case)
    states = recording.states
    state, message, where = _outcome(run_dir)
    lacking = states.lacks(state)
    # Nothing can be said about what a damaged recording does not show.
    ending = Ending(
        states.end, case.scene.duration, state == "finished" and not lacking, state in STOPPED_STATES or bool(lacking)
    )
    series = evaluate(recording)
    with np.errstate(all="ignore"):  # a diverged run holds numbers that overflow
        events = find_events(recording, series)
        findings = judge_expectations(case.actions.expect, states.time, series, events, ending)
        touches, contacts = _touches(recording)
        verdict, why = _verdict(findings, state, message)
        if lacking:
            verdict, why = "incomplete", f"the recording is damaged: {lacking}; run the case again"
        deforming = soft_diagnostics(recording)
        driven, motors = off_path(recording, loaded), motors_at_limit(recording, events)
        deep = deepest_contact(recording)
        evidence = {
            "case": case.name,
            "verdict": verdict,
            "why": why,
            "state": state,
            "message": message,
            "where": where,
            "time": {
                "reached": states.end,
                "duration": case.scene.duration,
                "dt": states.dt,
                "frames": states.frames,
            },
            "expect": {finding.name: asdict(finding) for finding in findings},
            "measures": {name: _summary(states.time, row) for name, row in series.items()},
            "events": {name: _times(events, name) for name in events.occurrences},
            "energy": diagnostics.energy_account(recording),
            "penetration": diagnostics.largest_penetration(recording),
            "non_finite": diagnostics.first_non_finite(recording),
            "speeds": diagnostics.speed_extremes(recording),
            "joint_limits": diagnostics.limit_overshoots(recording)[:MAX_LISTED_OVERSHOOTS],
            "deformables": deforming,
            "suspicions": [
                *suspicions(recording, deforming),
                *gone_through(recording),
                *([deep.message] if deep is not None else ()),
                *held_up(driven),
                *overloaded(motors),
                *diagnostics.energy_from_nowhere(recording),
            ],
            "substeps_factor": deep.substeps_factor if deep is not None else None,
            "removed": recording.states.removed,
            "bonds": bonds.summary(recording),
            "driven": recording.names.driven,
            "off_path": driven,
            "motors_at_limit": motors,
            "contacts": contacts,
            "visibility": summarise_visibility(run_dir, list(case.bodies)),
            "legibility": summarise_legibility(run_dir, case, events),
            "left_out": [*states.losses, *_left_out(recording, contacts)],
        }
    plain = to_plain(evidence)
    rows = sorted(
        [*events.sorted(), *touches], key=lambda row: (row["time"], row["name"] or "", row.get("between", []))
    )
    write_atomically(run_dir / "events.jsonl", "".join(dump_line(row) + "\n" for row in rows))
    write_atomically(run_dir / "measures.csv", _csv(states.time, series))
    write_atomically(run_dir / "evidence.json", json.dumps(plain, indent=1, sort_keys=True, allow_nan=False) + "\n")
    return plain


def to_plain(value: Any) -> Any:
    """Return data for strict JSON: numbers with nine digits, None for non-finite ones."""
    if isinstance(value, Mapping):
        return {str(key): to_plain(row) for key, row in value.items()}
    if isinstance(value, np.ndarray):
        return to_plain(value.tolist())
    if isinstance(value, list | tuple):
        return [to_plain(row) for row in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(f"{value:.9g}") + 0.0 if math.isfinite(value) else None
    return value if value is None else str(value)


def dump_line(row: Mapping[str, Any]) -> str:
    """Return a record as one line of strict JSON."""
    return json.dumps(to_plain(row), sort_keys=True, allow_nan=False)


def _outcome(run_dir: Path) -> tuple[str, str, Any]:
    """Return (state, message, where) of a run, from its record or from the program's own status."""
    status = read_status(run_dir / "status.json")
    where = status.get("where") or None
    record = RunRecord.read(run_dir)
    if record is not None and record.state != "running":
        return record.state, record.message, where or record.where
    state = str(status.get("state") or "interrupted")
    return state, "" if state == "finished" else str(status.get("message") or ""), where


def _verdict(findings: list[Finding], state: str, message: str) -> tuple[str, str]:
    """Return (passed, failed or incomplete; the reason)."""
    missed = [finding.name for finding in findings if finding.ok is False]
    reason = message if message.startswith(state) else f"{state}: {message}".removesuffix(": ")
    ended = f"the run did not finish ({reason})"
    if missed:
        first = f"{len(missed)} of {len(findings)} expectations missed: {', '.join(missed)}"
        return "failed", first if state == "finished" else f"{ended}; {first}"
    if state in STOPPED_STATES:
        return "incomplete", "the run was stopped before its end"
    if state != "finished":
        return "failed", ended
    return (
        "passed",
        f"all {len(findings)} expectations came true" if findings else "it ran to its end; nothing was expected",
    )


def _summary(time: Array, series: Series) -> dict[str, Any]:
    return {"unit": series.unit, "problem": series.problem or None, **diagnostics.extremes(time, series.values)}


def _times(events: EventLog, name: str) -> dict[str, Any]:
    times = [row["time"] for row in events.occurrences[name]]
    return {
        "count": len(times), "first": times[0] if times else None, "last": times[-1] if times else None,
        "problem": events.problems.get(name),
    }  # fmt: skip


def _touches(recording: RecordedCase) -> tuple[list[Occurrence], dict[str, Any]]:
    """Return the touches between different bodies as occurrences without a name, and their statistics."""
    names, log = recording.names, recording.contacts
    targets = list(names.copies.values())
    bodies = list(dict.fromkeys(body_of(t.copy) for t in targets))
    body = np.array([bodies.index(body_of(t.copy)) for t in targets], dtype=np.int64)
    named = np.array([name in _named_with_itself(recording.case) for name in bodies], dtype=bool)
    copy_of_surface = names.copy_of_link[recording.states.surface_links]
    touches = log.between(copy_of_surface, copy_of_surface)
    first, second = body[touches.pair[:, 0]], body[touches.pair[:, 1]]
    listed = (first != second) | named[first]
    hidden = log.count_episodes(choose(touches, ~listed))
    episodes = log.episodes(choose(touches, listed))
    total = len(episodes.start)
    if total > MAX_LISTED_EPISODES:
        size = np.linalg.norm(episodes.impulse, axis=1)
        hardest = np.lexsort((*episodes.pair.T[::-1], episodes.start, -np.where(np.isfinite(size), size, np.inf)))
        episodes = choose(episodes, hardest[:MAX_LISTED_EPISODES])
    rows = [{"name": None, "kind": "contact", **row} for row in episode_rows(episodes, targets, targets)]
    return rows, {
        "recorded": log.recorded,
        "rows": len(log.step),
        "episodes": total + hidden,
        "listed": len(rows),
        "left_out": total - len(rows),
        "within_repeated_bodies": hidden,
    }


def _named_with_itself(case: Case) -> set[str]:
    """Return bodies for which the case declares events or measures of contact between their own copies."""
    pairs = [e.between for e in case.actions.events.values() if isinstance(e, ContactEvent | SeparationEvent)]
    for measure in case.actions.measures.values():
        if isinstance(measure, ContactForce | ContactCount | Penetration) and measure.by is not None:
            pairs += product(measure.subjects, listed(measure.by))
    bases = [tuple(body_of(name) for name in pair) for pair in pairs]
    return {a for a, b in bases if a == b}


def _left_out(recording: RecordedCase, contacts: dict[str, Any]) -> list[str]:
    rows = []
    if contacts["left_out"]:
        rows.append(
            f"events.jsonl: {contacts['left_out']} of the smaller touches between bodies (it lists "
            f"{MAX_LISTED_EPISODES})"
        )
    if contacts["within_repeated_bodies"]:
        rows.append(f"events.jsonl: {contacts['within_repeated_bodies']} touches between copies of one body")
    if not contacts["recorded"]:
        rows.append(recording.contacts.why_not)
    if recording.states.deformables:
        rows.append("events.jsonl: touches of deformable bodies that no event asks for")
    return rows


def _csv(time: Array, series: Mapping[str, Series]) -> str:
    table = np.column_stack([time, *(row.values for row in series.values())]) if len(time) else np.zeros((0, 1))
    lines = [",".join(["time", *series])]
    lines += [",".join(f"{v:.9g}" if math.isfinite(v) else "" for v in row) for row in table.tolist()]
    return "\n".join(lines) + "\n"
