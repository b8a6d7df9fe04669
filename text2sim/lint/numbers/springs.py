"""Springs between bodies that are too stiff for the time step.

The force of a spring is computed once per time step T from positions and velocities (`templates/springs.py`). On a mass
m, stiffness k and damping c are stable for  k T^2 + 2 c T < 4 m  (the symplectic Euler method with explicit damping),
whatever the number of substeps. An end far from the centre of mass of a slender body meets as little as m / 4.
"""

from collections.abc import Iterator
from math import sqrt
from typing import NamedTuple

from text2sim.compiler.action_rows import Spring
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.words import amount
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.rounding import at_least, at_most

STABLE = 4.0
"""Bound of `(k T^2 + 2 c T) / m`."""
SLENDER = 1.0
"""The same for the end of a slender rod."""


class _Load(NamedTuple):
    """A link that springs pull."""

    share: float
    """`(k T^2 + 2 c T) / m`"""
    entity: str
    link: str | None
    mass: float
    """[kg]"""
    longest: float
    """Longest time step [s] without a warning."""


def _stiff(facts: Facts) -> Iterator[Problem]:
    pulled: dict[tuple[str, str | None], list[Spring]] = {}
    for row in facts.rows.springs:
        for end in ((row.a, row.a_link), (row.b, row.b_link)):
            pulled.setdefault(end, []).append(row)
    worst: dict[str, _Load] = {}
    for (name, link), rows in pulled.items():
        load = _load(facts, name, link, rows)
        control = max(rows, key=lambda row: row.stiffness).control
        if load is not None and (control not in worst or load.share > worst[control].share):
            worst[control] = load
    for control, load in worst.items():
        # What else is joined to a link moves with it, so that only free bodies diverge for certain.
        certain = load.share > STABLE and facts.tree(facts.copies[load.entity]) is None
        what = f"`{load.entity}.{load.link}`" if load.link else f"`{load.entity}`"
        text = (
            f"what pulls {what} ({amount(load.mass, 'kg')}) is too stiff for steps of "
            f"{amount(facts.case.scene.dt * 1e3, 'ms')}: it {'diverges' if certain else 'may diverge'}; use scene.dt "
            f"of {at_most(load.longest)} or less (substeps do not help), or {at_least(load.share / SLENDER)} times "
            "less stiffness and damping"
        )
        where = ("actions", "controls", control, "stiffness")
        yield facts.problem("stiff-spring", where, text, severity="error" if certain else "warning")


def _load(facts: Facts, name: str, link: str | None, rows: list[Spring]) -> _Load | None:
    """Return the load of a link; None if it is bearable, or if nothing can be said about it."""
    step, mass = facts.case.scene.dt, _mass(facts, name, link)
    k, c = sum(row.stiffness for row in rows), sum(row.damping for row in rows)
    total = k * step**2 + 2 * c * step
    if not 0.0 < SLENDER * mass < total:
        return None
    return _Load(total / mass, name, link, mass, (sqrt(c**2 + SLENDER * k * mass) - c) / k)


def _mass(facts: Facts, name: str, link: str | None) -> float:
    """Return the mass [kg] of a copy or of a link of it; 0 if it cannot move, or is not known."""
    copy = facts.copies[name]
    if not facts.moves(copy) or copy.model.kind == "driven":
        return 0.0
    tree = facts.tree(copy)
    if link is None or tree is None:
        return facts.masses.get(name, 0.0)
    return next((one.inertial.mass for one in tree.links() if one.name == link), 0.0)


_BOB = """\
bodies:
  bob:
    kind: rigid
    shape: {kind: sphere, radius: 0.03}
    material: {mass: 0.1}
    pose: {pos: [0, 0, 0.5]}
scene: {statics: {beam: {shape: {kind: box, size: [0.4, 0.05, 0.05]}, pose: {pos: [0, 0, 1]}}}}
actions:
  controls:
    hang: {kind: spring, body: bob, to: beam, stiffness: %s, damping: 0.1}
"""

RULES = (
    Rule(
        id="stiff-spring",
        title="A spring between bodies is too stiff for the time step.",
        reason="""\
The force of a spring is computed once per time step T. With a stiffness k and a damping c it is stable on a mass m for
`k T^2 + 2 c T < 4 m`, at the end of a slender body for a quarter of that; the springs at a body add up. Substeps do
not help.""",
        remedy="Use a smaller `scene.dt`, a softer spring, or `attach` for what shall not stretch.",
        example=_BOB % "2e3",
        fix=_BOB % "50",
        run=_stiff,
    ),
)
