"""Forces that tear deformable bodies, and bodies that tear by their own weight."""

import math
from collections.abc import Iterator
from typing import Any

from text2sim.compiler.shapes.boxes import sides
from text2sim.compiler.soft.scales import PARTICLE_CELLS
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule, first_per_place
from text2sim.lint.soft.facts import SoftBody, SoftFacts
from text2sim.lint.soft.walls import free_by, opening
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.regions import SIDES
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.rounding import at_least

TEARING_STRETCH = 2 / PARTICLE_CELLS
"""Stretch at which the particles of a body are two cells apart."""
TEARING_STRAIN = 0.5
"""Smallest strain of a pulled part of an mpm body at which its particles separate."""


def _tearing(facts: Facts) -> Iterator[Problem]:
    """Report forces on small parts of mpm bodies."""
    soft = facts.once(SoftFacts)
    bodies = {body.body: body for body in soft.of("mpm") if body.model.kind == "soft"}
    for name, control in facts.case.actions.controls.items():
        if control.kind != "force":
            continue
        body = bodies.get(body_of(control.body))
        if body is None or body.model.material.tear_stretch is not None:  # which is meant to tear
            continue
        forced, bore = _forced_stretch(facts, body)
        through = f"; `{bore}` also stretches it to {forced:.2g} times its length" if forced > 1.1 else ""
        if control.region is None:
            if forced > TEARING_STRETCH:
                text = (
                    f"`{bore}` stretches `{body.name}` to {forced:.2g} times its length: its particles separate at "
                    f"about {TEARING_STRETCH:.2g}; use a bore {at_least(math.sqrt(forced / TEARING_STRETCH))} times as "
                    "wide, a thinner body, or solver fem"
                )
                yield facts.problem("tearing-force", ("actions", "controls", name), text, key=True)
            continue
        area = _area(facts, body, control.region)
        if area is None or area <= 0.0:
            continue
        young = body.model.material.youngs_modulus
        force = math.hypot(*control.force)
        strain = force / (area * young)
        if (1 + strain) * forced - 1 > TEARING_STRAIN and strain > 0.1:
            text = (
                f"{force:.3g} N on {area * 1e4:.3g} cm2 of `{body.name}` give a strain of {strain:.2g} there "
                f"(E {young:.3g} Pa): particles more than two cells apart never hold together again; use "
                f"{TEARING_STRAIN * 0.6 / forced * area * young:.2g} N or less, a larger region, or `drag` for a slow "
                f"motion{through}"
            )
            yield facts.problem("tearing-force", ("actions", "controls", name, "force"), text)


@first_per_place
def _tears_itself(facts: Facts) -> Iterator[Problem]:
    """Report bodies whose own weight stretches them to where they tear."""
    held = {body_of(control.body) for control in facts.case.actions.controls.values() if control.kind == "attach"}
    for body in facts.once(SoftFacts).of("mpm"):
        material, limit = body.model.material, getattr(body.model.material, "tear_stretch", None)
        if limit is None:
            continue
        strain = material.density * facts.pull * sides(body.box)[2] / material.youngs_modulus
        strain *= 1.0 if body.body in held else material.poisson_ratio
        if 1 + strain < limit:
            continue
        how = "hangs" if body.body in held else "stands"
        text = (
            f"`{body.name}` tears as it {how}: its own weight stretches it by {strain:.2g} (E "
            f"{material.youngs_modulus:.3g} Pa), and it tears at {limit - 1:.2g}; use a youngs_modulus of "
            f"{2 * strain / (limit - 1) * material.youngs_modulus:.1g} or more, or a larger tear_stretch"
        )
        yield facts.problem("tears-itself", facts.where(body.body, "material", "tear_stretch"), text)


def _forced_stretch(facts: Facts, body: SoftBody) -> tuple[float, str]:
    """Return the stretch of a body in the narrowest opening on its path, and the name of the copy with the opening.

    A body of constant volume and mean cross-section A is A / a times as long in a bore of cross-section a.
    """
    soft = facts.once(SoftFacts)
    mean = soft.volume(body) / max(sides(body.box))
    worst, whose = 1.0, ""
    for one, copy in soft.pairs("mpm"):
        radius = opening(copy.shape) if one is body else None
        if radius is None:
            continue
        free = radius - free_by(copy, soft)
        stretch = mean / (math.pi * max(free, 0.1 * radius) ** 2)
        if stretch > worst:
            worst, whose = stretch, copy.name
    return worst, whose


def _area(facts: Facts, body: SoftBody, region: Any) -> float | None:
    """Return the approximate cross-section [m2] of a region of a body; None if it is not known."""
    size = sides(body.box)
    if region.face is not None:
        across = SIDES[region.sides[0]][0]
        u, v = (size[k] for k in range(3) if k != across)
        return u * v
    if region.sphere is not None:
        widths = sorted(min(2 * region.sphere.radius, s) for s in size)
        return math.pi / 4 * widths[1] * widths[2]
    if region.box is not None:
        low = [max(p, -s / 2) for p, s in zip(region.box.min, size, strict=True)]
        high = [min(p, s / 2) for p, s in zip(region.box.max, size, strict=True)]
        widths = sorted(max(0.0, q - p) for p, q in zip(low, high, strict=True))
        return widths[1] * widths[2]
    if region.edge is not None or region.corner is not None:
        # One row of particles, or one of them.
        grain = PARTICLE_CELLS * facts.once(SoftFacts).cell
        along = [size[k] for k in range(3) if k not in {SIDES[side][0] for side in region.sides}]
        return grain * (along[0] if len(along) == 1 else grain)
    return None


_JELLY = "{kind: soft, cell: 0.02, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.11]}"

RULES = (
    Rule(
        id="tearing-force",
        title="A force acts on such a small part of an mpm body that it tears.",
        reason=f"""\
Particles hold together as long as they share grid nodes: parts more than two cells apart are separate from then on, for
any material. A soft body that was pulled into a tube by its tip lost the tip. The rule reports a strain of more than
{TEARING_STRAIN:g} from the force over area and stiffness and from the narrowest opening on the path (the body's mean
cross-section over that of the free bore), and a stretch of {TEARING_STRETCH:.2g} from the bore alone.""",
        remedy="Use a larger region, a smaller force, or `drag` for a slow motion.",
        example=f"""\
bodies:
  jelly: {_JELLY}, material: {{youngs_modulus: 5.0e+4}}}}
actions:
  controls:
    pull: {{kind: force, body: jelly, region: {{sphere: {{center: [0.1, 0, 0], radius: 0.02}}}}, force: [80, 0, 0]}}
""",
        fix="actions: {controls: {pull: {region: {sphere: null, face: right}}}}",
        run=_tearing,
    ),
    Rule(
        id="tears-itself",
        title="A body with a tear_stretch tears by its own weight.",
        reason="""\
The foot of a body of height h bears `rho g h`. Divided by its stiffness that is the strain at its top as it hangs by an
attachment; as it stands, its foot bulges by Poisson's ratio times that. What tears stays torn.""",
        remedy="Use a stiffer material, or a larger `tear_stretch`.",
        example=f"""\
bodies:
  jelly: {_JELLY}, material: {{youngs_modulus: 3.0e+3, tear_stretch: 1.1}}}}
""",
        fix="bodies: {jelly: {material: {youngs_modulus: 3.0e+4}}}",
        run=_tears_itself,
    ),
)
