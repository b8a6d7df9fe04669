"""Estimates of the wall time of a simulation, from measurements on two cores."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftFacts
from text2sim.lint.words import length
from text2sim.runtime.progress import rough_duration
from text2sim.spec_schema.errors import Problem

MAX_POINTS = 5_000_000
"""Most points or elements of a solver. Each takes half a kilobyte, and 5 million of mpm 8 s per substep."""
LONG_RUN = 1800.0
"""Longest wall time [s] of a run without a warning."""
SUBSTEP_TIME = {"mpm": 1e-3, "pbd": 2.5e-3, "fem": 5e-3, "sap": 5e-3}
TIME_PER_POINT = {"mpm": 1.6e-6, "pbd": 1.3e-6, "fem": 1.8e-5, "sap": 1.2e-4}
"""Wall time [s] of a substep per solver, and per particle or tetrahedron. Fitted to runs on two cores: mpm with
1.7 to 11.6 thousand particles 3.6 to 17 ms, pbd with 0.6 to 5 thousand 3 to 9 ms, fem with 2.2 to 4.7 thousand
tetrahedra 47 to 75 ms, under sap with 1 to 4 thousand 95 to 516 ms."""
POINT_NAMES = {"mpm": "particles", "pbd": "particles", "fem": "tetrahedra", "ipc": "triangles"}
RIGID_SUBSTEP_TIME = {"newton": (1.5e-3, 4e-5), "cg": (2e-3, 1.5e-4)}
"""Wall time [s] of a substep with rigid bodies, and per moving link; measured with few and with hundreds of bodies."""


def expected_wall_time(facts: Facts) -> float:
    """Return the wall time [s] of a run on two cores, within a factor of three; 0 under ipc, where it is not known.

    Starting the engine, and compiling kernels for the first scene of its kind, take another minute or more.
    """
    if facts.settings.soft is not None and facts.settings.soft.model == "ipc":
        return 0.0
    links = 0
    for name in facts.case.bodies:
        for copy in facts.placed[name]:
            tree = facts.tree(copy)
            links += (facts.mount(copy) not in ("fixed", "soft")) if tree is None else sum(1 for _ in tree.links())
    base, each = RIGID_SUBSTEP_TIME[facts.settings.solver]
    second = wall_time(facts)[0] + (base + each * links) / facts.substep * (links > 0)
    return second * facts.case.scene.duration


def wall_time(facts: Facts) -> tuple[float, dict[str, int]]:
    """Return the wall time [s] of a simulated second on two cores, and the points or elements of each solver."""
    soft = facts.once(SoftFacts)
    counts: dict[str, int] = {}
    for body in soft.bodies:
        counts[body.solver] = counts.get(body.solver, 0) + soft.points(body)
    substeps = 1.0 / facts.substep
    total = 0.0
    for solver, count in counts.items():
        kind = "sap" if solver == "fem" and soft.model == "sap" else solver
        if kind in SUBSTEP_TIME:
            total += substeps * (SUBSTEP_TIME[kind] + TIME_PER_POINT[kind] * count)
    return total, counts


def cost(facts: Facts) -> str:
    """Say what makes deformable bodies dear: points, substeps, and what coarser ones would save; empty without any."""
    soft = facts.once(SoftFacts)
    if not soft.bodies or soft.model == "ipc":
        return ""
    counts = wall_time(facts)[1]
    most = max(counts, key=lambda solver: counts[solver])
    cells = f" in cells of {length(soft.cell)}" if "mpm" in counts else ""
    points = (f"{count:,} {name} {POINT_NAMES[name]}{cells * (name == 'mpm')}" for name, count in counts.items())
    return (
        f"{', '.join(points)}, {1.0 / facts.substep:,.0f} substeps per simulated second; with {_grains(most)} one and "
        f"a half times as large it is {1.5 ** (4 if most == 'mpm' else 3):.0f} times as fast"
    )


def _slow_run(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    if not soft.bodies or soft.model == "ipc":
        return
    second, counts = wall_time(facts)
    whole = second * facts.case.scene.duration
    if whole < LONG_RUN:
        return
    text = f"about {second:.2g} s of wall time per simulated second, {rough_duration(whole)} in all, on two cores: "
    most = max(counts, key=lambda solver: counts[solver])
    cells = (facts.where(body.body, "cell") for body in soft.of(most))
    where = facts.first_path(*cells, ("scene", "duration"))
    yield facts.problem("slow-scene", where, text + cost(facts))


def _too_many(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    for body in soft.bodies:
        if (count := soft.points(body)) > MAX_POINTS:
            larger = 1.1 * (count / MAX_POINTS) ** (1 / 3)
            text = (
                f"`{body.body}` has about {count:.2g} {POINT_NAMES[body.solver]}; at most {MAX_POINTS:,} are possible: "
                f"use {_grains(body.solver)} {larger:.2g} times as large"
            )
            yield facts.problem("too-many-points", facts.where(body.body), text, key=True)


def _grains(solver: str) -> str:
    return {"pbd": "particles", "fem": "elements"}.get(solver, "cells")


RULES = (
    Rule(
        id="too-many-points",
        severity="error",
        title="A deformable body has more particles or tetrahedra than memory holds.",
        reason=f"""\
Each takes about half a kilobyte in the solver, and 24 bytes per frame. With {MAX_POINTS:,} a substep of mpm takes 8
s.""",
        remedy="Use a larger `cell`, or a smaller body.",
        example="""\
bodies:
  sand: {kind: granular, cell: 0.0001, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.3]}}
""",
        fix="bodies: {sand: {cell: 0.02}}",
        run=_too_many,
    ),
    Rule(
        id="slow-scene",
        severity="warning",
        title="A scene with deformable bodies takes more than half an hour.",
        reason=f"""\
On two cores, a substep takes about 1 ms plus {TIME_PER_POINT["mpm"] * 1e6:g} us per mpm particle, 2.5 ms plus
{TIME_PER_POINT["pbd"] * 1e6:g} us per pbd particle, and {TIME_PER_POINT["fem"] * 1e6:g} us per tetrahedron
({TIME_PER_POINT["sap"] * 1e6:g} us under contact model sap). Half the cell makes eight times as many particles and
twice as many substeps. The rule reports estimates of more than {LONG_RUN / 60:g} minutes; they are accurate within a
factor of two.""",
        remedy="Use coarser cells, a shorter duration, softer materials (longer steps), or fewer bodies.",
        example="""\
scene: {duration: 5.0}
bodies:
  jelly: {kind: soft, cell: 0.004, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.3]}}
""",
        fix="bodies: {jelly: {cell: 0.02}}",
        run=_slow_run,
    ),
)
