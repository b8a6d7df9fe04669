"""Whereabouts of a body: its probable place at a time, and a box that it hardly leaves."""

import math

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.prescribed import displacement, displacements
from text2sim.compiler.shapes.boxes import NOWHERE, Bounds, apart, around, grown, swept
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.soft.lowering import mass
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import Flight, flight_of
from text2sim.lint.motion.reach import reach_of
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.names.selectors import body_of

HIGHEST = 1e4
"""Nothing is thought to get farther [m] than this."""
HELD = 2.0
"""How many times its size a body is thought to get that something holds, where its joints do not tell."""


class Whereabouts:
    """Where the bodies of a case get, each worked out when it is asked for; see `whereabouts`."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self._boxes: dict[str, Bounds] = {}
        self._lowest: float | None = None

    # --- at a time ---------------------------------------------------------------------------------------------

    def offset(self, copy: Copy, t: float) -> Vec:
        """Return how far [m] a copy has probably come at a time [s]: as far as it is driven, or flies alone."""
        if isinstance(copy.model, Driven):
            return displacement(copy.model.motion, t)
        flight = self.flight(copy)
        return flight.offset(min(t, flight.end)) if flight is not None else (0.0, 0.0, 0.0)

    def known_until(self, copy: Copy) -> float:
        """Return the time [s] up to which it is known where a copy is; 0 if it stays where it is, or is held."""
        if isinstance(copy.model, Driven):
            return self.facts.case.scene.duration
        flight = self.flight(copy)
        return flight.end if flight is not None and flight.moves else 0.0

    def flight(self, copy: Copy) -> Flight | None:
        """Return the way of a copy up to what it meets first; None for what is held or has no size."""
        return flight_of(self.facts, copy)

    # --- in the whole run --------------------------------------------------------------------------------------

    def box(self, copy: Copy) -> Bounds:
        """Return a box [m] that a copy hardly leaves: where it starts, where it falls, where it is driven to."""
        if copy.name not in self._boxes:
            self._boxes[copy.name] = self._box(copy)
        return self._boxes[copy.name]

    def meet(self, a: Copy, b: Copy) -> bool:
        """Whether two copies could come to each other; judged generously."""
        return not apart(self.box(a), self.box(b))

    def _box(self, copy: Copy) -> Bounds:
        box = self.facts.box(copy)
        assert box is not None, copy.name
        if not self.facts.moves(copy):
            return box
        size = max(high - low for low, high in zip(*box, strict=True))
        if isinstance(copy.model, Driven):
            return grown(swept(box, displacements(copy.model.motion)), size / 2)
        if not self.facts.free(copy) and not is_soft(copy.model):
            balls = reach_of(self.facts).body(copy)
            return _around_balls(balls) if balls else grown(box, HELD * size)
        low, high = swept(grown(box, size / 2), self._way(copy))
        floor = self._floor() - size if self.facts.case.scene.gravity[2] < 0 else -math.inf
        return (low[0], low[1], max(low[2], floor)), high

    def _way(self, copy: Copy) -> Bounds:
        """Box [m] of displacements by start velocity, gravity and forces."""
        t, pull = self.facts.case.scene.duration, self.facts.case.scene.gravity
        ways = [NOWHERE, self._pushed(copy)]
        ways.append(around([(0.0, 0.0, 0.0), _scaled(self.facts.velocities.get(copy.name, (0.0, 0.0, 0.0)), t)]))
        ways.append(around([(0.0, 0.0, 0.0), _scaled(pull, t * t / 2)]))
        total = NOWHERE
        for way in ways:
            total = swept(total, way)
        return total

    def _pushed(self, copy: Copy) -> Bounds:
        """Box [m] of displacements by the forces on a deformable copy."""
        total, t = NOWHERE, self.facts.case.scene.duration
        if not is_soft(copy.model):
            return total
        weight = mass(copy, self.facts.folder)
        for control in self.facts.case.actions.controls.values():
            if control.kind == "force" and body_of(control.body) == copy.body:
                times = t * t / 2 / weight
                times = min(times, t / control.drag) if control.drag else times
                total = swept(total, around([(0.0, 0.0, 0.0), _scaled(control.force, times)]))
        return total

    def _floor(self) -> float:
        """Height [m] below which nothing is."""
        if self._lowest is None:
            boxes = [box for copy in self.facts.copies.values() if (box := self.facts.box(copy)) is not None]
            heights = [low[2] for low, _ in boxes]
            heights += [ground.level / ground.up[2] for ground in self.facts.planes if ground.up[2] > 0.5]
            self._lowest = max(min(heights, default=0.0), -HIGHEST)
        return self._lowest


def whereabouts(facts: Facts) -> Whereabouts:
    """Return where the bodies of a case get, worked out once."""
    return facts.own(Whereabouts)


def _scaled(way: Vec, times: float) -> Vec:
    x, y, z = (max(-HIGHEST, min(c * times, HIGHEST)) for c in way)
    return x, y, z


def _around_balls(balls: list[tuple[Vec, float]]) -> Bounds:
    boxes = [grown((center, center), radius) for center, radius in balls]
    return around(corner for box in boxes for corner in box)
