"""Estimates of how long a scene takes to simulate, from measurements on two cores."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.soft.facts import SoftBody, SoftFacts, soft_facts
from text2sim.spec_schema.errors import Problem

MOST = 5_000_000
"""Points or elements of a solver. Each takes half a kilobyte, and 5 million of mpm 8 s a substep."""
LONG = 1800.0
"""Wall time [s] of a run that is worth a word."""
BASE = {"mpm": 1e-3, "pbd": 2.5e-3, "fem": 5e-3, "sap": 5e-3}
EACH = {"mpm": 1.6e-6, "pbd": 1.3e-6, "fem": 1.8e-5, "sap": 1.2e-4}
"""Wall time [s] of a substep: of the solver, and of each particle or tetrahedron. Fitted to runs on two cores: mpm with
1.7 to 11.6 thousand particles 3.6 to 17 ms, pbd with 0.6 to 5 thousand 3 to 9 ms, fem with 2.2 to 4.7 thousand
tetrahedra 47 to 75 ms, under sap with 1 to 4 thousand 95 to 516 ms."""
WORDS = {"mpm": "particles", "pbd": "particles", "fem": "tetrahedra", "ipc": "triangles"}
RIGID = {"newton": (1.5e-3, 4e-5), "cg": (2e-3, 1.5e-4)}
"""Wall time [s] of a substep with rigid bodies, and of each link that moves; of piles of hundreds and of few bodies."""


def expected(facts: Facts) -> float:
    """Return the wall time [s] that a run takes on two cores, within a factor of three; 0 under ipc: not known.

    Starting the engine, and compiling kernels for the first scene of its sort, take a minute or some besides.
    """
    if facts.settings.soft is not None and facts.settings.soft.model == "ipc":
        return 0.0
    links = 0
    for name in facts.case.bodies:
        for copy in facts.placed[name]:
            tree = facts.tree(copy)
            links += (facts.mount(copy) not in ("fixed", "soft")) if tree is None else sum(1 for _ in tree.links())
    base, each = RIGID[facts.settings.solver]
    second = wall_time(facts)[0] + (base + each * links) / facts.substep * (links > 0)
    return second * facts.case.scene.duration


def wall_time(facts: Facts) -> tuple[float, dict[str, int]]:
    """Return the wall time [s] of a simulated second on two cores, and the points or elements of each solver."""
    soft = soft_facts(facts)
    counts: dict[str, int] = {}
    for body in soft.bodies:
        counts[body.solver] = counts.get(body.solver, 0) + _count(soft, body)
    substeps = 1.0 / facts.substep
    total = 0.0
    for solver, count in counts.items():
        kind = "sap" if solver == "fem" and soft.model == "sap" else solver
        if kind in BASE:
            total += substeps * (BASE[kind] + EACH[kind] * count)
    return total, counts


def _count(soft: SoftFacts, body: SoftBody) -> int:
    return soft.points(body)


def _slow(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    if not soft.bodies or soft.model == "ipc":
        return
    second, counts = wall_time(facts)
    whole = second * facts.case.scene.duration
    if whole < LONG:
        return
    most = max(counts, key=lambda solver: counts[solver])
    power = {"mpm": 4, "pbd": 3, "fem": 3}.get(most, 3)
    text = (
        f"about {second:.2g} s of wall time for each simulated second, {_minutes(whole)} in all, on two cores: "
        + ", ".join(f"{count:,} {solver} {WORDS[solver]}" for solver, count in counts.items())
        + f", {1.0 / facts.substep:,.0f} substeps a second; {_coarser(soft, most)} one and a half times as large "
        f"would be {1.5**power:.0f} times as fast"
    )
    where = next(
        (facts.where(body.body, "cell") for body in soft.of(most) if facts.raw(facts.where(body.body, "cell"))),
        ("scene", "duration"),
    )
    yield facts.problem("slow-scene", where, text)


def _too_many(facts: Facts) -> Iterator[Problem]:
    soft = soft_facts(facts)
    for body in soft.bodies:
        if (count := _count(soft, body)) > MOST:
            larger = 1.1 * (count / MOST) ** (1 / 3)
            text = (
                f"`{body.body}` is made of about {count:.2g} {WORDS[body.solver]}; at most {MOST:,} are possible: take "
                f"{_coarser(soft, body.solver)} {larger:.2g} times as large"
            )
            yield facts.problem("too-many-points", facts.where(body.body), text, key=True)


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.2g} h"


def _coarser(soft: SoftFacts, solver: str) -> str:
    return {"mpm": "cells", "pbd": "particles", "fem": "elements"}.get(solver, "cells")


RULES = (
    Rule(
        id="too-many-points",
        severity="error",
        title="A deformable body of more particles or tetrahedra than memory holds.",
        reason=f"""\
Each takes about half a kilobyte in the solver, and 24 bytes in every frame. With {MOST:,} a substep of mpm takes
8 s.""",
        remedy="A larger `cell`, or a smaller body.",
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
        title="A scene with deformable bodies that takes more than half an hour.",
        reason=f"""\
A substep takes, on two cores, about 1 ms and {EACH["mpm"] * 1e6:g} us for each mpm particle, 2.5 ms and
{EACH["pbd"] * 1e6:g} us for each pbd particle, {EACH["fem"] * 1e6:g} us for each tetrahedron and
{EACH["sap"] * 1e6:g} us under contact model sap. Half the cell makes eight times as many particles and twice as many
substeps. From {LONG / 60:g} minutes on the estimate is told; it is right within a factor of two.""",
        remedy="Coarser cells, a shorter duration, softer materials (longer steps), fewer bodies.",
        example="""\
scene: {duration: 5.0}
bodies:
  jelly: {kind: soft, cell: 0.004, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.3]}}
""",
        fix="bodies: {jelly: {cell: 0.02}}",
        run=_slow,
    ),
)
