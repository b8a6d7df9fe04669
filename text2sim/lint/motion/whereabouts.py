"""Whereabouts of a body: its probable position at a time, and a box that it hardly leaves."""

import math
from functools import cache

from text2sim.compiler.belts import carriers, world_velocity
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.prescribed import displacement, displacements
from text2sim.compiler.shapes.boxes import NOWHERE, Bounds, apart, around, around_balls, grown, sides, swept
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.soft.lowering import mass
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import flight_of
from text2sim.lint.motion.reach import LinkReach
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.names.selectors import body_of

MAX_DISTANCE = 1e4
"""Largest predicted distance [m]."""
HELD_REACH = 2.0
"""Reach of a held body in multiples of its size, if its joints do not give it."""


class Whereabouts:
    """Predictions for the bodies of a case, from `facts.once`."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self.box = cache(self._box)
        """A box [m] that a copy hardly leaves: around its start, its fall and its prescribed motion."""
        self._lowest: float | None = None

    # --- at a time ---------------------------------------------------------------------------------------------

    def offset(self, copy: Copy, t: float) -> Vec:
        """Return the probable displacement [m] of a copy at a time [s]: by its motion, or in free flight."""
        if isinstance(copy.model, Driven):
            return displacement(copy.model.motion, t)
        flight = flight_of(self.facts, copy)
        return flight.offset(min(t, flight.end)) if flight is not None else (0.0, 0.0, 0.0)

    def known_until(self, copy: Copy) -> float:
        """Return the time [s] up to which the position of a copy is known; 0 if it is at rest, or is held."""
        if isinstance(copy.model, Driven):
            return self.facts.case.scene.duration
        flight = flight_of(self.facts, copy)
        return flight.end if flight is not None and flight.moves else 0.0

    # --- in the whole run --------------------------------------------------------------------------------------

    def meet(self, a: Copy, b: Copy) -> bool:
        """Return whether two copies could meet, generously estimated."""
        return not apart(self.box(a), self.box(b))

    def _box(self, copy: Copy) -> Bounds:
        box = self.facts.box(copy)
        assert box is not None, copy.name
        if not self.facts.moves(copy):
            return box
        size = max(sides(box))
        if isinstance(copy.model, Driven):
            return grown(swept(box, displacements(copy.model.motion)), size / 2)
        if not self.facts.free(copy) and not is_soft(copy.model):
            balls = self.facts.once(LinkReach).body(copy)
            return around_balls(balls) if balls else grown(box, HELD_REACH * size)
        low, high = swept(grown(box, size / 2), self._displacement_box(copy))
        floor = self._floor() - size if self.facts.case.scene.gravity[2] < 0 else -math.inf
        return (low[0], low[1], max(low[2], floor)), high

    def _displacement_box(self, copy: Copy) -> Bounds:
        """Return the box [m] of displacements by start velocity, gravity, forces and moving surfaces."""
        t, pull = self.facts.case.scene.duration, self.facts.case.scene.gravity
        thrown = _scaled(self.facts.velocities.get(copy.name, (0.0, 0.0, 0.0)), t)
        total = swept(self._pushed(copy), around([(0.0, 0.0, 0.0), thrown]))
        for carrier in carriers(self.facts.placed):
            total = swept(total, around([(0.0, 0.0, 0.0), _scaled(world_velocity(carrier), t)]))
        return swept(total, around([(0.0, 0.0, 0.0), _scaled(pull, t * t / 2)]))

    def _pushed(self, copy: Copy) -> Bounds:
        """Return the box [m] of displacements by the forces on a deformable copy."""
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
        """Return the height [m] below which there is nothing."""
        if self._lowest is None:
            boxes = [box for copy in self.facts.copies.values() if (box := self.facts.box(copy)) is not None]
            heights = [low[2] for low, _ in boxes]
            heights += [ground.level / ground.up[2] for ground in self.facts.planes if ground.up[2] > 0.5]
            self._lowest = max(min(heights, default=0.0), -MAX_DISTANCE)
        return self._lowest


def _scaled(displacement: Vec, times: float) -> Vec:
    x, y, z = (max(-MAX_DISTANCE, min(c * times, MAX_DISTANCE)) for c in displacement)
    return x, y, z
