"""Which families of bodies touch: a tiny scene for each pair, and what it shows.

Two bodies fly into each other in free fall, so that all momentum along x is theirs. Beside them one body slides over a
bed of the other: what it loses of its speed, over the momentum that the bed gives it upwards, is its friction.
"""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.softlab.lab import Lab, Run, RunFailed

G = 9.81
SPEED = 1.5
"""Of the body that flies [m/s]."""
SLIDE = 1.0
"""Of the body that slides at the start [m/s]."""
FRICTION = 0.3
"""Asked of every body."""
CELL, GRAIN, EDGE = 0.025, 0.02, 0.05
"""Cell of the grid, distance of cloth particles, edge of tetrahedra [m]."""
FAMILIES = ("rigid", "rope", "soft mpm", "granular", "liquid", "snow", "cloth", "soft fem")
LOOSE = ("granular", "liquid", "snow")
TOUCH = 0.03
"""Part of the momentum of a plastic blow from which on a body counts as touched."""


@dataclass(frozen=True)
class Pair:
    """Two families, and the contact model under which they meet."""

    first: str
    second: str
    model: str

    @property
    def name(self) -> str:
        """As `--only` takes it."""
        words = [family.replace("soft ", "") for family in (self.first, self.second)]
        return "-".join(words) + ("-under-sap" if self.is_extra else "")

    @property
    def is_extra(self) -> bool:
        """Whether neither of the two needs this model: some third body of the scene does."""
        return self.model == "sap" and "soft fem" not in (self.first, self.second)


def pairs() -> list[Pair]:
    """Return every pair of families, and those that a body of a third one parts."""
    found = []
    for k, first in enumerate(FAMILIES):
        for second in FAMILIES[k:]:
            found.append(Pair(first, second, "sap" if "soft fem" in (first, second) else "particle"))
    parted = [("rigid", "soft mpm"), ("rigid", "cloth"), ("soft mpm", "cloth"), ("cloth", "cloth"), ("rigid", "rigid")]
    return found + [Pair(first, second, "sap") for first, second in parted]


@dataclass(frozen=True)
class Finding:
    """What a pair did."""

    pair: str
    model: str
    given: float | None = None
    """Momentum that the struck body gained, over that of a plastic blow: 1 is a plastic one, 2 an elastic one."""
    lost: float | None = None
    """What the flying body lost, over the same."""
    through: bool = False
    """The flying body ended beyond the struck one."""
    frozen: bool = False
    """The struck body did not fall."""
    friction: float | None = None
    """Momentum lost along the bed over momentum gained across it; None where the bed did not carry the body."""
    problem: str | None = None

    @property
    def touches(self) -> bool:
        """Whether either of the two felt the other."""
        return max(abs(self.given or 0.0), abs(self.lost or 0.0)) > TOUCH

    @property
    def two_way(self) -> bool:
        """Whether both felt it."""
        return min(abs(self.given or 0.0), abs(self.lost or 0.0)) > TOUCH


def examine(lab: Lab, pair: Pair) -> Finding:
    """Run the scene of a pair and read what happened."""
    try:
        run = lab.run(scene(pair), pair.name)
    except RunFailed as error:
        return Finding(pair.name, pair.model, problem=str(error).strip().splitlines()[-1][:200])
    return Finding(pair.name, pair.model, **_blow(run), friction=_friction(run))


def scene(pair: Pair) -> str:
    """Return the case of a pair, below its name."""
    bed, slider = (pair.second, pair.first) if pair.first == "rope" else (pair.first, pair.second)
    controls = [
        f"    fly: {{kind: initial_velocity, body: flying, linear: [{SPEED}, 0, 0]}}",
        f"    slide: {{kind: initial_velocity, body: slider, linear: [{SLIDE}, 0, 0]}}",
    ]
    bodies = [_body("struck", pair.first, (0.0, 0.5, 1.0)), _body("flying", pair.second, (-0.2, 0.5, 1.0))]
    statics = []
    if bed != "rope":
        statics.append(_static("slab", (0.8, 0.36, 0.1), (0.0, 0.0, -0.05)))
        top = 0.0
        if bed != "rigid":
            top = 0.05
            bodies.append(_bed(bed))
        if bed in LOOSE:
            statics += [_static(f"end_{k}", (0.1, 0.36, 0.1), (0.25 * k, 0.0, 0.05)) for k in (-1, 1)]
            statics += [_static(f"side_{k}", (0.4, 0.1, 0.1), (0.0, 0.13 * k, 0.05)) for k in (-1, 1)]
        if bed == "cloth":
            top = GRAIN
            sides = ("left", "right", "front", "back")
            controls += [f"    pin_{s}: {{kind: attach, body: bed, region: {{edge: {s}}}, to: world}}" for s in sides]
        half = {"cloth": GRAIN, "rope": 0.02}.get(slider, 0.04)
        bodies.append(_body("slider", slider, (-0.12, 0.0, top + half + (0.03 if bed != "rigid" else 0.01)), lies=True))
    else:
        controls.pop()
    statics = [text.replace("end_-1", "end_a").replace("side_-1", "side_a") for text in statics]
    return "\n".join([
        "scene:",
        "  duration: 0.35",
        "  dt: 0.0025",
        "  record: {rate: 200}",
        f"  contact: {{model: {pair.model}}}",
        f"  mpm: {{cell: {CELL}, bounds: {{min: [-0.6, -0.3, -0.3], max: [0.8, 0.8, 1.3]}}}}",
        f"  pbd: {{particle_size: {GRAIN}, bounds: {{min: [-0.6, -0.3, -0.3], max: [0.8, 0.8, 1.3]}}}}",
        *(["  statics:", *statics] if statics else []),
        "bodies:",
        *bodies,
        "actions:",
        "  controls:",
        *controls,
        "",
    ])  # fmt: skip


def _static(name: str, size: tuple[float, ...], pos: tuple[float, ...]) -> str:
    shape = f"{{kind: box, size: {list(size)}}}"
    return f"    {name}: {{shape: {shape}, material: {{friction: {FRICTION}}}, pose: {{pos: {list(pos)}}}}}"


MATERIALS = {
    "soft": f"{{youngs_modulus: 1e5, friction: {FRICTION}}}",
    "granular": "{youngs_modulus: 1e5}",
    "liquid": "{stiffness: 1e5}",
    "snow": "{youngs_modulus: 1e5}",
}


def _body(name: str, family: str, pos: tuple[float, float, float], *, lies: bool = False) -> str:
    """A body of about 0.1 m; `lies`: flat on a bed, and a bit smaller."""
    if family == "rope":
        # Struck ropes stand across the way of flying ones.
        way = [0, 1, 0] if name == "struck" or lies else [0, 0, 1]
        start = [round(p - 0.06 * w, 4) for p, w in zip(pos, way, strict=True)]
        return (
            f"  {name}: {{kind: rope, length: 0.12, radius: 0.02, segments: 3, direction: {way}, anchored: false, "
            f"damping: 0.01, material: {{density: 1000, friction: {FRICTION}}}, pose: {{pos: {start}}}}}"
        )
    if family == "cloth":
        turn = "" if lies else ", euler_deg: [0, 90, 0]"
        return (
            f"  {name}: {{kind: cloth, solver: pbd, shape: {{kind: sheet, size: [0.12, 0.12]}}, "
            f"material: {{area_density: 5, friction: {FRICTION}, air_resistance: 0}}, "
            f"pose: {{pos: {_rounded(pos)}{turn}}}}}"
        )
    return f"  {name}: {_solid(family, 0.08 if lies else 0.1)}, pose: {{pos: {_rounded(pos)}}}}}"


def _solid(family: str, *size: float) -> str:
    sides = list(size * 3) if len(size) == 1 else list(size)
    shape = f"shape: {{kind: box, size: {sides}}}"
    if family == "rigid":
        return f"{{kind: rigid, {shape}, material: {{density: 1000, friction: {FRICTION}}}"
    if family in LOOSE:
        return f"{{kind: {family}, {shape}, cell: {CELL}, material: {MATERIALS[family]}"
    solver = family.split()[1]
    cell = EDGE if solver == "fem" else CELL
    return f"{{kind: soft, solver: {solver}, {shape}, cell: {cell}, material: {MATERIALS['soft']}"


def _bed(family: str) -> str:
    if family == "cloth":
        return (
            f"  bed: {{kind: cloth, solver: pbd, shape: {{kind: sheet, size: [0.6, 0.24]}}, "
            f"material: {{area_density: 5, friction: {FRICTION}, air_resistance: 0}}, "
            f"pose: {{pos: [0, 0, {GRAIN / 2}]}}}}"
        )
    size = (0.4, 0.16, 0.05)
    return f"  bed: {_solid(family, *size)}, pose: {{pos: [0, 0, 0.026]}}}}"


def _rounded(pos: tuple[float, ...]) -> list[float]:
    return [round(x, 4) for x in pos]


def _blow(run: Run) -> dict[str, Any]:
    masses = [run.mass(name) for name in ("struck", "flying")]
    plastic = masses[0] * masses[1] / sum(masses) * SPEED
    struck, flying = (run.momentum(name)[:, 0] for name in ("struck", "flying"))
    ahead = run.center("flying")[-1, 0] > run.center("struck")[-1, 0]
    fallen = run.center("struck")[0, 2] - run.center("struck")[-1, 2]
    return {
        "given": round(float(struck[-1] - struck[0]) / plastic, 3),
        "lost": round(float(masses[1] * SPEED - flying[-1]) / plastic, 3),
        "through": bool(ahead),
        "frozen": bool(fallen < G * run.time[-1] ** 2 / 8),
    }


def _friction(run: Run) -> float | None:
    """Impulse along the bed over impulse across it: (v0 - v) / (g t + vz), until the body is slow."""
    if run.row("slider") is None and not run.links("slider"):
        return None
    velocity = run.velocity("slider")
    slow = np.flatnonzero(velocity[:, 0] < 0.1 * SLIDE)
    end = int(slow[0]) if len(slow) else len(run.time) - 1
    across = G * run.time[end] + velocity[end, 2]
    if across < 0.2 * G * run.time[end]:
        return None
    return round(float((SLIDE - velocity[end, 0]) / across), 3)


def as_row(finding: Finding) -> dict[str, Any]:
    """Return what is kept of a finding on disk."""
    return asdict(finding)
