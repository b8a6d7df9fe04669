"""Keeps liquids, grains and snow out of rigid bodies.

Genesis 1.4.5 lets them creep into walls and floats: its grid stops nodes, not particles. Walls then leak, and what
floats sinks.
"""

import quadrants as qd
from genesis.engine.solvers.rigid.abd.forward_dynamics import func_vel_at_point
from genesis.engine.solvers.rigid.abd.misc import func_apply_coupling_force
from genesis.utils.array_class import GeomsInfo, GeomsState, LinksInfo, LinksState, RigidInfo, SDFInfo
from genesis.utils.sdf import sdf_func_normal_world, sdf_func_world


def keep_out(entities, every):
    """Move particles out of rigid bodies at every so many substeps of the built scene.

    Args:
        entities: Liquids, grains and snow.
        every: Substeps from one time to the next.
    """
    solver, rigid = entities[0].solver, entities[0].sim.rigid_solver
    state, facts, collider = rigid.dyn_state, rigid.dyn_info, rigid.collider
    substep, ranges = solver.substep_post_coupling, [(one.particle_start, one.particle_end) for one in entities]

    def kept(f):
        substep(f)
        if solver.sim.cur_substep_global % every == 0:
            for first, last in ranges:
                _move_out(
                    solver.particles, solver.particles_ng, solver.particles_info, f + 1, first, last, solver.dx / 4,
                    solver.substep_dt, every, solver._particle_volume_scale, state.geoms, facts.geoms, state.links,
                    facts.links, collider.sdf.sdf_info, rigid.rigid_info, collider.collider_config,
                )  # fmt: skip

    solver.substep_post_coupling = kept


@qd.kernel
def _move_out(
    particles: qd.template(),
    flags: qd.template(),
    info: qd.template(),
    f: qd.i32,
    first: qd.i32,
    last: qd.i32,
    radius: qd.f32,
    h: qd.f32,
    every: qd.i32,
    scale: qd.f32,
    geoms_state: GeomsState,
    geoms_info: GeomsInfo,
    links_state: LinksState,
    links_info: LinksInfo,
    sdf_info: SDFInfo,
    rigid_info: RigidInfo,
    collider_static_config: qd.template(),
):
    """Move particles that are nearer than a particle's radius out along the normal, and stop them there.

    What moves freely is kept two radii away, and given the momentum that moves the particles out until the next time:
    without it a float sinks on and on.
    """
    for i in range(first, last):
        if flags[f, i, 0].active:
            for g in range(geoms_info.needs_coup.shape[0]):
                if geoms_info.needs_coup[g]:
                    pos, link = particles[f, i, 0].pos, geoms_info.link_idx[g]
                    fixed = links_info.is_fixed[link]
                    reach = radius if fixed else 2.0 * radius
                    depth = reach - sdf_func_world(g, 0, pos, geoms_state, geoms_info, sdf_info)
                    if depth > 0.0:
                        normal = sdf_func_normal_world(
                            g, 0, pos, geoms_state, geoms_info, rigid_info, sdf_info, collider_static_config
                        )
                        particles[f, i, 0].pos = pos + depth * normal
                        slip = particles[f, i, 0].vel - func_vel_at_point(link, 0, pos, links_state)
                        speed = -slip.dot(normal)
                        if not fixed:
                            speed += depth / (every * h)
                        if speed > 0.0:
                            particles[f, i, 0].vel += speed * normal
                            blow = info[i].mass / scale * speed
                            func_apply_coupling_force(link, 0, pos, -blow / h * normal, links_state)
