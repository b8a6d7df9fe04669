"""Bodies in the grid of the material point method: what is too thin, too near, too fast for its cells."""

import math
from collections.abc import Iterator

from text2sim.compiler.soft.settings import wave_speed
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, soft_facts
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.words import at_most, length, more_copies
from text2sim.spec_schema.errors import Problem

COURANT, UNSTABLE = 0.5, 0.7
"""Fraction of a cell that a sound wave may cross in a substep. With 0.74 and 1.0, bars of 10 MPa diverged, with finite
numbers; with 0.3 to 0.9, bars of 1 MPa held for 0.25 s."""
EMPTY = 0.25
"""Thickness [cells] below which a body holds no particle: particles are half a cell apart."""
THIN = 2.2
"""Cells through the thinnest part of a body: strokes of 2.2 cells bent and held."""
NEAR = 2.0
"""Cells between bodies at the start: they touch at 1.6 cells."""


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
            f"({length(soft.cell)}): it tears and keeps no shape; `scene.mpm.cell` {at_most(thin / THIN)} gives it "
            f"{THIN:g}" + (f" (that is {(THIN / cells) ** 4:.2g} times as slow)" if cells > 0 else "")
        )
        if cells < EMPTY:
            text = (
                f"`{body.name}` is {length(thin)} thick at its thinnest, {cells:.2g} cells of the mpm grid "
                f"({length(soft.cell)}): no particle fits into it; make it {length(EMPTY * soft.cell)} thick or more"
            )
        severity = "error" if cells < (1.0 if body.model.kind == "soft" else EMPTY) else None
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
        id="sound-too-fast",
        severity="error",
        title="A time step too long for the stiffness of an mpm body.",
        reason=f"""\
The method is explicit: a sound wave, with c^2 = E (1 - nu) / ((1 + nu) (1 - 2 nu) rho), may cross half a cell in a
substep. At 0.74 and 1.0 cells bars of 10 MPa diverged within a second: all points in a corner of the domain, finite
numbers, no error. The engine's own suggestion looks at the grid alone. More than {COURANT:g} is a warning, more than
{UNSTABLE:g} an error. Without `scene.substeps` enough of them are chosen.""",
        remedy="""\
Leave `scene.substeps` out, or take as many as the message says; or make the material softer, or the grid coarser.""",
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
        fix="scene: {substeps: null}",
        run=_step,
    ),
    Rule(
        id="thin-soft-body",
        severity="warning",
        title="An mpm body is so thin that the grid cannot hold it together.",
        reason=f"""\
A body needs {THIN:g} cells through its thinnest part (letters with such strokes fell, bent and held); with fewer it has
no stiffness of its own against bending, and its parts separate. A soft body thinner than one cell is an error,
and so is any body thinner than a quarter of a cell: it holds no particle.""",
        remedy="Make the grid finer with `scene.mpm.cell`, or the body thicker; or take `solver: fem`.",
        example="""\
bodies:
  mat: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.4, 0.4, 0.03]}, pose: {pos: [0, 0, 0.3]}}
""",
        fix="bodies: {mat: {cell: 0.012}}",
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
        remedy="Leave two cells between bodies, with `clearance`, or more room in `repeat`; or make the grid finer.",
        example="""\
bodies:
  a: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 0.2]}}
  b: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.11, 0, 0.2]}}
""",
        fix="bodies: {b: {pose: {pos: [0.15, 0, 0.2]}}}",
        run=_too_near,
    ),
)
