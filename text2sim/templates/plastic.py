"""Plastic solids without a singular value decomposition."""

from typing import Any

import genesis as gs
import quadrants as qd
from stretches import corotated_stress, principal, restretched

MIN_STRETCH = 0.05
"""Smallest stretch, as in the engine."""


@qd.data_oriented
class Plastic(gs.materials.MPM.ElastoPlastic):
    """The engine's solid that yields at the stress of von Mises."""

    kept: float = 0.0
    """Part of the excess over the yield stress that is kept over a substep."""

    def model_post_init(self, context: Any) -> None:
        """Take the place of the engine's law."""
        super().model_post_init(context)
        self.update_F_S_Jp, self.update_stress, self.needs_svd = self._update_plastic, self._hand_on_stress, False

    @qd.func
    def _update_plastic(self, J, F_tmp, U, S, V, Jp):
        F_new = F_tmp
        axes, stretches = principal(F_tmp)
        kept = stretches
        strain = qd.Vector.zero(gs.qd_float, 3)
        for i in qd.static(range(3)):
            strain[i] = qd.log(max(stretches[i], MIN_STRETCH))
        deviator = strain - strain.sum() / 3
        size = deviator.norm(gs.EPS)
        excess = size - self.von_mises_yield_stress / (2 * self.mu)
        if excess > 0:
            kept = qd.exp(strain - (1 - self.kept) * excess / size * deviator)
            F_new = restretched(F_tmp, axes, stretches, kept)
        return F_new, corotated_stress(axes, kept, self.mu, self.lam, J), Jp

    @qd.func
    def _hand_on_stress(self, U, S, V, F_tmp, F_new, J, Jp, actu, m_dir):
        return S


@qd.data_oriented
class Viscoplastic(Plastic):
    """Bingham's solid: elastic below the yield stress of von Mises, and above it flows at `excess / (2 viscosity)`.

    With the norm s of the deviatoric stress, the engine's limit k and the shear modulus G, flow relaxes the stress by
    `ds/dt = -G (s - k) / viscosity` (Perzyna). An implicit step h takes it from s to
    `k + (s - k) / (1 + G h / viscosity)` (Simo and Hughes, Computational Inelasticity, 1998, chapter 3; for foams: Yue
    et al., Continuum foam, 2015). It is stable for every step, steady flow has the excess `2 viscosity rate` for every
    step, and without a viscosity it is the engine's return to the limit. As there, stress over 2 G is Hencky's strain.

    Args:
        viscosity: Plastic viscosity [Pa s].
        substep: Substep of the scene [s].
    """

    viscosity: float = 0.0
    substep: float = 1.0

    def model_post_init(self, context: Any) -> None:
        """Compute the part of its excess that stress keeps over a substep."""
        super().model_post_init(context)
        self.kept = self.viscosity / (self.viscosity + self.mu * self.substep)
