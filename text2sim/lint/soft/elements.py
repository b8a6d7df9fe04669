"""Bodies of finite elements: too few elements, too little compressible, models that their solver lacks."""

import math
from collections.abc import Iterator

from text2sim.compiler.shapes.extents import extents
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import soft_facts
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem

ENOUGH = 4.0
"""Elements through the thickness of a bar from which on nothing is said."""
ONE = 1.0
"""Part of its deflection that a bar with n elements through it lacks, times n^1.5. Measured at the tip of a cantilever
(`benchmarks.soft_physics`): 1 element 79 %, 2 36 %, 3 19 %, 4 12 %, 6 7 %."""
MOST = 0.8
"""No bar lacks more."""
SLENDER = 4.0
"""Length over thickness from which on a body is a bar or a plate that bends."""
LOCKING = 0.49
"""Poisson's ratio."""


def _too_stiff(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    seen = set()
    for body in soft.of("fem"):
        if body.body in seen:
            continue
        thin = soft.thickness(body)
        low, high = extents(body.copy.shape, (1.0, 0.0, 0.0, 0.0), facts.folder)
        longest = max(b - a for a, b in zip(low, high, strict=True))
        edge = soft.scales.spacing(body.body, "fem")
        through = thin / edge
        if longest < SLENDER * thin or through >= ENOUGH * (1 - 1e-3):
            continue
        seen.add(body.body)
        lacking = min(MOST, ONE * through**-1.5)
        text = (
            f"`{body.name}` has {through:.2g} elements of {length(edge)} through its thickness of {length(thin)}: "
            f"linear tetrahedra lock, and it bends by about {lacking:.0%} too little; `cell: {thin / ENOUGH:.2g}` "
            f"would leave {ONE * ENOUGH**-1.5:.0%}"
        )
        where = facts.said(body.body, "cell", "shape")
        yield facts.problem("too-few-elements", where, text, key=True)


def _incompressible(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    seen = set()
    for body in soft.of("fem", "mpm"):
        nu = getattr(body.model.material, "poisson_ratio", None)
        if nu is None or nu <= LOCKING or body.body in seen:
            continue
        seen.add(body.body)
        factor = math.sqrt((1 - nu) / ((1 + nu) * (1 - 2 * nu)))
        text = (
            f"a Poisson's ratio of {nu:g} hardly lets `{body.body}` change its volume: "
            + (
                f"sound is {factor:.2g} times as fast as in a bar, and so are the steps that it needs"
                if body.solver == "mpm"
                else "linear tetrahedra lock, and it is many times too stiff"
            )
            + "; 0.45 to 0.49 looks the same"
        )
        where = facts.where(body.body, "material", "poisson_ratio")
        yield facts.problem("nearly-incompressible", where, text)


def _model(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    seen = set()
    for body in soft.of("fem"):
        model = body.model.material.model
        if body.body in seen or model not in ("neo_hookean", "elasto_plastic"):
            continue
        if model == "neo_hookean" and soft.model == "ipc":
            continue
        seen.add(body.body)
        text = (
            f"`{body.body}` has model {model}, which the implicit fem solver lacks: it would be computed as `elastic` "
            "(corotated); leave the model out, or take `solver: mpm`"
        )
        where = facts.where(body.body, "material", "model")
        yield facts.problem("no-such-model", where, text)


RULES = (
    Rule(
        id="too-few-elements",
        severity="warning",
        title="A bar or plate has too few elements through its thickness, and is too stiff.",
        reason=f"""\
Linear tetrahedra lock in bending. Measured at the tip of a cantilever of 0.3 m by 60 mm, against Euler and Bernoulli
with shear: 1 element through the thickness lacks 79 % of the deflection, 2 lack 36 %, 3 lack 19 %, 4 lack 12 %, 6 lack
7 %: n elements about 1 over n to the power of 1.5. Reported below {ENOUGH:g}, for bodies {SLENDER:g} times as long as
thick.""",
        remedy="""\
Give the `cell` that the message names (half of it is about ten times as slow), or take `solver: mpm`.""",
        example="""\
bodies:
  bar:
    kind: soft
    solver: fem
    cell: 0.03
    shape: {kind: box, size: [0.5, 0.06, 0.06]}
    pose: {pos: [0, 0, 0.5]}
""",
        fix="bodies: {bar: {cell: 0.015}}",
        run=_too_stiff,
    ),
    Rule(
        id="nearly-incompressible",
        severity="warning",
        title="A Poisson's ratio so near to 0.5 that the method fails.",
        reason="""\
Towards 0.5 the stiffness against a change of volume goes to infinity. Linear tetrahedra then lock altogether; particles
on a grid need steps as short as the speed of sound is high: 4 times as short at 0.49, 13 times at 0.499.""",
        remedy="Take 0.45 to 0.49: rubber is not seen to differ.",
        example="""\
bodies:
  rubber:
    kind: soft
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    material: {poisson_ratio: 0.4995}
    pose: {pos: [0, 0, 0.3]}
""",
        fix="bodies: {rubber: {material: {poisson_ratio: 0.48}}}",
        run=_incompressible,
    ),
    Rule(
        id="no-such-model",
        severity="error",
        title="A material model that the solver of the body lacks.",
        reason="""\
The engine's explicit fem solver has a neo-Hookean model, but it diverges at steps that anyone can pay for (a box of
0.1 MPa at 0.2 ms: 77 m away after one step, then a crash of the process); so soft bodies of solver fem are solved
implicitly, and the implicit solver has none. Under contact model ipc every soft body is neo-Hookean anyway.""",
        remedy="Leave `model` out, or take `solver: mpm`, which has both.",
        example="""\
bodies:
  rubber:
    kind: soft
    solver: fem
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    material: {model: neo_hookean}
    pose: {pos: [0, 0, 0.3]}
""",
        fix="bodies: {rubber: {solver: mpm}}",
        run=_model,
    ),
)
