"""Keeps belts in motion and in place: statics whose surfaces move."""

import math

import genesis as gs
import torch
from genesis.utils.misc import qd_to_torch


class Belts:
    """Gives belts their speed before every step, with which friction carries what lies on them.

    A belt is on a slider with so much inertia that contacts hardly affect it. It is set back by as far as it comes in a
    step, so that it is in its place at the end of every step, and never farther from it than that. The values are
    written into the solver's fields: setting positions through the engine clears all contacts, and costs thirty times
    as much.

    Args:
        scene: Built scene.
        bodies: Entities by name.
        belts: Velocity [m/s] of the surface of each belt, along its slider, by name.
        dt: Time step [s].
    """

    def __init__(self, scene, bodies, belts, dt):
        solver = scene.rigid_solver
        joints = [bodies[name].joints[-1] for name in belts]
        dofs, speeds = [joint.dof_start for joint in joints], [math.hypot(*velocity) for velocity in belts.values()]
        solver.set_dofs_velocity(torch.tensor(speeds, dtype=gs.tc_float), dofs)
        velocity = torch.tensor(speeds, dtype=gs.tc_float, device=gs.device)
        self.values = [
            (solver.dyn_state.dofs.vel, dofs, velocity),
            (solver.qpos, [joint.q_start for joint in joints], -dt * velocity),
        ]

    def __call__(self, t):
        """Prepare the step that begins at t [s]."""
        for field, rows, value in self.values:
            values = qd_to_torch(field, copy=not gs.use_zerocopy)
            values[rows, 0] = value
            if not gs.use_zerocopy:
                field.from_torch(values)
