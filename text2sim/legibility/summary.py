"""Summary of the legibility of films in numbers and remarks, for evidence and critics."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from statistics import median
from typing import Any

import numpy as np

from text2sim.legibility.film import SAMPLED_PICTURES, Row, Watcher, nearest_frame
from text2sim.legibility.sight import MIN_PIXELS, Sight
from text2sim.legibility.turning import unseen_turns
from text2sim.spec_schema.names.selectors import body_of
from text2sim.templates.cadence import MAIN, Frame, frames, reels

PICTURES_OF_OTHER_FILMS = 8
"""Number of pictures of each film except the main one that are measured."""
MAX_FILMS = 6
"""Largest number of films that are measured."""
MAX_EVENTS = 8
"""Largest number of events whose moments are checked."""
MAX_REMARKS = 16
SMALL_SHARE = 0.002
"""Part of the picture below which a body is small: 43 x 43 pixels of 1280 x 720."""
HIDDEN_SHARE = 0.6
"""Part of a body above which it is reported as hidden by others."""
CUT_SHARE = 0.5
"""Part of a body within the picture below which it is reported as cut off."""
TRIMMED_SHARE = 0.97
"""Part of a body within the picture below which the picture's edge cuts it."""
WHOLE_SHARE = 0.75
"""Part of a static within the picture from which it is no mere background, such as a wall or a table top."""
FAINT_CONTRAST = 0.04
"""Contrast below which a body hardly stands out."""
QUICK_MOTION = 0.25
"""Displacement between pictures [heights of the picture] above which a body is too quick to follow."""
CUT_OFF = 0.25
"""Part of the recorded time after the end of a film above which the end is reported as missing."""
EMPTY_SPAN = 0.3
"""Part of the picture's width or height that all bodies together span in most pictures, below which it is empty."""

FAR_RATIO, FAR_MOMENTS = 3.0, 12
"""How many times as far as all others a body goes to be named as what makes a picture wide; moments that are tried."""


@dataclass(frozen=True)
class Moment:
    """An event that a film should show."""

    name: str
    t: float
    """Its time [s]."""
    bodies: tuple[str, ...]
    """Names of the bodies that it concerns."""


def summarise(watcher: Watcher, moments: Sequence[Moment] = ()) -> dict[str, Any]:
    """Return the measures of each film of a run, and remarks about the main film.

    Args:
        watcher: Measures the pictures of the run.
        moments: The first occurrence of each event of the run.
    """
    film, last = watcher.recording.film, watcher.recording.last
    pictures = {name: frames(film, shots, last) for name, shots in list(reels(film).items())[:MAX_FILMS]}
    rows = {
        name: watcher.rows(found, SAMPLED_PICTURES if name == MAIN else PICTURES_OF_OTHER_FILMS)
        for name, found in pictures.items()
    }
    remarks = [
        *_about_film(watcher, pictures[MAIN], rows[MAIN], last),
        *_about_bodies(watcher, pictures[MAIN], rows[MAIN]),
        *_about_statics(watcher, rows[MAIN]),
        *_about_moments(watcher, pictures[MAIN], moments[:MAX_EVENTS]),
        *_about_turning(watcher, pictures[MAIN], rows[MAIN]),
    ]
    return {
        "films": {name: _film(watcher, found) for name, found in rows.items()},
        "remarks": remarks[:MAX_REMARKS],
    }


def largest_shares(watcher: Watcher) -> dict[str, float]:
    """Return the largest part of the main film's picture that each thing fills; 0 for what is never seen."""
    film, last = watcher.recording.film, watcher.recording.last
    rows = watcher.rows(frames(film, reels(film)[MAIN], last))
    return {
        name: max((row["bodies"].get(name, {}).get("share") or 0.0 for row in rows), default=0.0)
        for name in watcher.recorded.names
    }


def least_inside(watcher: Watcher) -> dict[str, float]:
    """Return the smallest fraction of each thing that is within a picture of the main film; 0 where one misses it.

    Replays, which show again what was seen, are left out.
    """
    film, last = watcher.recording.film, watcher.recording.last
    found = watcher.rows(frames(film, reels(film)[MAIN], last))
    latest = accumulate((row["t"] for row in found), max)
    rows = [row for row, until in zip(found, latest, strict=True) if row["t"] >= until]
    return {
        name: min((row["bodies"].get(name, {}).get("inside") or 0.0 for row in rows), default=0.0)
        for name in watcher.recorded.names
    }


def _film(watcher: Watcher, rows: list[Row]) -> dict[str, Any]:
    statics = {name: max(row["bodies"].get(name, {}).get("share") or 0.0 for row in rows) for name in _statics(watcher)}
    return {
        "pictures": len(rows),
        "bodies": {name: _body(rows, name) for name in watcher.moving},
        "statics": statics,  # the largest part of a picture that each fills
    }


def _statics(watcher: Watcher) -> list[str]:
    """Statics that are visible; the backdrop of a film replaces planes."""
    replaced = {body_of(copy) for copy in watcher.recording.film["backdrop"]["planes"]}
    return [name for name in watcher.recorded.names if name in watcher.recorded.statics and name not in replaced]


def _body(rows: list[Row], name: str) -> dict[str, Any]:
    """Measures of a body over the pictures of a film."""
    found: list[Mapping[str, float | None]] = [row["bodies"].get(name, {}) for row in rows]
    shares = [row.get("share") or 0.0 for row in found]

    def known(key: str) -> list[float]:
        return [value for row in found if (value := row.get(key)) is not None]

    return {
        "share": {"min": min(shares), "median": median(shares), "max": max(shares)},
        "hidden": max(known("hidden"), default=None),
        "edge": min(known("edge"), default=None),
        "contrast": median(known("contrast")) if known("contrast") else None,
        "motion": max(known("motion"), default=None),
        "seen": sum(share > 0 for share in shares),
    }


def _about_film(watcher: Watcher, pictures: list[Frame], rows: list[Row], last: float) -> list[str]:
    """Remarks about the film as a whole: an empty picture, an early end."""
    found = []
    span = median(row["span"] for row in rows)
    cameras = {frame.camera: watcher.recording.film["cameras"][frame.camera] for frame in pictures}
    framed = {body_of(name) for camera in cameras.values() for name in camera.get("frame", {}).get("bodies", ())}
    # What else a camera holds by its `frame`, such as the bins at the end of a belt, is meant to be there.
    if 0 < span < EMPTY_SPAN and not framed & {*map(body_of, watcher.recording.statics)}:
        found.append(
            f"all bodies together span {_percent(span)} of the picture in most pictures: the camera can be "
            f"{0.8 / span:.1f} times as near, or go along{_what_goes_far(watcher, pictures)}"
        )
    end, latest = pictures[-1].t, max(frame.t for frame in pictures)
    if pictures[-1].again and latest - end > pictures[-1].speed:
        found.append(f"the film ends with a replay, at {end:.2f} s: what came of it, at {latest:.2f} s, is not its end")
    elif last - end > CUT_OFF * last and watcher.moves_between(end, last):
        found.append(f"the film ends at {end:.2f} s of {last:.2f} s: is the final state in it?")
    return found


def _what_goes_far(watcher: Watcher, pictures: list[Frame]) -> str:
    """Words for a body that goes much farther than all others, which makes the picture wide."""
    states, start = watcher.recording.states, pictures[0].t
    ways = {}
    for name in watcher.moving:
        first = states.tracks([name], start)
        some = [*pictures[:: max(1, len(pictures) // FAR_MOMENTS)], pictures[-1]]
        moved = [np.linalg.norm(states.tracks([name], frame.t) - first, axis=1) for frame in some]
        ways[name] = float(np.nanmax(moved, initial=0.0))
    *others, farthest = sorted(ways, key=ways.__getitem__)
    if not others or ways[farthest] < FAR_RATIO * ways[others[-1]]:
        return ""
    return f" (`{farthest}` goes {ways[farthest]:.2g} m, others {ways[others[-1]]:.2g} m at most)"


def _about_bodies(watcher: Watcher, pictures: list[Frame], rows: list[Row]) -> list[str]:
    found = []
    removed = {body_of(copy) for copy in watcher.recording.states.removed}
    for name in watcher.moving:
        numbers, body_rows = _body(rows, name), [row["bodies"].get(name) for row in rows]
        present = [row for row in body_rows if row is not None]
        if not present:
            found.append(f"`{name}` is in no picture")
            continue
        if not numbers["seen"]:
            found.append(f"`{name}` is in the picture and never seen: {_what_hides(watcher, pictures, rows, name)}")
            continue
        if numbers["share"]["max"] < SMALL_SHARE:
            found.append(f"`{name}` fills at most {_percent(numbers['share']['max'])} of the picture")
        if body_rows[0] is not None and body_rows[-1] is None and name not in removed:
            found.append(f"`{name}` leaves the picture at {_last_seen(watcher, pictures, rows, name):.2f} s")
        elif median(row["inside"] for row in present) < CUT_SHARE:
            found.append(f"most of `{name}` is beyond the edges of the picture")
        elif median(row["inside"] for row in present) < TRIMMED_SHARE:
            found.append(_cut(name, present, rows))
        if median(row["hidden"] or 0.0 for row in present) > HIDDEN_SHARE:
            found.append(f"`{name}` is hidden in most pictures: {_what_hides(watcher, pictures, rows, name)}")
        if (
            numbers["contrast"] is not None
            and numbers["contrast"] < FAINT_CONTRAST
            and numbers["share"]["max"] >= SMALL_SHARE
        ):
            found.append(f"`{name}` hardly stands out from what is around it")
        if numbers["motion"] is not None and numbers["motion"] > QUICK_MOTION:
            found.append(
                f"`{name}` crosses {_percent(numbers['motion'])} of the picture's height from one picture to the next"
            )
    return found


def _about_statics(watcher: Watcher, rows: list[Row]) -> list[str]:
    """Remarks about statics that are meant to be seen, because most of each is in the picture, and are cut off."""
    found = []
    for name in _statics(watcher):
        present = [row["bodies"][name] for row in rows if name in row["bodies"]]
        inside = median(row["inside"] for row in present) if present else 0.0
        if WHOLE_SHARE <= inside < TRIMMED_SHARE and max(row["share"] or 0.0 for row in present) >= SMALL_SHARE:
            found.append(f"{_cut(name, present, rows)}: show all of it, or let it go on far beyond")
    return found


def _cut(name: str, present: list[Mapping[str, Any]], rows: list[Row]) -> str:
    """Words for the part of a thing that is beyond the edges of the picture."""
    trimmed = [row["inside"] for row in present if row["inside"] < TRIMMED_SHARE]
    return (
        f"the picture's edge cuts off up to {_percent(1 - min(trimmed))} of `{name}` in {len(trimmed)} of "
        f"{len(rows)} pictures"
    )


def _about_moments(watcher: Watcher, pictures: list[Frame], moments: Sequence[Moment]) -> list[str]:
    found = []
    for moment in moments:
        frame = nearest_frame(pictures, moment.t)
        if frame is None:
            found.append(f"event `{moment.name}` at {moment.t:.2f} s is not in the film")
            continue
        sight, names = watcher.sight(frame), watcher.recorded.names
        for body in moment.bodies:
            if body not in names or body in watcher.recorded.statics:
                continue
            k, when = names.index(body), f"at the moment of event `{moment.name}` ({moment.t:.2f} s)"
            if not sight.inside[k]:
                found.append(f"`{body}` is not in the picture {when}")
            elif sight.hidden[k] > HIDDEN_SHARE and sight.alone[k] >= MIN_PIXELS:
                found.append(f"`{body}` is hidden {_percent(sight.hidden[k])}{_behind_what(sight, names, k)} {when}")
    return found


def _about_turning(watcher: Watcher, pictures: list[Frame], rows: list[Row]) -> list[str]:
    """Remarks about turning that nothing shows, of bodies on which a pattern would be seen."""
    return [
        f"`{name}` turns {turns:.1f} times, which a plain round surface does not show: give its `look` a `pattern`"
        for name, turns in unseen_turns(watcher.recording, pictures).items()
        if _body(rows, name)["share"]["max"] >= SMALL_SHARE
    ]


def _what_hides(watcher: Watcher, pictures: list[Frame], rows: list[Row], name: str) -> str:
    """The part of a body that is hidden, and what hides it, in the picture that shows least of it."""
    worst = max((row for row in rows if name in row["bodies"]), key=lambda row: row["bodies"][name]["hidden"] or 0.0)
    frame = next(frame for frame in pictures if frame.k == worst["frame"])
    sight, names = watcher.sight(frame), watcher.recorded.names
    k = names.index(name)
    return f"{_percent(sight.hidden[k])}{_behind_what(sight, names, k)} at {frame.t:.2f} s"


def _behind_what(sight: Sight, names: list[str], thing: int) -> str:
    """What hides most of a thing, as the end of a sentence; empty if nothing does."""
    hider = next((names[other] for other, _ in sight.hiders(thing)), None)
    return f" behind `{hider}`" if hider is not None else ""


def _last_seen(watcher: Watcher, pictures: list[Frame], rows: list[Row], name: str) -> float:
    """Time at which a body leaves the picture for good [s], by bisection between the measured pictures."""
    k = watcher.recorded.names.index(name)
    frames = [row["frame"] for row in rows if name in row["bodies"]]
    gone = [row["frame"] for row in rows if row["frame"] > frames[-1]]
    numbers = [frame.k for frame in pictures]
    low, high = numbers.index(frames[-1]), numbers.index(gone[0])
    while high - low > 1:
        middle = (low + high) // 2
        if watcher.sight(pictures[middle]).inside[k]:
            low = middle
        else:
            high = middle
    return pictures[high].t


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %" if part > 0.1 else f"{100 * float(part):.2g} %"
