"""Contact of cloth with mpm bodies.

Genesis 1.4.5 gives a node of the grid the mean velocity of the particles of cloth next to it, and gives each of these
the whole momentum that the node lost. So momentum appears from nothing, and cloth that is lighter than what lies on it
explodes. This module replaces that.
"""

import genesis as gs
import quadrants as qd

HELD = 1e4  # factor on the mass of attached particles, which nothing pushes away
CORE = 0.1  # relative change of mass over a cell below which a node lies inside a body and not at its surface


def add_contact(body):
    """Let all cloth in the built scene of `body` collide with its mpm bodies, after each step of the grid."""
    coupler, pbd, mpm = body.sim.coupler, body.solver, body.sim.mpm_solver
    particles = pbd.particles_reordered, pbd.particles_ng_reordered, pbd.particles_info_reordered
    shape = (*mpm.grid_res, 1)
    weight = qd.field(gs.qd_float, shape=shape)
    momentum, after, kick = (qd.Vector.field(3, gs.qd_float, shape=shape) for _ in range(3))
    grid_step, corner = coupler.mpm_grid_op, [int(x) for x in mpm.grid_offset]

    def step(f, *args, **options):
        grid_step(f, *args, **options)
        _collide(
            *particles, mpm.grid, weight, momentum, after, kick, f, *corner, mpm.inv_dx, 1 / mpm.particle_volume_scale
        )

    coupler.mpm_grid_op = step


@qd.func
def _node(pos, corner, inv_dx, grid: qd.template()):
    """Returns the nearest node, moved inside the grid so that it has neighbours."""
    node = qd.floor(pos * inv_dx + 0.5).cast(gs.qd_int) - corner
    for k in qd.static(range(3)):
        node[k] = qd.min(qd.max(node[k], 1), grid.shape[k + 1] - 2)
    return node


@qd.kernel
def _collide(
    particles: qd.template(),
    flags: qd.template(),
    info: qd.template(),
    grid: qd.template(),
    weight: qd.template(),
    momentum: qd.template(),
    after: qd.template(),
    kick: qd.template(),
    f: qd.i32,
    x: qd.i32,
    y: qd.i32,
    z: qd.i32,
    inv_dx: qd.f32,
    scale: qd.f32,
):
    """Let each node with mass and the particles that are nearest to it collide without rebound.

    With the reduced mass m of node and particles, the impulse takes away the approach a along the normal n of the body,
    m a n, and of the slip t as much as Coulomb's law allows, at most m mu a. Nodes in a body, where mass has no
    gradient, move along with the cloth.
    """
    for i, b in qd.ndrange(particles.shape[0], particles.shape[1]):
        node = _node(particles[i, b].pos, qd.Vector([x, y, z]), inv_dx, grid)
        weight[node, b] = 0.0
        momentum[node, b] = qd.Vector([0.0, 0.0, 0.0])
    for i, b in qd.ndrange(particles.shape[0], particles.shape[1]):
        node = _node(particles[i, b].pos, qd.Vector([x, y, z]), inv_dx, grid)
        if flags[i, b].active:
            mass = info[i, b].mass
            if not particles[i, b].free:
                mass *= HELD
            weight[node, b] += mass
            momentum[node, b] += mass * particles[i, b].vel
    for i, b in qd.ndrange(particles.shape[0], particles.shape[1]):
        node = _node(particles[i, b].pos, qd.Vector([x, y, z]), inv_dx, grid)
        here = grid[f, node, b].mass
        if flags[i, b].active and here > gs.EPS:
            velocity, cloth = grid[f, node, b].vel_out, momentum[node, b] / weight[node, b]
            normal = qd.Vector([0.0, 0.0, 0.0])
            for k in qd.static(range(3)):
                step = qd.Vector.unit(3, k, gs.qd_int)
                normal[k] = grid[f, node - step, b].mass - grid[f, node + step, b].mass
            approach, jump = velocity - cloth, cloth - velocity
            if normal.norm() > 2 * CORE * here:
                normal = normal.normalized()
                speed = qd.max(approach.dot(normal), 0.0)
                slip = approach - approach.dot(normal) * normal
                jump = -speed * normal - slip * qd.min(1.0, info[i, b].mu_k * speed / qd.max(slip.norm(), gs.EPS))
            mass = here * scale
            after[node, b] = velocity + jump * weight[node, b] / (mass + weight[node, b])
            kick[node, b] = -jump * mass / (mass + weight[node, b])
    for i, b in qd.ndrange(particles.shape[0], particles.shape[1]):
        node = _node(particles[i, b].pos, qd.Vector([x, y, z]), inv_dx, grid)
        if flags[i, b].active and grid[f, node, b].mass > gs.EPS:
            grid[f, node, b].vel_out = after[node, b]
            if particles[i, b].free:
                particles[i, b].vel += kick[node, b]
