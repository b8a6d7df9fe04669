"""Frequencies at which taut ropes and chains shake, which bound the time step.

A chain of links of mass m and length l under the tension T swings sideways from link to link at 2 sqrt(T / (m l)), the
highest frequency of a string of beads. The engine integrates that pull explicitly: a rope that carries a load and is
struck diverges at substeps of 1.5 over this frequency or more (measured with 2 to 40 kg on links of 2.5 g; 1.4 holds).
"""

import math
from collections.abc import Iterable, Sequence

from text2sim.compiler.controls import ControlRows
from text2sim.compiler.lower import Lowering
from text2sim.compiler.masses import masses_of
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import Group
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.trees.generators import link_of

SWING = 2.0
"""Assumed tension over weight; a load that swings down from the horizontal would pull with three times its weight."""


def taut_frequencies(
    lowering: Lowering, groups: Iterable[Group], copies: Sequence[Copy], rows: ControlRows, gravity: Vec
) -> dict[str, float]:
    """Return the angular frequency [rad/s] at which ropes and chains shake under what hangs on them, by copy.

    Args:
        lowering: Their trees.
        groups: Entities of bodies.
        copies: Of all bodies that move.
        rows: Controls, lowered: what is welded to a rope hangs on it.
        gravity: [m/s2]
    """
    ropes = [copy for copy in copies if copy.model.kind in ("rope", "chain")]
    if not ropes:
        return {}
    tied: dict[str, set[str]] = {copy.name: {copy.name} for copy in ropes}
    for weld in rows.welds:
        for rope, load in ((weld.a, weld.b), (weld.b, weld.a)):
            if rope in tied and weld.on:
                tied[rope].add(load)
    wanted = {name for names in tied.values() for name in names}
    weights = masses_of(lowering, groups, (c for c in copies if c.name in wanted and _hangs(c)))
    found = {}
    for copy in ropes:
        mass, length = link_of(copy.model)
        pull = SWING * math.hypot(*gravity) * sum(weights.get(name, 0.0) for name in tied[copy.name])
        found[copy.name] = 2 * math.sqrt(pull / (mass * length))
    return found


def _hangs(copy: Copy) -> bool:
    """Return whether nothing else carries a body."""
    return getattr(getattr(copy.model, "mount", None), "kind", "free") == "free" and copy.model.kind != "driven"
