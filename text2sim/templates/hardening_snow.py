"""Snow that hardens no more than the substep bears."""

from typing import Any

import genesis as gs
import quadrants as qd


@qd.data_oriented
class HardeningSnow(gs.materials.MPM.Snow):
    """The engine's snow, no stiffer than that sound crosses a cell in a substep.

    Compressed by a part e of its volume, the engine's snow is `exp(10 e)` times as stiff. Where a wall presses it again
    and again, that is thousands of times, and it diverges.

    Args:
        cell: Cell of the grid [m].
        substep: Substep of the scene [s].
    """

    cell: float = 1.0
    substep: float = 1.0
    hardest: float = 1.0

    def model_post_init(self, context: Any) -> None:
        """Find the largest factor, and take the place of the engine's law."""
        super().model_post_init(context)
        self.hardest = max(1.0, (self.cell / self.substep) ** 2 * self.rho / (self.lam + 2 * self.mu))
        self.update_stress = self._update_stress_bounded

    @qd.func
    def _update_stress_bounded(self, U, S, V, F_tmp, F_new, J, Jp, actu, m_dir):
        h = qd.min(qd.exp(10 * (1.0 - Jp)), self.hardest)
        mu, lam = self.mu * h, self.lam * h
        stress = 2 * mu * (F_new - U @ V.transpose()) @ F_new.transpose()
        return stress + qd.Matrix.identity(gs.qd_float, 3) * lam * J * (J - 1)
