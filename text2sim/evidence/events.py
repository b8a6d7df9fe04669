"""Detection of events in a recording.

Contact events have the resolution of a time step; the others are interpolated between frames.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from text2sim.evidence import bonds
from text2sim.evidence.contact_events import EventError, Occurrence, find_contacts, find_separations
from text2sim.evidence.measures import Series
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget, SelectionError
from text2sim.recording.geometry import depth_inside
from text2sim.recording.states import Array
from text2sim.spec_schema.models import events
from text2sim.spec_schema.models.controls import Attach, Release, Remove

LIMIT_TOUCH, LIMIT_LEAVE = 0.002, 0.02
"""Parts of a joint's range: nearer than the first to a limit, it has arrived; farther than the second, it has left."""


@dataclass
class EventLog:
    """Every time of every declared event."""

    occurrences: dict[str, list[Occurrence]] = field(default_factory=dict)
    """By name, each sorted by time."""
    problems: dict[str, str] = field(default_factory=dict)
    """Why an event could not be looked for, by name."""
    nearest: dict[str, str] = field(default_factory=dict)
    """How near an event came that never happened, by name, where that is known."""

    def first(self, name: str) -> float | None:
        """Return the first time [s] of an event; None if it never happened."""
        times = self.occurrences.get(name)
        return times[0]["time"] if times else None

    def sorted(self) -> list[Occurrence]:
        """Return all occurrences by time, then name."""
        return sorted((o for rows in self.occurrences.values() for o in rows), key=_order)


def find_events(recording: RecordedCase, series: Mapping[str, Series]) -> EventLog:
    """Find every declared event; one that comes `after` another is evaluated once that is known."""
    log = EventLog()
    events = recording.case.actions.events
    waiting = dict(events)
    while waiting:
        ready = [name for name, event in waiting.items() if not _prerequisites(recording, event) & waiting.keys()]
        if not ready:
            for name in waiting:
                log.occurrences[name] = []
                log.problems[name] = "it waits for itself: `after` or a release goes in a circle"
            break
        for name in ready:
            event = waiting.pop(name)
            since = 0.0 if event.after is None else log.first(event.after)
            log.occurrences[name] = []
            if event.after is not None and event.after not in events:
                log.problems[name] = f"there is no event `{event.after}` to come after"
            elif since is not None:
                _search(recording, series, name, event, since, log)
            else:
                log.nearest[name] = f"`{event.after}`, which it comes after, never happened"
    log.occurrences = {name: log.occurrences[name] for name in events}
    return log


def _prerequisites(recording: RecordedCase, event: events.Event) -> set[str]:
    """Return the names of the events that have to be known first."""
    names = {event.after} if event.after is not None else set()
    if isinstance(event, events.RemovedEvent):
        control = recording.case.actions.controls.get(event.remove)
        names |= {control.on} if isinstance(control, Remove) and control.on is not None else set()
    if isinstance(event, events.ReleasedEvent):
        names |= {c.on for c in _releases(recording, event) if c.on is not None}
    return names


def _search(
    recording: RecordedCase, series: Mapping[str, Series], name: str, event: events.Event, since: float, log: EventLog
) -> None:
    try:
        if isinstance(event, events.ReleasedEvent):
            rows = _released(recording, event, log)
        elif isinstance(event, events.RemovedEvent):
            rows = _removed(recording, event)
        elif isinstance(event, events.BrokenEvent):
            rows = bonds.breaks(recording, event.bond)
        else:
            rows = _FINDERS[event.kind](recording, series, event, since)
    except (SelectionError, EventError) as error:
        log.problems[name] = str(error)
        return
    if event.after is not None:
        # Rest may have begun before `since`; every other event has to occur after it.
        rows = [row for row in rows if row["time"] > since or (event.kind == "rest" and row["time"] == since)]
    log.occurrences[name] = sorted(({"name": name, "kind": event.kind, **row} for row in rows), key=_order)
    if not rows and (near := _how_near(recording, series, event, since)):
        log.nearest[name] = near


def _how_near(recording: RecordedCase, series: Mapping[str, Series], event: events.Event, since: float) -> str:
    """Return the value nearest to the bound of an event that did not happen; empty for kinds without one."""
    later = recording.states.time >= since
    if isinstance(event, events.ThresholdEvent):
        measured = series[event.measure]
        time, values, unit = recording.states.time[later], measured.values[later], f" {measured.unit}".rstrip()
        rising = event.above is not None
        if not np.isfinite(values).any():
            return ""
        best = int(np.nanargmax(values) if rising else np.nanargmin(values))
        if values[best] >= event.above if event.above is not None else values[best] <= (event.below or 0.0):
            return f"`{event.measure}` was already {'above' if rising else 'below'} it at {time[0]:.4g} s"
        most = "at most" if rising else "at least"
        return f"`{event.measure}` was {most} {values[best]:.4g}{unit}, at {time[best]:.4g} s"
    if isinstance(event, events.RestEvent):
        speeds = np.fmax.reduce([_speed(recording, target) for target in recording.names.select(event.of)], axis=0)
        if not np.isfinite(speeds[later]).any():
            return ""
        best = int(np.nanargmin(np.where(later, speeds, np.nan)))
        return f"it was slowest at {recording.states.time[best]:.4g} s, {speeds[best]:.3g} m/s"
    return ""


def _order(row: Occurrence) -> tuple[Any, ...]:
    return row["time"], row["name"] or "", row.get("between", []), row.get("of", "")


# --- from frames -------------------------------------------------------------------


def crossings(time: Array, height: Array) -> list[float]:
    """Return the times [s] at which values rise through zero, linearly interpolated between frames."""
    with np.errstate(invalid="ignore"):
        at = np.flatnonzero((height[:-1] < 0) & (height[1:] >= 0)) + 1
    part = -height[at - 1] / (height[at] - height[at - 1])
    return (time[at - 1] + part * (time[at] - time[at - 1])).tolist()


def _threshold(
    recording: RecordedCase, series: Mapping[str, Series], event: events.ThresholdEvent, since: float
) -> list[Occurrence]:
    """A measure crosses a value; starting beyond it does not count."""
    measured = series.get(event.measure)
    if measured is None or measured.problem:
        raise EventError(measured.problem if measured else f"there is no measure `{event.measure}`")
    height = measured.values - event.above if event.above is not None else (event.below or 0.0) - measured.values
    bound = event.above if event.above is not None else event.below
    return [{"time": t, "measure": event.measure, "value": bound} for t in crossings(recording.states.time, height)]


def _find_rest(recording: RecordedCase, series: Any, event: events.RestEvent, since: float) -> list[Occurrence]:
    """All bodies are slow for a while; the time is when that while begins. Rotation is ignored.

    For a deformable body, the root mean square speed of its points counts: sqrt(2 E / m).
    """
    time = recording.states.time
    targets = recording.names.select(event.of)
    about = {"of": event.of} if isinstance(event.of, str) else {"between": event.subjects}
    speeds = [_speed(recording, target) for target in targets]
    if not len(time):
        return []
    height = event.speed - np.fmax.reduce(speeds, axis=0)  # nan for what has left the scene
    quiet = height >= 0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], quiet, [False]]).astype(int)))
    rows = []
    for first, last in zip(edges[::2], edges[1::2] - 1, strict=True):
        begin = float(time[first])
        if first and height[first - 1] < 0:
            begin = crossings(time[first - 1 : first + 1], height[first - 1 : first + 1])[0]
        begin = max(begin, since)
        if time[last] - begin >= event.for_ - 1e-9:
            rows.append({"time": begin, **about})
    return rows


def _speed(recording: RecordedCase, target: RecordedTarget) -> Array:
    body = recording.deformable(target)
    if body is None:
        return np.linalg.norm(recording.velocity(target), axis=1)
    return np.sqrt(2 * recording.states.soft_kinetic[:, body.index].astype(float) / body.mass)


def _region(recording: RecordedCase, series: Any, event: events.RegionEvent, since: float) -> list[Occurrence]:
    """A body's origin enters or leaves a region."""
    sign = 1.0 if event.kind == "enters" else -1.0
    return _passages(recording, event.of, lambda points: sign * recording.depth_in(event.region, points))


def _left_domain(recording: RecordedCase, series: Any, event: events.LeftDomainEvent, since: float) -> list[Occurrence]:
    """A body's origin leaves the scene's domain; a body that starts outside has left it at the start."""
    domain = recording.case.scene.domain
    if domain is None:
        raise EventError("the scene has no domain that could be left")
    return _passages(recording, event.of, lambda points: -depth_inside(domain, points), from_start=True)


def _passages(
    recording: RecordedCase, selectors: str | list[str], height: Callable[[Array], Array], from_start: bool = False
) -> list[Occurrence]:
    time, rows = recording.states.time, []
    for target in recording.names.select(selectors):
        origin = recording.origin(target)
        high = height(origin)
        times = crossings(time, high)
        if from_start and len(high) and high[0] > 0:
            times.insert(0, float(time[0]))
        for t in times:
            rows.append(
                {
                    "time": t,
                    "of": target.label,
                    "pos": [float(np.interp(t, time, column)) for column in origin.T],
                }
            )
    return rows


def _joint_limit(recording: RecordedCase, series: Any, event: events.JointLimitEvent, since: float) -> list[Occurrence]:
    """A joint comes within 0.2 % of its range of a limit; again only after it was 2 % away.

    A joint that starts at a limit does not count.
    """
    time, rows = recording.states.time, []
    for label, joint in recording.names.select_joints(event.of):
        low, high = joint.limits
        if joint.kind not in ("hinge", "slider") or (low is None and high is None):
            raise EventError(f"{label} has no limits")
        position = recording.states.qpos[:, joint.q[0]].astype(float)
        span = high - low if low is not None and high is not None else 1.0
        for end, past in (("lower", low), ("upper", high)):
            if past is None:
                continue
            beyond = (position - past if end == "upper" else past - position) + LIMIT_TOUCH * span
            before = float(time[0]) if len(time) and beyond[0] >= 0 else None
            for t in crossings(time, beyond):
                between = beyond[(time > (before or 0.0)) & (time < t)]
                if before is None or (len(between) and between.min() < -LIMIT_LEAVE * span):
                    rows.append({"time": t, "of": label, "end": end, "limit": past})
                before = t
    return rows


def _releases(recording: RecordedCase, event: events.ReleasedEvent) -> list[Release]:
    controls = recording.case.actions.controls
    return [c for c in controls.values() if isinstance(c, Release) and c.attach == event.attach]


def _released(recording: RecordedCase, event: events.ReleasedEvent, log: EventLog) -> list[Occurrence]:
    """The case releases an attachment, at a time or on an event."""
    attach = recording.case.actions.controls.get(event.attach)
    if not isinstance(attach, Attach):
        raise EventError(f"there is no attach `{event.attach}`")
    times = [c.at if c.on is None else acted_on(recording, c.on, log) for c in _releases(recording, event)]
    own = [bond for bond in recording.states.bonds if bond.control == event.attach]
    end = recording.states.end + 1e-9
    if own and all(bond.broken_at is not None for bond in own):  # nothing was left to be released after that
        end = max(bond.broken_at or 0.0 for bond in own)
    return [{"time": t, "between": [attach.body, attach.to]} for t in times if t is not None and t <= end]


def acted_on(recording: RecordedCase, name: str, log: EventLog) -> float | None:
    """Return when the program acts on an event [s], None if it did not happen: rest is known only when it has lasted.

    Args:
        recording: The recording, whose case has the event.
        name: The event.
        log: What happened.
    """
    event, first = recording.case.actions.events[name], log.first(name)
    return first + event.for_ if first is not None and isinstance(event, events.RestEvent) else first


def _removed(recording: RecordedCase, event: events.RemovedEvent) -> list[Occurrence]:
    """The program takes copies out of the scene."""
    control = recording.case.actions.controls.get(event.remove)
    if not isinstance(control, Remove):
        raise EventError(f"there is no control `{event.remove}` of kind remove")
    copies = [target.copy for target in recording.names.select(control.body)]
    removed = recording.states.removed
    return [{"time": removed[copy], "of": copy} for copy in copies if copy in removed]


_FINDERS: dict[str, Callable[[RecordedCase, Mapping[str, Series], Any, float], list[Occurrence]]] = {
    "contact": find_contacts,
    "separation": find_separations,
    "threshold": _threshold,
    "rest": _find_rest,
    "left_domain": _left_domain,
    "enters": _region,
    "leaves": _region,
    "joint_limit": _joint_limit,
}
