"""Snow without a singular value decomposition."""

from typing import Any

import genesis as gs
import quadrants as qd
from stretches import corotated_stress, principal, restretched


@qd.data_oriented
class Snow(gs.materials.MPM.Snow):
    """The engine's snow (Stomakhin et al., A material point method for snow simulation, 2013)."""

    def model_post_init(self, context: Any) -> None:
        """Take the place of the engine's law."""
        super().model_post_init(context)
        self.update_F_S_Jp, self.update_stress, self.needs_svd = self._update_snow, self._hand_on_stress, False

    @qd.func
    def _update_snow(self, J, F_tmp, U, S, V, Jp):
        axes, stretches = principal(F_tmp)
        kept, Jp_new = qd.Vector.zero(gs.qd_float, 3), Jp
        for i in qd.static(range(3)):
            kept[i] = min(max(stretches[i], 1 - self.yield_lower), 1 + self.yield_higher)
            Jp_new *= stretches[i] / kept[i]
        hardened = qd.exp(10 * (1.0 - Jp))
        stress = corotated_stress(axes, kept, self.mu * hardened, self.lam * hardened, J)
        return restretched(F_tmp, axes, stretches, kept), stress, Jp_new

    @qd.func
    def _hand_on_stress(self, U, S, V, F_tmp, F_new, J, Jp, actu, m_dir):
        return S
