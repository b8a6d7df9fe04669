"""Detection of events in the contacts of a recording, with the resolution of a time step."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from text2sim.evidence.contacts import Episodes, choose
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget
from text2sim.evidence.soft_events import soft_episodes
from text2sim.spec_schema.models import events

Occurrence = dict[str, Any]
"""One time of an event: name, kind, time [s], and what is known about it."""


class EventError(ValueError):
    """Error: an event cannot be detected in this recording."""


def episode_rows(
    episodes: Episodes, first: Sequence[RecordedTarget], second: Sequence[RecordedTarget]
) -> list[Occurrence]:
    """Return touches as occurrences. `impulse` is what the first of `between` received from the second [N s].

    Args:
        episodes: The touches.
        first: Targets on one side, in the order of `Episodes.pair`.
        second: Targets on the other side.
    """
    plain = {column.name: getattr(episodes, column.name).tolist() for column in fields(episodes)}
    return [
        {
            "time": plain["start"][i],
            "end": plain["end"][i],
            "ongoing": plain["ongoing"][i],
            "between": [first[a].label, second[b].label],
            "pos": plain["pos"][i],
            "impulse": plain["impulse"][i],
            "normal_impulse": plain["normal_impulse"][i],
            "impact_impulse": plain["impact_impulse"][i],
            "peak_force": plain["peak_force"][i],
            "penetration": plain["depth"][i],
        }
        for i, (a, b) in enumerate(plain["pair"])
    ]


def _episodes(
    recording: RecordedCase, between: tuple[str, str]
) -> tuple[Episodes, list[RecordedTarget], list[RecordedTarget]]:
    if not recording.contacts.recorded:
        raise EventError(recording.contacts.why_not)
    names = recording.names
    first = names.select_touching(between[0])
    second = first if between[0] == between[1] else names.select_touching(between[1])
    groups = names.groups(first)
    touches = recording.contacts.between(groups, groups if second is first else names.groups(second))
    return recording.contacts.episodes(touches), first, second


def _soft_rows(recording: RecordedCase, between: tuple[str, str]) -> list[Occurrence] | None:
    """Return the touches of two selectors if one selects deformable bodies; None if neither does."""
    first, second = (recording.names.select_touching(selector) for selector in between)
    if all(target.soft is None for target in (*first, *second)):
        return None
    return soft_episodes(recording, first, second)


def find_contacts(recording: RecordedCase, series: Any, event: events.ContactEvent, since: float) -> list[Occurrence]:
    """Return the beginnings of touches.

    A touch counts if it transfers `min_impulse` within its first 50 ms; over a longer time,
    even a feather at rest would reach any impulse.

    Args:
        recording: What was recorded.
        series: Of measures; not needed.
        event: The event.
        since: Not needed.

    Raises:
        EventError: if contacts were not recorded, or there are no forces for `min_impulse`.
        SelectionError: if a selector matches nothing.
    """
    rows = _soft_rows(recording, event.between)
    if rows is not None:
        if event.min_impulse > 0:
            raise EventError("the engine reports no forces on deformable bodies: `min_impulse` cannot be judged")
        return rows
    episodes, first, second = _episodes(recording, event.between)
    return episode_rows(choose(episodes, episodes.impact_impulse >= event.min_impulse), first, second)


def find_separations(
    recording: RecordedCase, series: Any, event: events.SeparationEvent, since: float
) -> list[Occurrence]:
    """Return the ends of touches that do not resume for a while; undecided near the end of the run.

    Args:
        recording: What was recorded.
        series: Of measures; not needed.
        event: The event.
        since: Not needed.

    Raises:
        EventError: if contacts were not recorded.
        SelectionError: if a selector matches nothing.
    """
    rows = _soft_rows(recording, event.between)
    if rows is not None:
        return _lasting(rows, recording.states.end, event.for_)
    episodes, first, second = _episodes(recording, event.between)
    until = np.append(episodes.start[1:], recording.states.end)
    last = np.append((episodes.pair[1:] != episodes.pair[:-1]).any(axis=1), True)
    until = np.where(last[: len(episodes.end)], recording.states.end, until[: len(episodes.end)])
    over = (until - episodes.end >= event.for_ - 1e-9) & ~episodes.ongoing.astype(bool)
    rows = episode_rows(choose(episodes, over), first, second)
    return [{"time": r["end"], "between": r["between"], "touched_since": r["time"]} for r in rows]


def _lasting(rows: list[Occurrence], end: float, span: float) -> list[Occurrence]:
    """Return the ends of touches after which there is no other touch of the pair for a span [s]."""
    found = []
    for row in rows:
        later = [other["time"] for other in rows if other["between"] == row["between"] and other["time"] > row["time"]]
        if not row["ongoing"] and min(later, default=end) - row["end"] >= span - 1e-9:
            found.append({"time": row["end"], "between": row["between"], "touched_since": row["time"]})
    return found
