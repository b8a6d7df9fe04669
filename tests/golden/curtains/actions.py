"""The actions on the bodies of curtains, applied step by step."""

import math
from bisect import bisect_right

import numpy as np
from holds import Hold, Holds
from points import sides
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


def main_link(body):
    """Return the first link of a body that is not the world."""
    return next(link for link in body.links if link.name != "world")


# Body, joint, and its targets: start [s], controlled quantity, target as a function of time.
DRIVES = [
    (
        "left_hook[0]",
        "left_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, -0.735, -0.735, 0.0]),
            ),  # case.yaml:57 open_left
        ],
    ),
    (
        "left_hook[1]",
        "left_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, -0.63, -0.63, 0.0]),
            ),  # case.yaml:57 open_left
        ],
    ),
    (
        "left_hook[2]",
        "left_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, -0.525, -0.525, 0.0]),
            ),  # case.yaml:57 open_left
        ],
    ),
    (
        "left_hook[3]",
        "left_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, -0.42, -0.42, 0.0]),
            ),  # case.yaml:57 open_left
        ],
    ),
    (
        "left_hook[4]",
        "left_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, -0.315, -0.315, 0.0]),
            ),  # case.yaml:57 open_left
        ],
    ),
    (
        "left_hook[5]",
        "left_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, -0.21, -0.21, 0.0]),
            ),  # case.yaml:57 open_left
        ],
    ),
    (
        "left_hook[6]",
        "left_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, -0.105, -0.105, 0.0]),
            ),  # case.yaml:57 open_left
        ],
    ),
    (
        "left_hook[7]",
        "left_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.0, 0.0, 0.0]),
            ),  # case.yaml:57 open_left
        ],
    ),
    (
        "right_hook[0]",
        "right_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.735, 0.735, 0.0]),
            ),  # case.yaml:64 open_right
        ],
    ),
    (
        "right_hook[1]",
        "right_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.63, 0.63, 0.0]),
            ),  # case.yaml:64 open_right
        ],
    ),
    (
        "right_hook[2]",
        "right_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.525, 0.525, 0.0]),
            ),  # case.yaml:64 open_right
        ],
    ),
    (
        "right_hook[3]",
        "right_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.42, 0.42, 0.0]),
            ),  # case.yaml:64 open_right
        ],
    ),
    (
        "right_hook[4]",
        "right_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.315, 0.315, 0.0]),
            ),  # case.yaml:64 open_right
        ],
    ),
    (
        "right_hook[5]",
        "right_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.21, 0.21, 0.0]),
            ),  # case.yaml:64 open_right
        ],
    ),
    (
        "right_hook[6]",
        "right_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.105, 0.105, 0.0]),
            ),  # case.yaml:64 open_right
        ],
    ),
    (
        "right_hook[7]",
        "right_hook",
        [
            (
                0.0,
                "position",
                piecewise(times=[0.0, 1.0, 3.5, 5.0, 7.5], values=[0.0, 0.0, 0.0, 0.0, 0.0]),
            ),  # case.yaml:64 open_right
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


def make_holds(scene, bodies):
    """Return the holds of points of deformable bodies."""
    return [
        # case.yaml:55 hang_left
        Hold(
            scene,
            bodies["left"],
            pose=((-0.52, 0.0, 1.35), (0.707106781, 0.707106781, 0.0, 0.0)),
            region=sides((1, 1), within=0.0125),
            count=8,
            to=[
                main_link(bodies[name])
                for name in (
                    "left_hook[0]",
                    "left_hook[1]",
                    "left_hook[2]",
                    "left_hook[3]",
                    "left_hook[4]",
                    "left_hook[5]",
                    "left_hook[6]",
                    "left_hook[7]",
                )
            ],
        ),
        # case.yaml:56 hang_right
        Hold(
            scene,
            bodies["right"],
            pose=((0.52, 0.0, 1.35), (0.707106781, 0.707106781, 0.0, 0.0)),
            region=sides((1, 1), within=0.0125),
            count=8,
            to=[
                main_link(bodies[name])
                for name in (
                    "right_hook[0]",
                    "right_hook[1]",
                    "right_hook[2]",
                    "right_hook[3]",
                    "right_hook[4]",
                    "right_hook[5]",
                    "right_hook[6]",
                    "right_hook[7]",
                )
            ],
        ),
    ]


class Actions:
    """Everything that acts on the bodies besides gravity, contacts and joints."""

    def __init__(self, scene, bodies):
        """Set the start velocities, and look up the joints and links that the actions need."""
        self.each_step = [
            Drives(scene, bodies),
            Holds(make_holds(scene, bodies)),
        ]

    def before_step(self, step):
        """Apply all actions before time step `step`, which begins at `step * DT`."""
        t = step * DT
        for act in self.each_step:
            act(t)
