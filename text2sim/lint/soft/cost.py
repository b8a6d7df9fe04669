"""Estimates of the wall time of a simulation, from measurements on two cores."""

from collections.abc import Iterator

from text2sim.compiler.soft.settings import STRETCH_ITERATIONS
from text2sim.compiler.soft.solvers import is_soft
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
SUBSTEP_TIME = {"mpm": 1e-3, "pbd": 1.4e-3, "fem": 5e-3, "sap": 5e-3}
TIME_PER_POINT = {"mpm": 1.2e-6, "pbd": 1.15e-6, "fem": 1.8e-5, "sap": 1.2e-4}
"""Wall time [s] of a substep per solver, and per particle or tetrahedron. Fitted to runs on two cores: mpm with 2.8 to
17 thousand particles 3.9 to 23 ms (`cases/soft_press`, `squeeze_through`, `falling_letters` and `snow_plough`), pbd
with 0.6 to 5 thousand 3 to 9 ms, fem with 2.2 to 4.7 thousand tetrahedra 47 to 75 ms, under sap with 1 to 4 thousand
95 to 516 ms."""
SAP_PIECE_TIME = 0.04
"""What each convex piece of rigid bodies and statics adds to that under sap [s]. The engine fills it with tetrahedra: a
box with 330 to 3,100, a sphere with 3,800, each capsule of a ring with 1,400. With 1, 4 and 20 pieces and 209
tetrahedra of a soft body, a substep took 0.12, 0.17 and 0.7 s on two cores with other work to do."""
SWEEP_TIME = (2.8e-4, 4e-8)
"""What each sweep over the threads of pbd cloth adds to that [s], and per particle: 720, 2,693 and 5,920 particles took
5.7, 8.8 and 15 ms with 4 sweeps, 2,693 with 16 sweeps 16 ms, 5,920 with 32 sweeps 36 ms: on cores with five times as
much to do as they can, 1.5 times what the runs above took."""
LEAST_GAIN = 1.5
"""How much faster coarser cells have to make a run under sap to be worth a mention."""
COARSER = 1.5
"""How much larger the cells are of which it is told what they save."""
POINT_NAMES = {"mpm": "particles", "pbd": "particles", "fem": "tetrahedra", "ipc": "triangles"}
RIGID_SUBSTEP_TIME = {"newton": (1.5e-3, 4e-5), "cg": (2e-3, 1.5e-4)}
"""Wall time [s] of a substep with rigid bodies, and per moving link; measured with few and with hundreds of bodies."""
ROLLING_TIME = 1e-3
"""What each free body adds to that with the newton solver, the elliptic cone and rolling friction: six rows a contact
[s]. Stacks of 45 and 90 logs took 57 and 121 ms, 96 without rolling friction 45, on cores with other work to do."""


def expected_wall_time(facts: Facts) -> float:
    """Return the wall time [s] of a run on two cores, within a factor of three; 0 under ipc, where it is not known.

    Starting the engine, and compiling kernels for the first scene of its kind, take another minute or more.
    """
    if facts.settings.soft is not None and facts.settings.soft.model == "ipc":
        return 0.0
    return (
        (_soft_substep(facts, _counts(facts), _sweeps(facts)) + _rigid_substep(facts))
        / facts.substep
        * facts.case.scene.duration
    )


def _rigid_substep(facts: Facts) -> float:
    """Return the wall time [s] that rigid bodies take of a substep; 0 without any that move."""
    links = free = 0
    for name in facts.case.bodies:
        for copy in facts.placed[name]:
            tree, mount = facts.tree(copy), facts.mount(copy)
            links += (mount not in ("fixed", "soft")) if tree is None else sum(1 for _ in tree.links())
            free += mount == "free"
    settings = facts.settings
    base, each = RIGID_SUBSTEP_TIME[settings.solver]
    if settings.rolls and settings.solver == "newton" and settings.cone == "elliptic":
        base += ROLLING_TIME * free
    return base + each * links if links else 0.0


def _counts(facts: Facts) -> dict[str, float]:
    """Return the number of points or elements of each solver."""
    soft = facts.once(SoftFacts)
    counts: dict[str, float] = {}
    for body in soft.bodies:
        counts[body.solver] = counts.get(body.solver, 0) + soft.points(body)
    return counts


def _sweeps(facts: Facts) -> float:
    """Return the number of sweeps over the threads of pbd cloth in a substep; 0 without any."""
    soft = facts.settings.soft
    return 0.0 if soft is None or soft.pbd is None else soft.pbd.stretch_iterations


def _soft_substep(facts: Facts, counts: dict[str, float], sweeps: float) -> float:
    """Return the wall time [s] that deformable bodies take of a substep on two cores."""
    base, each = SWEEP_TIME
    sweeping = sweeps * (base + each * counts.get("pbd", 0.0))
    sap = facts.once(SoftFacts).model == "sap"
    kinds = {solver: "sap" if solver == "fem" and sap else solver for solver in counts}
    rigid = SAP_PIECE_TIME * _sap_pieces(facts)
    return (
        sweeping
        + rigid
        + sum(
            SUBSTEP_TIME[kind] + TIME_PER_POINT[kind] * counts[solver]
            for solver, kind in kinds.items()
            if kind in SUBSTEP_TIME
        )
    )


def _sap_pieces(facts: Facts) -> int:
    """Return the number of convex pieces of rigid bodies and statics under contact model sap; 0 under others."""
    if facts.once(SoftFacts).model != "sap":
        return 0
    return sum(len(facts.parts(copy)) for copy in facts.copies.values() if not is_soft(copy.model))


def cost(facts: Facts) -> str:
    """Say what makes deformable bodies dear: points, substeps, and what coarser ones would save; empty without any."""
    soft = facts.once(SoftFacts)
    if not soft.bodies or soft.model == "ipc" or soft.of("ipc"):
        return ""
    counts = _counts(facts)
    most = max(counts, key=lambda solver: counts[solver])
    cells = f" in cells of {length(soft.cell)}" if "mpm" in counts else ""
    points = (f"{count:,} {name} {POINT_NAMES[name]}{cells * (name == 'mpm')}" for name, count in counts.items())
    # A cloth is a surface, and derived sweeps grow with its points; only the substeps of mpm get longer with its cells.
    fewer = counts | {most: counts[most] / COARSER ** (2 if most == "pbd" else 3)}
    rigid, sweeps = _rigid_substep(facts), _sweeps(facts)
    eased = most == "pbd" and facts.case.scene.pbd.stretch_iterations is None
    left = max(STRETCH_ITERATIONS[0], sweeps / COARSER**2) if eased else sweeps
    faster = (_soft_substep(facts, counts, sweeps) + rigid) / (_soft_substep(facts, fewer, left) + rigid)
    faster *= COARSER if most == "mpm" else 1.0
    if (pieces := _sap_pieces(facts)) and faster < LEAST_GAIN:
        return (
            f"{pieces} convex rigid pieces take {SAP_PIECE_TIME} s each in {1.0 / facts.substep:,.0f} substeps per "
            "simulated second: use fewer and simpler rigid bodies and statics, or `decor`, or `solver: mpm`"
        )
    return (
        f"{', '.join(points)}, {1.0 / facts.substep:,.0f} substeps per simulated second; with {_grains(most)} one and "
        f"a half times as large it is about {faster:.2g} times as fast"
    )


def _slow_run(facts: Facts) -> Iterator[Problem]:
    soft = facts.once(SoftFacts)
    if not soft.bodies or soft.model == "ipc":
        return
    counts = _counts(facts)
    second = _soft_substep(facts, counts, _sweeps(facts)) / facts.substep
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
        title="A scene with deformable bodies takes more than half an hour.",
        reason=f"""\
On two cores, a substep takes about 1 ms plus {TIME_PER_POINT["mpm"] * 1e6:g} us per mpm particle, 1.4 ms plus
{TIME_PER_POINT["pbd"] * 1e6:g} us per pbd particle and {SWEEP_TIME[0] * 1e3:g} ms for each sweep over its threads, and
{TIME_PER_POINT["fem"] * 1e6:g} us per tetrahedron; under contact model sap {TIME_PER_POINT["sap"] * 1e6:g} us, and
{SAP_PIECE_TIME * 1e3:g} ms for each convex piece of rigid bodies and statics. Half the cell makes eight times as many
particles and twice as many substeps. The rule reports estimates of more than {LONG_RUN / 60:g} minutes; they are
accurate within a factor of two.""",
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
