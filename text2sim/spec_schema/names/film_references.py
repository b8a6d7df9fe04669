"""Checks of the names and times of cameras, lights, shots and overlays."""

from typing import Any

from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.cameras import Mounted
from text2sim.spec_schema.models.regions import BodyPoint
from text2sim.spec_schema.models.render import Render, Shot
from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.text.document import Path

MAX_FILMED = 100_000
"""Most frames of a film: at 25 frames per second, more than an hour."""
DERIVED = "main"
"""Name of the camera of a case without cameras."""


def check_film(table: NameTable) -> None:
    """Check the references of the render section."""
    render = table.loaded.case.render
    for section, things in (("cameras", render.cameras), ("lights", render.lights)):
        for name, thing in things.items():
            _check_targets(table, ("render", section, name), thing)
            if isinstance(thing, Mounted):
                _check_carrier(table, ("render", section, name, "on"), thing.on)
    _check_shots(table)
    measures = table.loaded.case.actions.measures
    for i, name in enumerate(render.overlay.values):
        table.check_known(("render", "overlay", "values", i), "measure", name, measures)
    _check_length(table)
    if render.quality == "final":
        message = "a run makes the rasterised preview; `text2sim render RUN --quality final` makes the final film"
        table.report(("render", "quality"), message, "no-final", severity="warning")


def _check_targets(table: NameTable, where: Path, thing: Any) -> None:
    for key in ("body", "look_at", "focus", "at"):
        target = getattr(thing, key, None)
        if isinstance(target, BodyPoint):
            table.find(target.body, (*where, key, "body"))
        elif isinstance(target, str):
            table.find(target, (*where, key))
    for i, selector in enumerate(getattr(thing, "frame", None) or ()):
        found = table.find(selector, (*where, "frame", i), many=True, touching=True)
        if found is not None and getattr(getattr(found.model, "shape", None), "kind", None) == "plane":
            message = f"`{found.name}` is a plane, too large for a picture; name the bodies on it"
            table.report((*where, "frame", i), message, "endless-frame")


def _check_carrier(table: NameTable, where: Path, on: str) -> None:
    member = table.find(on, where)
    if member is not None and (member.count > 1 or member.deforms):
        what = "deforms" if member.deforms else f"selects {member.count} copies"
        hint = f"{member.name}[0]" if member.count > 1 and not member.deforms else None
        message = f"`{on}` {what}: a camera is mounted on one body that does not deform, or on one link"
        table.report(where, message, "carrier", hint)


def _check_shots(table: NameTable) -> None:
    scene, render = table.loaded.case.scene, table.loaded.case.render
    known, film = list(render.cameras) or [DERIVED], _span_of_film(render, scene.duration)
    for name, shot in render.shots.items():
        where: Path = ("render", "shots", name)
        table.check_known((*where, "camera"), "camera", shot.camera, known)
        first, last = _span_of_shot(shot, film)
        if first >= scene.duration:
            message = f"the shot begins at {first:g} s, after the end of the run ({scene.duration:g} s)"
            table.report((*where, "from") if shot.from_ is not None else where, message, "after-end")
        elif last <= first:
            message = f"the shot would last from {first:g} s to {last:g} s; missing times are those of the film"
            table.report((*where, "from") if shot.from_ is not None else (*where, "to"), message, "empty-shot")
        elif last > scene.duration:
            message = f"the run ends at {scene.duration:g} s, and so does the shot"
            table.report((*where, "to"), message, "after-end", severity="warning")


def _check_length(table: NameTable) -> None:
    scene, render = table.loaded.case.scene, table.loaded.case.render
    start, end = _span_of_film(render, scene.duration)
    if start >= scene.duration:
        message = f"the film would start after the end of the run ({scene.duration:g} s)"
        table.report(("render", "during"), message, "after-end")
    seconds = 0.0 if render.shots else (end - start) / render.speed
    for shot in render.shots.values():
        first, last = _span_of_shot(shot, (start, end))
        seconds += max(min(last, scene.duration) - first, 0.0) / (shot.speed or render.speed) + shot.hold
    if seconds * render.fps > MAX_FILMED:
        message = f"gives {seconds * render.fps:.3g} frames of film; at most {MAX_FILMED:,} are possible"
        table.report(("render",), message, "too-many", key=True)


def _span_of_film(render: Render, duration: float) -> tuple[float, float]:
    """Return the first and last time [s] that the film may show."""
    start, end = span_of(render.during, duration)
    return start, min(end, duration)


def _span_of_shot(shot: Shot, film: tuple[float, float]) -> tuple[float, float]:
    """Return the first and last time [s] of a shot; those it does not have are the film's."""
    return film[0] if shot.from_ is None else shot.from_, film[1] if shot.to is None else shot.to
