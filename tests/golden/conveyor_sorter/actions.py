"""What acts on the bodies of conveyor_sorter, step by step."""

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
    """Return a function of time that swings about `offset`."""
    return lambda t: offset + amplitude * math.sin(2.0 * math.pi * frequency * (t - start) + phase)


def steps(times, values):
    """Return a function of time that jumps to each value at its time."""
    return lambda t: values[max(bisect_right(times, t) - 1, 0)]


def piecewise(times, values):
    """Return a function of time that goes straight from value to value."""
    return lambda t: float(np.interp(t, times, values))


def waypoints(times, values, ease):
    """Return a function of time through values; `smooth` stops at each."""
    if ease == "linear":
        return piecewise(times, values)
    ramps = [ramp(a, b, u, v, ease) for a, b, u, v in zip(times, times[1:], values, values[1:])]
    return lambda t: ramps[min(max(bisect_right(times, t) - 1, 0), len(ramps) - 1)](t)


# Body, joint, and its targets: from when [s], what is controlled, target as a function of time.
DRIVES = [
    (
        "roller[0]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[1]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[2]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[3]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[4]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[5]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[6]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[7]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[8]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[9]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[10]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[11]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[12]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[13]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[14]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[15]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[16]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[17]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[18]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "roller[19]",
        "roller",
        [
            (0.0, "velocity", ramp(start=0.2, end=0.7, before=0.0, after=10.0, ease="smooth")),  # case.yaml:96 belt
        ],
    ),
    (
        "pusher[0]",
        "pusher",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 2.1, 2.5, 3.1], values=[0.0, 0.0, 0.42, 0.0]),
            ),  # case.yaml:100 push_red
        ],
    ),
    (
        "pusher[1]",
        "pusher",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 2.75, 3.15, 3.75], values=[0.0, 0.0, 0.42, 0.0]),
            ),  # case.yaml:104 push_green
        ],
    ),
    (
        "gate",
        "gate",
        [
            (0.0, "position", ramp(start=5.5, end=6.2, before=0.0, after=-1.5, ease="smooth")),  # case.yaml:108 open
        ],
    ),
]


class Drives:
    """Sets the targets of all driven joints, one call for each kind of target."""

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
            # With the velocity of the target the servo follows without lag.
            speeds = [(end - start) / DT for end, start in zip(ends, starts)]
            self.solver.control_dofs_position_velocity(np.array(ends), np.array(speeds), dofs)
        if rows := wanted["velocity"]:
            dofs, ends, _ = (list(column) for column in zip(*rows))
            self.solver.control_dofs_velocity(np.array(ends), dofs)
        if rows := wanted["force"]:
            dofs, _, starts = (list(column) for column in zip(*rows))
            self.solver.control_dofs_force(np.array(starts), dofs)


class Actions:
    """Everything that happens to the bodies besides physics."""

    def __init__(self, scene, bodies):
        """Set start velocities, and look up the joints and links that are acted on."""
        self.each_step = [
            Drives(scene, bodies),
        ]

    def before_step(self, step):
        """Act on the bodies before time step number `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
