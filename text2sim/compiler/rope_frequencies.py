"""Frequencies at which taut ropes and chains shake, which bound the time step.

A chain of links of mass m and length l under the tension T swings sideways from link to link at 2 sqrt(T / (m l)), the
highest frequency of a string of beads. The engine integrates that pull explicitly: a rope that carries a load and is
struck diverges at substeps of 1.5 over this frequency or more (measured with 2 to 40 kg on links of 2.5 g; 1.4 holds).
"""

import math
from collections.abc import Iterable, Mapping, Sequence

from text2sim.compiler.controls import ControlRows
from text2sim.compiler.lower import Lowering
from text2sim.compiler.masses import masses_of
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import Group
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.trees.carried import carried_links
from text2sim.compiler.trees.generators import link_of
from text2sim.compiler.trees.tree import Tree
from text2sim.spec_schema.models.bodies import Articulated, Link

TENSION_FACTOR = 2.0
"""Assumed tension over weight; a load that swings down from the horizontal would pull with three times its weight."""


def taut_frequencies(
    lowering: Lowering, groups: Iterable[Group], copies: Sequence[Copy], rows: ControlRows, gravity: Vec
) -> dict[str, float]:
    """Return the angular frequency [rad/s] at which ropes and chains shake under what hangs on them, by copy.

    Three passive links or more in a row that a case lists itself are a chain as well.

    Args:
        lowering: Their trees.
        groups: Entities of bodies.
        copies: Of all bodies that move.
        rows: Controls, lowered: what is welded to a rope hangs on it.
        gravity: [m/s2]
    """
    pull = TENSION_FACTOR * math.hypot(*gravity)
    found = {
        copy.name: frequency
        for copy in copies
        if isinstance(copy.model, Articulated) and copy.model.links
        if (frequency := _fastest_hanging_link(copy.model.links, lowering.trees[copy.name], pull)) > 0.0
    }
    ropes = [copy for copy in copies if copy.model.kind in ("rope", "chain")]
    if not ropes:
        return found
    tied: dict[str, set[str]] = {copy.name: {copy.name} for copy in ropes}
    for weld in rows.welds:
        for rope, load in ((weld.a, weld.b), (weld.b, weld.a)):
            if rope in tied and weld.on:
                tied[rope].add(load)
    wanted = {name for names in tied.values() for name in names}
    weights = masses_of(lowering, groups, (c for c in copies if c.name in wanted and _hangs_freely(c)))
    for copy in ropes:
        mass, length = link_of(copy.model)
        if copy.model.kind == "chain":
            joints = lowering.trees[copy.name].joints()
            mass += min((joint.armature for _, joint in joints if joint.kind != "free"), default=0.0) / length**2
        load = sum(weights.get(name, 0.0) for name in tied[copy.name])
        found[copy.name] = 2 * math.sqrt(pull * load / (mass * length))
    return found


def _fastest_hanging_link(links: Mapping[str, Link], tree: Tree, pull: float) -> float:
    """Return the angular frequency [rad/s] of the fastest passive link that hangs in a row of them; 0 if none does."""
    rows = {row.link.name: row for row in carried_links(tree)}

    def slack(name: str | None) -> bool:
        joint = None if name is None else links[name].joint
        return joint is not None and joint.kind in ("hinge", "ball") and getattr(joint, "actuator", None) is None

    fastest = 0.0
    for name, link in links.items():
        row, above = rows.get(name), link.parent
        if row is None or above is None or not (row.reach and slack(name) and slack(above)):
            continue
        if any(slack(other) for other, child in links.items() if child.parent == name):
            heft = row.mass + row.link.all_joints()[0][1].armature / row.reach**2
            fastest = max(fastest, 2 * math.sqrt(pull * row.load / (heft * row.reach)))
    return fastest


def _hangs_freely(copy: Copy) -> bool:
    """Return whether nothing else carries a body."""
    return getattr(getattr(copy.model, "mount", None), "kind", "free") == "free" and copy.model.kind != "driven"
