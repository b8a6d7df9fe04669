"""Choice of frames for agents: events, extremes of measures and diagnostics, and frames between which much moves."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby, pairwise
from math import inf
from typing import TYPE_CHECKING, Any

from text2sim.legibility.film import nearest_frame
from text2sim.spec_schema.names.selectors import WORLD, body_of, strings_in

if TYPE_CHECKING:
    from text2sim.templates.cadence import Frame

Data = Mapping[str, Any]

MIN_INTERVAL, MIN_SPEED_FACTOR = 0.1, 0.2
"""Smallest time of film between frames of one camera [s], and fraction of full speed below which it grows."""
EVENT_OFFSET = 0.15
"""Time before and after an event at which frames are taken [s]."""
MAX_GAP_FRAMES, MIN_GAP_DIVISOR = 2, 5
"""Number of frames for the largest gaps, and the smallest fraction of what happens (one in `MIN_GAP_DIVISOR`) that
counts as a gap."""
TIME_SHARE, LEAST_MOTION = 0.25, 0.05
"""Weight of a film's time beside its motion in what happens, and its least value [heights of the picture]."""
EVEN_STILLS, MAX_EVENT_STILLS = 6, 3
"""Number of stills spread over a film that is judged, and largest number of stills of events beside them."""
MAX_EVENTS, MAX_EXTREMES, MAX_DEFORMED, MAX_DECIDED, MAX_STRIKES = 5, 4, 2, 4, 2
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
    decisive: bool = False
    """Whether it is shown although little moves around it."""


@dataclass
class Shown:
    """A chosen frame, with the reasons for it."""

    frame: "Frame"
    moments: list[FrameMoment] = field(default_factory=list)

    @property
    def reasons(self) -> list[str]:
        """Captions of its moments, with the time of those that the frame does not match exactly."""
        rows = [
            (one, abs(self.frame.t - one.t) > min(MIN_INTERVAL, _min_interval(self.frame)) / 2)
            for one in self.moments
            if one.reason
        ]
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
    yield from (*decided, *(replace(one, decisive=True) for one in strikes))
    events = _first_events(evidence, actions)
    expected = [row for row in (actions.get("expect") or {}).values() if isinstance(row, dict)]
    counted = {row.get("event") for row in expected if row.get("count") is not None}
    last_times = [(evidence["events"][one.reason].get("last") or 0.0, one) for one in events if one.reason in counted]
    again = [replace(one, t=t, reason=f"last {one.reason}") for t, one in last_times if t > one.t + MIN_INTERVAL]
    yield from (replace(one, decisive=True) for one in (*events, *again))
    used = {row.get("measure") for row in expected}
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


def _first_events(evidence: Data, actions: Data) -> list[FrameMoment]:
    """Return the first times of events, at no more than `MAX_EVENTS` moments.

    First come events that are expected, then those from which others are counted: `on`, `before`, `after`. Where there
    are too many of a rank, those are returned that are farthest from the others in time, so that the end is not left
    out.
    """
    planned = {name: row for name, row in (actions.get("events") or {}).items() if isinstance(row, Mapping)}
    rows = [row for row in (actions.get("expect") or {}).values() if isinstance(row, Mapping)]
    expected = {row["event"] for row in rows if row.get("event")}
    left, named = [*expected, *(row[key] for row in rows for key in ("on", "before") if row.get(key))], set[str]()
    while left:
        if (name := left.pop()) not in named:
            named.add(name)
            left += [after] if (after := planned.get(name, {}).get("after")) else []
    happened = {name: row["first"] for name, row in evidence["events"].items() if row.get("first") is not None}
    times: list[float] = []
    for rank in (expected, named - expected, {*happened} - named):
        waiting = sorted({happened[name] for name in rank & {*happened}})
        while waiting and len(times) < MAX_EVENTS:
            t = max(waiting, key=lambda one: (min((abs(one - other) for other in times), default=-one), one))
            waiting.remove(t)
            if all(abs(t - other) > MIN_INTERVAL for other in times):
                times.append(t)
    seen = [(name, t) for name, t in happened.items() if any(abs(t - other) <= MIN_INTERVAL for other in times)]
    seen.sort(key=lambda row: (row[0] not in named, row[1], row[0]))
    return [FrameMoment(t, name, named_bodies(planned.get(name))) for name, t in seen]


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
    """Yield the moments that decide expectations: failed ones first, measures before events.

    Where something true is only kept within bounds, the moment that came nearest to them may show nothing: such moments
    come after those at which something is reached, and are not decisive.
    """
    rows = []
    for name, found in (evidence.get("expect") or {}).items():
        asked = (actions.get("expect") or {}).get(name) or {}
        part = "measures" if asked.get("measure") else "events"
        if found.get("at") is not None:
            about = (actions.get(part) or {}).get(asked.get(part[:-1]))
            true = found.get("ok") is True
            kept = true and _keeps_within(asked)
            moment = FrameMoment(found["at"], f"expect:{name}", named_bodies(about), decisive=not kept)
            rows.append((true, part == "events", kept, moment))
    rows.sort(key=lambda row: row[:3])
    yield from [moment for *_, moment in rows][:MAX_DECIDED]


def _keeps_within(asked: Data) -> bool:
    """Whether an expectation bounds a measure over a span, and asks for no value that has to be reached in it."""
    reached = asked.get("above") if asked.get("stat") != "min" else asked.get("below")
    return asked.get("during") is not None and (asked.get("stat") is None or reached is None)


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


def choose_frames(
    wanted: Sequence[FrameMoment], pictures: Sequence["Frame"], count: int, motion: Sequence[float] = ()
) -> list[Shown]:
    """Return the frames to show, in the film's order: first and last, the wanted moments, shots, and others between.

    What happens up to frame k of the last one K, of which the motion so far is M, is

        c(k) = (M(k) + w k / K) / (M(K) + w),  w = max(TIME_SHARE M(K), LEAST_MOTION)

    Others stand halfway between those neighbours i, j between which most happens: where c is nearest to half of
    c(i) + c(j). Last, a frame that is neither decisive nor at an end, with c by a above one neighbour's and by b below
    the other's, is replaced by such a one, x after i and y before j, while 2 a b < x y. So the sum of squares of what
    happens between neighbours falls.

    Args:
        wanted: Moments, the most important first.
        pictures: All frames of the film.
        count: Largest number of frames.
        motion: How far bodies have moved up to each frame, see `legibility.visible_motion`; empty if unknown.
    """
    found: list[Shown] = []
    for frame in (pictures[0], pictures[-1]) if pictures else ():
        if not _similar_frame(found, frame):
            found.append(Shown(frame))
    found += [Shown(frame) for frame in _shots_without(wanted, pictures)[:MAX_SHOTS]]
    kept = [*found]
    happened = _happened(motion, len(pictures))
    _show(found, wanted, pictures, count - MAX_GAP_FRAMES)
    _halve(found, pictures, happened, min(count, len(found) + MAX_GAP_FRAMES), 1 / MIN_GAP_DIVISOR)
    _show(found, wanted, pictures, count)
    _halve(found, pictures, happened, count)
    if any(motion):
        _exchange(found, pictures, happened, kept)
        _show(found, wanted, pictures, len(found))  # names what new frames show
    return sorted(found, key=lambda one: one.frame.k)


def choose_stills(
    wanted: Sequence[FrameMoment], pictures: Sequence["Frame"], motion: Sequence[float] = ()
) -> list["Frame"]:
    """Return the frames by which a film is judged: `EVEN_STILLS`, and one for each event between the ends.

    Args:
        wanted: Moments, the most important first; those on the first `MAX_EVENT_STILLS` frames count, of decisive ones
            if there are enough.
        pictures: All frames of the film.
        motion: As for `choose_frames`.
    """
    first = sorted(wanted, key=lambda one: not one.decisive)
    shown = [(frame, one) for one in first if (frame := nearest_frame(pictures, one.t)) is not None]
    ends = [Shown(frame) for frame in (pictures[0], pictures[-1])]
    events = [frame for frame in dict.fromkeys(frame for frame, _ in shown) if _similar_frame(ends, frame) is None]
    events = events[:MAX_EVENT_STILLS]
    count = EVEN_STILLS + len(events)
    decisive = [replace(one, decisive=True) for frame, one in shown if frame in events]
    return [one.frame for one in choose_frames(decisive, pictures, count, motion)]


def _show(found: list[Shown], wanted: Sequence[FrameMoment], pictures: Sequence["Frame"], limit: int) -> None:
    """Add the frames of moments, up to a number of frames; moments that frames show already are noted with them."""
    for moment in wanted:
        frame = nearest_frame(pictures, moment.t)
        if frame is None:
            continue
        same = _similar_frame(found, frame)
        if same is None and len(found) < limit:
            found.append(same := Shown(frame))
        if same is not None and moment not in same.moments:
            same.moments.append(moment)


def _happened(motion: Sequence[float], count: int) -> list[float]:
    """How much of what happens in a film has happened up to each of its frames, 0 to 1; see `choose_frames`."""
    moved = [*motion] or [0.0] * count
    total = moved[-1] if moved else 0.0
    weight = max(TIME_SHARE * total, LEAST_MOTION)
    return [(row + weight * k / max(count - 1, 1)) / (total + weight) for k, row in enumerate(moved)]


def _halve(
    found: list[Shown], pictures: Sequence["Frame"], happened: Sequence[float], limit: int, least: float = 0.0
) -> None:
    """Add frames within the largest gaps of more than `least`, up to a number of frames."""
    while len(found) < limit:
        gap, frame = _halfway(found, pictures, happened)
        if frame is None or gap <= least:
            break
        found.append(Shown(frame))


def _halfway(
    found: Sequence[Shown], pictures: Sequence["Frame"], happened: Sequence[float]
) -> tuple[float, "Frame | None"]:
    """What happens in the largest gap that has a frame unlike its ends, and the one halfway in it."""
    numbers = sorted(one.frame.k for one in found)
    for gap, a, b in sorted(((happened[b] - happened[a], a, b) for a, b in pairwise(numbers)), reverse=True):
        unlike = [k for k in range(a + 1, b) if _similar_frame(found, pictures[k]) is None]
        if unlike:
            return gap, pictures[min(unlike, key=lambda k: abs(happened[k] - (happened[a] + happened[b]) / 2))]
    return 0.0, None


def _exchange(
    found: list[Shown], pictures: Sequence["Frame"], happened: Sequence[float], kept: Sequence[Shown]
) -> None:
    """Replace frames that resemble their neighbours by frames within the largest gaps; see `choose_frames`."""
    while True:
        found.sort(key=lambda one: one.frame.k)
        c = [happened[one.frame.k] for one in found]
        idle = [
            ((c[i] - c[i - 1]) * (c[i + 1] - c[i]), i)
            for i, one in enumerate(found[1:-1], 1)
            if one not in kept
            and not any(moment.decisive for moment in one.moments)
            and one.frame.camera in {found[i - 1].frame.camera, found[i + 1].frame.camera}
        ]
        lost, number = min(idle, default=(inf, 0))
        frame = _halfway(found, pictures, happened)[1]
        if frame is None:
            return
        after = next(i for i, one in enumerate(found) if one.frame.k > frame.k)
        if not 2 * lost < (happened[frame.k] - c[after - 1]) * (c[after] - happened[frame.k]):
            return
        found[number] = Shown(frame)


def _shots_without(wanted: Sequence[FrameMoment], pictures: Sequence["Frame"]) -> list["Frame"]:
    """Return the middle frames of those shots between the first and the last that no wanted moment shows."""
    chosen = {frame.k for one in wanted if (frame := nearest_frame(pictures, one.t)) is not None}
    shots = [list(frames) for _, frames in groupby(pictures, key=lambda frame: frame.camera)]
    return [shot[len(shot) // 2] for shot in shots[1:-1] if not chosen & {frame.k for frame in shot}]


def _similar_frame(found: Sequence[Shown], frame: "Frame") -> Shown | None:
    """A chosen frame that shows the same as a frame; None without one."""
    for one in found:
        if one.frame.camera == frame.camera and abs(one.frame.t - frame.t) < _min_interval(frame):
            return one
    return None


def _min_interval(frame: "Frame") -> float:
    """Simulated time within which other frames show the same [s]."""
    return MIN_INTERVAL * max(frame.speed, MIN_SPEED_FACTOR)


def with_attached(bodies: tuple[str, ...], actions: Data) -> tuple[str, ...]:
    """Return bodies and those attached to them or on springs with them, which a close-up should include."""
    pairs = [
        {body_of(row[key]) for key in ("body", "to") if isinstance(row.get(key), str)}
        for row in (actions.get("controls") or {}).values()
        if isinstance(row, Mapping) and row.get("kind") in ("attach", "spring")
    ]
    return tuple(dict.fromkeys([*bodies, *sorted(set().union(*(pair for pair in pairs if pair & {*bodies})))]))


def named_bodies(row: Any) -> tuple[str, ...]:
    """Return the names of the bodies of a measure or an event, given as data."""
    if not isinstance(row, Mapping):
        return ()
    return tuple(body_of(name) for key in ("of", "by", "to", "between") for name in strings_in(row.get(key)))
