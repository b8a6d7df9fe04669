"""Transfers between the particles of mpm and their grid, for one processor.

Genesis 1.4.5 adds what particles bring to the grid atomically, for threads that it does not have on a processor: that
takes half of the time of a soft body. These transfers add in turn, and a row of nodes at a time. What a particle does
by itself runs on spare threads. Results differ by rounding alone.
"""

import genesis as gs
import quadrants as qd
from singular_values import decomposed
from threads import Threads


def transfer_in_turn(sim):
    """Let the built simulator use these transfers, unless it runs on a GPU."""
    if gs.backend == gs.cpu:
        transfers = _Transfers(sim.mpm_solver)
        sim.mpm_solver.substep_pre_coupling = transfers.before_coupling
        sim.mpm_solver.g2p = transfers.after_coupling


@qd.func
def weights(at):
    """Return the first of the 3 x 3 x 3 nodes around a point, its distance from that node, and their weights [cells].

    They are those of quadratic B-splines (Jiang et al., The material point method for simulating continuum materials,
    2016, equation 123).
    """
    first = qd.floor(at - 0.5).cast(gs.qd_int)
    away = at - first.cast(gs.qd_float)
    return first, away, [0.5 * (1.5 - away) ** 2, 0.75 - (away - 1) ** 2, 0.5 * (away - 0.5) ** 2]


@qd.data_oriented
class _Transfers:
    """The transfers of MLS-MPM (Hu et al., 2018) for one environment."""

    def __init__(self, mpm):
        self.mpm, self.threads = mpm, Threads(mpm._n_particles)
        self.plastic = {material.idx for material in mpm._materials if material.needs_svd}
        self.stress = qd.Matrix.field(3, 3, gs.qd_float, shape=mpm._n_particles)

    def before_coupling(self, f):
        """Deform the particles, and fill the grid."""
        with self.threads:
            self.deform(f)
        self.to_grid(f)

    def after_coupling(self, f, *_):
        """Move the particles."""
        with self.threads:
            self.to_particles(f)

    @qd.kernel
    def deform(self, f: qd.i32):
        """Let the deformation gradients follow the velocity gradients, and note the stress [Pa]."""
        identity = qd.Matrix.identity(gs.qd_float, 3)
        for p in range(self.mpm._n_particles):
            if self.mpm.particles_ng[f, p, 0].active:
                F_tmp = (identity + self.mpm.substep_dt * self.mpm.particles[f, p, 0].C) @ self.mpm.particles[f, p, 0].F
                J, Jp, actu = F_tmp.determinant(), self.mpm.particles[f, p, 0].Jp, self.mpm.particles[f, p, 0].actu
                for m in qd.static(self.mpm._materials_idx):
                    if self.mpm.particles_info[p].material_idx == m:
                        U, S, V = identity, identity, identity
                        if qd.static(m in self.plastic):
                            U, S, V = decomposed(F_tmp)
                        F, S_new, Jp_new = self.mpm._materials_update_F_S_Jp[m](J=J, F_tmp=F_tmp, U=U, S=S, V=V, Jp=Jp)
                        self.stress[p] = self.mpm._materials_update_stress[m](
                            U=U, S=S_new, V=V, F_tmp=F_tmp, F_new=F, J=J, Jp=Jp, actu=actu,
                            m_dir=self.mpm.particles_info[p].muscle_direction,
                        )  # fmt: skip
                        self.mpm.particles[f + 1, p, 0].F = F
                        self.mpm.particles[f + 1, p, 0].Jp = Jp_new
                self.mpm.particles[f + 1, p, 0].actu = actu

    @qd.kernel
    def to_grid(self, f: qd.i32):
        """Add the mass and momentum of the particles to the nodes, which are listed."""
        qd.loop_config(serialize=True)
        for p in range(self.mpm._n_particles):
            if self.mpm.particles_ng[f, p, 0].active:
                mass, C = self.mpm.particles_info[p].mass, self.mpm.particles[f, p, 0].C
                at = self.mpm.particles[f, p, 0].pos * self.mpm._inv_dx
                first, away, w = weights(at)
                # Stress acts like a velocity gradient: both change momentum in proportion to the distance.
                force = -self.mpm.substep_dt * self.mpm._particle_volume * 4 * self.mpm._inv_dx
                slope = force * self.stress[p] + mass * self.mpm._dx * C
                momentum = mass * self.mpm.particles[f, p, 0].vel - slope @ away
                node = first - self.mpm._grid_offset
                for i, j in qd.static(qd.ndrange(3, 3)):
                    share = w[i][0] * w[j][1]
                    brought = share * (momentum + float(i) * slope[:, 0] + float(j) * slope[:, 1])
                    for k in qd.static(range(3)):
                        self._add(f, node + qd.Vector([i, j, k]), w[k][2] * share * mass, w[k][2] * brought)
                        brought += share * slope[:, 2]

    @qd.func
    def _add(self, f, node, mass, momentum):
        """Add to a node, and list it if it was empty."""
        before = self.mpm.grid[f, node, 0].mass
        self.mpm.grid[f, node, 0].mass = before + mass
        self.mpm.grid[f, node, 0].vel_in = self.mpm.grid[f, node, 0].vel_in + momentum
        if before == 0.0 and self.mpm.grid_dirty_flag[node] == 0:
            self.mpm.grid_dirty_flag[node] = 1
            number, ny, nz = self.mpm.grid_dirty_count[0], self.mpm._grid_res[1], self.mpm._grid_res[2]
            self.mpm.grid_dirty_list[number] = (node[0] * ny + node[1]) * nz + node[2]
            self.mpm.grid_dirty_count[0] = number + 1

    @qd.kernel
    def to_particles(self, f: qd.i32):
        """Give the particles velocities and velocity gradients of the nodes around them, and move them."""
        for p in range(self.mpm._n_particles):
            if self.mpm.particles_ng[f, p, 0].active:
                pos, zero = self.mpm.particles[f, p, 0].pos, qd.Vector.zero(gs.qd_float, 3)
                first, away, w = weights(pos * self.mpm._inv_dx)
                node = first - self.mpm._grid_offset
                # Sums of velocities by weight, and the same times the distance along each axis [cells].
                vel, along_x, along_y, along_z = zero, zero, zero, zero
                for i, j in qd.static(qd.ndrange(3, 3)):
                    share = w[i][0] * w[j][1]
                    middle = w[1][2] * self.mpm.grid[f, node + qd.Vector([i, j, 1]), 0].vel_out
                    end = w[2][2] * self.mpm.grid[f, node + qd.Vector([i, j, 2]), 0].vel_out
                    row = share * (w[0][2] * self.mpm.grid[f, node + qd.Vector([i, j, 0]), 0].vel_out + middle + end)
                    vel += row
                    along_x += float(i) * row
                    along_y += float(j) * row
                    along_z += share * (middle + 2 * end)
                gradient = qd.Matrix.cols([along_x, along_y, along_z]) - vel.outer_product(away)
                pos, vel = self.mpm.boundary.impose_pos_vel(pos + self.mpm.substep_dt * vel, vel)
                self.mpm.particles[f + 1, p, 0].pos = pos
                self.mpm.particles[f + 1, p, 0].vel = vel
                self.mpm.particles[f + 1, p, 0].C = 4 * self.mpm._inv_dx * gradient
            else:
                self.mpm.particles[f + 1, p, 0].pos = self.mpm.particles[f, p, 0].pos
                self.mpm.particles[f + 1, p, 0].vel = self.mpm.particles[f, p, 0].vel
                self.mpm.particles[f + 1, p, 0].C = self.mpm.particles[f, p, 0].C
                self.mpm.particles[f + 1, p, 0].F = self.mpm.particles[f, p, 0].F
                self.mpm.particles[f + 1, p, 0].Jp = self.mpm.particles[f, p, 0].Jp
            self.mpm.particles_ng[f + 1, p, 0].active = self.mpm.particles_ng[f, p, 0].active
