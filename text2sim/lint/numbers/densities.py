"""Densities that no material has, usually because of a wrong unit."""

from collections.abc import Iterator
from typing import Any

from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.numbers.magnitudes import kinds_of
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Articulated
from text2sim.spec_schema.text.document import Path

SOLID_DENSITIES = (20.0, 23_000.0)
"""Densities [kg/m3] of solids: from styrofoam to osmium (22,600). In g/cm3 no solid has more than 23."""
MASS_DENSITIES = (0.05, 30_000.0)
"""Densities [kg/m3] that a `mass` may give, with a margin for approximate shapes."""
SOFT_DENSITIES = {
    "soft": (5.0, 23_000.0, "solid (rubber has 1100, foam 20 or more)"),
    "granular": (20.0, 23_000.0, "heap (sand has 1600)"),
    "liquid": (50.0, 20_000.0, "liquid (petrol has 700, water 1000, mercury 13,500)"),
    "snow": (10.0, 1000.0, "snow (fresh snow has 100, ice 917)"),
    "cloth": (0.002, 30.0, "cloth (a shirt has 0.15, canvas 0.5, a carpet 3)"),
}
"""Densities of deformable bodies [kg/m3], of cloth [kg/m2], and materials that have them."""
MAX_GAS_DENSITY = 1.5
"""Largest density [kg/m3] of a part that represents air."""
MAX_MASS_DENSITY = 1e5
"""Largest density [kg/m3] from a `mass`: a small body may represent a heavy one."""


def _density(facts: Facts) -> Iterator[Problem]:
    for name in facts.case.bodies:
        yield from _masses(facts, name)
    for name, body in facts.case.bodies.items():
        if is_soft(body):
            yield from _deforming(facts, name, body)
            continue
        where: Path = ("bodies", name)
        for place, density in _densities(facts.value_at(where), where):
            low = MASS_DENSITIES[0] if "parts" in place and density <= MAX_GAS_DENSITY else SOLID_DENSITIES[0]
            if not low <= density <= SOLID_DENSITIES[1]:
                yield _unlikely_density(facts, place, density)


def _deforming(facts: Facts, name: str, body: Any) -> Iterator[Problem]:
    """Check the density of a deformable body, or the area density of a cloth."""
    key, unit, power = ("area_density", "kg/m2", 2) if body.kind == "cloth" else ("density", "kg/m3", 3)
    where = facts.where(name, "material", key)
    value, (low, high, known) = getattr(body.material, key), SOFT_DENSITIES[body.kind]
    if low <= value <= high or facts.value_at(where) is None:
        return
    text = f"no {known} has {'an area density' if power == 2 else 'a density'} of {value:g} {unit}"
    meant, other = (1000 * value, "g/cm3") if value < low else (value / 1000, f"g/m{power}")
    if (power == 2 and value < low) or not low <= meant <= high:
        yield facts.problem("implausible-density", where, text)
    else:
        text += f": {value:g} {other} are {meant:g} {unit}"
        yield facts.problem("implausible-density", where, text, hint=f"{meant:g}")


def _unlikely_density(facts: Facts, where: Path, density: float) -> Problem:
    """Return the problem, with the probable density if the value looks like g/cm3 or g/m3."""
    text = f"no solid has a density of {density:g} kg/m3"
    meant, unit = (1000 * density, "g/cm3") if density < SOLID_DENSITIES[0] else (density / 1000, "g/m3")
    known = "styrofoam has 20" if density < SOLID_DENSITIES[0] else "osmium, the densest, has 22,600"
    if SOLID_DENSITIES[0] <= meant <= SOLID_DENSITIES[1]:
        return facts.problem(
            "implausible-density", where, f"{text} ({known}): {density:g} {unit} are {meant:g} kg/m3", hint=f"{meant:g}"
        )
    return facts.problem("implausible-density", where, f"{text} ({known}); water has 1000, steel 7800")


def _masses(facts: Facts, name: str) -> Iterator[Problem]:
    """Check the masses of a body and its links over their volumes: in grams, one is a thousand times too dense."""
    body = facts.case.bodies[name]
    mass = getattr(getattr(body, "material", None), "mass", None)
    if body.kind == "rigid" and mass is not None:
        # A prefab may give the mass.
        where = facts.first_path(facts.where(name, "material", "mass"), facts.where(name))
        for copy in kinds_of(facts, name):
            text = _mass_text(
                copy.name, facts.masses[copy.name], sum(part.piece.volume() for part in facts.parts(copy))
            )
            if text:
                yield facts.problem("implausible-density", where, text)
                break
    tree = facts.tree(facts.placed[name][0])
    if isinstance(body, Articulated) and body.links is not None and tree is not None:
        for link in tree.links():
            material = body.links[link.name].material
            where = facts.where(name, "links", link.name, "material", "mass")
            if material is None or material.mass is None or facts.value_at(where) is None:
                continue
            text = _mass_text(f"{name}.{link.name}", material.mass, sum(geom.piece.volume() for geom in link.geoms))
            if text:
                yield facts.problem("implausible-density", where, text)


def _mass_text(name: str, mass: float, volume: float) -> str:
    """Return why a mass [kg] in a volume [m3] is implausible; empty if it is not."""
    if volume <= 0.0 or MASS_DENSITIES[0] <= mass / volume <= MAX_MASS_DENSITY:
        return ""
    density = mass / volume
    shown = f"{float(f'{density:.3g}'):,.0f}" if 1e3 <= density < 1e12 else f"{density:.3g}"
    text = (
        f"{mass:g} kg in the {_litres(volume)} of `{name}` are {shown} kg/m3, which no material has (steel has 7800); "
        "masses are in kilograms, lengths in metres"
    )
    if density > MAX_MASS_DENSITY and density / 1000 <= MASS_DENSITIES[1]:
        text += f": {mass:g} g are {mass / 1000:g} kg"
    return text


def _litres(volume: float) -> str:
    """Return a volume [m3] with a suitable unit."""
    if volume >= 1.0:
        return f"{volume:.3g} m3"
    return f"{volume * 1e3:.3g} l" if volume >= 1e-4 else f"{volume * 1e6:.3g} cm3"


def _densities(value: object, where: Path) -> Iterator[tuple[Path, float]]:
    """Yield every `density` inside some data, with its path."""
    if isinstance(value, dict):
        for key, item in value.items():
            if key == "density" and isinstance(item, int | float):
                yield (*where, key), item
            else:
                yield from _densities(item, (*where, key))


RULES = (
    Rule(
        id="implausible-density",
        title="A density is implausible: it may be in g/cm3.",
        reason=f"""\
Densities are in kg/m3: styrofoam has 20, wood 600, water 1000, steel 7800, osmium 22,600. A rigid body below
{SOLID_DENSITIES[0]:g} or above {SOLID_DENSITIES[1]:g} probably has a wrong unit: 7.8 for steel is in g/cm3, and such a
ball moves nothing that it hits. A part of a compound may have up to {MAX_GAS_DENSITY:g} if it represents the air in a
bottle. A `mass` over the volume of the shape may give {MASS_DENSITIES[0]:g} to {MAX_MASS_DENSITY:g} kg/m3: balloons are
hollow, and a small body may represent a heavy one. Deformable bodies have bounds of their own; for cloth it is the mass
per area, which shops give in g/m2.""",
        remedy="Multiply a density in g/cm3 by 1000; give a `mass` for a hollow body.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {density: 7.8}, place: {on: floor}}
""",
        fix="bodies: {ball: {material: {density: 7800}}}",
        run=_density,
    ),
)
