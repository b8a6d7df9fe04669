"""Distances that bodies travel before a contact holds them."""

import math
from typing import NamedTuple

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec, vector_dot, vector_unit
from text2sim.lint.facts import Facts
from text2sim.lint.parts import StandingPart
from text2sim.spec_schema.text.document import Path


class Pass(NamedTuple):
    """A body that may pass through another."""

    mover: Copy
    other: Copy
    speed: float
    """Closing speed [m/s]."""
    room: float
    """Half of both thicknesses [m] along the velocity: the engine has to detect the contact within this."""
    where: Path


def stopping_time(facts: Facts) -> float:
    """Return the time [s] that a contact needs to stop a body.

    It is detected a substep late at worst, and then yields for its timeconst over e.
    """
    settings = facts.settings
    if settings.bounce_time:
        return max(facts.substep, settings.bounce_time)
    return max(facts.substep, max(settings.timeconst, 2 * facts.substep) / math.e)


def hardest(parts: list[StandingPart], target: StandingPart, velocity: Vec) -> tuple[float, float]:
    """Return the speed [m/s] and the room [m] along the normal of a piece along which it is passed first.

    Args:
        parts: Pieces of the moving body.
        target: The piece that may be passed.
        velocity: Relative velocity [m/s].
    """
    best = (0.0, math.inf)
    for normal in _normals(target, velocity):
        speed = abs(vector_dot(velocity, normal))
        room = (width(parts, normal) + width([target], normal)) / 2
        if speed * best[1] > best[0] * room:
            best = speed, room
    return best


def width(parts: list[StandingPart], axis: Vec) -> float:
    """Return the largest width [m] of one of the pieces along an axis."""
    return max(high - low for low, high in (part.solid.span(axis) for part in parts))


def _normals(part: StandingPart, velocity: Vec) -> list[Vec]:
    """Return the directions along which a body may pass a piece."""
    ahead = vector_unit(velocity)
    if part.piece.kind == "box":
        return part.axes
    if part.piece.kind == "cylinder":
        axis = part.axes[2]
        along = vector_dot(axis, ahead)
        across = tuple(a - along * b for a, b in zip(ahead, axis, strict=True))
        return [axis, vector_unit(across)] if math.hypot(*across) > 1e-6 else [axis]
    if part.piece.kind in ("hull", "mesh"):
        return [ahead, *part.normals()]
    return [ahead]
