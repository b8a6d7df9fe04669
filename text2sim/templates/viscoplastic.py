"""A solid that flows slowly above its yield stress: the engine's plastic solid with a viscosity."""

from typing import Any

import genesis as gs
import quadrants as qd


@qd.data_oriented
class Viscoplastic(gs.materials.MPM.ElastoPlastic):
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
    kept: float = 0.0

    def model_post_init(self, context: Any) -> None:
        """Compute the part of its excess that stress keeps over a substep, and take the place of the engine's law."""
        super().model_post_init(context)
        self.kept = self.viscosity / (self.viscosity + self.mu * self.substep)
        self.update_F_S_Jp = self._update_viscoplastic

    @qd.func
    def _update_viscoplastic(self, J, F_tmp, U, S, V, Jp):
        F_new, S_new = F_tmp, S
        strain = qd.Vector.zero(gs.qd_float, 3)
        for i in qd.static(range(3)):
            strain[i] = qd.log(max(S[i, i], 0.05))  # the engine's least stretch
        deviator = strain - strain.sum() / 3
        size = deviator.norm(gs.EPS)
        excess = size - self.von_mises_yield_stress / (2 * self.mu)
        if excess > 0:
            S_new = qd.Matrix.zero(gs.qd_float, 3, 3)
            for i in qd.static(range(3)):
                S_new[i, i] = qd.exp(strain[i] - (1 - self.kept) * excess / size * deviator[i])
            F_new = U @ S_new @ V.transpose()
        return F_new, S_new, Jp
