"""Facts computed from a run and bound to requirements: counts, colours, visibility, touches, causes of motion.

A requirement with a false fact is not met, whatever the Critic says. If a fact is undecided, the Critic decides.
"""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from text2sim.agents.color_terms import color_name, matches_color
from text2sim.agents.drawn_colors import drawn_colors
from text2sim.agents.replies import Claim, Name
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.recording.run_files import read_json
from text2sim.spec_schema.errors import RunError, SpecError, Text2SimError
from text2sim.spec_schema.names.selectors import body_of, parse_selector

if TYPE_CHECKING:
    from text2sim.compiler.build import Resolution
    from text2sim.evidence.contact_events import Occurrence
    from text2sim.evidence.recorded_case import RecordedCase
    from text2sim.evidence.selection import RecordedTarget
    from text2sim.spec_schema.loaded import LoadedCase

MIN_VISIBLE_FRACTION = 0.0004
"""Smallest visible fraction: 19 x 19 pixels of 1280 x 720; seven hooks of 0.09 % in all are plainly seen."""
MIN_DISPLACEMENT, MIN_ROTATION_DEG = 0.01, 5.0
"""Smallest displacement [m] and rotation [deg] that count as motion."""
MIN_MOTION_RATIO = 2.0
"""Smallest ratio of the motion after a touch to that before it, if the touch is the cause."""
SAME, MAX_COMPARED = 0.01, 6
"""Relative difference up to which masses and sizes are the same, and most of them that are told."""
MOVING_CONTROLS = ("initial_velocity", "impulse", "force", "torque", "drive", "reach", "airflow")
"""Kinds of controls that act on a body by themselves; those that hold, let go or remove it are none, nor are fields."""
FROM_THE_START = 2.5
"""Number of time steps within which a touch counts as present from the start."""


Claims = Mapping[Name, list[Claim]]
FactAnswer = tuple[bool | None, str]
"""Whether a fact holds (None if undecided), and a sentence with the values found."""


@dataclass(frozen=True)
class Fact:
    """A computed fact about a requirement."""

    requirement: str
    ok: bool | None
    """None if undecided."""
    told: str
    """Sentence with the values found."""
    about_cause: bool = False
    """Whether it compares the run with one without a cause."""
    without: tuple[str, ...] = ()
    """The causes without which that run finished."""

    def __str__(self) -> str:
        return f"{ {True: 'true', False: 'FALSE', None: 'open'}[self.ok] }: {self.told}"


@dataclass(frozen=True)
class JudgedRun:
    """A run, as far as facts are computed from it."""

    recording: "RecordedCase"
    resolution: "Resolution"
    evidence: Mapping[str, Any]
    """Content of `evidence.json`."""
    seen: Mapping[str, float]
    """Largest part of a sampled picture that each body and static fills."""
    folder: Path
    """The run folder."""

    @cached_property
    def seen_links(self) -> dict[str, float]:
        """Largest part of a picture of the main film that each link fills, by label (`arm[1].hand`).

        Raises:
            RunError: If nothing was recorded that can be filmed.
        """
        from text2sim.legibility.film import Watcher
        from text2sim.legibility.summary import largest_shares
        from text2sim.recording.film_record import read_recording

        return largest_shares(Watcher(read_recording(self.folder), links=True))

    @cached_property
    def least_inside(self) -> dict[str, float]:
        """Smallest fraction of each body and static within a picture of the main film; raises like `seen_links`."""
        from text2sim.legibility.film import Watcher
        from text2sim.legibility.summary import least_inside
        from text2sim.recording.film_record import read_recording

        return least_inside(Watcher(read_recording(self.folder)))


def facts_as_data(facts: Iterable[Fact]) -> list[dict[str, Any]]:
    """Return the facts as data."""
    return [asdict(fact) for fact in facts]


def claim_faults(claims: Claims, requirements: Iterable[str], bodies: Iterable[str]) -> list[str]:
    """Describe the unknown names in a plan's claims.

    Args:
        claims: Claims by requirement.
        requirements: Names of requirements.
        bodies: Names of bodies in the plan.
    """
    bodies, requirements = list(bodies), list(requirements)
    wrong = [f"/facts/{name}: there is no requirement `{name}`" for name in claims if name not in requirements]
    for name, rows in claims.items():
        for body in dict.fromkeys(body for row in rows for body in row.bodies):
            if body not in bodies and not any(body.startswith(f"{one}_") for one in bodies):  # a part of a prefab
                wrong.append(f"/facts/{name}: `{body}` is not in `bodies`")
    return wrong


def compute_facts(claims: Claims, loaded: "LoadedCase", run: Path) -> list[Fact]:
    """Compute facts of a run.

    Args:
        claims: Facts that the plan asks for, by requirement.
        loaded: The case.
        run: The run folder.
    """
    if not claims:
        return []
    from text2sim.compiler.build import resolve_case
    from text2sim.evidence.recorded_case import RecordedCase

    try:
        recording, resolution = RecordedCase.load(run, loaded.case), resolve_case(loaded)
        evidence = json.loads((run / "evidence.json").read_text("utf-8"))
        judged = JudgedRun(recording, resolution, evidence, _most_seen(read_json(run / "visibility.json")), run)
    except (Text2SimError, OSError, ValueError) as error:
        return [Fact(name, None, str(error).splitlines()[0]) for name in claims]
    return [Fact(name, *_compute(row, judged)) for name, rows in claims.items() for row in rows]


def _compute(claim: Claim, run: JudgedRun) -> FactAnswer:
    from text2sim.evidence.selection import SelectionError

    try:
        return _FACT_FUNCTIONS[claim.sort](claim, run)
    except (SelectionError, RunError, SpecError, KeyError, ValueError) as error:
        return None, f"cannot be told: {str(error).splitlines()[0]}"


def _count(claim: Claim, run: JudgedRun) -> FactAnswer:
    """Whether a selector has the wanted number of bodies."""
    number = len(run.recording.names.select(claim.count))
    return number == claim.equals, f"there are {number} `{claim.count}`, wanted {claim.equals}"


def _same(claim: Claim, run: JudgedRun) -> FactAnswer:
    """Whether bodies have the same mass or size."""
    value = _mass if claim.same == "mass" else _size
    values = {target.label: value(target, run) for name in claim.of for target in run.recording.names.select(name)}
    if len(values) < 2:
        raise ValueError(f"{', '.join(f'`{name}`' for name in claim.of)} is only one body")
    unit, (least, most) = "kg" if claim.same == "mass" else "m", (min(values.values()), max(values.values()))
    told = ", ".join(f"`{name}` {number:.4g} {unit}" for name, number in list(values.items())[:MAX_COMPARED])
    return most <= (1 + SAME) * least, f"{claim.same}: {told}"


def _mass(target: "RecordedTarget", run: JudgedRun) -> float:
    if target.soft is not None:
        from text2sim.compiler.masses import masses

        return masses(run.resolution)[target.copy]
    return float(run.recording.masses[list(target.links)].sum())


def _size(target: "RecordedTarget", run: JudgedRun) -> float:
    """Longest side [m] of the box around a body as it starts, or around one of its links, along its own axes."""
    from text2sim.compiler.shapes.extents import body_extents, extents
    from text2sim.compiler.trees.link_trees import tree_extents

    (copy,) = (copy for copy in run.resolution.placed[body_of(target.copy)] if copy.name == target.copy)
    folder = run.resolution.loaded.folder
    if target.label != target.copy:
        link = (getattr(copy.model, "links", None) or {}).get(target.label.rpartition(".")[2])
        if link is None or link.shape is None:
            raise ValueError(f"`{target.label}` is a link, of which no size is known")
        low, high = extents(link.shape, IDENTITY, folder)
    elif copy.shape is not None:
        low, high = extents(copy.shape, IDENTITY, folder)
    else:
        low, high = body_extents(copy.model, IDENTITY, folder, tree_extents)
    return max(b - a for a, b in zip(low, high, strict=True))


def _is_passive(claim: Claim, run: JudgedRun) -> FactAnswer:
    """Whether a body or link is moved by gravity, contact and its joints alone: no control or motor acts on it."""
    names, case = run.recording.names, run.recording.case
    body = body_of(claim.passive)
    if body in case.bodies and case.bodies[body].kind == "driven":
        return False, f"`{body}` is driven along a given path"
    own = _columns(names.select(claim.passive))
    acting = [
        f"`{name}` ({control.kind})"
        for name, control in case.actions.controls.items()
        if control.kind in MOVING_CONTROLS
        and own & _columns(names.select(getattr(control, "joint", None) or getattr(control, "body", ())))
    ]
    told = f"{', '.join(acting)} acts on" if acting else "no force, drive or start velocity acts on"
    return not acting, f"{told} `{claim.passive}`"


def _columns(targets: Iterable["RecordedTarget"]) -> set[tuple[str, int]]:
    """The copies and links that a fact or control is about."""
    return {(target.copy, link) for target in targets for link in target.links or (target.root,)}


# --- colours -------------------------------------------------------------------------------------------------------


def _color(claim: Claim, run: JudgedRun) -> FactAnswer:
    """Whether a body, part or link is drawn in a colour; every copy of a body must show it somewhere."""
    wanted = parse_selector(claim.color)
    copies = run.resolution.placed.get(wanted.body, [])[wanted.first : wanted.last]
    if not copies:
        raise ValueError(f"there is no `{claim.color}`")
    drawn = [drawn_colors(copy, wanted.part) for copy in copies]
    if not all(drawn):
        return None, f"the colours of `{claim.color}` come from its file"
    names = sorted({color_name(color) for colors in drawn for color in colors})
    ok = all(any(matches_color(color, claim.like) for color in colors) for colors in drawn)
    return ok, f"`{claim.color}` is {', '.join(names[:4])}, wanted {claim.like}"


# --- what is seen, and what touched or moved what ------------------------------------------------------------------


def _is_seen(claim: Claim, run: JudgedRun) -> FactAnswer:
    """Whether the main film shows a body, or each of the links that a selector names."""
    if "." in claim.seen and not claim.whole:
        links = [target.label for target in run.recording.names.select(claim.seen)]
        least = min(links, key=lambda link: run.seen_links.get(link, 0.0))  # 0 where nothing of it is drawn
        return _enough(least, run.seen_links.get(least, 0.0), f", the least of {len(links)} links" * (len(links) > 1))
    (body,) = claim.bodies
    if claim.whole:
        from text2sim.legibility.summary import TRIMMED_SHARE

        part = run.least_inside[body]
        return (
            part >= TRIMMED_SHARE,
            f"{100 * part:.0f} % of `{body}` at least is within the picture, wanted all of it",
        )
    films = (run.evidence.get("legibility") or {}).get("films") or {}
    main = next(iter(films.values())) if films else {"bodies": {}}
    row, still = main["bodies"].get(body), main.get("statics", {}).get(body)
    most = row["share"]["max"] if row is not None else run.seen.get(body) if still is None else still
    if most is None:
        return None, f"what the film shows of `{body}` was not measured"
    pictures = f" and is seen in {row['seen']} of {main['pictures']} samples" if row and "pictures" in main else ""
    return _enough(body, most, pictures)


def _enough(name: str, most: float, pictures: str = "") -> FactAnswer:
    """Whether the largest part of a picture that something fills is enough to be seen."""
    told = f"`{name}` fills at most {100 * most:.2g} % of the film's picture{pictures}"
    if most >= MIN_VISIBLE_FRACTION:
        return True, told
    return False, f"{told}; it has to fill {100 * MIN_VISIBLE_FRACTION:.2g} % at some time"


def _most_seen(visibility: Any) -> dict[str, float]:
    """Largest part of a sampled picture that each body and static fills, all its copies together."""
    most: dict[str, float] = {}
    for samples in (visibility if isinstance(visibility, dict) else {}).values():
        for sample in samples:
            sums: dict[str, float] = {}
            for name, share in sample["shares"].items():
                base = body_of(name)
                sums[base] = sums.get(base, 0.0) + share
            most = {name: max(most.get(name, 0.0), sums.get(name, 0.0)) for name in {**most, **sums}}
    return most


def _touches(recording: "RecordedCase", of: str, others: Sequence[str]) -> "list[Occurrence]":
    """Touches of a selector and any of others, sorted by time.

    Raises:
        RunError: If they were not recorded.
    """
    from text2sim.evidence.events import find_events
    from text2sim.spec_schema.models.events import ContactEvent

    touches = {by: ContactEvent.model_validate({"kind": "contact", "between": [of, by]}) for by in others}
    actions = recording.case.actions.model_copy(update={"events": touches})
    log = find_events(replace(recording, case=recording.case.model_copy(update={"actions": actions})), {})
    if log.problems:
        raise RunError(next(iter(log.problems.values())))
    return sorted((row for rows in log.occurrences.values() for row in rows), key=lambda row: float(row["time"]))


def _any_of(selectors: Sequence[str]) -> str:
    return " or ".join(f"`{selector}`" for selector in selectors)


def _has_touched(claim: Claim, run: JudgedRun) -> FactAnswer:
    """Whether one body touches another: at all, for a total time, or never."""
    rows = _touches(run.recording, claim.touched, claim.by)
    if not rows:
        sentence = f"{_any_of(claim.by)} never touches `{claim.touched}`"
        if claim.never and run.evidence.get("state") != "finished":
            return None, f"{sentence} until the run ended, before its end"
        return claim.never, sentence
    total, until, step = 0.0, -inf, run.recording.states.dt
    for row in rows:
        start, end = float(row["time"]) - step, float(row["end"])  # a contact in a single step lasts that step
        total += max(0.0, end - max(start, until))
        until = max(until, end)
    sentence = (
        f"{_any_of(claim.by)} touches `{claim.touched}` first at {rows[0]['time']:.3g} s, for {total:.3g} s in all"
    )
    if claim.never:
        return False, f"{sentence}, wanted never"
    if claim.lasting is not None:
        return total >= claim.lasting - step / 2, f"{sentence}, wanted {claim.lasting:g} s"
    return True, sentence


def _has_moved(claim: Claim, run: JudgedRun) -> FactAnswer:
    """Whether a body moves after another has touched it, and hardly before."""
    rows, by = _touches(run.recording, claim.moved, claim.by), _any_of(claim.by)
    names = {target.label: target for target in run.recording.names.select(claim.moved)}
    if not rows:
        return False, f"{by} never touches `{claim.moved}`"
    touched = rows[0]["between"][0 if rows[0]["between"][0] in names else 1]
    at = float(rows[0]["time"])
    (moved, turn), (more, further) = _motion(run.recording, names[touched], at)
    ok = (more > MIN_DISPLACEMENT and more > MIN_MOTION_RATIO * moved) or (
        further > MIN_ROTATION_DEG and further > MIN_MOTION_RATIO * turn
    )
    before, after = f"{moved:.2g} m and {turn:.2g} deg", f"{more:.2g} m and {further:.2g} deg"
    if ok and at <= FROM_THE_START * run.recording.states.dt:
        return None, f"{by} touches `{touched}` from the start: its touch tells nothing"
    return ok, f"{by} first touches `{touched}` at {at:.3g} s, which moved {before} before, {after} after"


_FACT_FUNCTIONS: Mapping[str, Callable[[Claim, JudgedRun], FactAnswer]] = {
    "count": _count,
    "color": _color,
    "seen": _is_seen,
    "moved": _has_moved,
    "touched": _has_touched,
    "same": _same,
    "passive": _is_passive,
}
"""Function for each sort of fact (`FACTS` in `replies`)."""


def _motion(
    recording: "RecordedCase", target: "RecordedTarget", at: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the largest displacement [m] and rotation [deg] of a target, before a time [s] and after it."""
    states = recording.states
    places = recording.origin(target)
    if len(target.links) > 1 and (masses := recording.masses[list(target.links)]).sum() > 0:
        centers = recording.centers(np.array(target.links))
        places = np.einsum("fni,n->fi", centers, masses / masses.sum())
    turns = states.quat[:, target.root].astype(float) if target.soft is None else None
    there = max(int((~recording.gone(target.copy)).sum()), 1)  # frames until it was removed
    split = min(int(np.searchsorted(states.time, at, "right")) - 1, there - 1)
    spans = []
    # At the recorded time of a touch, its impulse has acted already, so the span after it begins one frame earlier.
    for rows in (slice(0, max(split, 1)), slice(max(split - 1, 0), there)):
        distance = float(np.linalg.norm(places[rows] - places[rows][0], axis=1).max())
        turn = 0.0
        if turns is not None:
            cosine = np.abs(turns[rows] @ turns[rows][0]).min()
            turn = float(np.degrees(2 * np.arccos(min(cosine, 1.0))))
        spans.append((distance, turn))
    return spans[0], spans[1]
