"""Distances between bodies at the start."""

import math

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import apart
from text2sim.compiler.shapes.gjk import distance
from text2sim.lint.facts import Facts
from text2sim.lint.parts import Ground

MAX_TESTED_PAIRS = 4000
"""Most pairs of pieces that are measured in a case; the others count as far apart."""


class Gaps:
    """Distances of copies at the start, up to a budget of tests."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self.left = MAX_TESTED_PAIRS

    def between(self, a: Copy, b: Copy, limit: float) -> float:
        """Return the distance [m] of two copies at the start, 0 if they overlap, and at most `limit`.

        Args:
            a: A copy.
            b: Another copy.
            limit: Largest distance of interest [m].
        """
        box_a, box_b = self.facts.box(a), self.facts.box(b)
        if box_a is None or box_b is None or apart(box_a, box_b, -limit):
            return limit
        best = limit
        for one in self.facts.parts(a):
            if apart(one.box, box_b, -best):
                continue
            for other in self.facts.parts(b):
                if self.left > 0 and best > 0.0 and not apart(one.box, other.box, -best):
                    self.left -= 1
                    best = min(best, distance(one.solid, other.solid))
        return best

    def to_plane(self, copy: Copy, ground: Ground, limit: float) -> float:
        """Return the height [m] of the lowest point of a copy above a plane, negative below, and at most `limit`.

        Args:
            copy: The copy.
            ground: The plane.
            limit: Largest height of interest [m].
        """
        depth = max((ground.depth(part) for part in self.facts.parts(copy)), default=-math.inf)
        return min(-depth, limit)
