"""Sand without a singular value decomposition, and sand that sticks together."""

import math
from typing import Any

import genesis as gs
import quadrants as qd
from stretches import principal, restretched, tensor_along

MIN_STRETCH = 1e-4
"""Smallest stretch, as in the engine."""


@qd.data_oriented
class Sand(gs.materials.MPM.Sand):
    """Sand with a yield surface of Drucker and Prager whose tip may lie at a tension.

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
        self.update_F_S_Jp, self.update_stress, self.needs_svd = self._update_sand, self._hand_on_stress, False

    @qd.func
    def _update_sand(self, J, F_tmp, U, S, V, Jp):
        axes, stretches = principal(F_tmp)
        strain, kept = qd.Vector.zero(gs.qd_float, 3), qd.Vector.zero(gs.qd_float, 3)
        values = qd.Vector.zero(gs.qd_float, 3)
        for i in qd.static(range(3)):
            strain[i] = qd.log(max(abs(stretches[i]), MIN_STRETCH))
        trace = strain.sum() + Jp
        deviator = strain - trace / 3
        size = deviator.norm(gs.EPS)
        Jp_new = gs.qd_float(0.0)
        if trace >= self.tip:  # torn: it bears no tension until it is pressed together again
            Jp_new = trace
        else:
            limit = (3 * self.lam + 2 * self.mu) / (2 * self.mu) * (self.tip - trace) * self.alpha
            kept = strain - max(0.0, size - limit) / size * deviator
        for i in qd.static(range(3)):
            values[i] = 2.0 * self.mu * kept[i] + self.lam * kept.sum()
        F_new = restretched(F_tmp, axes, stretches, qd.exp(kept))
        return F_new, tensor_along(axes, values), Jp_new

    @qd.func
    def _hand_on_stress(self, U, S, V, F_tmp, F_new, J, Jp, actu, m_dir):
        return S
