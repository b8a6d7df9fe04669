"""Acceleration fields [m/s2]. The engine applies them to mpm and pbd bodies only.

`Attraction` and `Whirl` replace two fields of the engine: its `Point` pushes where it should pull, and its `Vortex`
grows with the distance.
"""

import genesis as gs
import numpy as np
import quadrants as qd


@qd.data_oriented
class Attraction(gs.force_fields.ForceField):
    """An acceleration of `strength / r^falloff` towards a point."""

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
    """Accelerations `swirl / r^falloff` around a vertical axis and `inward / r^falloff` towards it."""

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


@qd.data_oriented
class Changing(gs.force_fields.ForceField):
    """Another field, scaled by a factor and displaced by a shift [m]; both change with time."""

    def __init__(self, field):
        super().__init__()
        self._field = field
        self._factor = qd.field(gs.qd_float, shape=())
        self._shift = qd.Vector.field(3, gs.qd_float, shape=())
        self._factor[None] = 1.0

    def change(self, factor, shift):
        """Set the factor and the shift [m] for the steps that follow."""
        self._factor[None] = factor
        self._shift[None] = shift

    @qd.func
    def _get_acc(self, pos, vel, t, i):
        return self._factor[None] * self._field._get_acc(pos - self._shift[None], vel, t, i)


class Fields:
    """Switches the fields on and off, and updates those that change with time at every step.

    Args:
        fields: For each field, a row of itself, its start and its end [s].
        changing: For each that changes, a row of its index in `fields`, its factor as a function of time (None: 1), and
            the velocity of its pattern [m/s].
    """

    def __init__(self, fields, changing=()):
        self.fields, self.active, self.changing = fields, set(), changing

    def __call__(self, t):
        """Update the fields before the step that begins at t [s]."""
        t += 1e-9  # rounding must not exclude a step that begins at `start`
        for number, (field, start, end) in enumerate(self.fields):
            if start <= t < end and number not in self.active:
                field.activate()
                self.active.add(number)
            elif not start <= t < end and number in self.active:
                field.deactivate()
                self.active.remove(number)
        for number, factor, drift in self.changing:
            if number in self.active:
                shift = np.array(drift) * t
                self.fields[number][0].change(1.0 if factor is None else factor(t), shift)
