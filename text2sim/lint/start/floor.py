"""Bodies that start below the ground, or come down beside it."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec, vector_dot
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.motion.flight import flight_of
from text2sim.lint.parts import Ground, lowest_of
from text2sim.lint.rule import Rule
from text2sim.lint.start.overlap import MIN_DEPTH, MIN_PUSH, push_speed
from text2sim.lint.words import length, more_copies, vector
from text2sim.spec_schema.errors import Problem


def _under_floor(facts: Facts) -> Iterator[Problem]:
    """Report each body and plane once."""
    for ground in facts.planes:
        for name in facts.case.bodies:
            sunk = [(depth, copy) for copy in facts.placed[name] if (depth := _sunk_depth(facts, ground, copy)) > 0]
            if sunk:
                depth, copy = max(sunk, key=lambda entry: entry[0])
                yield _sunk_finding(facts, ground, copy, depth, len(sunk))


def _sunk_depth(facts: Facts, ground: Ground, copy: Copy) -> float:
    """Return how deep [m] a copy is below a plane; 0 if it is too little to matter, or if it cannot move."""
    box = facts.box(copy)
    if box is None or is_soft(copy.model) or lowest_of(box, ground.up) >= ground.level - MIN_DEPTH:
        return 0.0
    depth = max((ground.depth(part) for part in facts.parts(copy) if part.moves), default=0.0)
    return depth if depth > max(MIN_PUSH / push_speed(facts, 1.0), MIN_DEPTH) else 0.0


def _sunk_finding(facts: Facts, ground: Ground, copy: Copy, depth: float, count: int) -> Problem:
    """Return the problem; a plane has no underside, so a body with its centre below comes back late, or never."""
    parts = [part for part in facts.parts(copy) if part.moves]
    whole = all(part.solid.span(ground.up)[1] < ground.level for part in parts)
    most = sum(vector_dot(ground.up, part.solid.center) < ground.level for part in parts) > len(parts) / 2
    free = facts.free(copy)
    text = f"`{copy.name}` is {'entirely' if whole else 'partly'} below `{ground.copy.name}` at the start"
    text += f", by {length(depth)}{more_copies(count)}"
    if free and whole:
        text += ": the engine does not bring it back, so it falls forever"
    elif free:
        text += f": the engine throws it out at {push_speed(facts, depth):.2g} m/s"
    else:
        text += ": it presses against its mount or joints for the whole run"
    how = "move it up" if ground.up[2] > 1 - 1e-9 else f"move it along {vector(ground.up)}"
    text += f"; {how} by {length(depth)}, or use `place: {{on: {ground.copy.name}}}`"
    severity = "error" if free and (whole or most) else None
    return facts.problem(
        "under-floor", facts.first_given(copy.body, "pose", "place", "repeat"), text, key=True, severity=severity
    )


def _floor_ends(facts: Facts) -> Iterator[Problem]:
    """Report each body once that starts, or comes down, beside all planes with nothing to hold it."""
    grounds = [ground for ground in facts.planes if ground.up[2] > 0.5]
    if not grounds or facts.case.scene.gravity[2] >= 0:
        return
    for name in facts.case.bodies:
        lost = [(copy, spot) for copy in facts.placed[name] if (spot := _comes_down(facts, copy, grounds)) is not None]
        if lost:
            copy, (x, y, z) = lost[0]
            ground = min(grounds, key=lambda ground: ground.beside((x, y, z)))
            size = 2 * (ground.beside((x, y, z)) + ground.half) + 2
            text = (
                f"`{copy.name}` comes down at x {x:.4g}, y {y:.4g}{more_copies(len(lost))} and falls past "
                f"`{ground.copy.name}`, which ends {ground.half:g} m from its centre; use "
                f"`shape: {{kind: plane, size: {math.ceil(size / 10) * 10:g}}}`"
            )
            yield facts.problem("floor-ends", facts.first_given(name, "pose", "place", "repeat"), text, key=True)


def _comes_down(facts: Facts, copy: Copy, grounds: list[Ground]) -> Vec | None:
    """Return where a copy passes the level of the grounds beside all of them; None if something is in its way."""
    if not facts.loose(copy):
        return None
    flies = any(facts.velocities.get(copy.name, ()))
    if not flies and min(ground.beside(copy.pos) for ground in grounds) < 0:
        return None
    flight = flight_of(facts, copy)
    if flight is None or flight.meeting is not None or not any(flight.acceleration):
        return None
    # The path ends downward: bisect the time at which it passes the highest ground.
    level = max(ground.level / ground.up[2] for ground in grounds)
    early, late = 0.0, flight.end
    if copy.pos[2] + flight.offset(late)[2] > level or copy.pos[2] < level:
        return None
    for _ in range(40):
        middle = (early + late) / 2
        early, late = (middle, late) if copy.pos[2] + flight.offset(middle)[2] > level else (early, middle)
    x, y, z = (p + q for p, q in zip(copy.pos, flight.offset(late), strict=True))
    return x, y, z


RULES = (
    Rule(
        id="under-floor",
        title="A body is partly or entirely below a plane at the start.",
        reason="""\
A plane is solid below. A body partly below it is thrown out as from an overlap; one entirely below it no longer touches
it and falls forever (observed: a sphere 0.3 m below). A free body that is below the plane entirely, or with most of its
pieces, is an error.""",
        remedy="Move the body up as the message says, or let `place: {on: floor}` find its height.",
        example="""\
bodies:
  crate: {kind: rigid, shape: {kind: box, size: [0.4, 0.4, 0.4]}, pose: {pos: [0, 0, 0.15]}}
""",
        fix="bodies: {crate: {pose: null, place: {on: floor}}}",
        run=_under_floor,
    ),
    Rule(
        id="floor-ends",
        title="A body starts, or comes down, beside the ground.",
        reason="""\
The engine's plane is as large as it is drawn (`size`, 40 m by default): a body beyond its edge touches nothing and
falls (measured: with 40 m, a box 19 m from the centre lies on it, one at 21 m falls past it).""",
        remedy="Make the plane larger, up to some kilometres, or place the body above it.",
        example="""\
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [25, 0, 0.5]}}
""",
        fix="scene: {statics: {floor: {shape: {size: 60}}}}",
        run=_floor_ends,
    ),
)
