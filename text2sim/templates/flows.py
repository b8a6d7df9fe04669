"""Moves the particles of streams through their pipes."""

import genesis as gs
import numpy as np
import quadrants as qd
import torch


class Flows:
    """Lets streams flow.

    Args:
        scene: The built scene.
        streams: Streams by copy name.
        bodies: Entities by copy name.
        dt: Time step [s].
    """

    def __init__(self, scene, streams, bodies, dt):
        self._flows = [Flow(scene, stream, bodies[name], dt) for name, stream in streams.items()]

    def __call__(self, t):
        """Prepare the step that begins at time `t` [s]."""
        for flow in self._flows:
            flow(t)


class Flow:
    """Moves the particles of one stream through its pipe, in every substep."""

    def __init__(self, scene, stream, entity, dt):
        self._sim, self._stream, self._entity, self._dt = scene.sim, stream, entity, dt
        self._fed, self._piped = 0, (0, 0)
        self._rows = [
            torch.tensor(rows, dtype=gs.tc_float, device=gs.device)
            for rows in (stream.mouth, stream.times, stream.velocity)
        ]
        solver, substep = entity.solver, entity.solver.substep_pre_coupling

        def fed(f):
            first, last = self._piped
            if last > first:
                now = self._sim.cur_substep_global * self._sim.substep_dt
                _carry(solver.particles, f, entity.particle_start, first, last, now, *self._rows)
            substep(f)

        solver.substep_pre_coupling = fed

    def __call__(self, t):
        """Let into the pipe what enters it during the step that begins at time `t` [s]."""
        stream, end = self._stream, t + self._dt
        first, last = np.searchsorted(stream.times, [t, end + stream.ahead]).tolist()
        if last > self._fed:
            self._entity.set_particles_active(
                gs.ACTIVE, torch.arange(self._fed, last, dtype=gs.tc_int, device=gs.device)
            )
        self._fed, self._piped, stream.now = last, (first, last), end


@qd.kernel
def _carry(
    particles: qd.template(),
    f: qd.i32,
    start: qd.i32,
    first: qd.i32,
    last: qd.i32,
    now: qd.f32,
    mouth: qd.types.ndarray(),
    times: qd.types.ndarray(),
    velocity: qd.types.ndarray(),
):
    for k in range(first, last):
        if times[k] >= now:  # the first may come out at once
            flown = now - times[k]
            for j in qd.static(range(3)):
                particles[f, start + k, 0].pos[j] = mouth[k, j] + flown * velocity[j]
                particles[f, start + k, 0].vel[j] = velocity[j]
            particles[f, start + k, 0].C = qd.Matrix.zero(gs.qd_float, 3, 3)
            particles[f, start + k, 0].F = qd.Matrix.identity(gs.qd_float, 3)
