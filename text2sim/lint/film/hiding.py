"""Whether something stands between a subject and the cameras."""

from text2sim.compiler.shapes.rotation import Vec
from text2sim.lint.facts import Facts
from text2sim.lint.film.shots import Shot
from text2sim.lint.film.subjects import Balls, drawn, middle_of

RAYS = 6
"""Points of a subject that are looked at."""


def maybe_hidden(facts: Facts, shot: Shot, name: str, balls: Balls) -> bool:
    """Return whether from all points of a subject the way to the camera goes through the box of something else."""
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


def hidden_behind(facts: Facts, seeing: list[Shot], name: str) -> str:
    """Say what hides a subject from all these cameras; nothing if something of it is seen."""
    from text2sim.drawing.views import visible

    copies = {copy.name for copy in facts.placed[name]}
    for shot in seeing:
        seen = visible(facts.resolution, shot.name)
        if copies & set(seen):
            return ""
    blocking = _blocking(facts, seeing[0], name)
    return f"it is hidden behind `{blocking}`; move the camera" if blocking else "it is hidden; move the camera"


def _blocking(facts: Facts, shot: Shot, name: str) -> str:
    middle = middle_of(drawn(facts, name))
    for copy in facts.copies.values():
        box = facts.box(copy)
        if copy.body != name and box is not None and _meets(box, shot.pos, middle):
            return copy.name
    return ""
