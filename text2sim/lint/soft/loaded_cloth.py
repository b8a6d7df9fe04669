"""Cloth of solver pbd that what hangs on it draws out."""

import math
from collections.abc import Iterator

from text2sim.compiler.action_rows import Hold
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.soft.scales import sheet_size
from text2sim.compiler.soft.settings import own_stretch
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.script.gap_bounds import height
from text2sim.lint.soft.facts import SoftBody, SoftFacts
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_least

MAX_LOADED_STRETCH = 0.05
"""Part by which a load may draw out a cloth without a report."""
MIN_AIR_GAP = 0.02
"""Smallest gap [m] below a load that hangs."""


def _overloaded(facts: Facts) -> Iterator[Problem]:
    """Report cloth that a rigid load draws out: its threads carry many times what they carry of its own weight.

    Its own weight loads them by half of it on average, see `own_stretch`, and a load M by all of M.
    """
    soft, seen = facts.once(SoftFacts), set[str]()
    pbd = facts.settings.soft.pbd if facts.settings.soft is not None else None
    holds = facts.rows.holds
    for body in soft.of("pbd"):
        density = getattr(body.model.material, "area_density", None)
        own = [row for row in holds if row.entity == body.name]
        loads = dict.fromkeys(name for row in own if row.both_ways for name in row.to)
        hanging = [facts.copies[name] for name in loads if _hangs(facts, facts.copies[name], body)]
        elastic = getattr(body.model.material, "youngs_modulus", None)
        if pbd is None or density is None or elastic or not hanging or body.body in seen or not _is_held(own):
            continue
        carried = sum(facts.masses.get(load.name, 0.0) / _carriers(holds, load) for load in hanging)
        stretch = _stretch(facts, body, carried)
        if stretch <= MAX_LOADED_STRETCH:
            continue
        seen.add(body.body)
        wide, tall = sheet_size(body.copy.shape, facts.folder)
        times = stretch / MAX_LOADED_STRETCH
        more = math.ceil(math.sqrt(times) * facts.case.scene.dt / facts.substep)
        text = (
            f"`{hanging[0].name}` hangs on `{body.name}`, {carried:.3g} kg on {density * wide * tall:.2g} kg of cloth: "
            f"in substeps of {facts.substep:.2g} s, with {pbd.stretch_iterations} stretch iterations, that makes it "
            f"{100 * stretch:.0f} % longer at rest, and twice that in a jerk, like rubber; use scene.substeps of "
            f"{more}, an `area_density` of {at_least(density * times)}, larger cells, or a `rope` or hinged plates "
            "for a strap"
        )
        yield facts.problem("cloth-overloaded", facts.first_given(body.body, "material", "cell", "shape"), text)


def _stretch(facts: Facts, body: SoftBody, carried: float) -> float:
    """Return the part by which a load [kg] makes a cloth longer at rest."""
    assert facts.settings.soft is not None
    pbd = facts.settings.soft.pbd
    assert pbd is not None
    wide, tall = sheet_size(body.copy.shape, facts.folder)
    own = own_stretch(tall, pbd.particle_size, facts.substep, pbd.stretch_iterations, facts.pull)
    return 2 * own * carried / (body.model.material.area_density * wide * tall)


def _hangs(facts: Facts, load: Copy, cloth: SoftBody) -> bool:
    """Return whether a load hangs on a cloth alone: it is free, in its lower half, and nothing is below it."""
    box = facts.box(load)
    others = {name for weld in facts.rows.welds for name in (weld.a, weld.b)} | facts.bonded | facts.sprung
    if box is None or not facts.free(load) or load.name in others:
        return False
    (x, y, z), (far_x, far_y, top) = box
    low, high = (corner[2] for corner in cloth.box)
    if top > (low + high) / 2 or any(height(ground, box) < MIN_AIR_GAP for ground in facts.planes):
        return False
    for other in facts.copies.values():
        below = None if other in (load, cloth.copy) else facts.box(other)
        if below is None or not (z - MIN_AIR_GAP < below[1][2] < top):
            continue
        if below[0][0] < far_x and below[1][0] > x and below[0][1] < far_y and below[1][1] > y:
            return False
    return True


def _is_held(holds: list[Hold]) -> bool:
    """Return whether something that is no load, nor another cloth, holds a cloth."""
    return any(not row.both_ways and row.seam is None for row in holds)


def _carriers(holds: list[Hold], load: Copy) -> int:
    """Return the number of cloths that carry a load."""
    return len({row.entity for row in holds if load.name in row.to})


RULES = (
    Rule(
        id="cloth-overloaded",
        title="A cloth is too light for what hangs on it, and stretches like rubber.",
        reason="""\
The threads of a cloth do not stretch by its material, but by what the solver leaves of their errors: a load M draws a
cloth of mass m and length L out by a part 6 M g h^2 L / (m n cell^2) at rest, with n iterations in substeps h, and by
twice that if it is put on at once (tests/physics/test_seams.py).""",
        remedy="""\
Make the cloth heavier or the load lighter, use larger cells or more `substeps` (twice as many stretch it a quarter as
much), give it the `youngs_modulus` of webbing, or make straps of hinged plates or a `rope`.""",
        example="""\
bodies:
  strip:
    kind: cloth
    cell: 0.02
    shape: {kind: sheet, size: [0.12, 0.4]}
    pose: {pos: [0, 0, 1.5], euler_deg: [90, 0, 0]}
  load: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 1.2]}}
actions:
  controls:
    hang: {kind: attach, body: strip, region: {edge: back}, to: world}
    lift: {kind: attach, body: strip, region: {edge: front}, to: load}
""",
        fix="bodies: {load: {material: {mass: 0.04}}}",
        run=_overloaded,
    ),
)
