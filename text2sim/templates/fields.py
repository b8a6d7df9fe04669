"""Fields: accelerations [m/s2] that fill space. The engine lets them act on mpm and pbd bodies, and on nothing else.

Those of the engine that are not here do as they say. Its own `Point` pushes where it should pull, and its `Vortex`
grows with the distance.
"""

import genesis as gs
import numpy as np
import quadrants as qd


@qd.data_oriented
class Attraction(gs.force_fields.ForceField):
    """A pull towards a point: `strength / r^falloff`."""

    def __init__(self, center, strength, falloff):
        super().__init__()
        self._center = qd.Vector(np.array(center), dt=gs.qd_float)
        self._strength, self._falloff = strength, falloff

    @qd.func
    def _get_acc(self, pos, vel, t, i):
        arm = self._center - pos
        distance = arm.norm(gs.EPS)
        return arm / distance * self._strength * distance ** (-self._falloff)


@qd.data_oriented
class Whirl(gs.force_fields.ForceField):
    """A whirl about a vertical axis: `swirl / r^falloff` around it, `inward / r^falloff` towards it."""

    def __init__(self, center, swirl, inward, falloff):
        super().__init__()
        self._center = qd.Vector(np.array(center), dt=gs.qd_float)
        self._swirl, self._inward, self._falloff = swirl, inward, falloff

    @qd.func
    def _get_acc(self, pos, vel, t, i):
        arm = pos - self._center
        arm[2] = 0.0
        distance = arm.norm(gs.EPS)
        around = qd.Vector([-arm[1], arm[0], 0.0], dt=gs.qd_float)
        return (self._swirl * around - self._inward * arm) / distance * distance ** (-self._falloff)


class Fields:
    """Switches the fields on and off: (field, from [s], to [s])."""

    def __init__(self, fields):
        self.fields, self.active = fields, set()

    def __call__(self, t):
        """Do so before the step that begins at t [s]."""
        t += 1e-9  # a step that begins at the start of a span belongs to it, whatever the rounding
        for number, (field, start, end) in enumerate(self.fields):
            if (start <= t < end) != (number in self.active):
                field.deactivate() if number in self.active else field.activate()
                self.active ^= {number}
