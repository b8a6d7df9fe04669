"""A liquid with a viscosity."""

import genesis as gs
import quadrants as qd


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
        """Set the shear modulus."""
        super().model_post_init(context)
        self.mu = self.viscosity / self.substep
