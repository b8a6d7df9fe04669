"""Checks of placements that need no geometry."""

from collections.abc import Iterator

from text2sim.spec_schema.models.base import AXES
from text2sim.spec_schema.models.placement import Align, Place
from text2sim.spec_schema.models.regions import BodyRegion

STANDING = ("on", "above", "below", "inside")
"""Relations that determine the height and leave x and y open."""
SIDES: dict[str, tuple[float, float, float]] = {
    "left_of": (-1.0, 0.0, 0.0),
    "right_of": (1.0, 0.0, 0.0),
    "in_front_of": (0.0, -1.0, 0.0),
    "behind": (0.0, 1.0, 0.0),
}
"""Direction in the world of each relation to a side."""
_ELSEWHERE = ("at", "inset", "direction", "align", "clearance", "offset", "facing", "flush_deg")
"""Fields that have no meaning in the frame of another body."""
_NAMES = "xyz"
_TINY = 1e-9


def direction_of(place: Place) -> tuple[float, float, float]:
    """Return the direction, not normalised, from the other body to a body that is beside it or moves towards it."""
    if place.relation in SIDES:
        return SIDES[place.relation]
    given = place.direction
    if given is None:
        given = "x" if place.relation == "beside" else "z"
    return AXES[given] if isinstance(given, str) else given


def contradictions(place: Place) -> Iterator[tuple[str, str]]:
    """Yield each field of a placement that has no effect or is redundant, with the reason."""
    relation = place.relation
    if relation == "relative_to":
        for field in _ELSEWHERE:
            if field in place.model_fields_set and getattr(place, field) is not None:
                yield field, f"`{field}` has no effect with `relative_to`; give pos, and quat or euler_deg"
        return
    if place.pos is not None:
        yield "pos", f"`pos` has no effect with `{relation}`; it belongs to relative_to; use `at` or `offset`"
    yield from _about_at(place, relation)
    if place.direction is not None:
        if relation not in ("beside", "touching"):
            yield "direction", f"`direction` has no effect with `{relation}`; it belongs to beside and touching"
        elif relation == "beside" and abs(direction_of(place)[2]) > _TINY:
            yield "direction", "with `beside`, z of `direction` must be 0; use `above` or `below` for other heights"
    if place.align is not None:
        yield from _about_align(place, relation)
    if place.flush_deg is not None:
        other = next((key for key in ("quat", "euler_deg", "facing") if getattr(place, key) is not None), None)
        if relation not in ("on", "above"):
            yield "flush_deg", f"`flush_deg` has no effect with `{relation}`; it belongs to on and above"
        elif other is not None:
            yield "flush_deg", f"`flush_deg` and `{other}` both determine the orientation; give only one of them"


def _about_at(place: Place, relation: str) -> Iterator[tuple[str, str]]:
    at = place.at
    if at is not None and relation not in STANDING:
        if relation != "touching":
            yield "at", f"`at` has no effect with `{relation}`; use `align` and `offset`"
        elif not isinstance(at, BodyRegion):
            yield "at", "`at: [x, y]` has no effect with `touching`; give a region of the other, such as `{face: top}`"
    sides = isinstance(at, BodyRegion) and at.sides
    if "inset" in place.model_fields_set and (not sides or relation == "touching"):
        yield "inset", "`inset` needs a side, an edge or a corner of the other in `at`, such as `at: {edge: left}`"


def _about_align(place: Place, relation: str) -> Iterator[tuple[str, str]]:
    if isinstance(place.align, Align) and not place.align.model_fields_set:
        yield "align", "is empty; give x, y or z"
    for axis in range(3):
        if place.alignment(axis) is None:
            continue
        why = _decided(place, relation, axis)
        if why is not None:
            yield "align", why
            return


def _decided(place: Place, relation: str, axis: int) -> str | None:
    """Return why a relation leaves no alignment open along an axis; None if it does."""
    name = "the height" if axis == 2 else _NAMES[axis]
    if relation in STANDING:
        if axis == 2:
            return f"`{relation}` already determines the height; use `clearance` or `offset` for a gap"
        return f"`at` already determines {name}; give only one of them" if place.at is not None else None
    if relation == "around":
        return None if axis == 2 else f"`around` already determines {name}; use `offset` to change it"
    if abs(direction_of(place)[axis]) > _TINY:
        return f"`{relation}` already determines {name} by its direction; use `offset` to change it"
    if place.at is not None:
        return f"`at` already determines {name}; give only one of them"
    return None
