"""Search for a camera and light for a run, by the measured legibility of bodies."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

import numpy as np

from text2sim.compiler.build import resolve_case
from text2sim.legibility.film import Watcher, spread_numbers
from text2sim.legibility.sight import contrast
from text2sim.legibility.summary import summarise
from text2sim.lint.facts import Facts
from text2sim.lint.film.subjects import subjects
from text2sim.recording.film_record import FilmRecord
from text2sim.recording.run_files import read_events
from text2sim.rendering.candidates import Candidate, Scorer, best
from text2sim.rendering.film import Filming
from text2sim.spec_schema.changes.operation import Operation
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.render import Render
from text2sim.templates.cadence import MAIN, frames, reels
from text2sim.templates.cameras import Cameras

MOMENTS, EVENTS = 4, 3
"""Numbers of sampled moments spread over the film, and of moments of events."""
LIGHTINGS: tuple[str, ...] = get_args(Render.model_fields["lighting"].annotation)
TRIAL = (160, 90)
"""Size of the pictures in which lights are compared [pixels]."""
LIT_AT = 2
"""Number of moments at which lights are compared."""
PLAIN = 0.06
"""Contrast by which another light must exceed `studio`."""
DARK, BURNT = 0.05, 0.97
"""Brightness below and above which the shape of a body is lost."""


@dataclass(frozen=True)
class RenderProposal:
    """A proposed `render` section."""

    render: dict[str, Any]
    """The section: `cameras`, and `lighting` if the case has no lights of its own."""
    operations: list[Operation]
    """The same as a JSON Patch of the case."""
    score: float
    """Score of the proposed camera, about 0 to 1."""
    before: float
    """Score of the present first camera of the run."""
    lights: dict[str, float]
    """Mean contrast of bodies in each light that was tried."""
    legibility: dict[str, Any]
    """Legibility of the proposed film, as in `evidence.json`."""
    tried: int
    """Number of cameras that were tried."""


def suggest(recording: FilmRecord, loaded: LoadedCase, tell: Callable[[str], None]) -> RenderProposal:
    """Return a camera and light for a run.

    Args:
        recording: The recording of the run.
        loaded: Its case.
        tell: Called with progress messages.

    Raises:
        SpecError: If the case cannot be resolved.
    """
    facts, film = Facts(resolve_case(loaded)), recording.film
    bare = _with_render(
        loaded, {key: value for key, value in _written(loaded).items() if key not in ("cameras", "shots")}
    )
    derived = resolve_case(bare).plan.render["cameras"]["main"]["frame"]
    times = _moments(recording)
    scorer = Scorer(recording, subjects(facts), times, derived["within"])
    chosen = _frames(scorer, derived["bodies"])
    tell(f"trying cameras at {len(times)} moments")
    ranked = best(scorer, chosen)
    score, camera = ranked[0]
    present = Cameras(film, recording.states)
    views = [present.view(*_camera_at(film, recording, t)) for t in times]
    before = scorer.judge(views, np.subtract(views[0].look_at, views[0].pos))
    render: dict[str, Any] = {"cameras": {"main": _words(camera, scorer)}}
    if film["overlay"].get("pace"):  # an author's camera would have no pace of its own
        render["shots"] = {
            f"part_{k}": {key: shot[key] for key in ("camera", "from", "to", "speed", "hold")} | {"camera": "main"}
            for k, shot in enumerate(film["shots"], 1)
        }
    lights: dict[str, float] = {}
    if not loaded.case.render.lights:
        tell("trying lights")
        lights = {name: _lit(recording, loaded, render | {"lighting": name}, scorer) for name in LIGHTINGS}
        winner = max(LIGHTINGS, key=lambda name: lights[name] + PLAIN * (name == "studio"))
        render = {"lighting": winner, **render}
    shown = _filmed(recording, loaded, render)
    return RenderProposal(
        render, _operations(loaded, render), round(score, 4), round(before, 4),
        {name: round(float(value), 4) for name, value in lights.items()}, summarise(Watcher(shown)), len(ranked),
    )  # fmt: skip


def _moments(recording: FilmRecord) -> list[float]:
    """Return times [s] spread over the film, and the first times of events."""
    film = recording.film
    pictures = frames(film, reels(film)[MAIN], recording.last)
    times = [pictures[k].t for k in spread_numbers(len(pictures), MOMENTS)]
    first: dict[str, float] = {}
    for row in read_events(recording.folder):
        if row["name"] and film["start"] <= row["time"] <= film["end"]:
            first.setdefault(row["name"], float(row["time"]))
    return sorted({round(t, 6) for t in [*times, *list(first.values())[:EVENTS]]})


def _camera_at(film: dict[str, Any], recording: FilmRecord, t: float) -> tuple[str, float, float]:
    """Return the present camera of the film, its frame time nearest to a time [s], and the camera's progress."""
    pictures = frames(film, reels(film)[MAIN], recording.last)
    frame = min(pictures, key=lambda frame: abs(frame.t - t))
    return frame.camera, frame.t, frame.part


def _frames(scorer: Scorer, derived: Sequence[str]) -> list[tuple[str, ...]]:
    """Return sets to frame: the bodies of the derived camera, all moving bodies, the subjects of the script."""
    names, statics = scorer.recorded.names, scorer.recorded.statics
    usual = tuple(name for name in derived if name in names)
    moving = tuple(name for name in names if name not in statics)
    main = tuple(name for name, weight in zip(names, scorer.weights, strict=True) if weight == 1.0)
    return [frame for frame in dict.fromkeys([usual, moving, main]) if frame]


def _words(candidate: Candidate, scorer: Scorer) -> dict[str, Any]:
    """Return a camera in the language."""
    words: dict[str, Any] = {
        "kind": "still",
        "frame": list(candidate.frame),
        "direction": [round(c, 2) for c in candidate.direction],
        "lens_mm": candidate.lens,
    }
    if scorer.within is not None and scorer.strays(candidate.frame):
        low, high = ([round(float(c), 2) for c in corner] for corner in scorer.within)
        words["within"] = {"min": low, "max": high}
    return words


def _written(loaded: LoadedCase) -> dict[str, Any]:
    """Return the `render` section as written, with variants and expressions resolved."""
    return loaded.case.render.model_dump(mode="json", by_alias=True, exclude_unset=True)


def _with_render(loaded: LoadedCase, render: dict[str, Any]) -> LoadedCase:
    """Return the case with another `render` section."""
    model = Render.model_validate(render)
    return replace(loaded, case=loaded.case.model_copy(update={"render": model}))


def _filmed(recording: FilmRecord, loaded: LoadedCase, render: dict[str, Any]) -> FilmRecord:
    """Return the recording with the film of a proposed `render` section."""
    kept = {key: value for key, value in _written(loaded).items() if key not in ("cameras", "shots")}
    return replace(recording, film=resolve_case(_with_render(loaded, kept | render)).plan.render)


def _lit(recording: FilmRecord, loaded: LoadedCase, render: dict[str, Any], scorer: Scorer) -> float:
    """Return the score of a light: contrast of bodies in traced frames, with a penalty for under- and overexposure."""
    shown = _filmed(recording, loaded, render)
    filming, watcher = Filming(shown, "draft", size=TRIAL, samples=4), Watcher(shown)
    pictures = filming.reels()[0].frames
    found = []
    for k in spread_numbers(len(pictures), LIT_AT + 2)[1:-1] or [0]:
        picture = filming.develop(filming.trace(pictures[k])).astype(float) / 255
        frame = pictures[k]
        view = watcher.cameras.view(frame.camera, frame.t, frame.part)
        sight = watcher.recorded.sight(frame.t, view, TRIAL)
        for n, weight in enumerate(scorer.weights):
            mask = sight.mask(n)
            if weight and mask.any() and (apart := contrast(picture, mask)) is not None:
                bright = picture[mask].mean(axis=1)
                lost = float(((bright < DARK) | (bright > BURNT)).mean())
                found.append((weight, apart * (1 - lost)))
    total = sum(weight for weight, _ in found)
    return sum(weight * value for weight, value in found) / total if total else 0.0


def _operations(loaded: LoadedCase, render: dict[str, Any]) -> list[Operation]:
    """Return the patch of the case as written."""
    data = loaded.written.data
    if not isinstance(data.get("render"), dict):
        return [{"op": "add", "path": "/render", "value": render}]
    found: list[Operation] = [{"op": "add", "path": f"/render/{key}", "value": value} for key, value in render.items()]
    if "shots" in data["render"] and "shots" not in render:
        found.append({"op": "remove", "path": "/render/shots"})
    return found
