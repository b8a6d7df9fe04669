"""Deformable bodies that are too soft for their weight, or too coarse to fold."""

from collections.abc import Iterator

from text2sim.compiler.shapes.boxes import sides
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem

MAX_PRESSURE_RATIO = 1.0
"""Smallest pressure of a body's weight on its base over its stiffness at which it collapses."""
USUAL_STIFFNESS = (3e3, 1e8)
"""Stiffness [Pa] of soft materials: jelly to hard rubber."""
STIFFNESS_UNITS, FULL = (("kPa", 1e3), ("MPa", 1e6), ("GPa", 1e9)), 1000.0
"""Units of stiffness [Pa], and the value from which the next unit is usual."""
MIN_CLOTH_PARTICLES = 8
"""Fewest particles along the longer side of a cloth without a warning."""


@first_per_place
def _collapses(facts: Facts) -> Iterator[Problem]:
    for body in facts.once(SoftFacts).of("mpm", "fem"):
        material = body.model.material
        key = "stiffness" if body.model.kind == "liquid" else "youngs_modulus"
        stiffness = getattr(material, key)
        height = sides(body.box)[2]
        weight = material.density * facts.pull * height
        if weight <= MAX_PRESSURE_RATIO * stiffness:
            continue
        text = (
            f"the weight of `{body.name}` puts {weight:.2g} Pa on its base ({material.density:g} kg/m3, "
            f"{length(height)} high), but its {key} is {stiffness:g} Pa: it collapses under its own weight"
        )
        unit = _probable_unit(stiffness, weight)
        where = facts.where(body.body, "material", key)
        if unit is None:
            text += f"; use {10 * weight:.0e} or more"
            yield facts.problem("squashes-itself", where, text)
        else:
            name, factor = unit
            meant = f"{stiffness * factor:g}"
            text += f"; {stiffness:g} {name} are {meant} Pa"
            yield facts.problem("squashes-itself", where, text, hint=meant)


def _is_usual(stiffness: float, weight: float) -> bool:
    """Return whether a stiffness [Pa] is usual and carries the weight [Pa]."""
    return USUAL_STIFFNESS[0] <= stiffness <= USUAL_STIFFNESS[1] and stiffness >= 3 * weight


def _probable_unit(stiffness: float, weight: float) -> tuple[str, float] | None:
    """Return the unit in which a stiffness may be given, and its value in Pa."""
    if stiffness >= FULL:
        return None
    return next((unit for unit in STIFFNESS_UNITS if _is_usual(stiffness * unit[1], weight)), None)


@first_per_place
def _coarse(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    for body in soft.of("pbd", "ipc"):
        side = max(sides(body.box))
        width = min(getattr(body.model.shape, "size", (side,)))
        edge = soft.scales.spacing(body.body, body.solver)
        narrow = width < 0.5 * edge
        if body.model.kind != "cloth" or (side >= MIN_CLOTH_PARTICLES * edge * (1 - 1e-3) and not narrow):
            continue
        grain = "particles" if body.solver == "pbd" else "triangles"
        if narrow:
            text = (
                f"`{body.name}` is {length(width)} wide, and its {grain} are {length(edge)} apart: it is a thread, not "
                "a cloth; make it wider, or use a `rope`"
            )
        else:
            text = (
                f"`{body.name}` is {length(side)} long and has {grain} {length(edge)} apart: {side / edge:.2g} of them "
                f"in a row make stiff plates that do not fold; use `cell: {side / 25:.2g}`"
            )
        yield facts.problem("coarse-cloth", facts.first_given(body.body, "cell", "shape"), text, key=True)


_JELLY = """\
bodies:
  jelly:
    kind: soft
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    material: {youngs_modulus: %s}
    pose: {pos: [0, 0, 0.3]}
"""
_RAG = """\
bodies:
  rag: {kind: cloth, cell: %s, shape: {kind: sheet, size: [0.5, 0.5]}, pose: {pos: [0, 0, 1]}}
"""

RULES = (
    Rule(
        id="squashes-itself",
        title="A deformable body is too soft to carry its own weight.",
        reason="""\
The pressure at the base of a body of height h is `density g h`. If that exceeds its stiffness, the body collapses under
its own weight: a jelly of 20 cm needs far more than 2000 Pa. Stiffness is in Pa; a value like 0.05 is probably in
MPa.""",
        remedy="Give `youngs_modulus` (for a liquid `stiffness`) in Pa: at least ten times the pressure at the base.",
        example=_JELLY % "0.05",
        fix=_JELLY % "5.0e+4",
        run=_collapses,
    ),
    Rule(
        id="coarse-cloth",
        title="A cloth has too few particles to fold.",
        reason=f"""\
A cloth bends where its triangles meet, and has contact at their corners: between them it is a plate that misses smaller
bodies. With solver pbd the distance of its particles is also its thickness in contact. The rule reports fewer than
{MIN_CLOTH_PARTICLES} particles along its longer side. All pbd cloth of a scene has the same distance.""",
        remedy="Use a smaller `cell`: a twenty-fifth of its side, or less.",
        example=_RAG % "0.1",
        fix=_RAG % "0.02",
        run=_coarse,
    ),
)
