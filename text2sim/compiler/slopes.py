"""Slopes and leaning bodies in a scene: what rests there creeps with the pyramidal friction cone."""

from collections.abc import Iterable, Iterator
from math import cos, hypot
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rings import ROUND_ABOUT_Z
from text2sim.compiler.shapes.rotation import Quaternion, Vec, quat_multiply, quat_of, quat_rotate, vector_cross
from text2sim.spec_schema.models.base import AXES
from text2sim.spec_schema.models.faceted import Faceted
from text2sim.spec_schema.models.shapes import Compound

MAX_LEVEL_TILT = 0.0087
"""Largest tilt [rad] of a level face: half a degree."""
SHAPES_WITHOUT_FACES = ("sphere", "ellipsoid", "torus")


def has_slopes(copies: Iterable[Copy], gravity: Vec) -> bool:
    """Return whether there are flat faces, except of packed bodies, that are neither level nor upright."""
    return next(tilted_copies(copies, gravity), None) is not None


def tilted_copies(copies: Iterable[Copy], gravity: Vec) -> Iterator[Copy]:
    """Yield the copies with such faces."""
    gravity_size = hypot(*gravity)
    if not gravity_size:
        return
    up = (gravity[0] / gravity_size, gravity[1] / gravity_size, gravity[2] / gravity_size)
    yield from (copy for copy in copies if _has_intended_tilt(copy) and _is_tilted(copy, up))


def _has_intended_tilt(copy: Copy) -> bool:
    """Return whether its tilt is intended, not that of a packing."""
    repeat = getattr(copy.model, "repeat", None)
    return (
        copy.shape is not None
        and copy.shape.kind not in SHAPES_WITHOUT_FACES
        and getattr(repeat, "kind", "") != "packing"
    )


def _is_tilted(copy: Copy, up: Vec) -> bool:
    if isinstance(copy.shape, Compound):
        return any(
            _has_tilted_faces(p.shape, quat_multiply(copy.quat, quat_of(p.pose)), up)
            for p in copy.shape.solids.values()
        )
    return _has_tilted_faces(copy.shape, copy.quat, up)


def _has_tilted_faces(shape: Any, quat: Quaternion, up: Vec) -> bool:
    """Return whether a shape's faces are neither level nor upright."""
    if shape.kind in SHAPES_WITHOUT_FACES:
        return False
    if isinstance(shape, Faceted):
        return True  # slanted faces are what they are used for
    z = _sine(quat, "z", up)
    if shape.kind in ROUND_ABOUT_Z:
        return MAX_LEVEL_TILT < z < cos(MAX_LEVEL_TILT)
    return z > MAX_LEVEL_TILT and (
        shape.kind == "plane" or min(_sine(quat, axis, up) for axis in "xy") > MAX_LEVEL_TILT
    )


def _sine(quat: Quaternion, axis: str, up: Vec) -> float:
    """Return the sine of the angle between a body's axis and the vertical."""
    return hypot(*vector_cross(quat_rotate(quat, AXES[axis]), up))
