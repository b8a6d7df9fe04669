"""Placement of the copies of one body: each by itself, or all together as a pattern."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

from text2sim.compiler.placing.around import along_axis
from text2sim.compiler.placing.footing import face_under
from text2sim.compiler.placing.group import PlacedGroup
from text2sim.compiler.placing.patterns import Variables, pattern_middle
from text2sim.compiler.placing.place_error import PatternError, PlaceError
from text2sim.compiler.placing.relations import height_on, settle
from text2sim.compiler.placing.spread import spread
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    ORIGIN,
    X_AXIS,
    Z_AXIS,
    Vec,
    frame_apply,
    quat_between,
    quat_from_yaw,
    quat_multiply,
    quat_of,
    quat_rotate,
    vector_plus,
)
from text2sim.compiler.shapes.sizes import CopySpot, Sizes
from text2sim.spec_schema.models.place_rules import contradictions
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.repeat import Line, Packing, Repeat, Ring, RunningBond, Spiral
from text2sim.spec_schema.names.selectors import parse_selector

COPYWISE_KEYS = ("at", "inset", "direction", "align", "clearance", "offset")
"""Keys of a place, besides its relation: if one differs from copy to copy, copies are placed one by one."""
LEVEL = 1e-9
"""Difference of heights [m] that counts as none."""
_MAX_ROUNDS = 40
_FACING_TOLERANCE = 1e-12
"""Largest angle [rad] between the direction in which a copy faces and that of its target."""
_ROUGH_FACING_TOLERANCE = 1e-6
"""Largest such angle [rad] that is accepted where rounding or rough bounds allow no better."""


@dataclass(slots=True)
class PlacementEntry:
    """A body or static that is to be placed."""

    name: str
    root: tuple[str, ...]
    """Its path in the case."""
    model: Any
    repeat: Repeat | None
    variables: list[Variables]
    """Variables of each copy."""
    models: list[Any]
    """The model as each copy has it."""
    alone: bool = False
    """Whether its place differs from copy to copy."""


class PlacementTargets:
    """Everything that is already placed, to which places of further bodies may refer.

    Args:
        find: Returns the copies that a selector means, or raises PlaceError for the given key of `place`.
        sizes: Bounds and pieces.
    """

    def __init__(self, find: Callable[[str, str], list[CopySpot]], sizes: Sizes) -> None:
        self.sizes = sizes
        self.spots = cache(find)
        """The copies that a selector means."""
        self.group = cache(lambda selector, key: PlacedGroup(self.spots(selector, key), sizes))
        """All that a selector means, as one group."""

    def partner(self, entry: PlacementEntry, index: int) -> PlacedGroup:
        """Return what one copy is placed in relation to: the copy of the same index, if brackets name several.

        Raises:
            PlaceError: if brackets name another number of copies than there are.
        """
        place: Place = entry.models[index].place
        selector, key = place.target, place.relation
        if not _pairs(entry, selector):
            return self.group(selector, key)
        spots = self.spots(selector, key)
        if len(spots) == 1:
            return self.group(selector, key)
        if len(spots) != len(entry.models):
            name = parse_selector(selector).body
            raise PlaceError(
                f"copies are placed one by one where brackets name several, and `{selector}` means {len(spots)}, "
                f"`{entry.name}` has {len(entry.models)}; `{name}` means all of them together",
                key,
                "pairs",
            )
        return PlacedGroup([spots[index]], self.sizes)

    def frame(self, entry: PlacementEntry, index: int) -> CopySpot:
        """Return the copy in whose frame one copy is placed.

        Raises:
            PlaceError: if the selector means several.
        """
        group, selector = self.partner(entry, index), entry.models[index].place.target
        spots = [*group.members, *group.planes]
        if len(spots) > 1:
            name = parse_selector(selector).body
            message = f"`{selector}` means {len(spots)} copies, and a frame is that of one, such as `{name}[0]`"
            raise PlaceError(message, "relative_to")
        return spots[0]


def arrange(entry: PlacementEntry, targets: PlacementTargets) -> list[CopySpot]:
    """Return the copies of a body where they start.

    Raises:
        PlaceError: if there is no such place.
        PatternError: if its pattern cannot be made.
    """
    spots = _oriented(entry, targets)
    before, steps = list[float](), list[float]()
    nearest, best = _ROUGH_FACING_TOLERANCE, None
    # Its position decides which way is towards its target, and its rotation may change its position.
    for _ in range(_MAX_ROUNDS):
        placed = _arranged(entry, spots, targets)
        off = _facing_errors(entry, placed, targets)
        left = max(map(abs, off), default=0.0)
        if left <= _FACING_TOLERANCE:
            return placed
        if left < nearest:
            nearest, best = left, placed
        steps = [_step(*row) for row in zip(off, before, steps, strict=True)] if steps else off
        before = off
        turns = [quat_from_yaw(step) for step in steps]
        spots = [s._replace(quat=quat_multiply(turn, s.quat)) for s, turn in zip(spots, turns, strict=True)]
    if best is not None:
        return best
    raise PlaceError("turning moves it, too, so that it never faces that; say `euler_deg`", "facing")


def _step(off: float, before: float, step: float) -> float:
    """Return how far [rad] to turn next, from what the last step gained, since turning also moves the copy."""
    gain = (before - off) / step if step else 1.0
    return min(max(off / min(max(gain, 0.2), 5.0), -1.0), 1.0)


def _pairs(entry: PlacementEntry, selector: str) -> bool:
    """Return whether copies are paired with what a selector with brackets means."""
    chosen = parse_selector(selector)
    one = chosen.first is not None and chosen.last == chosen.first + 1
    return entry.repeat is not None and chosen.indexed and not one


def _ringed(entry: PlacementEntry) -> bool:
    """Return whether copies surround something together, instead of each going round it."""
    together = not entry.alone and not _pairs(entry, entry.model.place.target)
    return together and isinstance(entry.repeat, Ring | Spiral)


def _oriented(entry: PlacementEntry, targets: PlacementTargets) -> list[CopySpot]:
    """Return the copies at the origin, oriented by their poses and places."""
    found: list[CopySpot] = []
    before, quat = None, IDENTITY
    rings = entry.model.place is not None and entry.model.place.around is not None and not _ringed(entry)
    for index, model in enumerate(entry.models):
        place: Place | None = model.place
        flush = None if place is None else place.flush_deg
        if model is not before or rings or flush is not None:
            before = model
            where = model.pose or model.place
            try:
                quat = IDENTITY if where is None else quat_of(where)
            except ValueError as error:
                raise PlaceError(str(error), "quat") from None
            if place is not None and flush is not None:
                leaning = quat_between(Z_AXIS, face_under(place, targets.partner(entry, index)))
                quat = quat_multiply(leaning, quat_from_yaw(math.radians(flush)))
            if rings and place is not None and place.quat is None and place.euler_deg is None:
                quat = along_axis(targets.partner(entry, index))
        found.append(CopySpot(ORIGIN, quat, getattr(model, "shape", None), model))
    return found


def _arranged(entry: PlacementEntry, spots: list[CopySpot], targets: PlacementTargets) -> list[CopySpot]:
    model, repeat = entry.model, entry.repeat
    place: Place | None = model.place
    if place is None:
        if model.pose is not None:
            spots = [spot._replace(pos=spot.model.pose.pos) for spot in spots]
        return spots if repeat is None else spread(repeat, spots, targets.sizes)
    if isinstance(repeat, Packing):
        raise PatternError("a packing lies in its region, which is in the world; leave out `place`", "place")
    if isinstance(repeat, Line) and repeat.start is not None:
        raise PatternError("a line with a `start` has its place; leave out `start` or `place`", "place")
    if place.relation == "relative_to":
        return _in_frames(entry, spots, targets)
    if repeat is None:
        return [
            _move_spot(spots[0], settle(place, PlacedGroup(spots, targets.sizes), targets.partner(entry, 0), ORIGIN))
        ]
    if _pairs(entry, place.target):
        spots = [spot._replace(pos=ORIGIN) for spot in spread(repeat, spots, targets.sizes)]
        return _one_by_one(entry, spots, targets)
    if entry.alone:
        return spread(repeat, _one_by_one(entry, spots, targets), targets.sizes)
    spots = spread(repeat, spots, targets.sizes)
    goal, middle = targets.partner(entry, 0), pattern_middle(repeat)
    if place.flush_deg is not None:
        # The pattern leans with its copies: left level, only one copy would rest on the slope.
        lean = quat_between(Z_AXIS, face_under(place, goal))
        spots = [spot._replace(pos=quat_rotate(lean, spot.pos)) for spot in spots]
        middle = quat_rotate(lean, middle)
    shift = settle(place, PlacedGroup(spots, targets.sizes), goal, middle, ringed=_ringed(entry))
    spots = [_move_spot(spot, shift) for spot in spots]
    alike = all(model is entry.models[0] for model in entry.models)
    return spots if alike or place.relation != "on" else _let_down(place, spots, goal, targets.sizes)


def _let_down(place: Place, spots: list[CopySpot], goal: PlacedGroup, sizes: Sizes) -> list[CopySpot]:
    """Return the copies of a level pattern, each where it stands; as a group, only the one that reaches lowest does."""
    alone = [PlacedGroup([spot], sizes) for spot in spots]
    below = [group.lowest(Z_AXIS) - spot.pos[2] for group, spot in zip(alone, spots, strict=True)]
    if _spread(spot.pos[2] for spot in spots) > LEVEL or _spread(below) <= LEVEL:
        return spots
    found = []
    for group, spot in zip(alone, spots, strict=True):
        try:
            drop = height_on(place, group, goal, 0.0, 0.0) + place.offset[2]
        except PlaceError:  # it stands beside the goal, held by its pattern
            drop = 0.0
        found.append(_move_spot(spot, (0.0, 0.0, min(drop, 0.0))))
    return found


def _spread(values: Iterable[float]) -> float:
    found = list(values)
    return max(found) - min(found)


def _in_frames(entry: PlacementEntry, spots: list[CopySpot], targets: PlacementTargets) -> list[CopySpot]:
    """Return copies that are placed and oriented in the frames of other copies."""
    for key, message in contradictions(entry.models[0].place):
        raise PlaceError(message, key)
    at = [spot.model.place.pos or ORIGIN for spot in spots]
    own = [spot._replace(pos=pos) for spot, pos in zip(spots, at, strict=True)]
    if entry.repeat is not None:
        own = spread(entry.repeat, own, targets.sizes)
    if _pairs(entry, entry.model.place.target):
        own = [spot._replace(pos=pos) for spot, pos in zip(own, at, strict=True)]
    frames = [targets.frame(entry, index) for index in range(len(own))]
    return [
        spot._replace(pos=frame_apply(frame.pos, frame.quat, spot.pos), quat=quat_multiply(frame.quat, spot.quat))
        for frame, spot in zip(frames, own, strict=True)
    ]


def _one_by_one(entry: PlacementEntry, spots: list[CopySpot], targets: PlacementTargets) -> list[CopySpot]:
    found = []
    for index, spot in enumerate(spots):
        goal = targets.partner(entry, index)
        try:
            shift = settle(spot.model.place, PlacedGroup([spot], targets.sizes), goal, ORIGIN)
        except PlaceError as error:
            raise PlaceError(f"copy {index}: {error}", error.key, error.rule, error.hint) from None
        found.append(_move_spot(spot, shift))
    return found


def _facing_errors(entry: PlacementEntry, placed: list[CopySpot], targets: PlacementTargets) -> list[float]:
    """Return the angles [rad] about the vertical by which copies must turn to face their targets, if they face any."""
    if entry.model.place is None or entry.model.place.facing is None:
        return []
    if isinstance(entry.repeat, RunningBond):
        raise PlaceError("a wall faces nothing; turn it with `euler_deg`", "facing")
    found = []
    for spot in placed:
        facing = spot.model.place.facing
        goal = targets.group(facing, "facing").middle() if isinstance(facing, str) else facing
        x, y = goal[0] - spot.pos[0], goal[1] - spot.pos[1]
        ahead = quat_rotate(spot.quat, X_AXIS)
        if math.hypot(x, y) < 1e-9:
            raise PlaceError("it is right above or below what it should face", "facing")
        if math.hypot(ahead[0], ahead[1]) < 1e-9:
            raise PlaceError("its +x axis, which should face it, points straight up or down", "facing")
        found.append(math.remainder(math.atan2(y, x) - math.atan2(ahead[1], ahead[0]), 2 * math.pi))
    return found


def _move_spot(spot: CopySpot, shift: Vec) -> CopySpot:
    return spot._replace(pos=vector_plus(spot.pos, shift))
