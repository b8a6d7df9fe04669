"""Tests whether something stands between a subject and the cameras."""

from text2sim.compiler.shapes.rotation import Vec
from text2sim.lint.facts import Facts
from text2sim.lint.film.shots import ShotView
from text2sim.lint.film.subjects import Balls

RAYS = 6
"""Points of a subject that are looked at."""


def maybe_hidden(facts: Facts, shot: ShotView, name: str, balls: Balls) -> bool:
    """Return whether from all points of a subject the way to the camera goes through the box of something else.

    Args:
        facts: The case.
        shot: The camera at a time.
        name: Name of the subject.
        balls: Balls around its parts: middle [m], radius [m].
    """
    step = max(len(balls) // RAYS, 1)
    boxes = [box for copy in facts.copies.values() if copy.body != name and (box := facts.box(copy)) is not None]
    return all(any(_meets(box, shot.pos, center) for box in boxes) for center, _ in balls[::step])


def _meets(box: tuple[Vec, Vec], start: Vec, end: Vec) -> bool:
    """Whether a line goes through a box."""
    first, last = 0.0, 1.0
    for a, b, low, high in zip(start, end, *box, strict=True):
        way = b - a
        if abs(way) < 1e-12:
            if not low <= a <= high:
                return False
            continue
        near, far = sorted(((low - a) / way, (high - a) / way))
        first, last = max(first, near), min(last, far)
    return first < last


def hidden_behind(facts: Facts, seeing: list[ShotView], name: str) -> str:
    """Say what hides a subject from all these cameras; nothing if something of it is seen.

    Args:
        facts: The case.
        seeing: Cameras that look towards the subject.
        name: Name of the subject.
    """
    from text2sim.legibility.layout import at_start

    copies = {copy.name for copy in facts.placed[name]}
    layouts = [at_start(facts.resolution, shot.name) for shot in seeing]
    if any(copies & layout.shares.keys() for layout in layouts):
        return ""
    blocking = layouts[0].hider(copies)
    return f"it is hidden behind `{blocking}`; move the camera" if blocking else "it is hidden; move the camera"
