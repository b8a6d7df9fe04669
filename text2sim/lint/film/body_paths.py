"""Predicted paths of bodies through the pictures of a film."""

from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec
from text2sim.lint.facts import Facts
from text2sim.lint.film.case_cameras import Offset, films_at, views_at
from text2sim.lint.film.subjects import center_of
from text2sim.lint.motion.whereabouts import Whereabouts
from text2sim.spec_schema.models.bodies import Driven

PATH_MOMENTS = 16
"""Moments at which the rules sample a path."""


def way_seen(facts: Facts, copy: Copy, start: float, end: float) -> Iterator[tuple[float, Vec, bool | None]]:
    """Yield moments of a copy's predicted path: time [s], position [m], and whether a camera that films then shows it.

    After the known part of the path, a body with a start velocity moves on horizontally.

    Args:
        facts: The case.
        copy: The copy; it has a size.
        start: First moment [s].
        end: Last moment [s].
    """
    center, radius = center_of(facts.balls(copy)), min(radius for _, radius in facts.balls(copy))
    known, pace = facts.once(Whereabouts).known_until(copy), facts.velocities.get(copy.name, (0.0, 0.0, 0.0))
    for k in range(PATH_MOMENTS):
        t = start + (end - start) * k / (PATH_MOMENTS - 1)
        step, on = facts.once(Whereabouts).offset(copy, t), max(t - known, 0.0)
        moved = (center[0] + step[0] + pace[0] * on, center[1] + step[1] + pace[1] * on, center[2] + step[2])
        views = [view for view in views_at(facts, t, offset_of(facts)) if films_at(facts, view.name, t)]
        yield t, moved, any(view.shows(moved, radius) for view in views) if views else None


def comes_in(facts: Facts, name: str) -> bool:
    """Return whether a body that no camera shows at the start probably moves into a picture."""
    render = facts.plan.render
    return any(
        shown
        for copy in facts.placed[name]
        if facts.balls(copy)
        if isinstance(copy.model, Driven) or any(facts.velocities.get(copy.name, ()))
        for _, _, shown in way_seen(facts, copy, render["start"], render["end"])
    )


def offset_of(facts: Facts) -> Offset:
    """Return the predicted displacement of copies, by name and time."""
    return lambda name, t: facts.once(Whereabouts).offset(facts.copies[name], t)
