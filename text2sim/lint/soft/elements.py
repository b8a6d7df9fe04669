"""Bodies of finite elements: too few elements, nearly incompressible, or with an unsupported model."""

import math
from collections.abc import Iterator

from text2sim.compiler.shapes.boxes import sides
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_most

MIN_ELEMENTS = 4.0
"""Fewest elements through the thickness of a bar without a warning."""
ONE_ELEMENT_ERROR = 1.0
"""Missing share of the deflection of a bar with n elements through it, times n^1.5. Measured at the tip of a cantilever
(`benchmarks.soft_physics`): 1 element 79 %, 2 36 %, 3 19 %, 4 12 %, 6 7 %."""
MAX_MISSING_SHARE = 0.8
"""Largest missing share."""
MIN_SLENDERNESS = 4.0
"""Smallest length over thickness of a bar or a plate that bends."""
MAX_POISSON = 0.49
"""Largest Poisson's ratio without a warning."""


@first_per_place
def _too_stiff(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    for body in soft.of("fem"):
        thin = soft.thickness(body)
        longest = max(sides(extents(body.copy.shape, IDENTITY, facts.folder)))
        edge = soft.scales.spacing(body.body, "fem")
        through = thin / edge
        if longest < MIN_SLENDERNESS * thin or through >= MIN_ELEMENTS * (1 - 1e-3):
            continue
        lacking = min(MAX_MISSING_SHARE, ONE_ELEMENT_ERROR * through**-1.5)
        text = (
            f"`{body.name}` has {through:.2g} elements of {length(edge)} through its thickness of {length(thin)}: "
            f"linear tetrahedra lock, and it bends by about {lacking:.0%} too little; with `cell: "
            f"{at_most(thin / MIN_ELEMENTS)}` it is {ONE_ELEMENT_ERROR * MIN_ELEMENTS**-1.5:.0%}"
        )
        where = facts.first_given(body.body, "cell", "shape")
        yield facts.problem("too-few-elements", where, text, key=True)


@first_per_place
def _incompressible(facts: Facts) -> Iterator[Problem]:
    for body in facts.once(SoftFacts).of("fem", "mpm"):
        nu = getattr(body.model.material, "poisson_ratio", None)
        if nu is None or nu <= MAX_POISSON:
            continue
        factor = math.sqrt((1 - nu) / ((1 + nu) * (1 - 2 * nu)))
        then = "linear tetrahedra lock, and it is many times too stiff"
        if body.solver == "mpm":
            then = f"sound is {factor:.2g} times as fast as in a bar, so it needs as many times shorter steps"
        text = f"a Poisson's ratio of {nu:g} hardly lets `{body.body}` change its volume: {then}; use 0.45 to 0.49"
        where = facts.where(body.body, "material", "poisson_ratio")
        yield facts.problem("nearly-incompressible", where, text)


@first_per_place
def _model(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    for body in soft.of("fem"):
        model = body.model.material.model
        if model not in ("neo_hookean", "elasto_plastic") or (model == "neo_hookean" and soft.model == "ipc"):
            continue
        text = (
            f"`{body.body}` has model {model}, which the implicit fem solver does not support: it would use `elastic` "
            "(corotated); leave the model out, or use `solver: mpm`"
        )
        where = facts.where(body.body, "material", "model")
        yield facts.problem("no-such-model", where, text)


RULES = (
    Rule(
        id="too-few-elements",
        title="A bar or plate has too few elements through its thickness, and is too stiff.",
        reason=f"""\
Linear tetrahedra lock in bending. Measured at the tip of a cantilever of 0.3 m by 60 mm, against Euler-Bernoulli theory
with shear: with 1 element through the thickness 79 % of the deflection is missing, with 2 36 %, 3 19 %, 4 12 %, 6 7 %:
with n elements about 1 over n to the power of 1.5. The rule reports fewer than {MIN_ELEMENTS:g}, for bodies
{MIN_SLENDERNESS:g} times as long as thick.""",
        remedy="""\
Use the `cell` of the message (half of it is about ten times as slow), or `solver: mpm`.""",
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
        title="A Poisson's ratio is so close to 0.5 that the method fails.",
        reason="""\
Towards 0.5 the bulk modulus goes to infinity. Linear tetrahedra then lock entirely; particles on a grid need shorter
steps, because the speed of sound grows: 4 times as short at 0.49, 13 times at 0.499.""",
        remedy="Use 0.45 to 0.49: for rubber the difference is not visible.",
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
        title="The solver of a body does not support its material model.",
        reason="""\
The engine's explicit fem solver has a neo-Hookean model, but it diverges at affordable steps (a box of 0.1 MPa at
0.2 ms: 77 m away after one step, then a crash of the process). So soft bodies of solver fem use the implicit solver,
which has none. Under contact model ipc every soft body is neo-Hookean.""",
        remedy="Leave `model` out, or use `solver: mpm`, which has both.",
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
