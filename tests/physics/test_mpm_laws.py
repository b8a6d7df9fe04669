"""Laws of our own of mpm bodies against those of the engine."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from text2sim import templates

COMPARED = """
import sys
import genesis as gs
import numpy as np
import quadrants as qd

gs.init(backend=gs.cpu, precision="64", logging_level="error")
from corotated import Corotated
from hardening_snow import HardeningSnow
from viscous_liquid import ViscousLiquid

engine = gs.materials.MPM
E = dict(E=3e4, nu=0.3)
PAIRS = {
    "corotated": (engine.Elastic(**E), Corotated(**E), 1.0),
    "viscous": (
        engine.Liquid(**E, viscous=True), ViscousLiquid(**E, viscous=True, viscosity=3e4 / 2.6, substep=1.0), 1.0
    ),
    "snow": (engine.Snow(**E, rho=100.0), HardeningSnow(**E, rho=100.0, cell=0.2, substep=1e-3), 0.8),
    "packed_snow": (engine.Snow(**E, rho=100.0), HardeningSnow(**E, rho=100.0, cell=0.2, substep=1e-3), 0.4),
}

@qd.data_oriented
class Laws:
    def __init__(self, theirs, ours, count):
        self.laws = theirs, ours
        self.F = qd.Matrix.field(3, 3, dtype=gs.qd_float, shape=count)
        self.gradients, self.stresses = (qd.Matrix.field(3, 3, dtype=gs.qd_float, shape=(2, count)) for _ in range(2))
        self.Jp = qd.field(dtype=gs.qd_float, shape=(2, count))

    @qd.kernel
    def compare(self, part: gs.qd_float):
        for i in range(self.F.shape[0]):
            F = self.F[i]
            for k in qd.static(range(2)):
                U, S, V = qd.Matrix.zero(gs.qd_float, 3, 3), qd.Matrix.zero(gs.qd_float, 3, 3), qd.Matrix.zero(gs.qd_float, 3, 3)
                if qd.static(self.laws[k].needs_svd):
                    U, S, V = qd.svd(F, gs.qd_float)
                Jp = part
                J = F.determinant()
                new, kept, Jp_new = self.laws[k].update_F_S_Jp(J=J, F_tmp=F, U=U, S=S, V=V, Jp=Jp)
                self.gradients[k, i], self.Jp[k, i] = new, Jp_new - Jp
                self.stresses[k, i] = self.laws[k].update_stress(
                    U=U, S=kept, V=V, F_tmp=F, F_new=new, J=J, Jp=Jp, actu=0.0, m_dir=qd.Vector([0.0, 0.0, 1.0])
                )

F = np.load(sys.argv[1])
for name, (theirs, ours, part) in PAIRS.items():
    assert theirs.needs_svd and ours.needs_svd == isinstance(ours, engine.Snow)
    laws = Laws(theirs, ours, len(F))
    laws.F.from_numpy(F)
    laws.compare(part)
    found = {key: getattr(laws, key).to_numpy() for key in ("gradients", "stresses", "Jp")}
    np.savez(f"{sys.argv[2]}/{name}.npz", **found)

from singular_values import decomposed

U, S, V = (qd.Matrix.field(3, 3, dtype=gs.qd_float, shape=len(F)) for _ in range(3))

@qd.kernel
def decompose(F: qd.template()):
    for i in F:
        U[i], S[i], V[i] = decomposed(F[i])

F[:3] = np.diag([1.0, 1e-9, 0.0]), np.diag([0.0, 0.0, 2.0]), np.zeros((3, 3))
laws.F.from_numpy(F)
decompose(laws.F)
np.savez(f"{sys.argv[2]}/decomposed.npz", F=F, U=U.to_numpy(), S=S.to_numpy(), V=V.to_numpy())

one, other, softer = Corotated(**E), Corotated(**E), Corotated(E=2e4, nu=0.3)
from engine import mend
assert one != other
mend()
assert one == other and one != softer and one != engine.Elastic(**E)
"""
LAWS = {
    "corotated": 1.0,
    "viscous": 1.0,
    "snow": 1.0,
    "packed_snow": (0.2 / 1e-3) ** 2 * 100 * 0.52 / 2.1e4 / np.exp(6),
}
"""Parts of the engine's stress. In packed snow, `exp(10 (1 - 0.4))` times as stiff, sound would cross more than the cell
of 0.2 m in the substep of 1 ms: it runs at sqrt(h (lambda + 2 mu) / rho), with h times 3e4 (1 - nu) / ((1 + nu) (1 - 2
nu)) Pa."""


def gradients() -> np.ndarray:
    """Return deformation gradients: small, large and extreme ones, rotated at random, and some inside out, (n, 3, 3)."""
    random = np.random.default_rng(1)
    turned = np.linalg.qr(random.normal(size=(400, 3, 3)))[0]
    turned[np.linalg.det(turned) < 0, :, 0] *= -1
    spread = np.repeat([1e-3, 0.1, 0.5, 1.0], 100)[:, None]
    stretches = np.exp(spread * random.normal(size=(400, 3)))
    stretches[:5] = 1.0
    stretches[50:55, 1] = stretches[50:55, 0]
    stretches[::10, 2] *= -1
    return turned @ (stretches[:, :, None] * turned[::-1].transpose(0, 2, 1))


@pytest.fixture(scope="module")
def compared(engine, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("laws")
    np.save(folder / "gradients.npy", gradients())
    (folder / "compared.py").write_text(COMPARED)  # kernels need their source
    env = os.environ | {"PYTHONPATH": str(Path(templates.__file__).parent)}
    command = [sys.executable, str(folder / "compared.py"), str(folder / "gradients.npy"), str(folder)]
    done = subprocess.run(command, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize("law", LAWS)
def test_a_law_gives_the_gradients_and_stresses_of_the_engine(compared, law):
    """In double precision, so that rounding and the ends of iterations are all that differs.

    What is inside out may be flipped along any direction, and the engine and we may choose differently where the least
    stretches nearly agree: those gradients only have to stay finite.
    """
    found, F = np.load(compared / f"{law}.npz"), gradients()
    sound = np.linalg.det(F) > 0
    assert sound.sum() == 360
    for key in ("gradients", "stresses", "Jp"):
        theirs, ours = found[key][:, sound]
        theirs = theirs * (LAWS[law] if key == "stresses" else 1.0)
        scale = np.maximum(1.0, np.abs(theirs).max(axis=tuple(range(1, theirs.ndim)), keepdims=True))
        assert np.abs((ours - theirs) / scale).max() < 2e-6, key
        if law != "viscous":  # whose volume has a root
            assert np.isfinite(found[key][1]).all(), key


def test_singular_values_are_those_of_numpy(compared):
    """F = U S Vᵀ with rotations U and V, also of what is flat; the least value has the sign of the determinant."""
    found = np.load(compared / "decomposed.npz")
    F, U, S, V = found["F"], found["U"], found["S"], found["V"]
    for turn in (U, V):
        assert np.allclose(turn.transpose(0, 2, 1) @ turn, np.eye(3), atol=1e-9)
        assert np.allclose(np.linalg.det(turn), 1.0)
    assert np.allclose(U @ S @ V.transpose(0, 2, 1), F, atol=1e-9)
    values = np.linalg.svd(F, compute_uv=False)
    assert (np.linalg.det(F) < 0).any()
    values[:, 2] *= np.where(np.linalg.det(F) < 0, -1.0, 1.0)
    assert np.allclose(np.sort(S[:, [0, 1, 2], [0, 1, 2]]), np.sort(values), atol=1e-9)
