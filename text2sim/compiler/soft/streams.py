"""Streams of what flows, as the program is told of them."""

from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import Vec, quat_rotate, vector_times, vector_unit
from text2sim.spec_schema.models.shapes import Stream


def stream_velocity(copy: Copy) -> Vec | None:
    """Return the velocity [m/s] of a stream at its mouth, in the world; None for any other body."""
    if not isinstance(copy.shape, Stream):
        return None
    return vector_times(_direction(copy, copy.shape), copy.shape.speed)


def stream_arguments(copy: Copy, spacing: float) -> dict[str, Any] | None:
    """Return the arguments of `templates/streams.py` for a copy; None for any other body.

    Args:
        copy: The copy of a deformable body.
        spacing: Distance of its particles [m].
    """
    shape = copy.shape
    if not isinstance(shape, Stream):
        return None
    own = {name: getattr(shape, name) for name in ("radius", "speed", "start", "duration")}
    return {"pos": tuple(copy.pos), "direction": _direction(copy, shape), **own, "spacing": spacing}


def _direction(copy: Copy, shape: Stream) -> Vec:
    return quat_rotate(copy.quat, vector_unit(shape.direction))
