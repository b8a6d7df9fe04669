"""Lower bounds on the distances of bodies at the start, from their boxes."""

from math import hypot

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds
from text2sim.lint.facts import Facts
from text2sim.lint.parts import Ground, lowest_of


def min_gap(facts: Facts, a: Copy, b: Copy) -> float:
    """Return a lower bound [m] on the distance of two copies; 0 if they may touch, or it is not known.

    Args:
        facts: The case.
        a: A copy.
        b: Another copy.
    """
    box_a, box_b = facts.box(a), facts.box(b)
    if box_a is not None and box_b is not None:
        return hypot(*(max(0.0, p - s, r - q) for p, q, r, s in zip(*box_a, *box_b, strict=True)))
    plane, box = (a, box_b) if box_a is None else (b, box_a)
    ground = facts.ground(plane)
    return max(0.0, height(ground, box)) if ground is not None and box is not None else 0.0


def height(ground: Ground, box: Bounds) -> float:
    """Return the height [m] of the lowest corner of a box above a plane; negative below."""
    return lowest_of(box, ground.up) - ground.level
