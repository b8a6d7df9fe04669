"""Bonds between rigid bodies that break where the stress on the face that they share is too high.

A bond is a weld with its anchor in the middle of that face. The force and the moment that the weld carries there give
the stresses at the edge of a round face of the same area, as in the parallel bonds of Potyondy and Cundall (2004), "A
bonded-particle model for rock". As there, bonds are as stiff as their faces are large: where a body has several, equal
welds would load small faces as much as large ones.
"""

import genesis as gs
import numpy as np
from genesis.utils.misc import qd_to_torch
from recorder import INVERSE, rotate

SLACK = 0.01
"""One minus the impedance of the median bond of a control: the smaller, the stiffer it is, and the harder are blows."""
MOST_SLACK = 0.9
"""The same of the smallest bonds, at most."""


class Bonds:
    """Bonds bodies at the start, and breaks the bonds that are overloaded.

    Args:
        scene: Built scene.
        bodies: Entities by name.
        rows: Control, two bodies or links (`body.link`), centre [m] and normal (from the first to the second) of their
            face in the world, its area [m2], tensile and shear strength [Pa] of each bond. Those without a face are
            welded as ever, and break at a force [N] of any direction.
        gone: Set of the links of removed bodies.
    """

    def __init__(self, scene, bodies, rows, gone=frozenset()):
        self.solver, self.rows, self.gone = scene.rigid_solver, rows, gone
        links = [tuple(_link(bodies, name) for name in row[1:3]) for row in rows]
        area, self.strength, self.shear_strength = (np.array([row[k] for row in rows], float) for k in (5, 6, 7))
        self.faceless = np.isnan(area)
        self.area, self.radius = area, np.sqrt(area / np.pi)
        inverse = self.solver.get_links_invweight().cpu().numpy().reshape(-1, 2).astype(float)
        inverse = np.array([inverse[a.idx] + inverse[b.idx] for a, b in links])
        # The rows of a rotation are scaled so that a moment bends the bond as it bends a round bar. What is on a
        # joint may have no inverse mass or inertia.
        free = (inverse > 1e-9).all(axis=1)
        self.arm = np.sqrt(np.divide(inverse[:, 1], inverse[:, 0], out=self.radius**-2, where=free)) * self.radius
        self.arm[self.faceless] = 1.0
        self.pairs = [(a.idx, b.idx) for a, b in links]
        self.index = {pair: i for i, pair in enumerate(self.pairs)}  # of the bonds that hold
        self.normals = np.zeros((len(rows), 2, 3))  # in the frames of both links
        self.first_link = np.array([a.idx for a, _ in links])
        self.centers = []
        for i, ((a, b), row) in enumerate(zip(links, rows, strict=True)):
            (pos, quat), (_, other) = _frame(a), _frame(b)
            center, normal = (pos, (0.0, 0.0, 1.0)) if self.faceless[i] else row[3:5]
            self.centers.append([float(x) for x in center])
            self.normals[i] = _rotate_back(quat, normal), _rotate_back(other, normal)
            self.solver.constraint_solver.add_dynamic_constraint(
                gs.EQUALITY_TYPE.WELD, a.idx, b.idx, a.idx, _rotate_back(quat, np.array(center) - pos), (self.arm[i],)
            )
        self._stiffen(np.where(free, area * inverse[:, 0], np.nan))
        self.peak, self.peak_at = np.zeros(len(rows)), np.zeros(len(rows))
        self.broken = {}  # row -> time [s], and by what
        self.begin, self.count, self.step = 0.0, 0, self.solver.substep_dt
        # A blow can begin and end within a step.
        substep = self.solver.substep

        def watched(f):
            substep(f)
            self.count += 1
            self.check(self.begin + self.count * self.step)

        self.solver.substep = watched

    def __call__(self, t):
        """Take note that the step from t [s] begins."""
        self.begin, self.count = t, 0
        for pair in [pair for pair in self.index if self.gone.intersection(pair)]:
            self._part(pair)

    def check(self, t):
        """Break the bonds that the substep that ended at t [s] has overloaded."""
        if not self.index:
            return
        welds = self.solver.get_weld_constraints(as_tensor=True, to_torch=False)
        pairs = zip(welds["link_a"].reshape(-1).tolist(), welds["link_b"].reshape(-1).tolist(), strict=True)
        at = np.array([self.index.get(pair, -1) for pair in pairs])
        load, at = welds["force"].reshape(-1, 6)[at >= 0].astype(float), at[at >= 0]
        first = self.solver.get_links_quat(self.first_link[at], relative=False).cpu().numpy().astype(float)
        pull, shear = _split(load[:, :3], rotate(first, self.normals[at, 0]))
        # The rows of the rotation count half angles times the arm, in the frame of the second link.
        twist, bend = _split(load[:, 3:] * self.arm[at, None] / 2, self.normals[at, 1])
        area, radius = self.area[at], self.radius[at]
        tension = pull / area + 4 * bend / (np.pi * radius**3)
        sliding = shear / area + 2 * np.abs(twist) / (np.pi * radius**3)
        faceless = self.faceless[at]
        tension[faceless], sliding[faceless] = np.linalg.norm(load[faceless, :3], axis=1), 0.0
        loads = np.stack([tension / self.strength[at], sliding / self.shear_strength[at]])
        worst = loads.max(axis=0)
        higher = worst > self.peak[at]
        self.peak[at[higher]], self.peak_at[at[higher]] = worst[higher], t
        for k in np.flatnonzero(worst >= 1.0):
            row = int(at[k])
            self.broken[row] = t, ("tension", "shear")[int(loads[:, k].argmax())]
            self._part(self.pairs[row])

    def report(self):
        """Return the largest load of each bond, as a fraction of its strength, and when and why it broke."""
        return [
            {
                "control": row[0], "between": [*row[1:3]], "pos": self.centers[i], "area": row[5],
                "peak": float(self.peak[i]), "peak_at": float(self.peak_at[i]),
                "broken_at": self.broken.get(i, (None, None))[0], "by": self.broken.get(i, (None, None))[1],
            }
            for i, row in enumerate(self.rows)
        ]  # fmt: skip

    def _stiffen(self, shares):
        """Make the welds stiff in proportion to their faces.

        Args:
            shares: Area times inverse mass [m2/kg] of each bond: a weld's stiffness is one over slack and inverse mass.
                nan if that is unknown.
        """
        slack, controls = np.full(len(shares), SLACK), np.array([row[0] for row in self.rows])
        for control in set(controls):
            own = (controls == control) & np.isfinite(shares)
            if own.any():
                slack[own] = np.minimum(SLACK * np.median(shares[own]) / shares[own], MOST_SLACK)
        welds = self.solver.get_equality_constraints(as_tensor=True, to_torch=False)
        pairs = zip(welds["obj_a"].reshape(-1).tolist(), welds["obj_b"].reshape(-1).tolist(), strict=True)
        field = self.solver.dyn_info.equalities.sol_params
        params = qd_to_torch(field, copy=not gs.use_zerocopy)
        for k, pair in enumerate(pairs):
            if pair in self.index:
                params[k, 0, 2:4] = 1.0 - slack[self.index[pair]]
        if not gs.use_zerocopy:
            field.from_torch(params)

    def _part(self, pair):
        del self.index[pair]
        self.solver.delete_weld_constraint(*pair)


def _link(bodies, name):
    body, _, link = name.partition(".")
    return bodies[body].get_link(link) if link else next(own for own in bodies[body].links if own.name != "world")


def _frame(link):
    """Return the position [m] and the quaternion of a link's frame in the solver."""
    get = (link.get_pos, link.get_quat)
    return tuple(one().cpu().numpy().astype(float).reshape(-1) for one in get)


def _rotate_back(quat, vector):
    return rotate(quat * INVERSE, np.asarray(vector, float))


def _split(vectors, normals):
    """Return the parts of vectors along normals, and the lengths of those across, (n,) each."""
    along = np.einsum("ij,ij->i", vectors, normals)
    return along, np.linalg.norm(vectors - along[:, None] * normals, axis=1)
