"""Rings on rods: whether the axis of a rod passes through a ring."""

from dataclasses import dataclass

import numpy as np

from text2sim.compiler.shapes.rotation import quat_of
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget
from text2sim.evidence.soft_measures import SoftMeasureError as MeasureError
from text2sim.evidence.solids import LinkSolid
from text2sim.recording.states import Array
from text2sim.recording.vectors import rotate
from text2sim.spec_schema.models.measures import Threaded
from text2sim.spec_schema.models.shapes import Compound
from text2sim.spec_schema.names.derived_measure_references import RODS

FLAT = 1e-5
"""Height over a plane, in lengths of a segment, that single precision of the recording leaves unknown."""


@dataclass(frozen=True)
class Ring:
    """The centre line of a ring over all frames: a circle."""

    center: Array
    """World [m], shape (F, 3)."""
    normal: Array
    """Unit vectors, world, shape (F, 3)."""
    radius: float
    """[m]"""


def count_threaded(recording: RecordedCase, measure: Threaded) -> Array:
    """Number of rings whose disc the axis of a rod crosses, shape (F,).

    The centre line of the ring is the border of a disc D, and the axis of the rod is a segment S from a to b. S crosses
    D at most once: if a and b lie on different sides of its plane, and the point of S in the plane is in D. D is a
    Seifert surface of the centre line, so this is the size of the linking number of the ring with S, closed far from it
    (Rolfsen, Knots and Links, 1976, section 5.D): 1 on the rod, also tilted or at its foot, 0 beside or beyond it.
    Rings and rods that have left the scene do not count.
    """
    rods = [
        (recording.gone(target.copy), *_axis(recording, target))
        for target in recording.names.select_touching(measure.by)
    ]
    total = np.zeros(recording.states.frames)
    for target in recording.names.select_touching(measure.of):
        ring = _ring(recording, target)
        on_any = [~gone & pierces(ring, a, b) for gone, a, b in rods]
        total += np.any(on_any, axis=0) & ~recording.gone(target.copy)
    return total


def pierces(ring: Ring, a: Array, b: Array) -> Array:
    """Return whether segments from a to b, (F, 3) each [m], cross the disc of a ring, shape (F,).

    An end within `FLAT` lengths of the plane is in it, and what only ends there does not cross.

    Args:
        ring: The ring.
        a: First ends.
        b: Second ends.
    """
    above_a, above_b = (((end - ring.center) * ring.normal).sum(axis=1) for end in (a, b))
    least = FLAT * np.linalg.norm(b - a, axis=1)
    across = (above_a * above_b < 0) & (np.minimum(abs(above_a), abs(above_b)) > least)
    part = np.divide(above_a, above_a - above_b, out=np.zeros_like(above_a), where=across)
    point = a + part[:, None] * (b - a)
    return across & (np.linalg.norm(point - ring.center, axis=1) < ring.radius)


def _solids(recording: RecordedCase, target: RecordedTarget) -> list[LinkSolid]:
    """Return the recorded collision shapes of a body of one link, a link, or a part of a compound."""
    solids = [] if target.root < 0 else recording.shapes.of(target.root)
    found = [solid for solid in solids if target.part is None or solid.part == target.part]
    if not found:
        raise MeasureError(f"this recording has no shape of {target.label}: run the case again")
    return found


def _axis(recording: RecordedCase, target: RecordedTarget) -> tuple[Array, Array]:
    """Return both ends of the axis of a rod [m], world, (F, 3) each; a box has it along its longest side."""
    solid, *more = _solids(recording, target)
    if more or solid.kind not in RODS:
        raise MeasureError(f"{target.label} is not a rod: it takes a {', '.join(RODS[:-1])} or {RODS[-1]}")
    low, high = solid.bounds
    longest = int(np.argmax(high - low))
    end = np.zeros(3)
    end[longest] = high[longest]
    ends = (solid.pos + solid.turn @ (sign * end) for sign in (-1.0, 1.0))
    a, b = (_in_world(recording, target, point) for point in ends)
    return a, b


def _ring(recording: RecordedCase, target: RecordedTarget) -> Ring:
    """Return the centre line of a torus or tube.

    It follows from the recorded pieces, since copies may differ in size: the capsules of a torus end on it, and the
    corners of a tube's staves are as far inside it as outside.
    """
    points = np.concatenate([_marks(solid) for solid in _solids(recording, target)])
    normal = rotate(np.array(_orientation(recording, target), float), np.array([0.0, 0.0, 1.0]))
    center = points.mean(axis=0)
    offset = points - center
    radius = np.linalg.norm(offset - np.outer(offset @ normal, normal), axis=1).mean()
    turned = rotate(recording.states.quat[:, target.root].astype(float), normal)
    return Ring(_in_world(recording, target, center), turned, float(radius))


def _marks(solid: LinkSolid) -> Array:
    """Return the ends of a capsule's middle line, or the corners of a hull, in the link's frame [m], shape (n, 3)."""
    if solid.kind == "capsule":
        own = np.array([[0.0, 0.0, sign * solid.size[1] / 2] for sign in (-1.0, 1.0)])
    elif solid.vertices is not None:
        own = np.unique(solid.vertices, axis=0)
    else:
        raise MeasureError(f"its {solid.kind} is not a piece of a ring")
    return solid.pos + own @ solid.turn.T


def _orientation(recording: RecordedCase, target: RecordedTarget) -> tuple[float, float, float, float]:
    """Return the orientation of a target's shape in the frame of its link: that of its part, if it is one."""
    shape = getattr(recording.names.model_of(target.copy), "shape", None)
    return (
        quat_of(shape.parts[target.part].pose) if target.part and isinstance(shape, Compound) else (1.0, 0.0, 0.0, 0.0)
    )


def _in_world(recording: RecordedCase, target: RecordedTarget, point: Array) -> Array:
    """Return a point of a link's frame in the world [m], shape (F, 3)."""
    states = recording.states
    return states.pos[:, target.root] + rotate(states.quat[:, target.root].astype(float), point)
