"""Questions about films, made of what was recorded, each with the evidence that proves its answer.

A question is asked only of what the film shows. Words alone must not give an answer away: of all questions with the
same text, every answer is right equally often, and only answers that are right for some of them are offered.
"""

import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.dataset.draws import generator
from text2sim.recording.run_files import read_events
from text2sim.recording.vectors import rotate

Row = dict[str, Any]
MOVED = 0.05
"""Part of the scene's size by which something has to move to count as moving."""
FALLEN = 45.0
"""Tilt [deg] from which on something has fallen over."""
SEEN = 0.002
"""Part of a picture that a thing fills at least that is asked about."""
HIDDEN = 0.6
"""Part of it that others hide at most."""
CLEAR = 0.25
"""Part of the pictures in which it has to be seen so."""
HEAVIER = 1.5
"""Mass of a body over that of another, from which on the question which is heavier is asked."""
PUSHED = 0.1
"""Change of speed [m/s] by which masses can be told from a collision."""
GAP = 2
"""Pictures by which two moments differ that are told apart."""
MOST = 5
"""Answers to choose from."""
MUCH = 3.0
"""Factor from which on something is much larger."""
PICTURES = 4
"""Moments of a film that are asked about."""


class Scene:
    """What is known of an item: when its bodies move, what touches what, and what of that is seen.

    Args:
        item: Its row.
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
        self._links = {row["body"]: k for k, row in reversed([*enumerate(links)]) if row["link"] != "world"}
        self._mass = Counter[str]()
        for row in links:
            self._mass[row["body"]] += row["mass"]
        still = {thing["body"] for thing in item["things"] if thing["static"]}
        bodies = dict.fromkeys(thing["body"] for thing in item["things"])
        self.copies = {body: [c for c in self._links if c.partition("[")[0] == body] for body in bodies}
        self.loose = [body for body in bodies if body not in still and self.copies[body]]
        self._pos, self._vel = pos.astype(float), vel.astype(float)
        self.clear = {body for body in bodies if self._is_clear(body)}
        chosen = [self._links[copy] for body in self.loose for copy in self.copies[body]]
        self.size = float(np.ptp(self._pos[0, chosen], axis=0).max()) if chosen else 0.0
        self.size = max(self.size, float(self._ways(chosen).max()) if chosen else 0.0, 1e-6)
        self.touches = [row for row in read_events(folder) if row.get("kind") == "contact" and _pair(row)]

    def _is_clear(self, body: str) -> bool:
        good = 0
        for frame in self.frames:
            mine = [one for one in frame["objects"] if one["name"].partition("[")[0] == body]
            share = sum(one["share"] for one in mine)
            hidden = min((one["hidden"] for one in mine if one["hidden"] is not None), default=1.0)
            good += share >= SEEN and hidden <= HIDDEN
        return good >= CLEAR * len(self.frames)

    def _ways(self, links: Sequence[int]) -> Any:
        return np.linalg.norm(self._pos[:, links] - self._pos[:1, links], axis=-1)

    def starts(self, body: str) -> float | None:
        """Return when the first of a body's copies has moved as far as counts [s]; None if none does."""
        ways = self._ways([self._links[copy] for copy in self.copies[body]]).max(axis=1)
        moved = np.flatnonzero(ways > MOVED * self.size)
        return float(self._time[moved[0]]) if len(moved) and moved[0] else None

    def moved(self, body: str) -> list[str]:
        """Return the copies that end elsewhere than they began."""
        links = [self._links[copy] for copy in self.copies[body]]
        return [
            c for c, far in zip(self.copies[body], self._ways(links)[self.last] > MOVED * self.size, strict=True) if far
        ]

    def fallen(self, body: str) -> list[str]:
        """Return the copies that have fallen over at the end of the film."""
        links = [self._links[copy] for copy in self.copies[body]]
        up = np.array((0.0, 0.0, 1.0))
        # The axis of a copy that pointed upwards at the start, turned with it.
        first, last = self._quat[0, links], self._quat[self.last, links]
        local = rotate(first * (1, -1, -1, -1), np.broadcast_to(up, (len(links), 3)))
        tilt = np.degrees(np.arccos(np.clip(rotate(last, local)[:, 2], -1, 1)))
        return [copy for copy, angle in zip(self.copies[body], tilt, strict=True) if angle > FALLEN]

    @property
    def last(self) -> int:
        """Recorded frame of the last picture."""
        return int(np.searchsorted(self._time, max(self.times) - 1e-9).clip(0, len(self._time) - 1))

    def mass(self, body: str) -> float:
        """Mass of the first copy of a body [kg]."""
        return float(self._mass[self.copies[body][0]])

    def pushed(self, body: str, t: float) -> float:
        """Return the change of speed of the first copy of a body from before to after a time [m/s]."""
        link = self._links[self.copies[body][0]]
        at = np.searchsorted(self._time, [t - 0.05, t + 0.1]).clip(0, len(self._time) - 1)
        return float(np.linalg.norm(self._vel[at[1], link] - self._vel[at[0], link]))

    def picture(self, t: float) -> int | None:
        """Return the first picture that shows a time or what comes after it; None if the film ends before."""
        return next((k for k, time in enumerate(self.times) if time >= t - 1e-9), None)


def ask(item: Mapping[str, Any], frames: Sequence[Row], folder: Path) -> list[Row]:
    """Return what can be asked about an item: `kind`, `question`, `right` and `evidence`.

    What is right has to be balanced against the same questions about other items before it is asked, see `balanced`.
    """
    scene = Scene(item, frames, folder)
    kinds = (_moves_first, _touches_first, _how_many, _touch_by, _will_touch, _heavier)
    return [
        {"key": item["key"], "kind": kind.__name__.strip("_"), **row, "evidence": json.dumps(row["evidence"])}
        for kind in kinds
        for row in kind(scene)
    ]


def what_if(
    base: Mapping[str, Any], other: Mapping[str, Any], words: str, frames: Sequence[Row], folder: Path
) -> list[Row]:
    """Return questions about an item that the run with another cause answers.

    Args:
        base: The item that is shown.
        other: The item in which one cause is different.
        words: What is different, see `cause_in_words`.
        frames: Pictures of the first.
        folder: Files of the first.
    """
    scene = Scene(base, frames, folder)
    came = {row["name"]: row for row in other["events"]}
    rows = []
    for event in base["events"]:
        name = event["name"]
        if name not in came or not scene.loose or not {*scene.loose} & scene.clear:
            continue
        evidence = {"item": other["key"], "event": name, "count": came[name]["count"], "cause": other["cause"]}
        rows.append(
            {
                "key": base["key"],
                "kind": "what_if",
                "question": f"If {words}, would this happen: {_words(name)}?",
                "right": "yes" if came[name]["count"] else "no",
                "evidence": json.dumps(evidence),
            }
        )
    return rows


def cause_in_words(path: str, value: Any, before: float | None) -> str:
    """Say what a counterfactual changes, without numbers: `the density of “ball” were much larger`.

    Args:
        path: Of what is changed.
        value: What it is now; None if it was taken away.
        before: What it was, if that was a number.
    """
    steps = path.split(".")
    name = _words(steps[-1])
    owner = _words(steps[2 if steps[0] in ("actions", "scene") else 1]) if len(steps) > 2 else ""
    subject = f"the {steps[-1].replace('_', ' ')} of {owner}" if owner else name
    if value is None:
        return f"{subject} were not there"
    if before is None or isinstance(value, bool) or not isinstance(value, int | float) or value == before:
        return f"{subject} were different"
    much = "much " if not before or not 1 / MUCH < value / before < MUCH else ""
    return f"{subject} were {much}{'larger' if value > before else 'smaller'}"


def _moves_first(scene: Scene) -> Iterator[Row]:
    starts = {body: t for body in scene.loose if body in scene.clear and (t := scene.starts(body)) is not None}
    order = sorted(starts, key=lambda body: starts[body])
    shown = {body: scene.picture(t) for body, t in starts.items()}
    for one, other in combinations(sorted(starts), 2):
        first, second = sorted((one, other), key=order.index)
        a, b = shown[first], shown[second]
        if a is not None and b is not None and b - a >= GAP:
            yield {
                "question": f"Which starts to move first, {_words(one)} or {_words(other)}?",
                "right": _words(first),
                "evidence": {"starts": {first: starts[first], second: starts[second]}},
            }


def _touches_first(scene: Scene) -> Iterator[Row]:
    for body in scene.loose:
        if body not in scene.clear:
            continue
        mine = [row for row in scene.touches if body in _pair(row) and len({*_pair(row)}) == 2 and row["time"] > 0.05]
        if not mine:
            continue
        first = min(mine, key=lambda row: row["time"])
        other = next(name for name in _pair(first) if name != body)
        if other in scene.clear and scene.picture(first["time"]) is not None:
            yield {
                "question": f"What does {_words(body)} touch first after the start?",
                "right": _words(other),
                "evidence": {"contact": first["between"], "time": first["time"]},
            }


def _how_many(scene: Scene) -> Iterator[Row]:
    for body in scene.loose:
        if body not in scene.clear or not 2 <= len(scene.copies[body]) <= 12:
            continue
        for words, found in (
            ("have moved away from their places", scene.moved(body)),
            ("have fallen over", scene.fallen(body)),
        ):
            yield {
                "question": f"How many of the {len(scene.copies[body])} of {_words(body)} {words} at the end?",
                "right": str(len(found)),
                "evidence": {"copies": found, "time": max(scene.times)},
            }


def _touch_by(scene: Scene) -> Iterator[Row]:
    """Has this touched that by a picture: whoever knows only the words cannot tell how fast things are."""
    for one, other, when in _first_touches(scene):
        for k in _moments(scene):
            t = scene.times[k]
            shown = None if when is None else scene.picture(when)
            if shown is not None and abs(shown - k) < GAP:
                continue
            touched = when is not None and when <= t
            yield {
                "question": f"Have {_words(one)} and {_words(other)} touched by picture {k} of {len(scene.times)}?",
                "right": "yes" if touched else "no",
                "evidence": {"first_contact": when, "picture_time": t},
            }


def _will_touch(scene: Scene) -> Iterator[Row]:
    """Will it reach: asked of the pictures before it does."""
    for one, other, when in _first_touches(scene):
        end = len(scene.times) // 3
        if end < GAP or (when is not None and when <= scene.times[end]):
            continue
        yield {
            "question": f"You see pictures 0 to {end} only. Will {_words(one)} touch {_words(other)} later on?",
            "right": "no" if when is None else "yes",
            "evidence": {"first_contact": when, "last_picture_time": scene.times[end]},
        }


def _heavier(scene: Scene) -> Iterator[Row]:
    for one, other, when in _first_touches(scene):
        if when is None or {one, other} - {*scene.loose}:
            continue
        masses = {body: scene.mass(body) for body in (one, other)}
        light, heavy = sorted(masses, key=lambda body: masses[body])
        pushes = {body: scene.pushed(body, when) for body in masses}
        if not masses[light] or masses[heavy] < HEAVIER * masses[light] or max(pushes.values()) < PUSHED:
            continue
        if pushes[light] > pushes[heavy] and scene.picture(when) is not None:
            yield {
                "question": f"Judging by how they move, which is heavier, {_words(one)} or {_words(other)}?",
                "right": _words(heavy),
                "evidence": {"mass": masses, "change_of_speed": pushes, "contact": when},
            }


def _first_touches(scene: Scene) -> Iterator[tuple[str, str, float | None]]:
    """Pairs of things that are well seen, one of them loose, that do not touch at the start; when they do [s]."""
    first: dict[tuple[str, str], float] = {}
    for row in scene.touches:
        pair = tuple(sorted(_pair(row)))
        first[pair[0], pair[1]] = min(first.get((pair[0], pair[1]), np.inf), row["time"])
    for one, other in combinations(sorted(scene.clear), 2):
        if {one, other} & {*scene.loose} and (when := first.get((one, other), np.inf)) > 0.05:
            yield one, other, float(when) if np.isfinite(when) else None


def _moments(scene: Scene) -> list[int]:
    count = len(scene.times)
    return sorted({round((count - 1) * k / PICTURES) for k in range(1, PICTURES)})


def _pair(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the bodies of a touch; links and copies are of their bodies."""
    return tuple(re.split(r"[.\[]", str(name))[0] for name in row.get("between", ()))


def _words(name: str) -> str:
    return f"“{name.replace('_', ' ')}”"


# --- what may be asked ----------------------------------------------------------------------------------------


def balanced(rows: Iterable[Row], counts: Mapping[tuple[str, str], Counter[str]], seed: int) -> Iterator[Row]:
    """Yield questions with choices, as the table has them, so that their text says nothing about the answer.

    Args:
        rows: What can be asked, with its `split`.
        counts: Of all of it: how often each answer is right, by split and question.
        seed: For the order of choices.
    """
    quota = {group: _quota(found) for group, found in counts.items()}
    given: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for row in rows:
        group = row["split"], row["question"]
        wanted = quota.get(group, {})
        if given[group][row["right"]] >= wanted.get(row["right"], 0):
            continue
        given[group][row["right"]] += 1
        choices, digest = [*wanted], sha256(row["question"].encode()).hexdigest()[:8]
        number = sum(given[group].values())
        generator(seed, row["key"], row["question"], number).shuffle(choices)
        kept = {name: row[name] for name in ("split", "key", "kind", "question", "evidence")}
        answer = {"choices": choices, "answer": choices.index(row["right"])}
        yield kept | answer | {"question_id": f"{row['key']}-{row['kind']}-{digest}"}


def _quota(found: Counter[str]) -> dict[str, int]:
    """How often each answer is taken: those that are right most often, each as often as the rarest of them.

    Of two answers up to `MOST`, as many as give the most questions.
    """
    ranked = sorted(found.items(), key=lambda pair: (-pair[1], pair[0]))[:MOST]
    best = max(range(1, len(ranked) + 1), key=lambda n: (n > 1, n * ranked[n - 1][1]))
    return {answer: ranked[best - 1][1] for answer, _ in ranked[:best]} if best > 1 else {}


def guess_by_words(rows: Sequence[Row], folds: int = 5) -> tuple[float, float]:
    """Return how often a classifier of words finds the answer without any picture, and how often chance does.

    Naive Bayes over the words, pairs of words and the whole of question and choice, trained on the other folds.
    """

    def features(row: Row, choice: str) -> list[str]:
        words = re.findall(r"\w+", row["question"].lower())
        pairs = [f"{a} {b}" for a, b in zip(words, words[1:], strict=False)]
        return [choice, *(f"{word}|{choice}" for word in {*words, *pairs}), f"{row['question']}|{choice}"]

    order = generator("folds", len(rows)).permutation(len(rows))
    hits = 0
    for fold in range(folds):
        seen = {True: Counter[str](), False: Counter[str]()}
        for k in order[np.arange(len(order)) % folds != fold]:
            for number, choice in enumerate(rows[k]["choices"]):
                seen[number == rows[k]["answer"]].update(features(rows[k], choice))
        totals = {truth: sum(found.values()) + 1 for truth, found in seen.items()}
        for k in order[np.arange(len(order)) % folds == fold]:
            scores = [
                sum(
                    np.log((seen[True][f] + 1) / totals[True]) - np.log((seen[False][f] + 1) / totals[False])
                    for f in features(rows[k], choice)
                )
                for choice in rows[k]["choices"]
            ]
            hits += int(np.argmax(scores)) == rows[k]["answer"]
    chance = float(np.mean([1 / len(row["choices"]) for row in rows])) if rows else 0.0
    return (hits / len(rows) if rows else 0.0), chance
