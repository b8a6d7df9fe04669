"""Soft bodies that stick to rigid bodies, such as foam, dough and mud.

Genesis 1.4.5 lets mpm bodies slide on a wall with friction, and leave it freely.
"""

import genesis as gs
import numpy as np
import quadrants as qd
from genesis.engine.solvers.rigid.abd.forward_dynamics import func_vel_at_point
from genesis.engine.solvers.rigid.abd.misc import func_apply_coupling_force
from genesis.utils.array_class import GeomsInfo, GeomsState, LinksState, RigidInfo, SDFInfo
from grid_step import touched
from solid_walls import surface_at


def add_adhesion(bodies, strengths):
    """Let bodies in the built scene stick to rigid bodies, after each step of the grid.

    Args:
        bodies: Copy name -> entity.
        strengths: Copy name -> largest traction [Pa] with which it sticks.
    """
    sim = bodies[next(iter(strengths))].sim
    mpm, rigid, coupler = sim.mpm_solver, sim.rigid_solver, sim.coupler
    state, facts, collider = rigid.dyn_state, rigid.dyn_info, rigid.collider
    own, sticky = qd.field(gs.qd_float, shape=mpm.n_particles), qd.field(gs.qd_float, shape=tuple(mpm.grid_res))
    stress = np.zeros(mpm.n_particles)
    for name, strength in strengths.items():
        stress[bodies[name].particle_start : bodies[name].particle_end] = strength
    own.from_numpy(stress)
    grid_step, corner = coupler.mpm_grid_op, [int(x) for x in mpm.grid_offset]

    def step(f, *args, **options):
        grid_step(f, *args, **options)
        _hold(
            mpm.particles, mpm.particles_ng, mpm.grid, mpm.grid_dirty_list, mpm.grid_dirty_count, own, sticky, f,
            *corner, mpm.dx, mpm.substep_dt, 1 / mpm.particle_volume_scale, state.geoms, facts.geoms, state.links,
            collider.sdf.sdf_info, rigid.rigid_info, collider.collider_config,
        )  # fmt: skip

    coupler.mpm_grid_op = step


@qd.kernel
def _hold(
    particles: qd.template(),
    flags: qd.template(),
    grid: qd.template(),
    nodes: qd.template(),
    count: qd.template(),
    own: qd.template(),
    sticky: qd.template(),
    f: qd.i32,
    x: qd.i32,
    y: qd.i32,
    z: qd.i32,
    dx: qd.f32,
    h: qd.f32,
    scale: qd.f32,
    geoms_state: GeomsState,
    geoms_info: GeomsInfo,
    links_state: LinksState,
    sdf_info: SDFInfo,
    rigid_info: RigidInfo,
    collider_static_config: qd.template(),
):
    """Stop the nodes within half a cell of a surface, as far as the traction on the face of a cell can.

    For each such face of the surface there is one of them. Motion towards the surface is left to contact. The
    traction at a node is that of a particle that shares its mass with it.
    """
    for i in range(own.shape[0]):
        if own[i] > 0.0 and flags[f, i, 0].active:
            base = qd.floor(particles[f, i, 0].pos / dx - 0.5).cast(gs.qd_int) - qd.Vector([x, y, z])
            for offset in qd.static(qd.grouped(qd.ndrange(3, 3, 3))):
                sticky[base + offset] = own[i]
    for n in range(count[0]):
        ii, jj, kk = touched(n, nodes, grid)
        stress = sticky[ii, jj, kk]
        if stress > 0.0:
            sticky[ii, jj, kk] = 0.0
        if stress > 0.0 and grid[f, ii, jj, kk, 0].mass > gs.EPS:
            pos = qd.Vector([ii + x, jj + y, kk + z]) * dx
            for g in range(geoms_info.needs_coup.shape[0]):
                if geoms_info.needs_coup[g]:
                    link = geoms_info.link_idx[g]
                    distance, normal = surface_at(
                        g, pos, 0.5 * dx, geoms_state, geoms_info, sdf_info, rigid_info, collider_static_config
                    )
                    if qd.abs(distance) < 0.5 * dx:
                        slip = grid[f, ii, jj, kk, 0].vel_out - func_vel_at_point(link, 0, pos, links_state)
                        slip -= qd.min(slip.dot(normal), 0.0) * normal
                        speed = slip.norm()
                        if speed > 0.0:
                            mass = grid[f, ii, jj, kk, 0].mass * scale
                            blow = qd.min(mass * speed, stress * dx * dx * h)
                            grid[f, ii, jj, kk, 0].vel_out -= blow / mass / speed * slip
                            func_apply_coupling_force(link, 0, pos, blow / h / speed * slip, links_state)
