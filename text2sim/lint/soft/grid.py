"""Mpm bodies that are too stiff, too thin or too close together for the grid."""

import math
from collections.abc import Iterator
from itertools import combinations

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.soft.settings import sound_step, wave_speed
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.soft.gaps import Gaps
from text2sim.lint.soft.starts import closest_pairs
from text2sim.lint.start.escape import Effort, overlap_of, overlapping
from text2sim.lint.words import length, length_of_at_least, more_copies
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_most

MAX_COURANT, UNSTABLE_COURANT = 0.5, 0.7
"""Fractions of a cell that a sound wave may cross per substep: with a warning, and with an error. With 0.74 and 1.0,
bars of 10 MPa diverged, with finite numbers; with 0.3 to 0.9, bars of 1 MPa held for 0.25 s."""
EMPTY_CELLS = 0.25
"""Thickness [cells] below which a body contains no particle: particles are half a cell apart."""
MIN_CELLS = 2.2
"""Fewest cells through the thinnest part of a body: strokes of 2.2 cells bent and held."""
MIN_DEPTH, STEP_BUDGET = 1e-5, 4000
"""Smallest depth [m] of an overlap that is not a touch, and budget for finding it."""
STREAM_CELLS = 2.0
"""The same of a stream, which has no shape to keep."""
MIN_GAP_CELLS = 2.0
"""Fewest cells between bodies at the start: they touch at 1.6 cells."""


def _step(facts: Facts) -> Iterator[Problem]:
    """Report the stiffest body."""
    soft = facts.once(SoftFacts)
    h, dt = facts.substep, facts.case.scene.dt
    impact = facts.settings.soft.impact if facts.settings.soft else 0.0
    rows = {body.body: (wave_speed(body.model.material, body.model, h, impact), body) for body in soft.of("mpm")}
    if not rows:
        return
    speed, body = max(rows.values(), key=lambda row: row[0])
    part = speed * h / soft.cell
    if part <= MAX_COURANT * 1.02:
        return
    needed = math.ceil(dt / sound_step(body.model.material, body.model, soft.cell, impact) - 1e-9)
    text = (
        f"sound has a speed of {speed:.3g} m/s in `{body.body}` and crosses {part:.2g} cells of the mpm grid "
        f"({length(soft.cell)}) in a substep of {h:.3g} s: "
        + (
            "it diverges, with finite numbers and no error"
            if part > UNSTABLE_COURANT
            else f"more than {MAX_COURANT:g} may diverge"
        )
        + f"; use scene.substeps of {needed}, or a softer body ({at_most((MAX_COURANT / part) ** 2)} of its stiffness)"
    )
    where = facts.first_path(("scene", "substeps"), ("scene", "dt"), facts.first_given(body.body, "material"))
    yield facts.problem("sound-too-fast", where, text, severity=None if part > UNSTABLE_COURANT else "warning")


def _thin_body(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    seen = set()
    for body in soft.of("mpm"):
        thin = soft.thickness(body)
        least = STREAM_CELLS if body.copy.shape.kind == "stream" else MIN_CELLS
        if body.body in seen or thin >= least * soft.cell * (1 - 1e-6):
            continue
        seen.add(body.body)
        cells = thin / soft.cell
        text = f"`{body.name}` is {length(thin)} thick at its thinnest, {soft.in_cells(thin)}"
        if cells < EMPTY_CELLS:
            text += f", and contains no particle; make it at least {length_of_at_least(EMPTY_CELLS * soft.cell)} thick"
        else:
            then = "it breaks up" if body.model.kind in ("liquid", "granular") else "it tears and keeps no shape"
            text += (
                f": {then}; `scene.mpm.cell` {at_most(thin / least)} gives it "
                f"{least:g} (that is {(least / cells) ** 4:.2g} times as slow)"
            )
        severity = "error" if cells < (1.0 if body.model.kind == "soft" else EMPTY_CELLS) else None
        where = facts.first_path(("scene", "mpm", "cell"), facts.first_given(body.body, "shape"))
        yield facts.problem("thin-soft-body", where, text, key=True, severity=severity)


def _too_near(facts: Facts) -> Iterator[Problem]:
    """Report each pair of mpm bodies that share grid nodes at the start once."""
    soft = facts.once(SoftFacts)
    room = MIN_GAP_CELLS * soft.cell
    merging = ("liquid", "granular")  # portions of one such body may touch
    pairs = ((a, b) for a, b in combinations(soft.of("mpm"), 2) if a.body != b.body or a.model.kind not in merging)
    for pair in closest_pairs(Gaps(facts), pairs, room):
        gap, a, b, count = pair
        depth = 0.0 if gap > 0.0 else _depth(facts, a.copy, b.copy)
        state = f"are {length(gap)} apart" if gap > 0.0 else "touch"
        if depth > MIN_DEPTH:
            state = f"are {length(depth)} inside each other"
        text = (
            f"`{a.name}` and `{b.name}` {state} at the start"
            f"{more_copies(count, 'pairs')}, closer than {MIN_GAP_CELLS:g} cells of the mpm grid "
            f"({length(soft.cell)}): they stay so and stick to each other, as if they were one body; "
            f"move one of them by {length(room - gap + depth)}, or, if one lies on the other to the end, let them "
            "touch and waive this"
        )
        yield facts.problem("soft-too-near", pair.where(facts), text, key=True)


def _depth(facts: Facts, a: Copy, b: Copy) -> float:
    """Return how deep [m] two copies are in each other; 0 if they only touch, or if it takes too long to find."""
    effort = Effort(STEP_BUDGET)
    pairs = [(p, q) for p in facts.parts(a) for q in facts.parts(b) if effort.spend() and overlapping(p, q)]
    return overlap_of(facts.parts(a), facts.parts(b), pairs, effort).depth if pairs and effort.left > 0 else 0.0


RULES = (
    Rule(
        id="sound-too-fast",
        severity="error",
        title="The time step is too long for the stiffness of an mpm body.",
        reason=f"""\
The method is explicit: a sound wave, with c^2 = E (1 - nu) / ((1 + nu) (1 - 2 nu) rho), may cross half a cell per
substep. At 0.74 and 1.0 cells bars of 10 MPa diverged within a second: all points in a corner of the domain, finite
numbers, no error. The engine's own suggestion only considers the grid. More than {MAX_COURANT:g} is a warning, more
than {UNSTABLE_COURANT:g} an error. By default the compiler derives enough substeps.""",
        remedy="""\
Leave `scene.substeps` out, or use as many as the message says; or make the material softer, or the grid coarser.""",
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
        title="An mpm body is too thin for the grid to hold it together.",
        reason=f"""\
A body needs {MIN_CELLS:g} cells through its thinnest part (letters with such strokes fell, bent and held); with fewer
it has no bending stiffness, and its parts separate. A stream needs {STREAM_CELLS:g} cells across. A soft body thinner
than one cell is an error, and so is any body thinner than a quarter of a cell, which contains no particle.""",
        remedy="Make the grid finer with `scene.mpm.cell`, or the body thicker; or use `solver: fem`.",
        example="""\
bodies:
  mat: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.4, 0.4, 0.03]}, pose: {pos: [0, 0, 0.3]}}
""",
        fix="bodies: {mat: {cell: 0.012}}",
        run=_thin_body,
    ),
    Rule(
        id="soft-too-near",
        title="Mpm bodies are so close at the start that they already touch.",
        reason=f"""\
Mpm bodies have contact through their common grid, below a distance of 1.6 cells: two cubes at rest on each other have a
gap of 1.6 cells between their particles. Bodies that start closer than {MIN_GAP_CELLS:g} cells move as one: a cube that
started 0.02, 0.5 or 1 cell above another kept that gap within 0.15 cells.""",
        remedy="""\
Leave two cells between bodies that are to come together or part, with `clearance` or more room in `repeat`; or make the
grid finer. Layers that lie on each other to the end may start without a gap: waive the rule and say so.""",
        example="""\
bodies:
  a: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 0.2]}}
  b: {kind: soft, cell: 0.02, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.11, 0, 0.2]}}
""",
        fix="bodies: {b: {pose: {pos: [0.15, 0, 0.2]}}}",
        run=_too_near,
    ),
)
