"""Keeps liquids, grains and snow out of rigid bodies.

Genesis 1.4.5 lets them creep into walls and floats: its grid stops nodes, not particles. Walls then leak, and what
floats sinks.
"""

import genesis as gs
import numpy as np
import quadrants as qd
from genesis.engine.solvers.rigid.abd.forward_dynamics import func_vel_at_point
from genesis.engine.solvers.rigid.abd.misc import func_apply_coupling_force
from genesis.utils import geom as gu
from genesis.utils.array_class import GeomsInfo, GeomsState, LinksState, RigidInfo, SDFInfo
from genesis.utils.sdf import sdf_func_normal_world, sdf_func_world
from grid_step import beside, touched

SUPPORTED = 0.56  # cells between a wall and a node that it holds up
DIRECTIONS = np.array([d for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)]) - 1  # to faces, edges and corners of a cube


def keep_out(entities, every, held_up=False):
    """Move particles out of rigid bodies at every so many substeps of the built scene.

    The first time, they are only moved: what starts on a floor would burst if its lowest layer began squeezed, and snow
    that fills a trough, which such a squeeze hardens a thousandfold, ended in nan.

    Args:
        entities: Liquids, grains and snow.
        every: Substeps from one time to the next.
        held_up: Whether to stop the nodes at walls, on which liquids rest.
    """
    if held_up:
        _hold_up(entities[0].sim)
    solver, rigid = entities[0].solver, entities[0].sim.rigid_solver
    state, facts, collider = rigid.dyn_state, rigid.dyn_info, rigid.collider
    substep, ranges = solver.substep_post_coupling, [(one.particle_start, one.particle_end) for one in entities]
    share = 0.0

    def kept(f):
        nonlocal share
        substep(f)
        if solver.sim.cur_substep_global % every == 0:
            for first, last in ranges:
                _move_out(
                    solver.particles, solver.particles_ng, solver.particles_info, f + 1, first, last,
                    solver.particle_radius, share, solver.substep_dt, solver._particle_volume_scale, state.geoms,
                    facts.geoms, state.links, collider.sdf.sdf_info, rigid.rigid_info, collider.collider_config,
                )  # fmt: skip
            share = 1.0

    solver.substep_post_coupling = kept


def _hold_up(sim):
    """Let no node near a wall flow into it.

    Particles rest a quarter of a cell and more from a wall. Those at a node that the wall does not stop ride on it, and
    the pressure of the few behind it hardly acts on it: a liquid sinks into that layer by millimetres a second, unless
    its walls stand at nodes. With these nodes stopped, it keeps its level wherever they stand.

    On the outside of a free body no node is stopped: it may float, and would displace a quarter of a cell too much on
    every side. A node is inside if more of the body lies beyond it, in the direction away from the wall.
    """
    mpm, rigid, coupler = sim.mpm_solver, sim.rigid_solver, sim.coupler
    state, facts, collider = rigid.dyn_state, rigid.dyn_info, rigid.collider
    extremes = np.tile(np.float32(1e6) * DIRECTIONS, (max(1, len(rigid.links)), 1, 1))  # of what is not free: anywhere
    for link in rigid.links:
        if link.geoms and any(joint.type is gs.JOINT_TYPE.FREE for joint in link.entity.joints):
            points = np.concatenate(
                [gu.transform_by_trans_quat(one.init_verts, one.init_pos, one.init_quat) for one in link.geoms]
            )
            extremes[link.idx] = points[np.argmax(points @ DIRECTIONS.T, axis=0)]
    tips = qd.Vector.field(3, gs.qd_float, shape=extremes.shape[:2])
    tips.from_numpy(extremes)
    grid_step, corner = coupler.mpm_grid_op, [int(x) for x in mpm.grid_offset]

    def step(f, *args, **options):
        grid_step(f, *args, **options)
        _stop_nodes(
            mpm.grid, mpm.grid_dirty_list, mpm.grid_dirty_count, tips, f, *corner, mpm.dx, mpm.substep_dt,
            mpm._particle_volume_scale, state.geoms, facts.geoms, state.links, collider.sdf.sdf_info, rigid.rigid_info,
            collider.collider_config,
        )  # fmt: skip

    coupler.mpm_grid_op = step


@qd.kernel
def _stop_nodes(
    grid: qd.template(),
    nodes: qd.template(),
    count: qd.template(),
    tips: qd.template(),
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
    for n in range(count[0]):
        ii, jj, kk = touched(n, nodes, grid)
        if grid[f, ii, jj, kk, 0].mass > gs.EPS:
            pos = qd.Vector([ii + x, jj + y, kk + z]) * dx
            for g in range(geoms_info.needs_coup.shape[0]):
                if geoms_info.needs_coup[g]:
                    distance, normal = surface_at(
                        g, pos, SUPPORTED * dx, geoms_state, geoms_info, sdf_info, rigid_info, collider_static_config
                    )
                    link = geoms_info.link_idx[g]
                    if distance < SUPPORTED * dx and _encloses(tips, link, pos, normal, links_state):
                        slip = grid[f, ii, jj, kk, 0].vel_out - func_vel_at_point(link, 0, pos, links_state)
                        speed = -slip.dot(normal)
                        if speed > 0.0:
                            grid[f, ii, jj, kk, 0].vel_out += speed * normal
                            blow = grid[f, ii, jj, kk, 0].mass / scale * speed
                            func_apply_coupling_force(link, 0, pos, -blow / h * normal, links_state)


@qd.func
def _encloses(tips: qd.template(), link, pos, normal, links_state: LinksState):
    """Return whether one of the tips of a link lies beyond a point, in the direction of the normal."""
    local = gu.qd_inv_transform_by_trans_quat(pos, links_state.pos[link, 0], links_state.quat[link, 0])
    away = gu.qd_inv_transform_by_quat(normal, links_state.quat[link, 0])
    k = 0
    while k < tips.shape[1] and (tips[link, k] - local).dot(away) <= 0.0:
        k += 1
    return k < tips.shape[1]


@qd.kernel
def _move_out(
    particles: qd.template(),
    flags: qd.template(),
    info: qd.template(),
    f: qd.i32,
    first: qd.i32,
    last: qd.i32,
    radius: qd.f32,
    share: qd.f32,
    h: qd.f32,
    scale: qd.f32,
    geoms_state: GeomsState,
    geoms_info: GeomsInfo,
    links_state: LinksState,
    sdf_info: SDFInfo,
    rigid_info: RigidInfo,
    collider_static_config: qd.template(),
):
    """Move particles that are nearer than half their distance out along the normal, and stop them there.

    The way out squeezes the layer at the wall, as thick as particles are apart: the deformation gradient learns of it,
    and pressure keeps the next particles away. Otherwise they pile up there, the level falls and floats sink.
    """
    for i in range(first, last):
        if flags[f, i, 0].active:
            for g in range(geoms_info.needs_coup.shape[0]):
                if geoms_info.needs_coup[g]:
                    pos, link = particles[f, i, 0].pos, geoms_info.link_idx[g]
                    distance, normal = surface_at(
                        g, pos, radius, geoms_state, geoms_info, sdf_info, rigid_info, collider_static_config
                    )
                    depth = radius - distance
                    if depth > 0.0:
                        particles[f, i, 0].pos = pos + depth * normal
                        squeezed = share * qd.min(depth / (2.0 * radius), 0.5) * normal.outer_product(normal)
                        particles[f, i, 0].F -= squeezed @ particles[f, i, 0].F
                        slip = particles[f, i, 0].vel - func_vel_at_point(link, 0, pos, links_state)
                        speed = -slip.dot(normal)
                        if speed > 0.0:
                            particles[f, i, 0].vel += speed * normal
                            blow = info[i].mass / scale * speed
                            func_apply_coupling_force(link, 0, pos, -blow / h * normal, links_state)


@qd.func
def surface_at(
    g,
    pos,
    near,
    geoms_state: GeomsState,
    geoms_info: GeomsInfo,
    sdf_info: SDFInfo,
    rigid_info: RigidInfo,
    collider_static_config: qd.template(),
):
    """Return the signed distance [m] of a point from a shape, and the normal there; infinite and 0 if it is not near.

    Args:
        g: Number of the shape.
        pos: The point [m].
        near: Distance [m] that counts. Twice of it is looked at: what is round may stick out of its bounding box.
        geoms_state: Poses of the shapes.
        geoms_info: The shapes.
        sdf_info: Their distance fields.
        rigid_info: The rigid solver's constants.
        collider_static_config: The collider's settings.
    """
    distance, normal = qd.math.inf, qd.Vector([0.0, 0.0, 0.0])
    if beside(g, pos, 2.0 * near, geoms_state, geoms_info):
        if geoms_info.type[g] == gs.GEOM_TYPE.BOX:
            distance, normal = _from_box(g, pos, geoms_state, geoms_info)
        else:
            distance = sdf_func_world(g, 0, pos, geoms_state, geoms_info, sdf_info)
            if distance < near:
                normal = sdf_func_normal_world(
                    g, 0, pos, geoms_state, geoms_info, rigid_info, sdf_info, collider_static_config
                )
    return distance, normal


@qd.func
def _from_box(g, pos, geoms_state: GeomsState, geoms_info: GeomsInfo):
    """Return the signed distance [m] of a point from a box, and the normal of the nearest face, edge or corner.

    The engine looks primitives up at 32 nodes along each axis, in a space that exceeds them by a fifth of their longest
    side: a thin plate falls between two of them.
    """
    local = gu.qd_inv_transform_by_trans_quat(pos, geoms_state.pos[g, 0], geoms_state.quat[g, 0])
    data, outer, nearest = geoms_info.data[g], qd.Vector([0.0, 0.0, 0.0]), qd.Vector([0.0, 0.0, 0.0])
    largest = -1e9
    for k in qd.static(range(3)):
        out, side = qd.abs(local[k]) - data[k] / 2, 1.0 if local[k] >= 0.0 else -1.0
        outer[k] = qd.max(out, 0.0) * side
        if out > largest:
            largest, nearest = out, qd.Vector([0.0, 0.0, 0.0])
            nearest[k] = side
    distance = largest
    if largest > 0.0:
        distance = outer.norm()
        nearest = outer / distance
    return distance, gu.qd_transform_by_quat(nearest, geoms_state.quat[g, 0])
