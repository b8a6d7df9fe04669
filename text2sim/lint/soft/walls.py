"""Rigid walls around the grid of the material point method: what leaks through them, and what they close."""

import math
from collections.abc import Iterator
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, SoftFacts, soft_facts
from text2sim.lint.words import at_most, length
from text2sim.spec_schema.errors import Problem

LOADED, LEAKING, STILL = 3.0, 2.0, 1.0
"""Thickness in cells of a wall: one that is pressed should have the first, must have the second; one that only stands
there should have the third. Measured at a load of 65 to 90 N on 31 cm2: of 1668 particles 440 passed a plate of 1.3
cells, 164 one of 1.9, 40 were some millimetres in one of 2.9, none passed one of 5. Standing walls of 1 to 1.3 cells
never leaked."""
ON_TOP = 2.0
"""The same of what is free to lie on a body."""
HOLDING = 0.5
"""Reach in cells with which walls hold a liquid: benchmarks/soft_leaks.py."""
NECK = 2.5
"""Radius of an opening in cells: sand ran steadily through 2.6."""


def _thin_wall(facts: Facts) -> Iterator[Problem]:
    """One finding for each rigid body that is too thin for the grid."""
    soft = soft_facts(facts)
    seen = set()
    for body, copy in soft.pairs("mpm"):
        if copy.body in seen:
            continue
        wanted, why = _wanted(facts, soft, body, copy)
        thin = min((part.thickness for part in facts.parts(copy)), default=math.inf)
        cells = thin / soft.cell
        if cells >= wanted * (1 - 1e-6):
            continue
        seen.add(copy.body)
        text = (
            f"`{copy.name}` is {length(thin)} thick, {cells:.2g} cells of the mpm grid ({length(soft.cell)}), and "
            f"{why}: `{body.name}` leaks through it; make it {length(wanted * soft.cell)} or thicker, or "
            f"`scene.mpm.cell` {at_most(thin / wanted)}, or, if it holds the body by `attach` alone, "
            "`material: {touch_soft: false}`"
        )
        severity = "error" if wanted == LOADED and cells < LEAKING else None
        yield facts.problem("thin-wall", facts.said(copy.body, "shape"), text, key=True, severity=severity)


def _wanted(facts: Facts, soft: SoftFacts, body: SoftBody, copy: Copy) -> tuple[float, str]:
    """How many cells thick a rigid copy should be, and what it does."""
    mount = facts.mount(copy)
    if mount == "driven":
        return LOADED, "it is driven"
    if any(motor.entity == copy.name for motor in facts.plan.motors):
        return LOADED, "a motor presses it"
    if not facts.moves(copy):
        return STILL, "walls of less let particles through"
    if mount == "tree":  # thin limbs and ropes: what they do to the body is seen at their scale
        return 0.0, ""
    return ON_TOP, "it is free to lie on the body" if facts.free(copy) else "what comes down on it presses it"


def _narrow(facts: Facts) -> Iterator[Problem]:
    """One finding for each funnel or tube through which an mpm body hardly gets."""
    soft = soft_facts(facts)
    seen = set()
    for body, copy in soft.pairs("mpm"):
        radius = opening(copy.shape)
        if radius is None or copy.body in seen or radius >= NECK * soft.cell * (1 - 1e-6):
            continue
        seen.add(copy.body)
        text = (
            f"the opening of `{copy.name}` has a radius of {length(radius)}, {radius / soft.cell:.2g} cells of the mpm "
            f"grid ({length(soft.cell)}): `{body.name}` gets stuck in it; a radius of {length(NECK * soft.cell)}, or "
            f"`scene.mpm.cell` {at_most(radius / NECK)}, lets it through"
        )
        yield facts.problem("narrow-opening", facts.said(copy.body, "shape"), text, key=True)


def _leaks(facts: Facts) -> Iterator[Problem]:
    """One finding for each wall that reaches too short for a liquid."""
    soft = soft_facts(facts)
    seen = set()
    for body, copy in soft.pairs("mpm"):
        cells = free_by(copy, soft) / soft.cell
        if body.model.kind != "liquid" or facts.moves(copy) or cells >= HOLDING * (1 - 1e-6) or copy.body in seen:
            continue
        seen.add(copy.body)
        share = 7 if cells < 0.25 else 2
        text = (
            f"`{body.name}` runs through `{copy.name}`, which it feels from {length(free_by(copy, soft))} on, "
            f"{cells:.2g} cells of the mpm grid: some {share} % of a dam of 12 cells had leaked after a second; "
            f"leave `soft_reach` out, or make it {length(HOLDING * soft.cell)}, with which nothing did"
        )
        yield facts.problem("leaks", facts.said(copy.body, "material"), text, key=True)


def free_by(copy: Copy, soft: SoftFacts) -> float:
    """Return how far [m] from the surface of a rigid body the grid keeps mpm bodies: its `soft_reach`."""
    return getattr(copy.model.material, "soft_reach", None) or soft.scales.reach


def opening(shape: Any) -> float | None:
    """Return the radius [m] of the narrowest hole through a shape, if it has one."""
    kind = getattr(shape, "kind", None)
    if kind == "funnel":
        return min(shape.top_radius, shape.bottom_radius)
    if kind == "tube":
        return shape.inner_radius
    if kind == "torus":
        return shape.radius - shape.bar_radius
    if kind == "compound":
        return min((r for part in shape.solids.values() if (r := opening(part.shape)) is not None), default=None)
    return None


RULES = (
    Rule(
        id="thin-wall",
        severity="warning",
        title="A wall or plate is so thin that particles leak through it.",
        reason=f"""\
The grid of mpm bodies feels rigid ones at its nodes only. Measured with a piston on soft cubes, of 1668 particles: 440
passed a plate of 1.3 cells, 164 one of 1.9; 40 were some millimetres in one of 2.9, and none passed one of 5. What a
motor or a prescribed motion presses on mpm bodies should be {LOADED:g} cells thick, and is an error below {LEAKING:g};
what lies on them {ON_TOP:g}; what stands still {STILL:g}.""",
        remedy="""\
Make it thicker (a thin part may be drawn and a thick one touch: a `compound` with two parts), or the grid finer with
`scene.mpm.cell`; half the cell takes sixteen times as long.""",
        example="""\
bodies:
  jelly: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.11]}}
  press:
    kind: driven
    shape: {kind: cylinder, radius: 0.15, height: 0.05}
    pose: {pos: [0, 0, 0.26]}
    motion: {kind: oscillate, axis: z, amplitude: 0.1, frequency: 0.5}
""",
        fix="bodies: {press: {shape: {height: 0.08}, pose: {pos: [0, 0, 0.27]}}}",
        run=_thin_wall,
    ),
    Rule(
        id="leaks",
        severity="warning",
        title="A liquid runs through walls that reach too short.",
        reason="""\
The grid feels a wall where one of its nodes comes within reach. In a dam break of 12 cells (benchmarks/soft_leaks.py)
7 % of the water was in or behind walls of five cells after a second with a `soft_reach` of a tenth of a cell, 2 % with
a quarter, and none with half a cell, which is what walls have if a case says nothing.""",
        remedy="Leave `soft_reach` out, or make it half a cell or more; the more, the slower a liquid runs.",
        example="""\
scene:
  statics:
    tank:
      shape: {kind: cup, radius: 0.3, height: 0.4, thickness: 0.1}
      material: {soft_reach: 0.002}
      pose: {pos: [0, 0, 0.2]}
bodies:
  water: {kind: liquid, cell: 0.02, shape: {kind: cylinder, radius: 0.15, height: 0.2}, pose: {pos: [0, 0, 0.25]}}
""",
        fix="scene: {statics: {tank: {material: null}}}",
        run=_leaks,
    ),
    Rule(
        id="narrow-opening",
        severity="warning",
        title="An opening is so narrow that the grid closes it.",
        reason=f"""\
Particles feel a wall from half a cell away. Sand ran steadily through a neck with a radius of 2.6 cells; a soft body
went through tubes of 3.8 cells. Below {NECK:g} cells of radius flow is slow or stops, whatever the material.""",
        remedy="Make the opening wider, or the grid finer with `scene.mpm.cell`.",
        example="""\
scene:
  statics:
    funnel:
      shape: {kind: funnel, top_radius: 0.2, bottom_radius: 0.03, height: 0.2, thickness: 0.03}
      pose: {pos: [0, 0, 0.3]}
bodies:
  sand: {kind: granular, cell: 0.02, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.65]}}
""",
        fix="scene: {statics: {funnel: {shape: {bottom_radius: 0.08}}}}",
        run=_narrow,
    ),
)
