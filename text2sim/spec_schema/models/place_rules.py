"""Rules about the words of a place that need no geometry."""

from collections.abc import Iterator

from text2sim.spec_schema.models.base import AXES
from text2sim.spec_schema.models.placement import Align, Place
from text2sim.spec_schema.models.regions import BodyRegion

STANDING = ("on", "above", "below", "inside")
"""Relations that decide the height, and leave x and y open."""
SIDES: dict[str, tuple[float, float, float]] = {
    "left_of": (-1.0, 0.0, 0.0),
    "right_of": (1.0, 0.0, 0.0),
    "in_front_of": (0.0, -1.0, 0.0),
    "behind": (0.0, 1.0, 0.0),
}
"""Relations to a side of the world."""
_NAMES = "xyz"
_TINY = 1e-9


def direction_of(place: Place) -> tuple[float, float, float]:
    """Return the side from which a body comes or at which it stands; not normalised."""
    if place.relation in SIDES:
        return SIDES[place.relation]
    given = place.direction
    if given is None:
        given = "x" if place.relation == "beside" else "z"
    return AXES[given] if isinstance(given, str) else given


def contradictions(place: Place) -> Iterator[tuple[str, str]]:
    """What is said in a place but has no meaning there, or is said twice: the word, and why."""
    relation = place.relation
    yield from _about_at(place, relation)
    if place.direction is not None:
        if relation not in ("beside", "touching"):
            yield "direction", f"`direction` has no meaning with `{relation}`; it goes with beside and touching"
        elif relation == "beside" and abs(direction_of(place)[2]) > _TINY:
            yield "direction", "`beside` means a level side: z must be 0; over and under are `above` and `below`"
    if place.align is not None:
        yield from _about_align(place, relation)
    if place.flush_deg is not None:
        other = next((key for key in ("quat", "euler_deg", "facing") if getattr(place, key) is not None), None)
        if relation not in ("on", "above"):
            yield "flush_deg", f"`flush_deg` has no meaning with `{relation}`; it goes with on and above"
        elif other is not None:
            yield "flush_deg", f"`flush_deg` decides how it is turned, and so does `{other}`; leave out one of the two"


def _about_at(place: Place, relation: str) -> Iterator[tuple[str, str]]:
    at = place.at
    if at is not None and relation not in STANDING:
        if relation != "touching":
            yield "at", f"`at` has no meaning with `{relation}`; `align` and `offset` say the rest"
        elif not isinstance(at, BodyRegion):
            yield "at", "`at: [x, y]` has no meaning with `touching`; a region of the other has, `at: {face: top}`"
    sides = isinstance(at, BodyRegion) and at.sides
    if "inset" in place.model_fields_set and (not sides or relation == "touching"):
        yield "inset", "`inset` goes with a side, an edge or a corner of the other in `at`: `at: {edge: left}`"


def _about_align(place: Place, relation: str) -> Iterator[tuple[str, str]]:
    if isinstance(place.align, Align) and not place.align.model_fields_set:
        yield "align", "says nothing; it takes x, y, z"
    for axis in range(3):
        if place.alignment(axis) is None:
            continue
        why = _decided(place, relation, axis)
        if why is not None:
            yield "align", why
            return


def _decided(place: Place, relation: str, axis: int) -> str | None:
    """Why nothing is left to align along an axis; None if there is."""
    name = "the height" if axis == 2 else _NAMES[axis]
    if relation in STANDING:
        if axis == 2:
            return f"`{relation}` decides the height itself; a gap is said by `clearance` or `offset`"
        return f"`at` decides {name} already; leave out one of the two" if place.at is not None else None
    if relation == "around":
        return None if axis == 2 else f"`around` decides {name} itself; `offset` moves it from there"
    if abs(direction_of(place)[axis]) > _TINY:
        return f"`{relation}` decides {name} itself, as its direction is not across; `offset` moves it from there"
    if place.at is not None:
        return f"`at` decides {name} already; leave out one of the two"
    return None
