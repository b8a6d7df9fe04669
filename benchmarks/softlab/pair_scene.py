"""The scene of some pairs of families: a plot for each, side by side.

In each plot two bodies fly into each other in free fall, and beside them one body slides over a bed of the other. One
scene for several pairs, since the engine compiles the kernels of each scene anew, which takes longer than the run.
"""

from benchmarks.softlab.families import FRICTION, LOOSE, SLIDE, SPEED, Pair

CELL, GRAIN, EDGE = 0.025, 0.02, 0.05
"""Cell of the grid, distance of cloth particles, edge of tetrahedra [m]."""
PITCH = 0.8
"""From plot to plot, along y [m]."""
STEPS = {"particle": 0.0025, "sap": 0.005}
"""Time steps [s] by contact model."""


def scene(pairs: list[Pair]) -> str:
    """Return the case of pairs of one contact model, below its name; names of bodies end with the pair's number."""
    statics: list[str] = []
    bodies: list[str] = []
    controls: list[str] = []
    for k, pair in enumerate(pairs):
        _plot(pair, f"_{k}", PITCH * k, statics, bodies, controls)
    bounds = f"{{min: [-0.4, -0.25, -0.1], max: [0.5, {0.5 + PITCH * (len(pairs) - 1):g}, 0.95]}}"
    model = pairs[0].model
    return "\n".join([
        "scene:",
        "  duration: 0.35",
        f"  dt: {STEPS[model]}",
        "  record: {rate: 200}",
        f"  contact: {{model: {model}}}",
        f"  mpm: {{cell: {CELL}, bounds: {bounds}}}",
        f"  pbd: {{particle_size: {GRAIN}, bounds: {bounds}}}",
        *(["  statics:", *statics] if statics else []),
        "bodies:",
        *bodies,
        "actions:",
        "  controls:",
        *controls,
        "",
    ])  # fmt: skip


def _plot(pair: Pair, end: str, y: float, statics: list[str], bodies: list[str], controls: list[str]) -> None:
    """Add what one pair needs, with names that end so, and in a plot that begins there."""
    bodies.append(_body(f"struck{end}", pair.first, (0.0, y + 0.35, 0.75)))
    bodies.append(_body(f"flying{end}", pair.second, (-0.2, y + 0.35, 0.75)))
    controls.append(f"    fly{end}: {{kind: initial_velocity, body: flying{end}, linear: [{SPEED}, 0, 0]}}")
    bed, slider = (pair.second, pair.first) if pair.first == "rope" else (pair.first, pair.second)
    if bed == "rope":
        return
    statics.append(_static(f"slab{end}", (0.8, 0.36, 0.1), (0.0, y, -0.05)))
    top = 0.0
    if bed != "rigid":
        top = 0.05
        bodies.append(_bed(bed, end, y))
    if bed in LOOSE:
        for k, side in ((-1, "near"), (1, "far")):
            statics.append(_static(f"end_{side}{end}", (0.1, 0.36, 0.1), (0.25 * k, y, 0.05)))
            statics.append(_static(f"side_{side}{end}", (0.4, 0.1, 0.1), (0.0, y + 0.13 * k, 0.05)))
    if bed == "cloth":
        top = GRAIN
        for side in ("left", "right", "front", "back"):
            held = f"{{kind: attach, body: bed{end}, region: {{edge: {side}}}, to: world}}"
            controls.append(f"    pin_{side}{end}: {held}")
    half = {"cloth": GRAIN, "rope": 0.02}.get(slider, 0.04)
    z = top + half + (0.03 if bed != "rigid" else 0.01)
    bodies.append(_body(f"slider{end}", slider, (-0.12, y, z), lies=True))
    controls.append(f"    slide{end}: {{kind: initial_velocity, body: slider{end}, linear: [{SLIDE}, 0, 0]}}")


def _static(name: str, size: tuple[float, ...], pos: tuple[float, ...]) -> str:
    shape = f"{{kind: box, size: {list(size)}}}"
    return f"    {name}: {{shape: {shape}, material: {{friction: {FRICTION}}}, pose: {{pos: {_rounded(pos)}}}}}"


MATERIALS = {
    "soft mpm": f"{{youngs_modulus: 1e5, friction: {FRICTION}}}",
    "soft fem": f"{{youngs_modulus: 1e5, friction: {FRICTION}, damping: 0}}",
    "granular": "{youngs_modulus: 1e5}",
    "liquid": "{stiffness: 1e5}",
    "snow": "{youngs_modulus: 1e5}",
}


def _body(name: str, family: str, pos: tuple[float, float, float], *, lies: bool = False) -> str:
    """A body of about 0.1 m; `lies`: flat on a bed, and a bit smaller."""
    if family == "rope":
        # Struck ropes stand across the way of flying ones; what slides lies along its way, or it would roll.
        way = [1, 0, 0] if lies else [0, 1, 0] if name.startswith("struck") else [0, 0, 1]
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
    return f"{{kind: soft, solver: {solver}, {shape}, cell: {cell}, material: {MATERIALS[family]}"


def _bed(family: str, end: str, y: float) -> str:
    if family == "cloth":
        return (
            f"  bed{end}: {{kind: cloth, solver: pbd, shape: {{kind: sheet, size: [0.6, 0.24]}}, "
            f"material: {{area_density: 5, friction: {FRICTION}, air_resistance: 0}}, "
            f"pose: {{pos: {_rounded((0, y, GRAIN / 2))}}}}}"
        )
    size = (0.4, 0.16, 0.05)
    return f"  bed{end}: {_solid(family, *size)}, pose: {{pos: {_rounded((0, y, 0.026))}}}}}"


def _rounded(pos: tuple[float, ...]) -> list[float]:
    return [round(x, 4) for x in pos]
