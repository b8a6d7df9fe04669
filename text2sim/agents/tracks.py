"""Positions and velocities of bodies at events, and how contacts were missed, for the Critic and the Planner."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.agents.frame_choice import named_bodies
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import SelectionError
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.events import ContactEvent
from text2sim.spec_schema.names.selectors import body_of

MAX_BODIES = 5
"""Largest number of bodies whose tracks are listed, those of measures first; of several copies, only the first."""
MAX_EVENTS = 3
"""Largest number of events at which they are listed, the earliest first."""
MAX_PAIRS = 400
"""Largest number of pairs of copies that are compared for a contact that never happened."""
SLOW = 0.005
"""Speed [m/s] below which no velocity is listed, and displacement [m] below which a body is left out."""


def tracks_text(run: Path, case: Case, events: Mapping[str, Mapping[str, Any]]) -> str:
    """Return a section of the evidence with one line for each body that moves.

    Args:
        run: The run folder.
        case: The case.
        events: Events of the evidence, by name.
    """
    rows = track_rows(run, case, events)
    return "\n".join(["## Positions [m], velocities v [m/s]", "", *(f"- {row}" for row in rows)]) if rows else ""


def track_rows(run: Path, case: Case, events: Mapping[str, Mapping[str, Any]], limit: int = MAX_BODIES) -> list[str]:
    """Return how contacts were missed, and positions and velocities of what moves, at start, events and end.

    Args:
        run: The run folder.
        case: The case.
        events: Events of the evidence, by name.
        limit: Largest number of bodies that move.
    """
    recording = RecordedCase.load(run, case)
    time = recording.states.time
    if not len(time):
        return []
    firsts = sorted((row["first"], name) for name, row in events.items() if row.get("first") is not None)
    moments = [("start", float(time[0])), *((name, t) for t, name in firsts[:MAX_EVENTS]), ("end", float(time[-1]))]
    frames = np.abs(time[:, None] - [t for _, t in moments]).argmin(axis=0)
    measured = [name for measure in case.actions.measures.values() for name in named_bodies(measure.model_dump())]
    rows = _missed_contacts(recording, case, events)
    limit += len(rows)
    for name in dict.fromkeys([*(name for name in measured if name in case.bodies), *case.bodies]):
        target = recording.names.select(name)[0]
        places, velocities = recording.origin(target)[frames], recording.velocity(target)[frames]
        if np.nanmax(np.linalg.norm(places - places[:1], axis=1), initial=0.0) < SLOW:
            continue
        found = [
            f"{label} {_vector(place)}{_velocity_text(velocity)}"
            for (label, _), place, velocity in zip(moments, places, velocities, strict=True)
            if np.isfinite(place).all()
        ]
        rows.append(f"`{target.label}`: " + "; ".join(found))
    return rows[:limit]


def _missed_contacts(recording: RecordedCase, case: Case, events: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return for each contact that never happened when the centres of its bodies were nearest to each other."""
    rows = []
    for name, event in case.actions.events.items():
        if not isinstance(event, ContactEvent) or events.get(name, {}).get("first") is not None:
            continue
        if any(body_of(selector) in case.scene.statics for selector in event.between):
            continue  # the centre of a floor says nothing
        try:
            ones, others = (recording.names.select(selector) for selector in event.between)
        except SelectionError:
            continue
        pairs = [(one, other) for one in ones for other in others if one.label != other.label][:MAX_PAIRS]
        gaps = np.array(
            [np.linalg.norm(recording.origin(one) - recording.origin(other), axis=1) for one, other in pairs]
        )
        if not np.isfinite(gaps).any():
            continue
        pair, frame = np.unravel_index(np.nanargmin(gaps), gaps.shape)
        one, other = pairs[pair]
        places = f"{_vector(recording.origin(one)[frame])} and {_vector(recording.origin(other)[frame])}"
        when = f"{recording.states.time[frame]:.3g} s: {gaps[pair, frame]:.2g} m between centres, at {places}"
        rows.append(f"`{name}` never happened; `{one.label}` and `{other.label}` were nearest at {when}")
    return rows[:MAX_EVENTS]


def _vector(values: Any) -> str:
    return "(" + ", ".join(f"{round(float(value), 2) + 0.0:g}" for value in values) + ")"


def _velocity_text(velocity: Any) -> str:
    if not np.isfinite(velocity).all():
        return ""
    return "" if np.linalg.norm(velocity) < SLOW else f" v {_vector(velocity)}"
