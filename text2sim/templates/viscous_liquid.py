"""A liquid with a viscosity."""

import genesis as gs
import quadrants as qd
from corotated import rotation


@qd.data_oriented
class ViscousLiquid(gs.materials.MPM.Liquid):
    """The engine's liquid with a dynamic viscosity.

    The engine forgets shear after every substep, so that its shear stress is `2 mu` times the strain of one substep:
    that of a Newtonian liquid of viscosity `mu` times the substep.

    Args:
        viscosity: Dynamic viscosity [Pa s].
        substep: Substep of the scene [s].
    """

    viscosity: float = 0.0
    substep: float = 1.0

    def model_post_init(self, context) -> None:
        """Set the shear modulus, and do without the engine's decomposition."""
        super().model_post_init(context)
        self.mu = self.viscosity / self.substep
        self.update_stress, self.needs_svd = self._update_stress_viscous, False

    @qd.func
    def _update_stress_viscous(self, U, S, V, F_tmp, F_new, J, Jp, actu, m_dir):
        stress = 2 * self.mu * (F_tmp - rotation(F_tmp)) @ F_tmp.transpose()
        return stress + qd.Matrix.identity(gs.qd_float, 3) * self.lam * J * (J - 1)
