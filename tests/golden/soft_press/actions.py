"""The actions on the bodies of soft_press, applied step by step."""

import math
from bisect import bisect_right

import numpy as np
from scene import DT


def constant(value):
    """Return a function of time that is always `value`."""
    return lambda t: value


def ramp(start, end, before, after, ease):
    """Return a function of time that goes from `before` at `start` to `after` at `end`."""

    def value(t):
        u = min(max((t - start) / (end - start), 0.0), 1.0)
        return before + (after - before) * (u * u * (3.0 - 2.0 * u) if ease == "smooth" else u)

    return value


def sine(amplitude, frequency, offset, phase, start):
    """Return a function of time that oscillates about `offset`."""
    return lambda t: offset + amplitude * math.sin(2.0 * math.pi * frequency * (t - start) + phase)


def steps(times, values):
    """Return a step function of time."""
    return lambda t: values[max(bisect_right(times, t) - 1, 0)]


def piecewise(times, values):
    """Return a piecewise linear function of time."""
    return lambda t: float(np.interp(t, times, values))


def waypoints(times, values, ease):
    """Return a function of time through waypoints; `smooth` stops at each of them."""
    if ease == "linear":
        return piecewise(times, values)
    ramps = [ramp(a, b, u, v, ease) for a, b, u, v in zip(times, times[1:], values, values[1:])]
    return lambda t: ramps[min(max(bisect_right(times, t) - 1, 0), len(ramps) - 1)](t)


# Body, joint, and its targets: start [s], controlled quantity, target as a function of time.
DRIVES = [
    (
        "piston",
        "ram",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 0.4, 1.2, 2.2, 2.8], values=[0.0, 0.0, -0.14, -0.14, 0.0]),
            ),  # case.yaml:67 press
        ],
    ),
    (
        "piston",
        "head",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.3, 2.0, 2.2, 2.8], values=[0.0, 0.0, 1.05, 1.05, 0.0]),
            ),  # case.yaml:71 twist
        ],
    ),
]


class Drives:
    """Sets the targets of all driven joints, with one call for each controlled quantity."""

    def __init__(self, scene, bodies):
        self.solver = scene.rigid_solver
        self.rows = [(bodies[name].get_joint(joint).dofs_idx[0], targets) for name, joint, targets in DRIVES]

    def __call__(self, t):
        wanted = {"position": [], "velocity": [], "force": []}
        for dof, targets in self.rows:
            for start, mode, target in reversed(targets):
                if t >= start or start == 0.0:
                    wanted[mode].append((dof, target(t + DT), target(t)))
                    break
        if rows := wanted["position"]:
            dofs, ends, starts = (list(column) for column in zip(*rows))
            # With the target's velocity as well, the servo follows without lag.
            speeds = [(end - start) / DT for end, start in zip(ends, starts)]
            self.solver.control_dofs_position_velocity(np.array(ends), np.array(speeds), dofs)
        if rows := wanted["velocity"]:
            dofs, ends, _ = (list(column) for column in zip(*rows))
            self.solver.control_dofs_velocity(np.array(ends), dofs)
        if rows := wanted["force"]:
            dofs, _, starts = (list(column) for column in zip(*rows))
            self.solver.control_dofs_force(np.array(starts), dofs)


class Actions:
    """Everything that acts on the bodies besides gravity, contacts and joints."""

    def __init__(self, scene, bodies):
        """Set the start velocities, and look up the joints and links that the actions need."""
        self.each_step = [
            Drives(scene, bodies),
        ]

    def before_step(self, step):
        """Apply all actions before time step `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
