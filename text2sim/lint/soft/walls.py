"""Rigid walls that are too thin for mpm bodies, or too narrow an opening."""

import math
from collections.abc import Iterator
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.soft.scales import thickness
from text2sim.compiler.soft.solvers import holds_up, unfelt_links
from text2sim.lint.facts import Facts
from text2sim.lint.joints.drives import spans_of
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftBody, SoftFacts
from text2sim.lint.words import length, length_of_at_least
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.soft_bodies import FLOWING
from text2sim.spec_schema.rounding import at_most

LOADED_WALL_CELLS, LEAKING_WALL_CELLS = 3.0, 2.0
"""Thickness [cells] with which a wall that presses on a soft body avoids a warning and an error. Measured at a load of
65 to 90 N on 31 cm2: of 1668 particles 440 passed a plate of 1.3 cells, 164 one of 1.9, 40 were some millimetres in one
of 2.9, none passed one of 5."""
HIT_WALL_CELLS = 1.25
"""The same of a wall at rest that soft bodies may hit. Measured with cubes of 0.15 m and 40 kPa at 4 m/s
(tests/physics/test_soft_controls.py -k walls): one of 1.2 cells let the whole cube through, one of 1.3 held it."""
CUTTING_CELLS = 1.5, 5.0
"""The same of what cuts a body with a `tear_stretch`, and by how much it grows with that: nodes that move along with a
wire strain what lies beside it by its thickness in cells. Measured with blocks of 15 kPa, thickness with reach: at 1.3,
1 cell tore a tenth of what was in its way, 1.5 half, 2 all but the top layer, 2.25 all; at 1.2, 2.1 cells cut one block
and not another; at 1.15, 1.5 and 2.25 cells cut."""
LEAKS, SINKS, PUSHED = "leaks through it", "loses its level behind it and falls into itself", "is pushed through it"
CLOSES = "closes behind it instead of being cut"
"""What a body does about a wall or a cutter that is too thin."""
ON_TOP = 2.0
"""Thickness [cells] of a free body on top of an mpm body."""
HOLDING_CELLS, LEAKING_CELLS, PUSHING_CELLS = 1.1, 0.3, 0.5
"""Thickness [cells] of a wall at rest that holds up what flows, of a post that lets no particle through, and of a wall
that moves. Particles are moved out of rigid bodies (templates/solid_walls.py): benchmarks/soft_leaks.py,
tests/physics/test_solid_walls.py. But pressure needs nodes that stand still: tests/physics/test_narrow_vessel.py."""
HELD_UP_CELLS, MOVED_CELLS = 0.5, 0.8
"""The same of a wall at rest, and of one that is free or on a joint, in scenes without grains and snow, where the nodes
at walls are stopped: at rest 0.5 and 1.15 cells held alike; cans with a motor held with 0.8 and burst with 0.5."""
MIN_NECK_CELLS = 2.5
"""Smallest radius [cells] of an opening: sand ran steadily through 2.6."""


def _thin_wall(facts: Facts) -> Iterator[Problem]:
    """Report each rigid body that is too thin for the grid once."""
    soft = facts.once(SoftFacts)
    seen = set()
    for body, copy in soft.pairs("mpm"):
        if copy.body in seen:
            continue
        wanted, why, then = _wanted_cells(facts, copy, body.model)
        thin, link, others = _thinnest(facts, copy, body)
        more = 2 * max(free_by(copy, soft) - soft.scales.reach, 0.0)
        cells = (thin + more) / soft.cell
        if cells >= wanted * (1 - 1e-6):
            continue
        seen.add(copy.body)
        name = copy.name if link is None else f"{copy.name}.{link}"
        text = (
            f"`{name}` is {length(thin)} thick, {soft.in_cells(thin + more)}"
            f"{' with its soft_reach' if more else ''}, and {why}: `{body.body}` {then}; make it "
            f"{length_of_at_least(wanted * soft.cell - more)} or thicker, or `scene.mpm.cell` "
            f"{at_most((thin + more) / wanted)}"
        )
        if then == CLOSES:
            text += f", or give it `soft_reach: {1.005 * (free_by(copy, soft) + (wanted - cells) / 2 * soft.cell):.3g}`"
        text += (
            ", or, if it only holds the body by `attach`, `material: {touch_soft: false}`"
            if link is None
            else ", or, if it need not touch, `material: {touch_soft: false}` or parts with `decor: true`"
        )
        limit = wanted * soft.cell * (1 - 1e-6) - more
        if also := [f"`{copy.name}.{link}` ({length(size)})" for link, size in others.items() if size < limit]:
            text += f"; the same holds for {', '.join(also)}"
        severity = "error" if wanted == LOADED_WALL_CELLS and cells < LEAKING_WALL_CELLS else None
        where = (
            facts.first_given(copy.body, "shape") if link is None else facts.where(copy.body, "links", link, "shape")
        )
        yield facts.problem("thin-wall", where, text, key=True, severity=severity)


def _thinnest(facts: Facts, copy: Copy, body: SoftBody) -> tuple[float, str | None, dict[str, float]]:
    """Return the smallest thickness [m] of a copy, the link that has it if there are several, and those of the others.

    Links that deformable bodies do not feel do not count, nor do parts of a ram that stay behind what meets `body`.
    """
    if copy.shape is not None and copy.shape.kind == "compound" and facts.mount(copy) == "slider":
        return _front(facts, copy, body), None, {}
    if copy.shape is not None and copy.shape.kind != "plane":
        return thickness(copy.shape, facts.folder), None, {}
    unfelt = unfelt_links(copy.model)
    sizes: dict[str | None, float] = {}
    for part in facts.parts(copy):
        if part.link not in unfelt:
            sizes[part.link] = min(part.thickness, sizes.get(part.link, math.inf))
    if not sizes:
        return math.inf, None, {}
    thinnest = min(sizes, key=lambda link: sizes[link])
    return sizes[thinnest], thinnest, {name: size for name, size in sizes.items() if name and name != thinnest}


def _front(facts: Facts, copy: Copy, body: SoftBody) -> float:
    """Return the smallest thickness [m] of the solid parts of a compound that are nearest to a body, within a cell."""
    gaps: dict[str | None, float] = {}
    for part in facts.parts(copy):
        sides = zip(*part.box, *body.box, strict=True)
        size = math.hypot(*(max(low - high, least - most, 0.0) for least, high, low, most in sides))
        gaps[part.piece.part] = min(size, gaps.get(part.piece.part, math.inf))
    solids = copy.shape.solids
    nearest = min(gaps.values()) + facts.once(SoftFacts).cell
    return min(thickness(solids[name].shape, facts.folder) for name, size in gaps.items() if size <= nearest)


def _is_post(piece: Piece) -> bool:
    """Return whether a piece is thin in two directions, so that it holds nothing up."""
    if piece.kind in ("cylinder", "capsule"):
        return 2 * piece.size[0] < piece.size[1]
    sizes = sorted(piece.size)
    return piece.kind == "box" and sizes[1] < 2 * sizes[0]


def _wanted_cells(facts: Facts, copy: Copy, body: Any) -> tuple[float, str, str]:
    """Return how many cells thick a rigid copy should be beside an mpm body, why, and what the body does otherwise."""
    mount, then = facts.mount(copy), LEAKS if body.kind in FLOWING else PUSHED
    held_up = body.kind == "liquid" and holds_up(
        one.kind for one in facts.plan.deformables.values() if one.solver == "mpm"
    )
    moved = "it is driven" if mount == "driven" else "a motor moves it"
    spans = [span for (name, _), some in spans_of(facts).items() if name == copy.name for span in some]
    if mount == "driven" or any(span.moves for span in spans):
        if getattr(body.material, "tear_stretch", None) is not None:
            least, more = CUTTING_CELLS
            return least + more * (body.material.tear_stretch - 1), moved, CLOSES
        if held_up and mount != "driven":
            return MOVED_CELLS, moved, then
        return PUSHING_CELLS if body.kind in FLOWING else LOADED_WALL_CELLS, moved, then
    if not facts.moves(copy) or spans:  # motors that only hold it
        if body.kind in FLOWING:
            if any(not _is_post(part.piece) for part in facts.parts(copy)):
                return HELD_UP_CELLS if held_up else HOLDING_CELLS, "the grid does not see thinner walls", SINKS
            return LEAKING_CELLS, "particles pass through thinner posts", then
        return HIT_WALL_CELLS, "soft bodies that hit thinner walls pass through them", then
    if mount == "tree":  # what passes through thin limbs and ropes is not visible
        return 0.0, "", then
    if held_up:
        return MOVED_CELLS, "the body presses on it", then
    return ON_TOP, "it may lie on the body" if facts.free(copy) else "the body presses on it", then


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
            f"`{body.name}` gets stuck in it; use a radius of {length_of_at_least(MIN_NECK_CELLS * soft.cell)}, or "
            f"`scene.mpm.cell` {at_most(radius / MIN_NECK_CELLS)}"
        )
        yield facts.problem("narrow-opening", facts.first_given(copy.body, "shape"), text, key=True)


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
        title="A wall or plate is too thin, and mpm bodies pass through it.",
        reason=f"""\
The mpm grid detects rigid bodies only at its nodes. Measured with a piston on soft cubes, of 1668 particles: 440 passed
a plate of 1.3 cells, 164 one of 1.9; 40 were some millimetres in one of 2.9, and none passed one of 5. A body that a
motor or a prescribed motion presses on soft bodies should be {LOADED_WALL_CELLS:g} cells thick, and is an error below
{LEAKING_WALL_CELLS:g}; a body on top of them {ON_TOP:g}; a wall that soft bodies may hit {HIT_WALL_CELLS:g}: at 4 m/s a
cube passed through 1.2 cells. Particles of liquids, grains and snow are moved out of rigid bodies, so that they do not
leak through {LEAKING_CELLS:g} cells. Liquids also rest on the nodes at walls: {HELD_UP_CELLS:g} cells
hold their level, and {MOVED_CELLS:g} if they are free or on a joint. With grains or snow in the scene, no node
is stopped between walls of a cell or less:
pressure holds nothing up there, and what they contain falls into itself. Such walls need {HOLDING_CELLS:g} cells,
and {PUSHING_CELLS:g} if they push. What is driven
through a body with a `tear_stretch` cuts it with `1.5 + 5 (tear_stretch - 1)` cells; the body closes behind less.""",
        remedy="""\
Make it thicker (or use a `compound` of a thick part with `look: {visible: false}` and a thin one, flush inside, with
`decor: true`), or make the grid finer with `scene.mpm.cell`; half the cell takes sixteen times as long.""",
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
        id="narrow-opening",
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
