"""Creases of cloth: folds tighter than a given radius stay.

Bending of cloth in Genesis 1.4.5 is flat at rest, and knows no sign of an angle. Here every edge has an angle of rest,
which follows its fold beyond a limit: perfect plasticity.
"""

import math

import numpy as np
import quadrants as qd

TINY = 1e-12


class Creases:
    """Replaces the bending of all cloth in a scene by one that keeps creases.

    Args:
        bodies: The bodies by name, after the scene was built.
        radii: For each cloth with creases, the radius of curvature [m] below which a fold stays.
    """

    def __init__(self, bodies, radii):
        self.solver = bodies[next(iter(radii))].solver
        edges, copies = self.solver.inner_edges_info, self.solver.particles.shape[1]
        corners = np.stack([getattr(edges, corner).to_numpy() for corner in ("v1", "v2", "v3", "v4")], axis=1)
        places, limits = self.solver.particles.pos.to_numpy()[:, 0].astype(float), np.full(len(corners), np.inf)
        for name, radius in radii.items():
            own = (corners[:, 0] >= bodies[name].particle_start) & (corners[:, 0] < bodies[name].particle_end)
            limits[own] = spans(places[corners[own]]) / radius
        self.limits, self.rest = qd.field(qd.f32, len(corners)), qd.field(qd.f32, (len(corners), copies))
        self.limits.from_numpy(limits.astype(np.float32))
        self.rest.fill(0.0)
        self.solver._kernel_solve_bending = self._bend

    def _bend(self, _):
        solver, fields = self.solver, (self.limits, self.rest)
        for sweep in range(solver._max_bending_solver_iterations):
            _bend(solver.inner_edges_info, solver.particles_info, solver.particles, *fields, solver.substep_dt, sweep)
            _move(solver.particles_info, solver.particles)


def spans(corners):
    """Return the width [m] of cloth that bends at each edge: half the heights of both its triangles.

    In a grid that is the distance of neighbouring folds, along its lines as along its diagonals.

    Args:
        corners: Ends of the edges and the corners opposite them [m], (n, 4, 3).
    """
    along = corners[:, 1] - corners[:, 0]
    twice = sum(np.linalg.norm(np.cross(along, corners[:, k] - corners[:, 0]), axis=1) for k in (2, 3))
    return twice / np.linalg.norm(along, axis=1) / 2


@qd.kernel
def _bend(
    edges: qd.template(),
    info: qd.template(),
    particles: qd.template(),
    limits: qd.template(),
    rest: qd.template(),
    h: qd.f32,
    sweep: qd.i32,
):
    """Add displacements that turn each edge to its angle of rest, after that has followed in the first sweep.

    The angle between two triangles and its gradient are those of Bridson et al., Simulation of clothing with folds and
    wrinkles, 2003. Compliance acts as in the engine, where it is divided by the squared sine of the angle.
    """
    for e, b in rest:
        v1, v2, v3, v4 = edges[e].v1, edges[e].v2, edges[e].v3, edges[e].v4
        along = particles[v2, b].pos - particles[v1, b].pos
        one, other = particles[v3, b].pos - particles[v1, b].pos, particles[v4, b].pos - particles[v1, b].pos
        length, n1, n2 = along.norm(), along.cross(one), other.cross(along)
        if qd.min(n1.norm(), n2.norm()) > TINY:
            angle = qd.atan2(n1.cross(n2).dot(along) / length, n1.dot(n2))
            bent = angle - rest[e, b]
            bent -= 2 * math.pi * qd.round(bent / (2 * math.pi))
            over = qd.abs(bent) - limits[e]
            if sweep == 0 and over > 0.0:
                over *= qd.select(bent > 0.0, 1.0, -1.0)
                rest[e, b] += over
                bent -= over
            g3, g4 = -length / n1.norm_sqr() * n1, -length / n2.norm_sqr() * n2
            t3, t4 = one.dot(along) / length**2, other.dot(along) / length**2
            g1, g2 = -(1 - t3) * g3 - (1 - t4) * g4, -t3 * g3 - t4 * g4
            w1, w2 = particles[v1, b].free / info[v1].mass, particles[v2, b].free / info[v2].mass
            w3, w4 = particles[v3, b].free / info[v3].mass, particles[v4, b].free / info[v4].mass
            weight = w1 * g1.norm_sqr() + w2 * g2.norm_sqr() + w3 * g3.norm_sqr() + w4 * g4.norm_sqr()
            sine = qd.sin(bent) ** 2
            total = weight * sine + edges[e].bending_compliance / h**2
            if total > 0.0:
                step = -bent * sine / total * edges[e].bending_relaxation
                particles[v1, b].dpos += w1 * step * g1
                particles[v2, b].dpos += w2 * step * g2
                particles[v3, b].dpos += w3 * step * g3
                particles[v4, b].dpos += w4 * step * g4


@qd.kernel
def _move(info: qd.template(), particles: qd.template()):
    for i, b in particles:
        if particles[i, b].free and info[i].material_type == 0:
            particles[i, b].pos += particles[i, b].dpos
            particles[i, b].dpos.fill(0)
