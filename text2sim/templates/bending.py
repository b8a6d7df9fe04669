"""Bending of sheets that are stiff, keep their shape, or keep their creases.

Bending of cloth in Genesis 1.4.5 is flat at rest, knows no sign of an angle, and is as stiff as its solver gets. Here
every edge has an angle of rest: that at the start if the sheet keeps its shape. Where a fold is too tight, the angle of
rest follows it: perfect plasticity. A sheet may have a flexural rigidity.
"""

import math

import numpy as np
import quadrants as qd

TINY = 1e-12
SLIVER = 0.25
"""Largest (frequency of one edge alone times substep)^2: edges of slivers are softened to it."""


class Bending:
    """Replaces the bending of all cloth in a scene.

    Args:
        bodies: The bodies by name, after the scene was built.
        rows: By name of a sheet: its flexural rigidity [N m], None for the engine's compliance; the radius of curvature
            [m] below which a fold stays, None if none does; whether it is at rest as it starts, or else flat.
    """

    def __init__(self, bodies, rows):
        self.solver = bodies[next(iter(rows))].solver
        edges, copies = self.solver.inner_edges_info, self.solver.particles.shape[1]
        corners = np.stack([getattr(edges, corner).to_numpy() for corner in ("v1", "v2", "v3", "v4")], axis=1)
        places = self.solver.particles.pos.to_numpy()[:, 0].astype(float)[corners]
        masses = self.solver.particles_info.mass.to_numpy().astype(float)[corners]
        limits, stiffness, rest = np.full(len(corners), np.inf), np.zeros(len(corners)), np.zeros(len(corners))
        for name, (rigidity, radius, at_rest) in rows.items():
            own = (corners[:, 0] >= bodies[name].particle_start) & (corners[:, 0] < bodies[name].particle_end)
            if rigidity is not None and own.any():
                stiffness[own] = stable(rigidity, places[own], corners[own], masses[own], self.solver.substep_dt)
            if radius is not None:
                limits[own] = spans(places[own]) / radius
            if at_rest:
                rest[own] = angles(places[own])
        self.limits, self.stiffness = qd.field(qd.f32, len(corners)), qd.field(qd.f32, len(corners))
        self.limits.from_numpy(limits.astype(np.float32))
        self.stiffness.from_numpy(stiffness.astype(np.float32))
        self.rest = qd.field(qd.f32, (len(corners), copies))
        self.rest.from_numpy(np.repeat(rest.astype(np.float32)[:, None], copies, axis=1))
        self.solver._kernel_solve_bending = self._bend

    def _bend(self, _):
        solver, fields = self.solver, (self.limits, self.stiffness, self.rest)
        for sweep in range(solver._max_bending_solver_iterations):
            _bend(solver.inner_edges_info, solver.particles_info, solver.particles, *fields, solver.substep_dt, sweep)
            _move(solver.particles_info, solver.particles)


def angles(corners):
    """Return the angle by which the cloth is bent at each edge [rad], as in `_bend`.

    Args:
        corners: Ends of the edges and the corners opposite them [m], (n, 4, 3).
    """
    along, one, other = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    n1, n2 = np.cross(along, one), np.cross(other, along)
    length = np.linalg.norm(along, axis=1)
    return np.arctan2((np.cross(n1, n2) * along).sum(axis=1) / length, (n1 * n2).sum(axis=1))


def gradients(corners):
    """Return the gradient of each edge's angle by the positions of its corners [1/m], (n, 4, 3), as in `_bend`."""
    along, one, other = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    length = np.linalg.norm(along, axis=1)[:, None]
    n1, n2 = np.cross(along, one), np.cross(other, along)
    g3, g4 = (-length * n / (n * n).sum(axis=1)[:, None] for n in (n1, n2))
    t3, t4 = ((side * along).sum(axis=1)[:, None] / length**2 for side in (one, other))
    return np.stack([(t3 - 1) * g3 + (t4 - 1) * g4, -t3 * g3 - t4 * g4, g3, g4], axis=1)


def stable(rigidity, corners, points, masses, h):
    """Return the stiffness of each edge [N m]: that of the rigidity, or less where a substep is too long for it.

    Forces that are added at predicted positions are stable while the highest frequency times the substep is below 1.15.

    Args:
        rigidity: Flexural rigidity [N m].
        corners: Ends of the edges and the corners opposite them [m], (n, 4, 3).
        points: Their numbers, (n, 4).
        masses: Their masses [kg], (n, 4).
        h: Substep [s].
    """
    by = gradients(corners)
    alone = ((by * by).sum(axis=2) / masses).sum(axis=1) * h**2
    stiffness = np.minimum(
        rigidity * np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1) / spans(corners), SLIVER / alone
    )
    # The highest frequency of the sheet, by power iteration from noise.
    moved = np.random.default_rng(0).normal(size=(points.max() + 1, 3))
    for _ in range(60):
        moments = stiffness * (by * moved[points]).sum(axis=(1, 2))
        pull = np.zeros_like(moved)
        np.add.at(pull, points, by * moments[:, None, None] / masses[..., None])
        highest = np.linalg.norm(pull) / np.linalg.norm(moved)
        moved = pull / np.linalg.norm(pull)
    return stiffness * min(1.0, 1.0 / (highest * h**2))


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
    stiffness: qd.template(),
    rest: qd.template(),
    h: qd.f32,
    sweep: qd.i32,
):
    """Add displacements that turn each edge to its angle of rest, after that has followed in the first sweep.

    The angle between two triangles and its gradient are those of Bridson et al., Simulation of clothing with folds and
    wrinkles, 2003. Compliance acts as in the engine, where it is divided by the squared sine of the angle.

    An edge with a stiffness k [N m] is turned by the moment k times its angle, once in a substep. With
    k = D length / span, a sheet bent to the curvature c stores D c^2 / 2 per area.
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
            relaxation, step = edges[e].bending_relaxation, 0.0
            if stiffness[e] > 0.0:
                if sweep == 0:
                    # The divisor matters where a triangle is squeezed flat, so that its gradients are large.
                    step = -bent / (1.0 / (stiffness[e] * h**2) + weight)
            elif weight > 0.0:
                sine = qd.sin(bent) ** 2
                step = -bent * sine / (weight * sine + edges[e].bending_compliance / h**2 + TINY) * relaxation
            if step != 0.0:
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
