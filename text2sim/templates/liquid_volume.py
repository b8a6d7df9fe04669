"""Keeps the volume of liquids.

Genesis 1.4.5 integrates the volume of a particle from velocities alone and never compares it with the particles that
are there: a liquid at rest is pressed together at its bottom. The velocity gradient of a lone particle, which nothing
damps, grows until it throws the particle away or gives nan.
"""

import genesis as gs
import numpy as np
import quadrants as qd
from genesis.utils.array_class import GeomsInfo, GeomsState, RigidInfo, SDFInfo
from solid_walls import surface_at
from transfers import weights

RELAXATION = 0.3  # s, in which the volume of a particle follows that of its surroundings
TOLERATED = 0.05  # by which a liquid may be denser: particles are never spread evenly
LARGEST = 1.05  # volume, by that at rest, beyond which what is torn apart pulls no harder
LONE = 0.2  # of its density at rest, below which a drop has no shear either
FOAM = 0.8  # of that density, below which a liquid has room, and no pressure
SAME = 0.7  # cosine of the angle between the normals of walls that count as one
FAR = 1e9  # m


def keep_volume(bodies, densities, liquids, every):
    """Let the volume of each particle of a liquid follow what is there, at every so many substeps of the built scene.

    Args:
        bodies: Copy name -> entity.
        densities: Copy name -> density [kg/m3] at rest, of all mpm bodies.
        liquids: Names of the liquids among them.
        every: Substeps from one time to the next.
    """
    sim = bodies[liquids[0]].sim
    mpm, rigid = sim.mpm_solver, sim.rigid_solver
    state, facts, collider = rigid.dyn_state, rigid.dyn_info, rigid.collider
    density = np.full(mpm.n_particles, np.inf, dtype=np.float32)
    for name, value in densities.items():
        density[bodies[name].particle_start : bodies[name].particle_end] = value * mpm.particle_volume_scale
    own, filled = qd.field(gs.qd_float, shape=mpm.n_particles), qd.field(gs.qd_float, shape=tuple(mpm.grid_res))
    own.from_numpy(density)
    ranges = [(bodies[name].particle_start, bodies[name].particle_end) for name in liquids]
    substep, corner = mpm.substep_post_coupling, [int(x) for x in mpm.grid_offset]

    def kept(f):
        substep(f)
        if sim.cur_substep_global % every == 0:
            _fill(mpm.particles, mpm.particles_ng, mpm.particles_info, own, filled, f + 1, *corner, mpm.dx)
            for first, last in ranges:
                _follow(
                    mpm.particles, mpm.particles_ng, filled, f + 1, first, last, *corner, mpm.dx,
                    min(1.0, mpm.substep_dt * every / RELAXATION), state.geoms, facts.geoms, collider.sdf.sdf_info,
                    rigid.rigid_info, collider.collider_config,
                )  # fmt: skip

    mpm.substep_post_coupling = kept


@qd.func
def _in_front(x):
    """Return the part of a node's quadratic B-spline that lies in front of a plane, x cells away."""
    x = qd.min(qd.max(x, -1.5), 1.5)
    part = 0.5 + 0.75 * x - x**3 / 3.0
    if x < -0.5:
        part = (1.5 + x) ** 3 / 6.0
    elif x > 0.5:
        part = 1.0 - (1.5 - x) ** 3 / 6.0
    return part


@qd.func
def _along(walls, k: qd.template(), vector):
    """Return the component of a vector along the normal of a wall."""
    return walls[k, 0] * vector[0] + walls[k, 1] * vector[1] + walls[k, 2] * vector[2]


@qd.kernel
def _fill(
    particles: qd.template(),
    flags: qd.template(),
    info: qd.template(),
    density: qd.template(),
    filled: qd.template(),
    f: qd.i32,
    x: qd.i32,
    y: qd.i32,
    z: qd.i32,
    dx: qd.f32,
):
    """Set the nodes around particles to the sum of the volumes [m3] there."""
    for i in range(density.shape[0]):
        if flags[f, i, 0].active:
            base = weights(particles[f, i, 0].pos / dx)[0]
            for offset in qd.static(qd.grouped(qd.ndrange(3, 3, 3))):
                filled[base - qd.Vector([x, y, z]) + offset] = 0.0
    for i in range(density.shape[0]):
        if flags[f, i, 0].active:
            base, _, w = weights(particles[f, i, 0].pos / dx)
            for offset in qd.static(qd.grouped(qd.ndrange(3, 3, 3))):
                weight = w[offset[0]][0] * w[offset[1]][1] * w[offset[2]][2]
                filled[base - qd.Vector([x, y, z]) + offset] += weight * info[i].mass / density[i]


@qd.kernel
def _follow(
    particles: qd.template(),
    flags: qd.template(),
    filled: qd.template(),
    f: qd.i32,
    first: qd.i32,
    last: qd.i32,
    x: qd.i32,
    y: qd.i32,
    z: qd.i32,
    dx: qd.f32,
    rate: qd.f32,
    geoms_state: GeomsState,
    geoms_info: GeomsInfo,
    sdf_info: SDFInfo,
    rigid_info: RigidInfo,
    collider_static_config: qd.template(),
):
    """Compare how full the nodes around a particle are with the room that walls leave there.

    Of a liquid, F is the cube root of J times the identity, and J is the volume by that at rest. A particle that has
    more room than its J says loses its pressure; one that has clearly less gains it.
    """
    for i in range(first, last):
        if flags[f, i, 0].active:
            pos = particles[f, i, 0].pos
            # Normal and distance of the nearest plane in each of three directions.
            walls = qd.Matrix([[0.0, 0.0, 0.0, FAR], [0.0, 0.0, 0.0, FAR], [0.0, 0.0, 0.0, FAR]])
            for g in range(geoms_info.needs_coup.shape[0]):
                if geoms_info.needs_coup[g]:
                    distance, normal = surface_at(
                        g, pos, 3.0 * dx, geoms_state, geoms_info, sdf_info, rigid_info, collider_static_config
                    )
                    if distance < 3.0 * dx:
                        # It takes the place of the farthest, or of those in its direction if it is nearer than all.
                        place, nearer_than = 0, -FAR
                        for k in qd.static(range(3)):
                            if walls[k, 3] > nearer_than:
                                place, nearer_than = k, walls[k, 3]
                        for k in qd.static(range(3)):
                            if _along(walls, k, normal) > SAME:
                                place, nearer_than = k, qd.min(nearer_than, walls[k, 3])
                        if distance < nearer_than:
                            for k in qd.static(range(3)):
                                if k == place:
                                    walls[k, 0], walls[k, 1], walls[k, 2] = normal[0], normal[1], normal[2]
                                    walls[k, 3] = distance
                                elif _along(walls, k, normal) > SAME:
                                    walls[k, 3] = FAR
            base, away, w = weights(pos / dx)
            volume, room = 0.0, 0.0
            for offset in qd.static(qd.grouped(qd.ndrange(3, 3, 3))):
                part = 1.0
                for k in qd.static(range(3)):
                    distance = walls[k, 3] / dx + _along(walls, k, offset - away)
                    part *= _in_front(distance) if distance > 0.0 else 0.0
                if part > 0.0:
                    weight = w[offset[0]][0] * w[offset[1]][1] * w[offset[2]][2]
                    volume += weight * filled[base - qd.Vector([x, y, z]) + offset]
                    room += weight * part
            fullness = volume / qd.max(room, 0.05) / dx**3
            J = qd.min(particles[f, i, 0].F.determinant(), LARGEST)
            if fullness < LONE:
                J = 1.0
                particles[f, i, 0].C = qd.Matrix.zero(gs.qd_float, 3, 3)
            elif fullness < FOAM:
                J = qd.max(J, 1.0)
            else:
                wanted = qd.min(1.0 / fullness, qd.max(J, 1.0))
                if wanted > J or wanted < J - TOLERATED:
                    J += rate * (wanted - J)
            particles[f, i, 0].F = qd.Matrix.identity(gs.qd_float, 3) * qd.pow(qd.max(J, 0.1), 1.0 / 3.0)
