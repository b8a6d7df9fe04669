"""Corotated elastic solid of mpm, whose particles find their rotation without a singular value decomposition."""

from typing import Any

import genesis as gs
import quadrants as qd
from singular_values import decomposed

MIN_VOLUME_RATIO = 0.02
"""Ratio of volumes below which, as for what is inside out, the decomposition is used after all."""
TOLERANCE = 1e-10
"""Square of the last step at which the iteration ends; its error is about as large as the square of that step."""
MAX_ITERATIONS = 15
"""Largest number of steps. A stretch s takes `log2(s)` of them, and four more."""


@qd.func
def rotation(gradient):
    """Return the rotation of a deformation gradient F, the factor R of its polar decomposition, (3, 3).

    Newton's iteration `R <- (R + R^-T) / 2` from `R = F` (Higham, Computing the polar decomposition, 1986). It takes
    much less time than the engine's decomposition.
    """
    result = gradient
    if gradient.determinant() > MIN_VOLUME_RATIO:
        moved = gs.qd_float(1.0)
        for _ in range(MAX_ITERATIONS):
            if moved > TOLERANCE:
                a, b, c = result[0, :], result[1, :], result[2, :]
                cofactors = qd.Matrix.rows([b.cross(c), c.cross(a), a.cross(b)])
                step = 0.5 * (cofactors / result.determinant() - result)
                result += step
                moved = step.norm_sqr()
    else:
        left, _, right = decomposed(gradient)
        result = left @ right.transpose()
    return result


@qd.data_oriented
class Corotated(gs.materials.MPM.Elastic):
    """The engine's elastic solid with the model `corotation`."""

    def model_post_init(self, context: Any) -> None:
        """Take the place of the engine's stress, and do without its decomposition."""
        super().model_post_init(context)
        self.update_stress, self.needs_svd = self._update_stress_rotated, False

    @qd.func
    def _update_stress_rotated(self, U, S, V, F_tmp, F_new, J, Jp, actu, m_dir):
        stress = 2 * self.mu * (F_tmp - rotation(F_tmp)) @ F_tmp.transpose()
        return stress + qd.Matrix.identity(gs.qd_float, 3) * self.lam * J * (J - 1)
