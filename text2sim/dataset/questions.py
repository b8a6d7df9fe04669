"""Questions about films, derived from recordings, each with the evidence that proves its answer.

Questions are only about what the film shows. `balance` selects from them.
"""

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, compress
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from text2sim.recording.run_files import read_events
from text2sim.recording.vectors import rotate, rotate_back

Row = dict[str, Any]
MAX_START_TIME = 0.05
"""Contacts up to this time [s] exist from the start."""
MIN_MOVED = 0.05
"""Distance, as a part of the scene's size, above which a body moves."""
AT_REST = 0.005
"""Distance, as a part of the scene's size, below which a body still rests."""
FALLEN_TILT_DEG = 45.0
"""Tilt [deg] above which a copy has fallen over."""
TALL_INERTIA_RATIO = 0.75
"""Moment of inertia about the vertical, as a part of the smaller of the others, below which a body can fall over."""
MIN_SEEN = 0.002
"""Smallest part of a picture that a thing in a question fills."""
MAX_HIDDEN = 0.6
"""Largest part of such a thing that others hide."""
MIN_CLEAR_PICTURES = 0.25
"""Smallest part of the pictures that show such a thing so well."""
MIN_MASS_RATIO = 1.5
"""Smallest ratio of masses for questions about the heavier body."""
MIN_SPEED_CHANGE = 0.1
"""Smallest change of speed [m/s] in a collision that tells masses apart."""
MIN_PICTURES_APART = 2
"""Smallest number of pictures between two times that a viewer can tell apart."""
MUCH_LARGER = 3.0
"""Factor above which a value is much larger."""
FILM_PARTS = 4
"""Parts of a film; questions about times are asked at their ends."""


class ItemScene:
    """The scene of an item: motion of its bodies, contacts, and what the film shows of them.

    Args:
        item: Row of the item.
        frames: Rows of its pictures, with visibility.
        folder: Its files.
    """

    def __init__(self, item: Mapping[str, Any], frames: Sequence[Row], folder: Path):
        self.item, self.frames = item, frames
        self.times = [frame["time"] for frame in frames]
        layout = json.loads((folder / "layout.json").read_text("utf-8"))
        with np.load(folder / "states.npz") as arrays:
            self._time, pos, self._quat, vel = (arrays[name] for name in ("time", "pos", "quat", "vel"))
        links = layout["links"]
        self._inertia = [row["inertia"] for row in links]
        self._links = {row["body"]: k for k, row in reversed([*enumerate(links)]) if row["link"] != "world"}
        self._mass = Counter[str]()
        for row in links:
            self._mass[row["body"]] += row["mass"]
        still = {thing["body"] for thing in item["things"] if thing["static"]}
        bodies = dict.fromkeys(thing["body"] for thing in item["things"])
        self.copies = {body: [c for c in self._links if c.partition("[")[0] == body] for body in bodies}
        self.loose = [body for body in bodies if body not in still and self.copies[body]]
        self._pos, self._vel = pos.astype(float), vel.astype(float)
        self._seen = {body: [self._sees(frame, body) for frame in frames] for body in bodies}
        self.clear = {body for body, seen in self._seen.items() if sum(seen) >= MIN_CLEAR_PICTURES * len(frames)}
        chosen = [self._links[copy] for body in self.loose for copy in self.copies[body]]
        self.size = 1e-6
        """Extent of the loose bodies at the start, or their largest displacement if that is larger [m]."""
        if chosen:
            extent = np.ptp(self._pos[0, chosen], axis=0).max()
            self.size = max(float(extent), float(self._displacements(chosen).max()), self.size)
        self.last = int(np.searchsorted(self._time, max(self.times) - 1e-9).clip(0, len(self._time) - 1))
        """Recorded frame of the last picture."""
        self.touches = [row for row in read_events(folder) if row.get("kind") == "contact" and _pair(row)]

    def _sees(self, frame: Row, body: str) -> bool:
        copies = [thing for thing in frame["objects"] if thing["name"].partition("[")[0] == body]
        share = sum(thing["share"] for thing in copies)
        return (
            share >= MIN_SEEN
            and min((o["hidden"] for o in copies if o["hidden"] is not None), default=1.0) <= MAX_HIDDEN
        )

    def shows(self, t: float, *bodies: str) -> bool:
        """Whether the picture of a time shows all of these bodies well enough."""
        k = self.picture(t)
        return k is not None and all(self._seen[body][k] for body in bodies)

    def _displacements(self, links: Sequence[int]) -> Any:
        return np.linalg.norm(self._pos[:, links] - self._pos[:1, links], axis=-1)

    def _links_of(self, body: str) -> list[int]:
        return [self._links[copy] for copy in self.copies[body]]

    def starts(self, body: str) -> float | None:
        """Return when the first copy of a body starts to move [s]; None if none does."""
        moved = np.flatnonzero(self._displacement(body) > MIN_MOVED * self.size)
        return float(self._time[moved[0]]) if len(moved) and moved[0] else None

    def rests_at(self, body: str, t: float) -> bool:
        """Whether no copy of a body has moved up to a time [s]."""
        until = np.searchsorted(self._time, t, side="right")
        return bool(self._displacement(body)[:until].max() < AT_REST * self.size)

    def _displacement(self, body: str) -> Any:
        return self._displacements(self._links_of(body)).max(axis=1)

    def moved(self, body: str) -> list[str]:
        """Return the copies that have left their places at the end of the film."""
        far = self._displacements(self._links_of(body))[self.last] > MIN_MOVED * self.size
        return list(compress(self.copies[body], far))

    def fallen(self, body: str) -> list[str]:
        """Return the copies that have fallen over at the end of the film."""
        links = self._links_of(body)
        up = np.broadcast_to((0.0, 0.0, 1.0), (len(links), 3))
        # The axis of a copy that pointed upwards at the start, turned with it.
        now = rotate(self._quat[self.last, links], rotate_back(self._quat[0, links], up))
        tilt = np.degrees(np.arccos(np.clip(now[:, 2], -1, 1)))
        return list(compress(self.copies[body], tilt > FALLEN_TILT_DEG))

    def is_tall(self, body: str) -> bool:
        """Whether a body can fall over: it is taller than wide, and not a ball."""
        link = self._links[self.copies[body][0]]
        axes = rotate_back(np.broadcast_to(self._quat[0, link], (3, 4)), np.eye(3))
        about = np.einsum("ni,ij,nj->n", axes, np.array(self._inertia[link], float), axes)
        return bool(about[2] < TALL_INERTIA_RATIO * min(about[:2]))

    def mass(self, body: str) -> float:
        """Return the mass of the first copy of a body [kg]."""
        return float(self._mass[self.copies[body][0]])

    def pushed(self, body: str, t: float) -> float:
        """Return the change of speed of the first copy of a body from before to after a time [m/s]."""
        link = self._links[self.copies[body][0]]
        at = np.searchsorted(self._time, [t - 0.05, t + 0.1]).clip(0, len(self._time) - 1)
        return float(np.linalg.norm(self._vel[at[1], link] - self._vel[at[0], link]))

    def picture(self, t: float) -> int | None:
        """Return the first picture at a time [s] or later; None if the film ends before."""
        return next((k for k, time in enumerate(self.times) if time >= t - 1e-9), None)


def candidate_questions(item: Mapping[str, Any], frames: Sequence[Row], folder: Path) -> list[Row]:
    """Return candidate questions about an item: `kind`, `question`, `right` and `evidence`.

    `balanced_questions` selects from them such that answers to equal questions about other items are equally frequent.

    Args:
        item: Row of the item.
        frames: Rows of its frames.
        folder: Folder of the item.
    """
    scene = ItemScene(item, frames, folder)
    if sorted(scene.times) != scene.times:  # with a replay, the order of pictures is not that of events
        return []
    kinds = (_moves_first, _touches_first, _how_many, _touch_by, _will_touch, _heavier)
    return [
        {"key": item["key"], "kind": kind.__name__.strip("_"), **row, "evidence": json.dumps(row["evidence"])}
        for kind in kinds
        for row in kind(scene)
    ]


def what_if(
    base: Mapping[str, Any], other: Mapping[str, Any], words: str, frames: Sequence[Row], folder: Path
) -> list[Row]:
    """Return questions about an item that its counterfactual answers.

    Args:
        base: The item that is shown.
        other: Its counterfactual, in which one cause is different.
        words: The difference, see `cause_in_words`.
        frames: Rows of the pictures of the base.
        folder: Files of the base.
    """
    scene = ItemScene(base, frames, folder)
    actions = yaml.safe_load((folder / "case.yaml").read_text("utf-8")).get("actions") or {}
    counts, rows = {row["name"]: row["count"] for row in other["events"]}, []
    for name in (event["name"] for event in base["events"]):
        pair = _pair((actions.get("events") or {}).get(name, {}))
        if name not in counts or not {*scene.loose} & scene.clear or not {*pair} <= scene.clear:
            continue
        happens = " touch ".join(_words(body) for body in pair) if pair else f"this happen: {_words(name)}"
        evidence = {"item": other["key"], "event": name, "count": counts[name], "cause": other["cause"]}
        rows.append(
            {
                "key": base["key"],
                "kind": "what_if",
                "question": f"If {words}, would {happens}?",
                "right": "yes" if counts[name] else "no",
                "evidence": json.dumps(evidence),
            }
        )
    return rows


def cause_in_words(path: str, value: Any, before: float | None) -> str:
    """Describe a counterfactual without numbers: `the density of “ball” were much larger`.

    Args:
        path: Path of the changed value.
        value: The new value; None if it was removed.
        before: The old value, if that was a number.
    """
    steps = path.split(".")
    name = _words(steps[-1])
    owner = _words(steps[2 if steps[0] in ("actions", "scene") else 1]) if len(steps) > 2 else ""
    subject = f"the {steps[-1].replace('_', ' ')} of {owner}" if owner else name
    if value is None:
        return f"{subject} were not there"
    if before is None or isinstance(value, bool) or not isinstance(value, int | float) or value == before:
        return f"{subject} were different"
    much = "much " if not before or not 1 / MUCH_LARGER < value / before < MUCH_LARGER else ""
    return f"{subject} were {much}{'larger' if value > before else 'smaller'}"


def _moves_first(scene: ItemScene) -> Iterator[Row]:
    starts = {body: t for body in scene.loose if body in scene.clear and (t := scene.starts(body)) is not None}
    for one, other in combinations(sorted(starts), 2):
        first, second = sorted((one, other), key=lambda body: starts[body])
        a, b = (scene.picture(starts[body]) for body in (first, second))
        # A slower body that starts at the same time does not start later.
        if a is not None and b is not None and b - a >= MIN_PICTURES_APART and scene.rests_at(second, starts[first]):
            yield {
                "question": f"Which starts to move first, {_words(one)} or {_words(other)}?",
                "right": _words(first),
                "evidence": {"starts": {first: starts[first], second: starts[second]}},
            }


def _touches_first(scene: ItemScene) -> Iterator[Row]:
    for body in scene.loose:
        touches = [row for row in scene.touches if body in _pair(row) and len({*_pair(row)}) == 2]
        # Contacts with its support repeat, and do not count.
        before = {name for row in touches if row["time"] <= MAX_START_TIME for name in _pair(row)} - {body}
        first = min((row for row in touches if not before & {*_pair(row)}), key=lambda row: row["time"], default=None)
        if first is not None and scene.shows(first["time"], *_pair(first)):
            yield {
                "question": f"What does {_words(body)} touch first after the start?",
                "right": _words(next(name for name in _pair(first) if name != body)),
                "evidence": {"contact": first["between"], "time": first["time"]},
            }


def _how_many(scene: ItemScene) -> Iterator[Row]:
    for body in scene.loose:
        if not scene.shows(max(scene.times), body) or not 2 <= len(scene.copies[body]) <= 12:
            continue
        counts = {"have moved away from their places": scene.moved(body)}
        if scene.is_tall(body):
            counts["have fallen over"] = scene.fallen(body)
        for words, found in counts.items():
            yield {
                "question": f"There are {len(scene.copies[body])} of {_words(body)}. How many {words} at the end?",
                "right": str(len(found)),
                "evidence": {"copies": found, "time": max(scene.times)},
            }


def _touch_by(scene: ItemScene) -> Iterator[Row]:
    """Whether two things have touched by a picture: words alone do not tell how fast things are."""
    for one, other, when in _first_touches(scene):
        for k in _moments(scene):
            t = scene.times[k]
            shown = None if when is None else scene.picture(when)
            touched = when is not None and when <= t
            if when is not None and shown is not None:
                if abs(shown - k) < MIN_PICTURES_APART or (touched and not scene.shows(when, one, other)):
                    continue
            yield {
                "question": f"Have {_words(one)} and {_words(other)} touched by picture {k} of {len(scene.times)}?",
                "right": "yes" if touched else "no",
                "evidence": {"first_contact": when, "picture_time": t},
            }


def _will_touch(scene: ItemScene) -> Iterator[Row]:
    """Whether two things will touch, asked about the pictures before."""
    for one, other, when in _first_touches(scene):
        end = len(scene.times) // 3
        if end < MIN_PICTURES_APART or (
            when is not None and (when <= scene.times[end] or not scene.shows(when, one, other))
        ):
            continue
        yield {
            "question": f"You see pictures 0 to {end} only. Will {_words(one)} touch {_words(other)} later on?",
            "right": "no" if when is None else "yes",
            "evidence": {"first_contact": when, "last_picture_time": scene.times[end]},
        }


def _heavier(scene: ItemScene) -> Iterator[Row]:
    for one, other, when in _first_touches(scene):
        if when is None or {one, other} - {*scene.loose} or any(len(scene.copies[body]) > 1 for body in (one, other)):
            continue
        masses = {body: scene.mass(body) for body in (one, other)}
        light, heavy = sorted(masses, key=lambda body: masses[body])
        pushes = {body: scene.pushed(body, when) for body in masses}
        if (
            not masses[light]
            or masses[heavy] < MIN_MASS_RATIO * masses[light]
            or max(pushes.values()) < MIN_SPEED_CHANGE
        ):
            continue
        if pushes[light] > pushes[heavy] and scene.shows(when, one, other):
            yield {
                "question": f"Judging by how they move, which is heavier, {_words(one)} or {_words(other)}?",
                "right": _words(heavy),
                "evidence": {"mass": masses, "change_of_speed": pushes, "contact": when},
            }


def _first_touches(scene: ItemScene) -> Iterator[tuple[str, str, float | None]]:
    """Pairs of clear things, at least one loose, without contact at the start, and when they first touch [s]."""
    first: dict[tuple[str, str], float] = {}
    for row in scene.touches:
        pair = tuple(sorted(_pair(row)))
        first[pair[0], pair[1]] = min(first.get((pair[0], pair[1]), np.inf), row["time"])
    for one, other in combinations(sorted(scene.clear), 2):
        if {one, other} & {*scene.loose} and (when := first.get((one, other), np.inf)) > MAX_START_TIME:
            yield one, other, float(when) if np.isfinite(when) else None


def _moments(scene: ItemScene) -> list[int]:
    count = len(scene.times)
    return sorted({round((count - 1) * k / FILM_PARTS) for k in range(1, FILM_PARTS)})


def _pair(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the bodies of a contact, without link or copy."""
    return tuple(re.split(r"[.\[]", str(name))[0] for name in row.get("between", ()))


def _words(name: str) -> str:
    return f"“{name.replace('_', ' ')}”"
