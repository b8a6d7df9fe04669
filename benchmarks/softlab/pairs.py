"""What runs of pairs of families showed.

Two bodies fly into each other in free fall, so that all momentum along x is theirs. Beside them one body slides over a
bed of the other: what it loses of its speed, over the momentum that the bed gives it upwards, is its friction.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.softlab.families import SLIDE, SPEED, Pair
from benchmarks.softlab.lab import Lab, Run, RunFailed
from benchmarks.softlab.pair_scene import scene

G = 9.81
TOUCH = 0.03
"""Part of the momentum of a plastic blow from which on a body counts as touched."""
TOGETHER = {"particle": 7, "sap": 1}
"""Pairs in one scene, by contact model: for more of them its steps take longer than the kernels that are saved."""


@dataclass(frozen=True)
class Finding:
    """What a pair did."""

    pair: str
    model: str
    given: float | None = None
    """Momentum that the struck body gained, over that of a plastic blow: 1 is a plastic one, 2 an elastic one."""
    lost: float | None = None
    """What the flying body lost, over the same."""
    through: bool = False
    """The flying body ended beyond the struck one."""
    frozen: bool = False
    """The struck body did not fall."""
    friction: float | None = None
    """Momentum lost along the bed over momentum gained across it; None where the bed did not carry the body."""
    problem: str | None = None

    @property
    def touches(self) -> bool:
        """Whether either of the two felt the other."""
        return max(abs(self.given or 0.0), abs(self.lost or 0.0)) > TOUCH

    @property
    def two_way(self) -> bool:
        """Whether both felt it."""
        return min(abs(self.given or 0.0), abs(self.lost or 0.0)) > TOUCH


def batches(pairs: list[Pair]) -> list[list[Pair]]:
    """Return pairs by their contact models, as many as go into one scene."""
    found = []
    for model, most in TOGETHER.items():
        those = [pair for pair in pairs if pair.model == model]
        found += [those[k : k + most] for k in range(0, len(those), most)]
    return found


def examine(lab: Lab, pairs: list[Pair]) -> list[Finding]:
    """Run the scene of some pairs and read what happened; where it fails, run them one by one."""
    try:
        run = lab.run(scene(pairs), pairs[0].name)
    except RunFailed as error:
        if len(pairs) > 1:
            return [finding for pair in pairs for finding in examine(lab, [pair])]
        return [Finding(pairs[0].name, pairs[0].model, problem=str(error).strip().splitlines()[-1][:200])]
    return [
        Finding(pair.name, pair.model, **_blow(run, f"_{k}"), friction=_friction(run, f"_{k}"))
        for k, pair in enumerate(pairs)
    ]


def _blow(run: Run, end: str) -> dict[str, Any]:
    masses = [run.mass(name + end) for name in ("struck", "flying")]
    plastic = masses[0] * masses[1] / sum(masses) * SPEED
    struck, flying = (run.momentum(name + end)[:, 0] for name in ("struck", "flying"))
    ahead = run.center("flying" + end)[-1, 0] > run.center("struck" + end)[-1, 0]
    fallen = run.center("struck" + end)[0, 2] - run.center("struck" + end)[-1, 2]
    return {
        "given": round(float(struck[-1] - struck[0]) / plastic, 3),
        "lost": round(float(masses[1] * SPEED - flying[-1]) / plastic, 3),
        "through": bool(ahead),
        "frozen": bool(fallen < G * run.time[-1] ** 2 / 8),
    }


def _friction(run: Run, end: str) -> float | None:
    """Impulse along the bed over impulse across it: (v0 - v) / (g t + vz), until the body is slow."""
    if run.row("slider" + end) is None and not run.links("slider" + end):
        return None
    velocity = run.velocity("slider" + end)
    slow = np.flatnonzero(velocity[:, 0] < 0.1 * SLIDE)
    last = int(slow[0]) if len(slow) else len(run.time) - 1
    across = G * run.time[last] + velocity[last, 2]
    if across < 0.2 * G * run.time[last]:
        return None
    return round(float((SLIDE - velocity[last, 0]) / across), 3)


def as_row(finding: Finding) -> dict[str, Any]:
    """Return what is kept of a finding on disk."""
    return asdict(finding)
