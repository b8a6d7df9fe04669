"""Placement around something: a ring on its pole, chairs around a table."""

import math
from collections.abc import Iterator

from text2sim.compiler.placing.group import PlacedGroup
from text2sim.compiler.placing.place_error import PlaceError
from text2sim.compiler.placing.sides import lined_up
from text2sim.compiler.shapes.boxes import middle, sides
from text2sim.compiler.shapes.geometry import inner_floor
from text2sim.compiler.shapes.rings import ROUND_ABOUT_Z
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    Quaternion,
    Vec,
    quat_between,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
)
from text2sim.compiler.shapes.sizes import CopySpot
from text2sim.compiler.shapes.solid import Solid, shrunk
from text2sim.compiler.shapes.sweep import least_distance, sweep
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.shapes import Torus

TESTED_DIRECTIONS = 16
"""Number of sideways directions in which a ring must not come off its pole."""
MAX_EXCESS = 1e-4
"""Fraction of its own size by which a pole may be larger than the hole."""


def axis_frame(target: PlacedGroup) -> Quaternion:
    """Return an orientation whose z lies along a body's axis: z of what is round, else its longest side.

    It never points down.
    """
    frame = target.frame()
    kinds = {getattr(spot.shape, "kind", None) for spot in target.members}
    local = Z_AXIS
    if not kinds <= ROUND_ABOUT_Z:
        wide, deep, tall = sides(target.bounds(frame))
        if tall < max(wide, deep) * (1 - 1e-6):
            local = X_AXIS if wide >= deep else Y_AXIS
    x, y, z = quat_rotate(frame, local)
    if z < -1e-9 or (abs(z) <= 1e-9 and (x, y) < (0.0, 0.0)):
        local = (-local[0], -local[1], -local[2])
    return quat_multiply(frame, quat_between(Z_AXIS, local))


def along_axis(target: PlacedGroup) -> Quaternion:
    """Return the orientation of a ring around a body: its z along the body's axis, otherwise as it is described."""
    if not target.members:
        return IDENTITY
    axis = quat_rotate(axis_frame(target), Z_AXIS)
    return IDENTITY if axis[2] > 1 - 1e-12 else quat_between(Z_AXIS, axis)


def surround(place: Place, subject: PlacedGroup, target: PlacedGroup, middle: Vec, ringed: bool) -> Vec:
    """Return the shift [m] that brings a subject around a target, checked to fit there.

    Args:
        place: The relation.
        subject: What is placed: hollow things, or the copies of a ring.
        target: What it goes around.
        middle: The subject's own point.
        ringed: Whether the copies stand around the target together.

    Raises:
        PlaceError: if it does not fit, or does not surround it.
    """
    if target.planes:
        raise PlaceError("a plane has no outside to go around", "around")
    dx, dy, dz = place.offset
    if ringed:
        center = target.middle()
        z = lined_up(subject, target, 2, place.alignment(2) or "min")
        shift = (center[0] - middle[0] + dx, center[1] - middle[1] + dy, z + dz)
        _check_ring(place, subject, target, shift)
        return shift
    frame = axis_frame(target)
    error: PlaceError | None = None
    for x, y, z in _centred(place, subject, target, middle, frame):
        shift = (x + dx, y + dy, z + dz)
        try:
            _check_fit(place, subject, target, shift, frame)
        except PlaceError as found:
            error = error or found
        else:
            return shift
    assert error is not None
    raise error


def _centred(place: Place, subject: PlacedGroup, target: PlacedGroup, own: Vec, frame: Quaternion) -> Iterator[Vec]:
    """Yield shifts that bring the subject on the target's axis.

    Its hole is about its own z axis, or else in the middle of its bounds; the target's axis goes through the middle
    of its bounds, or else through its origin.
    """
    back = quat_conjugate(frame)
    (low, high), (bottom, top) = subject.bounds(frame), target.bounds(frame)
    subject_points = [quat_rotate(back, own), middle((low, high))]
    target_points = [middle((bottom, top))]
    if len(target.members) == 1:
        target_points.append(quat_rotate(back, target.members[0].pos))
    end = place.alignment(2) or "center"
    along = (bottom[2] + top[2] - low[2] - high[2]) / 2
    if end != "center":
        along = bottom[2] - low[2] if end == "min" else top[2] - high[2]
    tried: set[tuple[float, float]] = set()
    for target_point in target_points:
        for here in subject_points:
            across = (round(target_point[0] - here[0], 12) + 0.0, round(target_point[1] - here[1], 12) + 0.0)
            if across not in tried:
                tried.add(across)
                yield quat_rotate(frame, (*across, along))


def _check_fit(place: Place, subject: PlacedGroup, target: PlacedGroup, shift: Vec, frame: Quaternion) -> None:
    name, gap = place.target, place.clearance
    solids = subject.solids()
    within = [shrunk(solid, 1 - MAX_EXCESS) for solid in target.solids()]
    room = least_distance(solids, within, start=shift, enough=gap + 1e-9)
    if room == 0.0:
        raise PlaceError(f"it does not fit around `{name}`{_widths(subject, target, frame)}", "around")
    if gap:
        room = least_distance(solids, target.solids(), start=shift, enough=gap)
        if room < gap - 1e-6:
            message = f"it does not fit around `{name}` with this clearance: only {room:.3g} m is left"
            raise PlaceError(message, "clearance")
    for k in range(TESTED_DIRECTIONS):
        angle = 2 * math.pi * k / TESTED_DIRECTIONS
        direction = quat_rotate(frame, (math.cos(angle), math.sin(angle), 0.0))
        if sweep(solids, within, direction, start=shift) is None:
            raise PlaceError(
                f"it does not surround `{name}`: it comes off sideways. A hollow shape (a torus, a tube, a "
                "compound with a hole) goes around by itself, copies with `repeat: {kind: ring}`",
                "offset" if any(place.offset) else "around",
            )


def _widths(subject: PlacedGroup, target: PlacedGroup, frame: Quaternion) -> str:
    """Return in words what is known of the width of the hole and of what is in it."""
    low, high = target.bounds(frame)
    wide = [high[k] - low[k] for k in (0, 1)]
    size = f"{wide[0]:.3g} m" if abs(wide[0] - wide[1]) < 1e-6 else f"{wide[0]:.3g} m by {wide[1]:.3g} m"
    hole = _hole(subject.members[0])
    if hole is None:
        return f", which is {size} across"
    return f": its hole is {2 * hole:.3g} m wide, and that is {size} across"


def _hole(spot: CopySpot) -> float | None:
    """Return the radius [m] of the hole of a shape; None if it is not known."""
    if isinstance(spot.shape, Torus):
        return spot.shape.radius - spot.shape.bar_radius
    floor = None if spot.shape is None else inner_floor(spot.shape)
    return None if floor is None else floor.radius


def _check_ring(place: Place, subject: PlacedGroup, target: PlacedGroup, shift: Vec) -> None:
    others = [shrunk(solid, 1 - MAX_EXCESS) for solid in target.solids()]
    within, gap, least = None, place.clearance, 0.0
    for index, spot in enumerate(subject.members):
        solids = subject.sizes.solids(spot)
        room = least_distance(solids, others, start=shift, enough=gap + 1e-9)
        if room == 0.0 or room < gap - 1e-6:
            within = index if within is None else within
            least = max(least, _outwards(place, solids, spot, target, shift))
    if within is not None:
        message = (
            f"its copies do not fit around `{place.target}`: copy {within} is too near; "
            f"make the radius larger by {math.ceil(1000 * least - 1e-3) / 1000:g} m"
        )
        raise PlaceError(message, "around")


def _outwards(place: Place, solids: list[Solid], spot: CopySpot, target: PlacedGroup, shift: Vec) -> float:
    """Return how much farther [m] from the middle of the target a copy has to be."""
    middle = target.middle()
    x, y = spot.pos[0] + shift[0] - middle[0], spot.pos[1] + shift[1] - middle[1]
    norm = math.hypot(x, y)
    out = (x / norm, y / norm, 0.0) if norm > 1e-9 else X_AXIS
    far = math.dist(*target.bounds()) + math.dist(*target.sizes.of(spot)) + place.clearance
    start = (shift[0] + far * out[0], shift[1] + far * out[1], shift[2])
    distance = sweep(solids, target.solids(), (-out[0], -out[1], 0.0), gap=place.clearance, start=start)
    return 0.0 if distance is None else far - distance
