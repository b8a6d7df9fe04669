"""Contact of cloth with rigid bodies: friction, and the force of what is squeezed between two of them.

Genesis 1.4.5 pushes particles of cloth out of rigid bodies, but does not change their tangential velocity. What
lands on a cloth on the ground bounces, since its contact has no damping.
"""

import genesis as gs
import numpy as np
import quadrants as qd
import torch
from genesis.engine.solvers.rigid.abd.forward_dynamics import func_vel_at_point
from genesis.engine.solvers.rigid.abd.misc import func_apply_coupling_force
from genesis.utils.array_class import GeomsInfo, GeomsState, LinksState, RigidInfo, SDFInfo
from genesis.utils.sdf import sdf_func_normal_world, sdf_func_world

TINY = 1e-12  # smallest slip in a substep [m], against division by zero
SETTLING = 0.02  # speed [m/s] of parting bodies at which what they squeeze stops to push; of closing ones, pushes twice


def add_friction(body):
    """Give all cloth in the built scene of `body` friction on rigid bodies, and let it carry what stands on it."""
    coupler, pbd = body.sim.coupler, body.solver
    radii = [_radius(geom) for geom in body.sim.rigid_solver.geoms]
    bounds = torch.as_tensor(np.array(radii), dtype=gs.tc_float, device=gs.device)
    particles = pbd.particles_reordered, pbd.particles_ng_reordered, pbd.particles_info_reordered
    coupler.kernel_pbd_rigid_collide = lambda **rigid: _collide(
        *particles, bounds, pbd.particle_size / 2, pbd.substep_dt, **rigid
    )


def _radius(geom):
    """Return the radius [m] of the ball about the origin of a shape that it lies in."""
    return np.inf if geom.type == gs.GEOM_TYPE.PLANE else np.linalg.norm(geom.init_verts, axis=1).max()


@qd.kernel
def _collide(
    particles: qd.template(),
    flags: qd.template(),
    info: qd.template(),
    bounds: qd.types.ndarray(),
    reach: qd.f32,
    h: qd.f32,
    geoms_state: GeomsState,
    geoms_info: GeomsInfo,
    links_state: LinksState,
    sdf_info: SDFInfo,
    rigid_info: RigidInfo,
    collider_static_config: qd.template(),
):
    """Move particles out of rigid bodies, and back along their slip by at most the friction coefficient times that way.

    A displacement dx of a particle of mass m in a substep h stands for an impulse m dx / h, so the ratio of both
    displacements is that of both forces, as in Coulomb's law. Compare Macklin et al., Unified particle physics, 2014,
    equations 23 and 24, for friction between particles.

    A particle that two bodies push towards each other, over the same way d, presses them apart with m d / h^2, as
    impulses m d / h in each substep would.
    """
    for i, b in qd.ndrange(particles.shape[0], particles.shape[1]):
        if flags[i, b].active:
            link_a, way_a, normal_a = -1, 0.0, qd.Vector([0.0, 0.0, 0.0], dt=qd.f32)
            for g in range(geoms_info.needs_coup.shape[0]):
                depth = 0.0
                away = (particles[i, b].pos - geoms_state.pos[g, b]).norm()
                if geoms_info.needs_coup[g] and away < bounds[g] + reach:
                    depth = reach - sdf_func_world(g, b, particles[i, b].pos, geoms_state, geoms_info, sdf_info)
                if depth > 0.0:
                    link, old = geoms_info.link_idx[g], particles[i, b].pos
                    normal = sdf_func_normal_world(
                        g, b, old, geoms_state, geoms_info, rigid_info, sdf_info, collider_static_config
                    )
                    press = qd.min(depth, -way_a * normal_a.dot(normal))
                    if press > 0.0 and link != link_a:
                        apart = func_vel_at_point(link_a, b, old, links_state)
                        apart = (apart - func_vel_at_point(link, b, old, links_state)).dot(normal)
                        force = info[i, b].mass / h**2 * press * qd.math.clamp(1 - apart / SETTLING, 0.0, 2.0)
                        func_apply_coupling_force(link, b, old, -force * normal, links_state)
                        func_apply_coupling_force(link_a, b, old, force * normal, links_state)
                    link_a, way_a, normal_a = link, depth, normal
                    # Resolve earlier overlap without adding velocity.
                    near = reach - sdf_func_world(g, b, particles[i, b].ipos, geoms_state, geoms_info, sdf_info)
                    particles[i, b].ipos += qd.min(qd.max(near, 0.0), depth) * normal
                    pos = old + depth * normal
                    if particles[i, b].free:
                        slip = pos - particles[i, b].ipos - func_vel_at_point(link, b, pos, links_state) * h
                        slip -= slip.dot(normal) * normal
                        friction = qd.max(geoms_info.friction[g], info[i, b].mu_k)
                        pos -= slip * qd.min(1.0, friction * depth / qd.max(slip.norm(), TINY))
                    speed = (pos - particles[i, b].ipos) / h
                    blow = info[i, b].mass * (speed - particles[i, b].vel)
                    func_apply_coupling_force(link, b, old, -blow / h, links_state)
                    particles[i, b].pos = pos
                    particles[i, b].vel = speed
