"""Densities of no material: most often the slip of a unit."""

from collections.abc import Iterator
from typing import Any

from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.numbers.magnitudes import kinds_of
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Articulated
from text2sim.spec_schema.text.document import Path

SOLID = (20.0, 23_000.0)
"""Densities [kg/m3] of what is solid: from styrofoam to osmium (22,600). In g/cm3 no solid has more than 23."""
MATTER = (0.05, 30_000.0)
"""The same of anything at all: what a `mass` comes to, with room for shapes that are only near."""
DEFORMING = {
    "soft": (5.0, 23_000.0, "solid (rubber has 1100, foam 20 or more)"),
    "granular": (20.0, 23_000.0, "heap (sand has 1600)"),
    "liquid": (50.0, 20_000.0, "liquid (petrol has 700, water 1000, mercury 13,500)"),
    "snow": (10.0, 1000.0, "snow (fresh snow has 100, ice 917)"),
    "cloth": (0.002, 30.0, "cloth (a shirt has 0.15, canvas 0.5, a carpet 3)"),
}
"""The same of what deforms, and what has such densities: of a cloth [kg/m2], of all else [kg/m3]."""
GAS = 1.5
"""Density [kg/m3] up to which a part of a body stands for the air in it."""
PACKED = 1e5
"""Density [kg/m3] above which a `mass` is no longer that of a small body that stands for a heavy one."""


def _density(facts: Facts) -> Iterator[Problem]:
    yield from _mass(facts)
    yield from _link_masses(facts)
    for name, body in facts.case.bodies.items():
        if is_soft(body):
            yield from _deforming(facts, name, body)
            continue
        where: Path = ("bodies", name)
        for place, density in _densities(facts.raw(where), where):
            low = MATTER[0] if "parts" in place and density <= GAS else SOLID[0]
            if not low <= density <= SOLID[1]:
                yield _unlikely(facts, place, density)


def _deforming(facts: Facts, name: str, body: Any) -> Iterator[Problem]:
    """The same of what deforms: a density, or the mass of an area of cloth."""
    key, unit, power = ("area_density", "kg/m2", 2) if body.kind == "cloth" else ("density", "kg/m3", 3)
    where = facts.where(name, "material", key)
    value, (low, high, known) = getattr(body.material, key), DEFORMING[body.kind]
    if low <= value <= high or facts.raw(where) is None:
        return
    text = f"{'an area density' if power == 2 else 'a density'} of {value:g} {unit} is that of no {known}"
    meant, other = (1000 * value, "g/cm3") if value < low else (value / 1000, f"g/m{power}")
    if (power == 2 and value < low) or not low <= meant <= high:
        yield facts.problem("implausible-density", where, text)
    else:
        text += f": {value:g} {other} are {meant:g} {unit}"
        yield facts.problem("implausible-density", where, text, hint=f"{meant:g}")


def _unlikely(facts: Facts, where: Path, density: float) -> Problem:
    """A finding, with the density that was meant if it looks like one in g/cm3, or in g/m3."""
    text = f"a density of {density:g} kg/m3 is that of no solid"
    meant, unit = (1000 * density, "g/cm3") if density < SOLID[0] else (density / 1000, "g/m3")
    known = "styrofoam has 20" if density < SOLID[0] else "osmium, the densest, has 22,600"
    if SOLID[0] <= meant <= SOLID[1]:
        return facts.problem(
            "implausible-density", where, f"{text} ({known}): {density:g} {unit} are {meant:g} kg/m3", hint=f"{meant:g}"
        )
    return facts.problem("implausible-density", where, f"{text} ({known}); water has 1000, steel 7800")


def _mass(facts: Facts) -> Iterator[Problem]:
    """What a `mass` comes to, over the volume of the shape: a body in grams is a thousand times too dense."""
    low, high = MATTER[0], PACKED
    for name, body in facts.case.bodies.items():
        mass = getattr(getattr(body, "material", None), "mass", None)
        if mass is None or body.kind != "rigid":
            continue
        for copy in kinds_of(facts, name):
            volume = sum(part.piece.volume() for part in facts.parts(copy))
            if volume <= 0.0 or low <= mass / volume <= high:
                continue
            density = mass / volume
            text = (
                f"{mass:g} kg in the {_litres(volume)} of `{copy.name}` are {_round(density)} kg/m3, a density of no "
                "material (steel has 7800); masses are in kilograms, lengths in metres"
            )
            if density > high and low <= density / 1000 <= MATTER[1]:
                text += f": {mass:g} g are {mass / 1000:g} kg"
            yield facts.problem("implausible-density", _mass_of(facts, name), text)
            break


def _link_masses(facts: Facts) -> Iterator[Problem]:
    low, high = MATTER[0], PACKED
    for name, body in facts.case.bodies.items():
        links = body.links if isinstance(body, Articulated) else None
        tree = facts.tree(facts.placed[name][0])
        if links is None or tree is None:
            continue
        for link in tree.links():
            material = links[link.name].material
            volume = sum(geom.piece.volume() for geom in link.geoms)
            where = facts.where(name, "links", link.name, "material", "mass")
            if material is None or material.mass is None or volume <= 0.0 or facts.raw(where) is None:
                continue
            if not low <= material.mass / volume <= high:
                text = (
                    f"{material.mass:g} kg in the {_litres(volume)} of `{name}.{link.name}` are "
                    f"{_round(material.mass / volume)} kg/m3, a density of no material (steel has 7800); masses are in "
                    "kilograms, lengths in metres"
                )
                yield facts.problem("implausible-density", where, text)


def _mass_of(facts: Facts, name: str) -> Path:
    """Path of the mass of a body, or of the body where a prefab says it."""
    where = facts.where(name, "material", "mass")
    return where if facts.raw(where) is not None else facts.where(name)


def _round(value: float) -> str:
    """A number with three digits, and never with an exponent below a million million."""
    return f"{float(f'{value:.3g}'):,.0f}" if 1e3 <= value < 1e12 else f"{value:.3g}"


def _litres(volume: float) -> str:
    """A volume [m3] in words."""
    if volume >= 1.0:
        return f"{volume:.3g} m3"
    return f"{volume * 1e3:.3g} l" if volume >= 1e-4 else f"{volume * 1e6:.3g} cm3"


def _densities(value: object, where: Path) -> Iterator[tuple[Path, float]]:
    if isinstance(value, dict):
        for key, item in value.items():
            if key == "density" and isinstance(item, int | float):
                yield (*where, key), item
            else:
                yield from _densities(item, (*where, key))


RULES = (
    Rule(
        id="implausible-density",
        severity="warning",
        title="A density is that of no solid: it may be in g/cm3.",
        reason=f"""\
Densities are in kg/m3: styrofoam has 20, wood 600, water 1000, steel 7800, osmium 22,600. A rigid body below
{SOLID[0]:g} or above {SOLID[1]:g} is rather a slip of the unit: 7.8 for steel is in g/cm3, and such a ball moves
nothing that it hits. A part of a compound may have up to {GAS:g}, if it stands for the air in a bottle. A `mass` is
divided by the volume of the shape, and may be that of {MATTER[0]:g} to {PACKED:g} kg/m3: balloons are hollow, and a
small body often stands for a heavy one. What deforms has bounds of its own: of a cloth it is the mass of an area, which
shops give in g/m2.""",
        remedy="Multiply a density in g/cm3 by 1000; give a `mass` where that is what counts, as for a hollow body.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {density: 7.8}, place: {on: floor}}
""",
        fix="bodies: {ball: {material: {density: 7800}}}",
        run=_density,
    ),
)
