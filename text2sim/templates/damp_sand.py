"""Sand that sticks together: the engine's sand with cohesion."""

import math
from typing import Any

import genesis as gs
import quadrants as qd


@qd.data_oriented
class DampSand(gs.materials.MPM.Sand):
    """Sand with a yield surface of Drucker and Prager whose tip lies at a tension.

    The engine's sand yields where the deviatoric stress exceeds `3 alpha p`, which touches the law of Mohr and Coulomb
    in triaxial compression. Cohesion C adds `C / tan(friction_angle)` to the pressure p: the tip is at a tension.

    Args:
        cohesion: Shear strength without pressure [Pa].
    """

    cohesion: float = 0.0
    tip: float = 0.0

    def model_post_init(self, context: Any) -> None:
        """Compute the volumetric strain at the tip, and take the place of the engine's law."""
        super().model_post_init(context)
        bulk = self.lam + 2 * self.mu / 3
        self.tip = self.cohesion / math.tan(math.radians(self.friction_angle)) / bulk
        self.update_F_S_Jp = self._update_damp

    @qd.func
    def _update_damp(self, J, F_tmp, U, S, V, Jp):
        strain, S_new, Jp_new = qd.Vector.zero(gs.qd_float, 3), qd.Matrix.zero(gs.qd_float, 3, 3), gs.qd_float(0.0)
        for i in qd.static(range(3)):
            strain[i] = qd.log(max(abs(S[i, i]), 1e-4))
            S_new[i, i] = 1
        trace = strain.sum() + Jp
        deviator = strain - trace / 3
        size = deviator.norm(gs.EPS)
        if trace >= self.tip:  # torn: it bears no tension until it is pressed together again
            Jp_new = trace
        else:
            limit = (3 * self.lam + 2 * self.mu) / (2 * self.mu) * (self.tip - trace) * self.alpha
            for i in qd.static(range(3)):
                S_new[i, i] = qd.exp(strain[i] - max(0.0, size - limit) / size * deviator[i])
        return U @ S_new @ V.transpose(), S_new, Jp_new
