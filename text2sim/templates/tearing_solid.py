"""A solid that tears: the engine's elastic solid with a largest stretch."""

import math
from typing import Any

import genesis as gs
import numpy as np
import quadrants as qd
from genesis.utils.misc import qd_to_numpy
from recorder import Recorder
from stretches import corotated_stress, principal, restretched, tensor_along

FRICTION_ANGLE = math.radians(30.0)
"""Angle of friction of what has torn."""
MIN_STRETCH = 1e-4
"""Smallest stretch of what has torn, as in the engine's sand."""
TORN = 2.0
"""Jp of a particle that has just torn: 1 is the engine's for one that has not. What it exceeds `TORN` by is how far the
particle has loosened since."""


@qd.data_oriented
class TearingSolid(gs.materials.MPM.Elastic):
    """An elastic solid that tears where a principal stretch exceeds a limit, for ever.

    What has torn follows the law of the engine's sand (Klar et al., Drucker-Prager elastoplasticity for sand animation,
    2016): it bears pressure and friction, and no tension. What it has loosened by it gives way before it bears again
    (their volume correction), so that the faces of a tear close without a gap.

    Args:
        tear_stretch: The limit; a bar that is drawn out to it has this many times its length.
    """

    tear_stretch: float = math.inf
    alpha: float = 0.0

    def model_post_init(self, context: Any) -> None:
        """Take the place of the engine's law."""
        super().model_post_init(context)
        sine = math.sin(FRICTION_ANGLE)
        self.alpha = math.sqrt(2 / 3) * 2 * sine / (3 - sine)  # as in `MPM.Sand`
        self.update_F_S_Jp, self.update_stress, self.needs_svd = self._update_tearing, self._hand_on_stress, False

    @qd.func
    def _update_tearing(self, J, F_tmp, U, S, V, Jp):
        F_new, Jp_new = F_tmp, Jp
        axes, stretches = principal(F_tmp)
        stress = corotated_stress(axes, stretches, self.mu, self.lam, J)
        if qd.static(self.model == "neohooken"):
            stress = self._update_stress_neohooken(U, S, V, F_tmp, F_new, J, Jp, 0.0, 0.0)
        if Jp < TORN and max(stretches[0], stretches[1], stretches[2]) > self.tear_stretch:
            Jp_new = gs.qd_float(TORN)
        if Jp_new >= TORN:
            strain, kept = qd.Vector.zero(gs.qd_float, 3), qd.Vector.zero(gs.qd_float, 3)
            values = qd.Vector.zero(gs.qd_float, 3)
            for i in qd.static(range(3)):
                strain[i] = qd.log(max(abs(stretches[i]), MIN_STRETCH))
            trace = strain.sum() + Jp_new - TORN
            deviator = strain - trace / 3
            size = deviator.norm(gs.EPS)
            if trace >= 0.0:
                Jp_new = TORN + trace
            else:
                Jp_new = TORN
                limit = -(3 * self.lam + 2 * self.mu) / (2 * self.mu) * trace * self.alpha
                kept = strain - max(0.0, size - limit) / size * deviator
            F_new = restretched(F_tmp, axes, stretches, qd.exp(kept))
            for i in qd.static(range(3)):  # Hencky's law, as for sand: both laws agree for small strains
                values[i] = 2.0 * self.mu * kept[i] + self.lam * kept.sum()
            stress = tensor_along(axes, values)
        return F_new, stress, Jp_new

    @qd.func
    def _hand_on_stress(self, U, S, V, F_tmp, F_new, J, Jp, actu, m_dir):
        return S


class TearRecorder(Recorder):
    """Also records which points have torn: `soft_torn`, 0 or 1, shape (P,) in each frame."""

    def _record(self, t: float) -> None:
        super()._record(t)
        frame, soft = self._frames[-1], self._soft
        frame["soft_torn"] = np.zeros(len(frame["soft_points"]), np.float32)
        for body, rows in zip(soft._bodies, soft._rows, strict=True):
            if isinstance(body.entity.material, TearingSolid):
                solver = body.entity.solver
                jp = qd_to_numpy(solver.particles.Jp, copy=True)[self._scene.sim.cur_substep_local, body.span, 0]
                frame["soft_torn"][rows] = jp >= TORN
