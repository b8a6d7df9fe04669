"""Rigid walls that are too thin for mpm bodies, too short in reach, or too narrow an opening."""

import math
from collections.abc import Iterator
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.soft.scales import thickness
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.words import at_most, length
from text2sim.spec_schema.errors import Problem

LOADED_WALL_CELLS, LEAKING_WALL_CELLS, UNLOADED_WALL_CELLS = 3.0, 2.0, 1.0
"""Thickness [cells] of a wall under pressure that avoids a warning and an error, and of a wall at rest. Measured at a
load of 65 to 90 N on 31 cm2: of 1668 particles 440 passed a plate of 1.3 cells, 164 one of 1.9, 40 were some
millimetres in one of 2.9, none passed one of 5. Walls at rest of 1 to 1.3 cells never leaked."""
HIT_WALL_CELLS = 1.25
"""The same of a wall at rest that soft bodies may hit. Measured with cubes of 0.15 m and 40 kPa at 4 m/s
(tests/physics/test_soft_controls.py -k walls): one of 1.2 cells let the whole cube through, one of 1.3 held it."""
ON_TOP = 2.0
"""Thickness [cells] of a free body on top of an mpm body."""
HOLDING_CELLS = 0.5
"""Reach [cells] with which walls hold a liquid: benchmarks/soft_leaks.py."""
MIN_NECK_CELLS = 2.5
"""Smallest radius [cells] of an opening: sand ran steadily through 2.6."""


def _thin_wall(facts: Facts) -> Iterator[Problem]:
    """Report each rigid body that is too thin for the grid once."""
    soft = facts.once(SoftFacts)
    seen = set()
    for body, copy in soft.pairs("mpm"):
        if copy.body in seen:
            continue
        wanted, why = _wanted_cells(facts, copy, body.model.kind)
        thin, link = _thinnest(facts, copy)
        more = 2 * max(free_by(copy, soft) - soft.scales.reach, 0.0)
        cells = (thin + more) / soft.cell
        if cells >= wanted * (1 - 1e-6):
            continue
        seen.add(copy.body)
        name = copy.name if link is None else f"{copy.name}.{link}"
        text = (
            f"`{name}` is {length(thin)} thick, {soft.in_cells(thin + more)}"
            f"{' with its soft_reach' if more else ''}, and {why}: `{body.name}` leaks through it; make it "
            f"{length(wanted * soft.cell - more)} or thicker, or `scene.mpm.cell` {at_most((thin + more) / wanted)}, or"
        )
        text += (
            ", if it only holds the body by `attach`, `material: {touch_soft: false}`"
            if link is None
            else " draw it as a part with `decor: true`, if it need not touch"
        )
        severity = "error" if wanted == LOADED_WALL_CELLS and cells < LEAKING_WALL_CELLS else None
        where = (
            facts.first_given(copy.body, "shape") if link is None else facts.where(copy.body, "links", link, "shape")
        )
        yield facts.problem("thin-wall", where, text, key=True, severity=severity)


def _thinnest(facts: Facts, copy: Copy) -> tuple[float, str | None]:
    """Return the smallest thickness [m] of a copy, and the link that has it if there are several."""
    if copy.shape is not None and copy.shape.kind != "plane":
        return thickness(copy.shape, facts.folder), None
    thinnest = min(facts.parts(copy), key=lambda part: part.thickness, default=None)
    return (math.inf, None) if thinnest is None else (thinnest.thickness, thinnest.link)


def _wanted_cells(facts: Facts, copy: Copy, kind: str) -> tuple[float, str]:
    """Return how many cells thick a rigid copy should be beside an mpm body of a kind, and why."""
    mount = facts.mount(copy)
    if mount == "driven":
        return LOADED_WALL_CELLS, "it is driven"
    if any(motor.entity == copy.name for motor in facts.plan.motors):
        return LOADED_WALL_CELLS, "a motor moves it"
    if not facts.moves(copy):
        if kind == "soft":
            return HIT_WALL_CELLS, "soft bodies that hit thinner walls pass through them"
        return UNLOADED_WALL_CELLS, "thinner walls let particles through"
    if mount == "tree":  # leaks through thin limbs and ropes are not visible
        return 0.0, ""
    return ON_TOP, "it may lie on the body" if facts.free(copy) else "the body presses on it"


@first_per_place
def _narrow(facts: Facts) -> Iterator[Problem]:
    """Report funnels and tubes that are too narrow for an mpm body."""
    soft = facts.once(SoftFacts)
    for body, copy in soft.pairs("mpm"):
        radius = opening(copy.shape)
        if radius is None or radius >= MIN_NECK_CELLS * soft.cell * (1 - 1e-6):
            continue
        text = (
            f"the opening of `{copy.name}` has a radius of {length(radius)}, {soft.in_cells(radius)}: "
            f"`{body.name}` gets stuck in it; use a radius of {length(MIN_NECK_CELLS * soft.cell)}, or "
            f"`scene.mpm.cell` {at_most(radius / MIN_NECK_CELLS)}"
        )
        yield facts.problem("narrow-opening", facts.first_given(copy.body, "shape"), text, key=True)


@first_per_place
def _leaks(facts: Facts) -> Iterator[Problem]:
    """Report walls whose reach is too short for a liquid."""
    soft = facts.once(SoftFacts)
    for body, copy in soft.pairs("mpm"):
        cells = free_by(copy, soft) / soft.cell
        if body.model.kind != "liquid" or facts.moves(copy) or cells >= HOLDING_CELLS * (1 - 1e-6):
            continue
        share = 7 if cells < 0.25 else 2
        text = (
            f"`{body.name}` leaks through `{copy.name}`, whose reach is {length(free_by(copy, soft))}, {cells:.2g} "
            f"cells of the mpm grid: about {share} % of a dam of 12 cells leaked within a second; leave `soft_reach` "
            f"out, or use {length(HOLDING_CELLS * soft.cell)}, with which nothing leaked"
        )
        yield facts.problem("leaks", facts.first_given(copy.body, "material"), text, key=True)


def free_by(copy: Copy, soft: SoftFacts) -> float:
    """Return the distance [m] at which the grid keeps mpm bodies from a rigid surface: its `soft_reach`."""
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
        title="A wall or plate is too thin, and particles leak through it.",
        reason=f"""\
The mpm grid detects rigid bodies only at its nodes. Measured with a piston on soft cubes, of 1668 particles: 440 passed
a plate of 1.3 cells, 164 one of 1.9; 40 were some millimetres in one of 2.9, and none passed one of 5. A body that a
motor or a prescribed motion presses on mpm bodies should be {LOADED_WALL_CELLS:g} cells thick, and is an error below
{LEAKING_WALL_CELLS:g}; a body on top of them {ON_TOP:g}; a wall at rest {UNLOADED_WALL_CELLS:g}, or
{HIT_WALL_CELLS:g} where soft bodies may hit it: at 4 m/s a cube passed through 1.2 cells.""",
        remedy="""\
Make it thicker (or use a `compound` with a thin visible part and a thick one for contact), or make the grid finer with
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
        title="A liquid leaks through walls whose reach is too short.",
        reason="""\
The grid detects a wall where one of its nodes is within reach. In a dam break of 12 cells (benchmarks/soft_leaks.py)
7 % of the water was in or behind walls of five cells after a second with a `soft_reach` of a tenth of a cell, 2 % with
a quarter, and none with half a cell, which is the default.""",
        remedy="Leave `soft_reach` out, or make it at least half a cell; a larger value slows a liquid down.",
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
        title="An opening is too narrow for the grid.",
        reason=f"""\
Particles feel a wall at a distance of half a cell. Sand ran steadily through a neck with a radius of 2.6 cells; a soft
body passed through tubes of 3.8 cells. Below {MIN_NECK_CELLS:g} cells of radius, flow is slow or stops for any
material.""",
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
