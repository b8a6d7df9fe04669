"""Lower bounds on the gaps between bodies at the start, from their boxes."""

from math import sqrt

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds
from text2sim.lint.facts import Facts
from text2sim.lint.parts import Ground, lowest_of


def gap(facts: Facts, a: Copy, b: Copy) -> float:
    """Return a lower bound [m] of the distance of two copies; 0 if they may touch, or nothing is known.

    Args:
        facts: The case.
        a: A copy.
        b: Another copy.
    """
    here, there = facts.box(a), facts.box(b)
    if here is not None and there is not None:
        sides = (max(0.0, p - s, r - q) for p, q, r, s in zip(*here, *there, strict=True))
        return sqrt(sum(side * side for side in sides))
    plane, box = (a, there) if here is None else (b, here)
    ground = next((ground for ground in facts.planes if ground.copy is plane), None)
    return max(0.0, height(ground, box)) if ground is not None and box is not None else 0.0


def height(ground: Ground, box: Bounds) -> float:
    """Return how high [m] the lowest corner of a box is above a plane; negative below."""
    return lowest_of(box, ground.up) - ground.level
