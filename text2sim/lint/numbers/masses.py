"""Mass ratios that the constraint solver cannot resolve.

Light links: the engine's solver stops when the residual is below its tolerance times the mass of all moving bodies. It
leaves a link lighter than `tolerance x total` (or 0.2 tolerance) unsolved; the engine reports this when it builds the
scene (`rigid_solver.py`: "too small for the constraint solver to be numerically stable").

Heavy on light: contacts and welds are springs with a compliance proportional to the inverse mass of the body they act
on. A body of mass m that carries M yields by about `c g tc^2 M / m`, where tc is the contact's time constant; for welds
it is two substeps. Measured with 1 to 60 kg on a tray of 0.1 kg, c is 0.002 to 0.004 for flat contacts; with rings that
hang in each other 0.014 to 0.035; with 1 to 40 kg welded to a hook of 0.05 kg 0.014 to 0.04. 50 kg on a rope of 20
links of 2.5 g at substeps of 0.2 ms stretched the weld by 0.9 mm, which is 0.029.
"""

from collections.abc import Iterator
from math import ceil, sqrt

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.settings import MIN_TIMECONST
from text2sim.compiler.shapes.boxes import sides
from text2sim.lint.facts import Facts
from text2sim.lint.joints.mechanics import Mechanics
from text2sim.lint.rule import Rule, one_per_place
from text2sim.lint.words import amount
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.controls import Attach
from text2sim.spec_schema.rounding import at_least, at_most

ENGINE_TOLERANCE = 1e-5
"""Default tolerance of the engine in single precision."""
FLAT_COMPLIANCE, EDGE_COMPLIANCE, WELD_COMPLIANCE = 0.003, 0.02, 0.02
"""Compliance of flat contacts, round contacts and welds, in units of `g tc^2 M / m`."""
ROUND_SHAPES = ("sphere", "capsule", "ellipsoid", "torus", "cone")
MAX_YIELD_SHARE = 0.1
"""Largest share of its thickness by which a body may yield."""
MAX_WELD_YIELD = 0.005
"""Largest distance [m] by which a weld may yield."""


def _light(facts: Facts) -> Iterator[Problem]:
    tolerance = facts.settings.tolerance or ENGINE_TOLERANCE
    links = list(_links(facts))
    total = sum(facts.masses.get(copy.name, 0.0) for copy in facts.moving)
    floor = tolerance * max(total, 0.2)
    for name, link, mass in links:
        if 0.0 < mass < floor:
            what = f"`{name}` has" if link is None else f"`{link}` of `{name}` has, with its children,"
            text = (
                f"{what} {mass:.2g} kg, which the {facts.settings.solver} solver neglects among {total:.3g} kg of "
                f"moving bodies: its tolerance is {tolerance:g} of the total, so this would shake or pass through "
                f"others; give it {at_least(floor)} kg or more, or set scene.solver.tolerance to "
                f"{0.3 * mass / max(total, 0.2):.0e}"
            )
            yield facts.problem("light-link", facts.where(name), text, key=True)


def _links(facts: Facts) -> Iterator[tuple[str, str | None, float]]:
    """Yield name, link and mass [kg] with all beyond it, of every movable body or link; for copies, the lightest."""
    for name in facts.case.bodies:
        group = [copy for copy in facts.placed[name] if facts.masses.get(copy.name) and facts.moves(copy)]
        if not group:
            continue
        copy = min(group, key=lambda copy: facts.masses[copy.name])
        tree = facts.tree(copy)
        if tree is None or sum(1 for _ in tree.links()) == 1:
            yield name, None, facts.masses[copy.name]
            continue
        totals = facts.once(Mechanics).totals(copy)
        movable = [link.name for link in tree.links() if link.all_joints()]
        link = min(movable, key=lambda link: totals[link].mass, default=None)
        if link is not None:
            yield name, link, totals[link].mass


@one_per_place
def _ratio(facts: Facts) -> Iterator[Problem]:
    yield from _stacked(facts)
    yield from _welded(facts)


def _yield_distance(facts: Facts, factor: float, time: float, heavy: float, light: float) -> float:
    """Return the distance [m] by which a light body yields under a heavy one."""
    return factor * facts.pull * time**2 * heavy / light


def _needed_settings(facts: Facts, time: float, *, contact: bool) -> str:
    """Return the substeps, and for contacts the time constant, that keep the yield within bounds.

    Args:
        facts: The case.
        time: Time constant [s] that is needed.
        contact: Whether it is that of contacts, which is at least `MIN_TIMECONST` unless the case gives it.
    """
    must_be_given = contact and (time < MIN_TIMECONST or facts.case.scene.contact.timeconst is not None)
    wanted = [f"contact.timeconst of {at_most(time)} s"] if must_be_given else []
    substeps = ceil(2 * facts.case.scene.dt / (float(at_most(time)) if must_be_given else time) - 1e-9)
    if substeps > facts.settings.substeps or not must_be_given:
        wanted.insert(0, f"scene.substeps of {substeps}")
    return " with ".join(wanted)


def _stacked(facts: Facts) -> Iterator[Problem]:
    """Report free bodies that stand on much lighter ones."""
    masses = sorted(m for copy in facts.moving if (m := facts.masses.get(copy.name)) and facts.free(copy))
    if (
        not masses
        or _yield_distance(facts, EDGE_COMPLIANCE, facts.settings.timeconst, masses[-1], masses[0])
        < MAX_YIELD_SHARE * 1e-3
    ):
        return
    for pair in facts.near(-1e-3):
        light, heavy = sorted(pair, key=lambda copy: facts.masses.get(copy.name, 0.0))
        low, high = facts.masses.get(light.name, 0.0), facts.masses.get(heavy.name, 0.0)
        if low <= 0.0 or high <= low or not (facts.free(light) and facts.free(heavy)):
            continue
        under, over = facts.box(light), facts.box(heavy)
        if under is None or over is None or over[0][2] < under[1][2] - 2e-3:
            continue
        size = min(sides(under))
        round_ = any(getattr(copy.shape, "kind", "") in ROUND_SHAPES for copy in pair)
        time = facts.settings.timeconst
        sag = _yield_distance(facts, EDGE_COMPLIANCE if round_ else FLAT_COMPLIANCE, time, high, low)
        if sag > MAX_YIELD_SHARE * size:
            text = (
                f"`{heavy.name}` ({high:.3g} kg) stands on `{light.name}` ({low:.3g} kg), which yields by about "
                f"{amount(min(sag, size) * 1e3, 'mm')} of its {amount(size * 1e3, 'mm')} at the present contact "
                f"stiffness; use {_needed_settings(facts, time * sqrt(MAX_YIELD_SHARE * size / sag), contact=True)}, "
                f"or a mass ratio of {at_most(high / low * MAX_YIELD_SHARE * size / sag)}"
            )
            yield facts.problem("mass-ratio", facts.where(light.name), text, key=True)


def _welded(facts: Facts) -> Iterator[Problem]:
    """Report free bodies that are attached to much lighter links."""
    time = 2 * facts.substep  # the time constant of welds, for any `contact.timeconst`
    for weld in facts.rows.welds:
        if not weld.on:
            continue
        for name, link, other in ((weld.a, weld.a_link, weld.b), (weld.b, weld.b_link, weld.a)):
            holder, load = facts.copies[name], facts.copies[other]
            carried = facts.masses.get(other, 0.0)
            if carried <= 0.0 or not facts.free(load) or facts.free(holder) or not facts.moves(holder):
                continue
            own = _mass_beyond(facts, holder, link)
            sag = _yield_distance(facts, WELD_COMPLIANCE, time, carried, own) if own > 0.0 else 0.0
            control = facts.case.actions.controls[weld.control]
            if sag > MAX_WELD_YIELD and isinstance(control, Attach):
                what = f"`{name}.{link}`" if link else f"`{name}`"
                text = (
                    f"`{other}` ({carried:.3g} kg) hangs on {what} ({own:.3g} kg): the weld is softer, the lighter the "
                    f"link is, and sags by about {amount(sag * 1e3, 'mm')}; use "
                    f"{_needed_settings(facts, time * sqrt(MAX_WELD_YIELD / sag), contact=False)}, or a link of "
                    f"{at_least(own * sag / MAX_WELD_YIELD)} kg"
                )
                yield facts.problem("mass-ratio", ("actions", "controls", weld.control), text, key=True)


def _mass_beyond(facts: Facts, copy: Copy, link: str | None) -> float:
    """Return the mass [kg] of a link with all beyond it."""
    if copy.model.kind in ("rigid", "driven"):
        return facts.masses.get(copy.name, 0.0) if copy.model.kind == "rigid" else 0.0
    totals = facts.once(Mechanics).totals(copy)
    tree = facts.tree(copy)
    name = link or (tree.roots[0].name if tree is not None and tree.roots else "")
    return totals[name].mass if name in totals else 0.0


_TWO = """\
scene: {substeps: 1}
bodies:
  shell: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.02]}, material: {mass: %s}, place: {on: floor}}
  block: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, material: {mass: 60}, place: {on: shell}}
"""

RULES = (
    Rule(
        id="light-link",
        title="A body or link is too light for the solver among all moving bodies.",
        reason="""\
The constraint solver stops when the residual is small compared with the mass of all moving bodies. It may leave a link
lighter than its tolerance times that mass unsolved: the link shakes, sinks or flies off. The tolerance is 1e-8 with
newton and 1e-5 with cg unless `scene.solver.tolerance` gives another.""",
        remedy="Make it heavier, use the newton solver, or set `scene.solver.tolerance`.",
        example="""\
scene: {solver: {kind: cg}}
bodies:
  block: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, material: {mass: 2000}, place: {on: floor}}
  bead: {kind: rigid, shape: {kind: sphere, radius: 0.01}, pose: {pos: [1, 0, 0.5]}}
""",
        fix="scene: {solver: {kind: newton}}",
        run=_light,
        own_contact=True,
    ),
    Rule(
        id="mass-ratio",
        title="A heavy body stands on, or hangs on, a light one.",
        reason="""\
Contacts and welds of the engine are springs with a compliance proportional to the inverse mass of the body they act on:
a body of mass m that carries M yields by about `0.003 g timeconst^2 M / m` (round contacts and welds by seven times
that; the time constant of welds is two substeps). 60 kg on 0.1 kg sank by 5 mm at substeps of 10 ms. Links of one tree
(chains, arms) do not yield.""",
        remedy="Use more substeps, which shorten the contact's time constant, or a smaller mass ratio.",
        example=_TWO % "0.1",
        fix=_TWO % "5",
        run=_ratio,
        own_contact=True,
    ),
)
