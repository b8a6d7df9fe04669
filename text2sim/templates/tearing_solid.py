"""A solid that tears: the engine's elastic solid with a largest stretch."""

import math
from typing import Any

import genesis as gs
import numpy as np
import quadrants as qd
from genesis.utils.misc import qd_to_numpy
from recorder import Recorder

FRICTION_ANGLE = math.radians(30.0)
"""Angle of friction of what has torn."""
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
        self.needs_svd = True
        self.update_F_S_Jp, self.update_stress = self._update_tearing, self._update_stress_tearing

    @qd.func
    def _update_tearing(self, J, F_tmp, U, S, V, Jp):
        F_new, S_new, Jp_new = F_tmp, S, Jp
        if Jp < TORN and max(S[0, 0], S[1, 1], S[2, 2]) > self.tear_stretch:
            Jp_new = gs.qd_float(TORN)
        if Jp_new >= TORN:
            strain = qd.Vector.zero(gs.qd_float, 3)
            S_new = qd.Matrix.identity(gs.qd_float, 3)
            for i in qd.static(range(3)):
                strain[i] = qd.log(max(abs(S[i, i]), 1e-4))
            trace = strain.sum() + Jp_new - TORN
            deviator = strain - trace / 3
            size = deviator.norm(gs.EPS)
            if trace >= 0.0:
                Jp_new = TORN + trace
            else:
                Jp_new = TORN
                limit = -(3 * self.lam + 2 * self.mu) / (2 * self.mu) * trace * self.alpha
                for i in qd.static(range(3)):
                    S_new[i, i] = qd.exp(strain[i] - max(0.0, size - limit) / size * deviator[i])
            F_new = U @ S_new @ V.transpose()
        return F_new, S_new, Jp_new

    @qd.func
    def _update_stress_tearing(self, U, S, V, F_tmp, F_new, J, Jp, actu, m_dir):
        stress = qd.Matrix.zero(gs.qd_float, 3, 3)
        if Jp < TORN:
            if qd.static(self.model == "corotation"):
                stress = self._update_stress_corotation(U, S, V, F_tmp, F_new, J, Jp, actu, m_dir)
            else:
                stress = self._update_stress_neohooken(U, S, V, F_tmp, F_new, J, Jp, actu, m_dir)
        else:  # Hencky's law, as for sand: both laws agree for small strains
            volume = qd.log(S[0, 0] * S[1, 1] * S[2, 2])
            center = qd.Matrix.zero(gs.qd_float, 3, 3)
            for i in qd.static(range(3)):
                center[i, i] = (2.0 * self.mu * qd.log(S[i, i]) + self.lam * volume) / S[i, i]
            stress = U @ center @ V.transpose() @ F_new.transpose()
        return stress


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
