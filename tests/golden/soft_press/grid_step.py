"""Steps of the mpm grid that skip what is far away.

Genesis 1.4.5 visits all nodes of the grid twice in each substep, though it lists those that particles touch, and asks
every shape for its distance from each of them. In a domain with room to splash, and with vessels of many parts, that
takes many times as long as all the rest.
"""

import genesis as gs
import quadrants as qd
from genesis.utils.array_class import GeomsInfo, GeomsState, LinksState, RigidInfo, SDFInfo

REACH = 2.303  # ln 10: distance from a surface, by its softness, from which the engine no longer acts on a node


def skip_far(sim):
    """Let the built simulator visit touched nodes only, both in the step of the grid and to clear it afterwards."""
    grid = _Grid(sim)
    sim.coupler.mpm_grid_op, sim.mpm_solver.reset_dirty_cells = grid.step, grid.clear


@qd.func
def touched(n, nodes: qd.template(), grid: qd.template()):
    """Return the indices of a node.

    Args:
        n: Its place in the list.
        nodes: The solver's list, `grid_dirty_list`, of `grid_dirty_count` nodes.
        grid: The solver's grid: frames, three axes, environments.
    """
    flat, ny, nz = nodes[n], grid.shape[2], grid.shape[3]
    return qd.Vector([flat // (ny * nz), flat // nz % ny, flat % nz])


@qd.func
def beside(g, pos, reach, geoms_state: GeomsState, geoms_info: GeomsInfo):
    """Return whether a point is in the bounding box of a shape, or nearer to it than `reach` along each axis.

    Args:
        g: Number of the shape.
        pos: The point [m].
        reach: Distance [m]; the boxes are those of the last search for contacts.
        geoms_state: Bounding boxes of the shapes.
        geoms_info: The shapes.
    """
    low, high = geoms_state.aabb_min[g, 0] - reach, geoms_state.aabb_max[g, 0] + reach
    return geoms_info.type[g] == gs.GEOM_TYPE.PLANE or ((pos > low).all() and (pos < high).all())


@qd.data_oriented
class _Grid:
    """The grid of a scene that has no solvers but those of mpm, pbd, fem and rigid bodies."""

    def __init__(self, sim):
        self.mpm, self.coupler = sim.mpm_solver, sim.coupler

    @qd.kernel
    def step(
        self,
        f: qd.i32,
        t: qd.f32,
        geoms_state: GeomsState,
        geoms_info: GeomsInfo,
        links_state: LinksState,
        rigid_info: RigidInfo,
        sdf_info: SDFInfo,
        collider_static_config: qd.template(),
    ):
        """Turn momenta into velocities; gravity, force fields, rigid bodies and the sides of the domain change them."""
        for n in range(self.mpm.grid_dirty_count[0]):
            i, j, k = touched(n, self.mpm.grid_dirty_list, self.mpm.grid)
            mass = self.mpm.grid[f, i, j, k, 0].mass
            if mass > gs.EPS:
                pos = (qd.Vector([i, j, k]) + self.mpm.grid_offset) * self.mpm.dx
                vel = self.mpm.grid[f, i, j, k, 0].vel_in / mass + self.mpm.substep_dt * self.mpm._gravity[0]
                for field in qd.static(range(len(self.mpm._ffs))):
                    vel += self.mpm.substep_dt * self.mpm._ffs[field].get_acc(pos, vel, t, -1)
                if qd.static(self.coupler._rigid_mpm):
                    for g in range(geoms_info.needs_coup.shape[0]):
                        reach = self.mpm.dx + REACH * geoms_info.coup_softness[g]
                        if geoms_info.needs_coup[g] and beside(g, pos, reach, geoms_state, geoms_info):
                            vel = self.coupler._func_collide_with_rigid_geom(
                                pos, vel, mass / self.mpm._particle_volume_scale, g, 0, geoms_state, geoms_info,
                                links_state, rigid_info, sdf_info, collider_static_config,
                            )  # fmt: skip
                _, self.mpm.grid[f, i, j, k, 0].vel_out = self.mpm.boundary.impose_pos_vel(pos, vel)

    @qd.kernel
    def clear(self, f: qd.i32):
        """Empty the nodes, and the marks by which the solver knows that they are listed."""
        for n in range(self.mpm.grid_dirty_count[0]):
            i, j, k = touched(n, self.mpm.grid_dirty_list, self.mpm.grid)
            self.mpm.grid[f, i, j, k, 0].mass = 0.0
            self.mpm.grid[f, i, j, k, 0].vel_in = qd.Vector([0.0, 0.0, 0.0])
            self.mpm.grid[f, i, j, k, 0].vel_out = qd.Vector([0.0, 0.0, 0.0])
            self.mpm.grid_dirty_flag[i, j, k] = 0
