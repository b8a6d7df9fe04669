"""Tests whether something hides a subject from the cameras."""

from text2sim.compiler.looks import hides
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.film.case_cameras import CameraView
from text2sim.lint.film.subjects import Balls
from text2sim.spec_schema.models.shapes import Compound

TESTED_POINTS = 6
"""Points of a subject that are tested."""


def maybe_hidden(facts: Facts, view: CameraView, name: str, balls: Balls) -> bool:
    """Return whether the boxes of other bodies block the line of sight to every tested point of a subject.

    Args:
        facts: The case.
        view: The camera at a time.
        name: Name of the subject.
        balls: Balls around its parts: centre [m], radius [m].
    """
    step = max(len(balls) // TESTED_POINTS, 1)
    others = [
        (copy, box) for copy in facts.copies.values() if copy.body != name and (box := facts.box(copy)) is not None
    ]

    def between(center: Vec) -> bool:
        return any(
            _crosses(box, view.pos, center)
            and any(_crosses(part, view.pos, center) for part in _boxes(facts, copy, box))
            for copy, box in others
        )

    return all(between(center) for center, _ in balls[::step])


def _boxes(facts: Facts, copy: Copy, whole: Bounds) -> list[Bounds]:
    """Return the boxes around the opaque parts of a compound; of any other copy, the box around the whole."""
    if is_soft(copy.model) or not isinstance(copy.shape, Compound):
        return [whole]
    looks = {name: part.look for name, part in copy.shape.parts.items()}
    clear = {name for name, look in looks.items() if look is not None and not hides(look.opacity, look.finish)}
    return [part.box for part in facts.parts(copy) if part.piece.part not in clear]


def _crosses(box: tuple[Vec, Vec], start: Vec, end: Vec) -> bool:
    """Return whether a line segment passes through a box."""
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


def hidden_behind(facts: Facts, seeing: list[CameraView], name: str) -> str:
    """Return what hides a subject from all these cameras; empty if one sees part of it.

    Args:
        facts: The case.
        seeing: Cameras that look towards the subject.
        name: Name of the subject.
    """
    from text2sim.legibility.layout import at_start

    copies = {copy.name for copy in facts.placed[name]}
    first = None
    for view in seeing:
        layout = at_start(facts.resolution, view.name)
        if copies & layout.shares.keys():
            return ""
        first = first or layout
    blocking = first.hider(copies) if first else ""
    return f"it is hidden behind `{blocking}`; move the camera" if blocking else "it is hidden; move the camera"
