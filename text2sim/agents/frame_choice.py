"""Choice of frames for the Critic: events, extremes of measures and diagnostics, and evenly spaced frames."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, Any

from text2sim.legibility.film import nearest_frame, spread_numbers
from text2sim.spec_schema.names.selectors import WORLD, body_of, strings_in

if TYPE_CHECKING:
    from text2sim.templates.cadence import Frame

Data = Mapping[str, Any]

MIN_INTERVAL, MIN_SPEED_FACTOR = 0.1, 0.2
"""Smallest simulated time between frames of one camera at full speed [s]; in slow motion, it shrinks in proportion to
the speed, down to this fraction."""
EVENT_OFFSET = 0.15
"""Time before and after an event at which frames are taken [s]."""
MAX_GAP_FRAMES, MIN_GAP_DIVISOR = 2, 5
"""Number of frames for the longest gaps, and the smallest fraction of the film (one in `MIN_GAP_DIVISOR`) that counts
as a gap."""
MAX_EVENTS, MAX_EXTREMES, MAX_DEFORMED, MAX_DECIDED, MAX_STRIKES = 4, 4, 2, 4, 2
"""Largest numbers of moments of each sort."""
AT_REST_FROM = 0.05
"""Time [s] until which bodies that rest on each other from the start touch for the first time."""
MAX_SHOTS = 3
"""Largest number of shots that are shown although nothing else in them is."""
MIN_PENETRATION = 0.002
"""Smallest penetration whose worst moment is shown [m]."""
MIN_DEFORMATION = {"strain": 0.05, "stretch": 1.05, "volume": 0.05}
"""Smallest deformation whose worst moment is shown; for `volume`, the relative change."""


@dataclass(frozen=True)
class FrameMoment:
    """A moment worth showing."""

    t: float
    """Simulated time [s]."""
    reason: str = ""
    """Caption."""
    bodies: tuple[str, ...] = ()
    """Bodies that it is about."""


@dataclass
class Shown:
    """A chosen frame, with the reasons for it."""

    frame: "Frame"
    moments: list[FrameMoment] = field(default_factory=list)

    @property
    def reasons(self) -> list[str]:
        """Captions of its moments, with the time of those that the frame does not match exactly."""
        rows = [(one, abs(self.frame.t - one.t) > _min_interval(self.frame) / 2) for one in self.moments if one.reason]
        return [f"{one.reason} at {one.t:.2f} s" if apart else one.reason for one, apart in rows]

    @property
    def bodies(self) -> set[str]:
        """Bodies that its moments are about."""
        return {body for one in self.moments for body in one.bodies}


def moments(evidence: Data, actions: Data, strikes: Sequence[FrameMoment] = ()) -> Iterator[FrameMoment]:
    """Yield the moments worth showing, the most important first.

    Args:
        evidence: Content of `evidence.json`.
        actions: The `actions` section of the case.
        strikes: Moments after strikes.
    """
    last = float(evidence["time"]["reached"])
    decided = list(_deciding_moments(evidence, actions))
    yield from decided
    yield from strikes
    happened = sorted(
        ((row["first"], name) for name, row in evidence["events"].items() if row.get("first") is not None),
    )[:MAX_EVENTS]
    events = [FrameMoment(t, name, named_bodies((actions.get("events") or {}).get(name))) for t, name in happened]
    yield from events
    used = {row.get("measure") for row in (actions.get("expect") or {}).values() if isinstance(row, dict)}
    extremes = [
        FrameMoment(row[f"{end}_at"], f"{end} of {name}", named_bodies((actions.get("measures") or {}).get(name)))
        for name, row in (evidence.get("measures") or {}).items()
        if name in used and not row.get("problem")
        for end in ("max", "min")
        if row.get(f"{end}_at") is not None
    ]
    yield from _frames_around([one for one in decided if MIN_INTERVAL < one.t < last - MIN_INTERVAL][:2])
    yield from _deformed(evidence)
    yield from [one for one in extremes if MIN_INTERVAL < one.t < last - MIN_INTERVAL][:MAX_EXTREMES]
    depth = evidence.get("penetration") or {}
    if (depth.get("value") or 0) >= MIN_PENETRATION:
        yield FrameMoment(depth["time"], "deepest overlap", tuple(map(body_of, depth.get("between") or ())))
    yield from _frames_around(events[:3])


def after_strikes(occurrences: Sequence[Data], statics: Collection[str]) -> list[FrameMoment]:
    """Return the moments shortly after two bodies that can move met first: where something starts to move.

    Args:
        occurrences: Content of `events.jsonl`, by time. Touches that the case declares count first, then the hardest.
        statics: Names of what cannot move.
    """
    first: dict[frozenset[str], tuple[bool, float, FrameMoment]] = {}
    for row in occurrences:
        pair = tuple(dict.fromkeys(body_of(name) for name in row.get("between") or ()))
        if row.get("kind") != "contact" or len(pair) < 2 or set(pair) & {*statics, WORLD}:
            continue
        found = FrameMoment(row["time"] + EVENT_OFFSET, f"after {' and '.join(pair)} met", pair)
        rank = (row.get("name") is None, -(row.get("impact_impulse") or 0.0))
        key = frozenset(pair)
        if key not in first or (first[key][2].t == found.t and rank < first[key][:2]):
            first[key] = (*rank, found)
    ranked = sorted(first.values(), key=lambda one: one[:2])
    return [one[2] for one in ranked if one[2].t > EVENT_OFFSET + AT_REST_FROM][:MAX_STRIKES]


def _frames_around(moments: Sequence[FrameMoment]) -> Iterator[FrameMoment]:
    """Yield moments shortly before and after the given ones."""
    for row in moments:
        yield FrameMoment(row.t - EVENT_OFFSET, f"before {row.reason}", row.bodies)
        yield FrameMoment(row.t + EVENT_OFFSET, f"after {row.reason}", row.bodies)


def _deciding_moments(evidence: Data, actions: Data) -> Iterator[FrameMoment]:
    """Yield the moments that decide expectations: failed ones first, measures before events."""
    rows = []
    for name, found in (evidence.get("expect") or {}).items():
        asked = (actions.get("expect") or {}).get(name) or {}
        part = "measures" if asked.get("measure") else "events"
        if found.get("at") is not None:
            about = (actions.get(part) or {}).get(asked.get(part[:-1]))
            rows.append(
                (found.get("ok") is True, part, FrameMoment(found["at"], f"expect:{name}", named_bodies(about)))
            )
    rows.sort(key=lambda row: (row[0], row[1] == "events"))
    yield from [moment for *_, moment in rows][:MAX_DECIDED]


def _deformed(evidence: Data) -> Iterator[FrameMoment]:
    """Yield the moments of largest strain, stretch and change of volume."""
    found = []
    for body, row in (evidence.get("deformables") or {}).items():
        for name, least in MIN_DEFORMATION.items():
            worst = row.get(name) or {}
            value = worst.get("value")
            if value is not None and (abs(value - 1) if name == "volume" else value) >= least:
                found.append(FrameMoment(worst["at"], f"greatest {name} of {body}", (body,)))
                break
    yield from found[:MAX_DEFORMED]


def choose_frames(wanted: Sequence[FrameMoment], pictures: Sequence["Frame"], count: int) -> list[Shown]:
    """Return the frames to show, in the film's order: first and last, the wanted moments, shots, and others between.

    Args:
        wanted: Moments, the most important first.
        pictures: All frames of the film.
        count: Largest number of frames.
    """
    found: list[Shown] = []
    for frame in (pictures[0], pictures[-1]) if pictures else ():
        if not _similar_frame(found, frame):
            found.append(Shown(frame))
    found += [Shown(frame) for frame in _shots_without(wanted, pictures)[:MAX_SHOTS]]
    for place, limit in ((wanted, count - MAX_GAP_FRAMES), (_middles_of_gaps(found, pictures), count), (wanted, count)):
        for moment in place:
            frame = nearest_frame(pictures, moment.t)
            if frame is None:
                continue
            same = _similar_frame(found, frame)
            if same is None and len(found) < limit:
                found.append(same := Shown(frame))
            if same is not None and moment not in same.moments:
                same.moments.append(moment)
    for k in spread_numbers(len(pictures), 2 * count):
        if len(found) < count and not _similar_frame(found, pictures[k], (pictures[-1].k - pictures[0].k) / count / 2):
            found.append(Shown(pictures[k]))
    return sorted(found, key=lambda one: one.frame.k)


def _shots_without(wanted: Sequence[FrameMoment], pictures: Sequence["Frame"]) -> list["Frame"]:
    """Return the middle frames of those shots between the first and the last that no wanted moment shows."""
    chosen = {frame.k for one in wanted if (frame := nearest_frame(pictures, one.t)) is not None}
    shots = [list(frames) for _, frames in groupby(pictures, key=lambda frame: frame.camera)]
    return [shot[len(shot) // 2] for shot in shots[1:-1] if not chosen & {frame.k for frame in shot}]


def _middles_of_gaps(found: Sequence[Shown], pictures: Sequence["Frame"]) -> Iterator[FrameMoment]:
    """Yield the middles of the longest spans without a chosen frame."""
    for _ in range(MAX_GAP_FRAMES):
        frames = sorted((one.frame for one in found), key=lambda frame: frame.k)
        spans = [(b.k - a.k, a.k) for a, b in pairwise(frames)]
        longest, first = max(spans, default=(0, 0))
        if MIN_GAP_DIVISOR * longest > len(pictures):
            yield FrameMoment(pictures[first + longest // 2].t)


def _similar_frame(found: Sequence[Shown], frame: "Frame", film: float = 0) -> Shown | None:
    """A chosen frame that shows the same as a frame, or is less than `film` frames away; None without one."""
    for one in found:
        same = one.frame.camera == frame.camera and abs(one.frame.t - frame.t) < _min_interval(frame)
        if same or abs(one.frame.k - frame.k) < film:
            return one
    return None


def _min_interval(frame: "Frame") -> float:
    """Simulated time within which other frames show the same [s]."""
    return MIN_INTERVAL * min(1.0, max(frame.speed, MIN_SPEED_FACTOR))


def with_attached(bodies: tuple[str, ...], actions: Data) -> tuple[str, ...]:
    """Return bodies and those attached to them, which a close-up should include."""
    pairs = [
        {body_of(row[key]) for key in ("body", "to") if isinstance(row.get(key), str)}
        for row in (actions.get("controls") or {}).values()
        if isinstance(row, Mapping) and row.get("kind") == "attach"
    ]
    return tuple(dict.fromkeys([*bodies, *sorted(set().union(*(pair for pair in pairs if pair & {*bodies})))]))


def named_bodies(row: Any) -> tuple[str, ...]:
    """Return the names of the bodies of a measure or an event, given as data."""
    if not isinstance(row, Mapping):
        return ()
    return tuple(body_of(name) for key in ("of", "by", "to", "between") for name in strings_in(row.get(key)))
