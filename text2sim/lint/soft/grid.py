"""Bodies in the grid of the material point method: what is too thin, too near, too fast for its cells."""

import math
from collections.abc import Iterator
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.soft.settings import wave_speed
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, SoftFacts, soft_facts
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.words import length, more_copies
from text2sim.spec_schema.errors import Problem

LOADED, LEAKING, STILL = 3.0, 2.0, 1.0
"""Thickness in cells of a wall: one that is pressed should have the first, must have the second; one that only stands
there should have the third. Measured at a load of 65 to 90 N on 31 cm2: of 1668 particles 440 passed a plate of 1.3
cells, 164 one of 1.9, 40 were some millimetres in one of 2.9, none passed one of 5. Standing walls of 1 to 1.3 cells
never leaked."""
COURANT, UNSTABLE = 0.5, 0.7
"""Part of a cell that a sound wave may cross in a substep; at 0.74 and 1.0 bars of 10 MPa diverged, with finite
numbers, while 0.3 to 0.9 held for 0.25 s at 1 MPa."""
THIN = 2.2
"""Cells through a body: strokes of 2.2 cells bent and held."""
NEAR = 2.0
"""Cells between bodies at the start: they touch at 1.6 cells."""
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
            f"`scene.mpm.cell` {_smaller(thin / wanted)}"
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
    return NEAR, "it is free to lie on the body"


def _smaller(value: float) -> str:
    """A number of two digits that is no larger."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.floor(value / digit + 1e-9) * digit:.2g}"


def _narrow(facts: Facts) -> Iterator[Problem]:
    """One finding for each funnel or tube through which an mpm body hardly gets."""
    soft = soft_facts(facts)
    seen = set()
    for body, copy in soft.pairs("mpm"):
        radius = _opening(copy.shape)
        if radius is None or copy.body in seen or radius >= NECK * soft.cell * (1 - 1e-6):
            continue
        seen.add(copy.body)
        text = (
            f"the opening of `{copy.name}` has a radius of {length(radius)}, {radius / soft.cell:.2g} cells of the mpm "
            f"grid ({length(soft.cell)}): `{body.name}` gets stuck in it; a radius of {length(NECK * soft.cell)}, or "
            f"`scene.mpm.cell` {_smaller(radius / NECK)}, lets it through"
        )
        yield facts.problem("narrow-opening", facts.said(copy.body, "shape"), text, key=True)


def _opening(shape: Any) -> float | None:
    """Radius [m] of the narrowest hole through a shape, if it has one."""
    kind = getattr(shape, "kind", None)
    if kind == "funnel":
        return min(shape.top_radius, shape.bottom_radius)
    if kind == "tube":
        return shape.inner_radius
    if kind == "torus":
        return shape.radius - shape.bar_radius
    if kind == "compound":
        return min((r for part in shape.parts.values() if (r := _opening(part.shape)) is not None), default=None)
    return None


def _step(facts: Facts) -> Iterator[Problem]:
    """One finding: for the stiffest body."""
    soft = soft_facts(facts)
    rows = {body.body: (wave_speed(body.model.material, body.model), body) for body in soft.of("mpm")}
    if not rows:
        return
    speed, body = max(rows.values(), key=lambda row: row[0])
    h, dt = facts.substep, facts.case.scene.dt
    part = speed * h / soft.cell
    if part <= COURANT * 1.02:
        return
    needed = math.ceil(dt * speed / (COURANT * soft.cell) - 1e-9)
    text = (
        f"sound runs at {speed:.3g} m/s in `{body.body}` and crosses {part:.2g} cells of the mpm grid "
        f"({length(soft.cell)}) in a substep of {h:.3g} s: "
        + ("it diverges, with finite numbers and no error" if part > UNSTABLE else f"more than {COURANT:g} may diverge")
        + f"; scene.substeps of {needed} would do, or a softer body ({(COURANT / part) ** 2:.2g} of its stiffness)"
    )
    where = next(
        (path for path in (("scene", "substeps"), ("scene", "dt")) if facts.raw(path) is not None),
        facts.said(body.body, "material"),
    )
    yield facts.problem("sound-too-fast", where, text, severity=None if part > UNSTABLE else "warning")


def _thin_body(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    seen = set()
    for body in soft.of("mpm"):
        thin = soft.thickness(body)
        if body.body in seen or thin >= THIN * soft.cell * (1 - 1e-6):
            continue
        seen.add(body.body)
        cells = thin / soft.cell
        text = (
            f"`{body.name}` is {length(thin)} thick at its thinnest, {cells:.2g} cells of the mpm grid "
            f"({length(soft.cell)}): it tears and keeps no shape; `scene.mpm.cell` {_smaller(thin / THIN)} gives it "
            f"{THIN:g}" + (f" (that is {(THIN / cells) ** 4:.2g} times as slow)" if cells > 0 else "")
        )
        severity = "error" if cells < 1.0 and body.model.kind == "soft" else None
        where = ("scene", "mpm", "cell") if facts.case.scene.mpm.cell is not None else facts.said(body.body, "shape")
        yield facts.problem("thin-soft-body", where, text, key=True, severity=severity)


def _too_near(facts: Facts) -> Iterator[Problem]:
    """One finding for each pair of mpm bodies whose grid nodes are shared at the start."""
    soft = soft_facts(facts)
    bodies, room, gaps = soft.of("mpm"), NEAR * soft.cell, Gaps(facts)
    found: dict[tuple[str, str], list[tuple[float, SoftBody, SoftBody]]] = {}
    for k, a in enumerate(bodies):
        for b in bodies[k + 1 :]:
            gap = gaps.between(a.copy, b.copy, room)
            if gap < room * (1 - 1e-3) and not (a.body == b.body and a.model.kind in ("liquid", "granular")):
                found.setdefault((a.body, b.body), []).append((gap, a, b))
    for rows in found.values():
        gap, a, b = min(rows, key=lambda row: row[0])
        text = (
            f"`{a.name}` and `{b.name}` are "
            + (f"{length(gap)} apart" if gap > 0 else "inside each other")
            + f" at the start{more_copies(len(rows), 'pairs')}, "
            f"less than {NEAR:g} cells of the mpm grid ({length(soft.cell)}): they push each other away at once"
            + (", and stick" if gap <= 0 else "")
            + f"; {length(room - max(gap, 0.0))} more between them would do"
        )
        where = (
            facts.said(a.body, "repeat", "place", "pose") if a.body == b.body else facts.said(b.body, "place", "pose")
        )
        yield facts.problem("soft-too-near", where, text, key=True)


RULES = (
    Rule(
        id="thin-wall",
        severity="warning",
        title="A wall or plate is so thin that particles leak through it.",
        reason=f"""\
The grid of mpm bodies feels rigid ones at its nodes only. Measured with a piston on soft cubes, of 1668 particles: 440
passed a plate of 1.3 cells, 164 one of 1.9; 40 were some millimetres in one of 2.9, and none passed one of 5. What a
motor or a prescribed motion presses on mpm bodies should be {LOADED:g} cells thick, and is an error below {LEAKING:g};
what lies on them {NEAR:g}; what stands still {STILL:g}.""",
        way_out="""\
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
        mended="""\
bodies:
  jelly: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.11]}}
  press:
    kind: driven
    shape: {kind: cylinder, radius: 0.15, height: 0.08}
    pose: {pos: [0, 0, 0.27]}
    motion: {kind: oscillate, axis: z, amplitude: 0.1, frequency: 0.5}
""",
        run=_thin_wall,
    ),
    Rule(
        id="narrow-opening",
        severity="warning",
        title="An opening is so narrow that the grid closes it.",
        reason=f"""\
Particles feel a wall from half a cell away. Sand ran steadily through a neck with a radius of 2.6 cells; a soft body
went through tubes of 3.8 cells. Below {NECK:g} cells of radius flow is slow or stops, whatever the material.""",
        way_out="Make the opening wider, or the grid finer with `scene.mpm.cell`.",
        example="""\
scene:
  statics:
    funnel:
      shape: {kind: funnel, top_radius: 0.2, bottom_radius: 0.03, height: 0.2, thickness: 0.03}
      pose: {pos: [0, 0, 0.3]}
bodies:
  sand: {kind: granular, cell: 0.02, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.65]}}
""",
        mended="""\
scene:
  statics:
    funnel:
      shape: {kind: funnel, top_radius: 0.2, bottom_radius: 0.08, height: 0.2, thickness: 0.03}
      pose: {pos: [0, 0, 0.3]}
bodies:
  sand: {kind: granular, cell: 0.02, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.65]}}
""",
        run=_narrow,
    ),
    Rule(
        id="sound-too-fast",
        severity="error",
        title="A time step too long for the stiffness of an mpm body.",
        reason=f"""\
The method is explicit: a sound wave, with c^2 = E (1 - nu) / ((1 + nu) (1 - 2 nu) rho), may cross half a cell in a
substep. At 0.74 and 1.0 cells bars of 10 MPa diverged within a second: all points in a corner of the domain, finite
numbers, no error. The engine's own suggestion looks at the grid alone. More than {COURANT:g} is a warning, more than
{UNSTABLE:g} an error. Without `scene.substeps` they are chosen so that it holds.""",
        way_out="""\
Leave `scene.substeps` out, or take as many as the message says; or a softer material, or a coarser grid.""",
        example="""\
scene: {dt: 0.004, substeps: 4}
bodies:
  rubber:
    kind: soft
    cell: 0.02
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    material: {youngs_modulus: 1.0e+6}
    pose: {pos: [0, 0, 0.3]}
""",
        mended="""\
scene: {dt: 0.004}
bodies:
  rubber:
    kind: soft
    cell: 0.02
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    material: {youngs_modulus: 1.0e+6}
    pose: {pos: [0, 0, 0.3]}
""",
        run=_step,
    ),
    Rule(
        id="thin-soft-body",
        severity="warning",
        title="An mpm body is so thin that the grid cannot hold it together.",
        reason=f"""\
A body needs {THIN:g} cells through its thinnest part (letters with such strokes fell, bent and held); with fewer it has
no stiffness of its own against bending, and its parts separate. A soft body thinner than one cell is an error.""",
        way_out="Make the grid finer with `scene.mpm.cell`, or the body thicker; or take `solver: fem`.",
        example="""\
bodies:
  mat: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.4, 0.4, 0.03]}, pose: {pos: [0, 0, 0.3]}}
""",
        mended="""\
bodies:
  mat: {kind: soft, cell: 0.012, shape: {kind: box, size: [0.4, 0.4, 0.03]}, pose: {pos: [0, 0, 0.3]}}
""",
        run=_thin_body,
    ),
    Rule(
        id="soft-too-near",
        severity="warning",
        title="Mpm bodies are so near each other at the start that they touch already.",
        reason=f"""\
Mpm bodies touch through the grid that they share, from 1.6 cells on: two cubes at rest on each other have a gap of 1.6
cells between their particles. What starts nearer than {NEAR:g} cells pushes itself apart in the first steps, or moves
as one; what starts inside each other sticks.""",
        way_out="Leave two cells between bodies, with `clearance`, or more room in `repeat`; or make the grid finer.",
        example="""\
bodies:
  a: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 0.2]}}
  b: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.11, 0, 0.2]}}
""",
        mended="""\
bodies:
  a: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 0.2]}}
  b: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.15, 0, 0.2]}}
""",
        run=_too_near,
    ),
)
