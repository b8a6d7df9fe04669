"""Deformable bodies out of proportion: too soft to bear their own weight, cut too coarsely to fold."""

import math
from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import soft_facts
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem

FLAT = 1.0
"""Weight of a body on its own foot [Pa] over its stiffness, from which on it is squashed flat by itself."""
USUAL = (3e3, 1e8)
"""Stiffness [Pa] of what is called soft: jelly to hard rubber."""
UNITS, FULL = (("kPa", 1e3), ("MPa", 1e6), ("GPa", 1e9)), 1000.0
"""Units of stiffness [Pa], and the number from which on the next one would have been taken."""
FEW = 8
"""Particles along the longer side of a cloth from which on nothing is said."""


def _collapses(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    gravity = math.hypot(*facts.case.scene.gravity)
    seen = set()
    for body in soft.of("mpm", "fem"):
        material = body.model.material
        key = "stiffness" if body.model.kind == "liquid" else "youngs_modulus"
        stiffness = getattr(material, key)
        height = body.box[1][2] - body.box[0][2]
        weight = material.density * gravity * height
        if body.body in seen or weight <= FLAT * stiffness:
            continue
        seen.add(body.body)
        text = (
            f"`{body.name}` weighs {weight:.2g} Pa on its own foot ({material.density:g} kg/m3, {length(height)} "
            f"high), and its {key} is {stiffness:g} Pa: it is squashed flat by its own weight"
        )
        unit = _meant(stiffness, weight)
        where = facts.where(body.body, "material", key)
        if unit is None:
            text += f"; {10 * weight:.0e} or more would hold it"
            yield facts.problem("squashes-itself", where, text)
        else:
            name, factor = unit
            meant = f"{stiffness * factor:g}"
            text += f"; {stiffness:g} {name} are {meant} Pa"
            yield facts.problem("squashes-itself", where, text, hint=meant)


def _usual(stiffness: float, weight: float) -> bool:
    """Whether something of this stiffness [Pa] is soft, and bears its weight [Pa]."""
    return USUAL[0] <= stiffness <= USUAL[1] and stiffness >= 3 * weight


def _meant(stiffness: float, weight: float) -> tuple[str, float] | None:
    """The unit in which a number may have been given, and how many Pa it is."""
    if stiffness >= FULL:
        return None
    return next((unit for unit in UNITS if _usual(stiffness * unit[1], weight)), None)


def _coarse(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    seen = set()
    for body in soft.of("pbd", "ipc"):
        low, high = body.box
        side = max(b - a for a, b in zip(low, high, strict=True))
        width = min(getattr(body.model.shape, "size", (side,)))
        edge = soft.scales.spacing(body.body, body.solver)
        narrow = width < 0.5 * edge
        if body.model.kind != "cloth" or body.body in seen or (side >= FEW * edge * (1 - 1e-3) and not narrow):
            continue
        seen.add(body.body)
        grain = "particles" if body.solver == "pbd" else "triangles"
        if narrow:
            text = (
                f"`{body.name}` is {length(width)} wide, and its {grain} are {length(edge)} apart: a thread, and no "
                "cloth; make it wider, or take a `rope`"
            )
        else:
            text = (
                f"`{body.name}` is {length(side)} long and has {grain} {length(edge)} apart: {side / edge:.2g} of them "
                f"in a row make a few stiff plates, no cloth; `cell: {side / 25:.2g}` would let it fold"
            )
        yield facts.problem("coarse-cloth", facts.said(body.body, "cell", "shape"), text, key=True)


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
        severity="warning",
        title="A deformable body is too soft to bear its own weight.",
        reason="""\
At the foot of a body of height h stand `density g h` of pressure. Where that is more than its stiffness, the body is
squashed to nothing by its own weight: a jelly of 20 cm needs far more than 2000 Pa. Stiffness is in Pa: 0.05 is what
someone writes who means MPa.""",
        remedy="Give `youngs_modulus` (of a liquid `stiffness`) in Pa: ten times the pressure at its foot, or more.",
        example=_JELLY % "0.05",
        fix=_JELLY % "5.0e+4",
        run=_collapses,
    ),
    Rule(
        id="coarse-cloth",
        severity="warning",
        title="A cloth is made of so few particles that it cannot fold.",
        reason=f"""\
A cloth bends where its triangles meet, and touches things by its corners: between them it is a plate, and what is
smaller than a plate is missed. With solver pbd the distance of its particles is its thickness in contact as well.
Reported below {FEW} of them along its longer side. All pbd cloth of a scene has the same distance.""",
        remedy="Give a smaller `cell`: a twenty-fifth of its side, or less.",
        example=_RAG % "0.1",
        fix=_RAG % "0.02",
        run=_coarse,
    ),
)
