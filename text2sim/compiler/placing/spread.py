"""Puts copies at their places in the pattern of their body."""

from collections.abc import Sequence
from itertools import repeat as again

from text2sim.compiler.placing.divisions import divided
from text2sim.compiler.placing.packing import PackingError, grain_of, pack
from text2sim.compiler.placing.patterns import bond_slots, pattern_slots
from text2sim.compiler.placing.place_error import PatternError
from text2sim.compiler.shapes.rotation import IDENTITY, Vec, quat_multiply, quat_rotate, vector_plus
from text2sim.compiler.shapes.sizes import CopySpot, Sizes
from text2sim.compiler.shapes.space import SpaceError
from text2sim.spec_schema.models.repeat import Divided, Line, Packing, Repeat, RunningBond, Stack
from text2sim.spec_schema.models.shapes import Box


def spread(repeat: Repeat, spots: Sequence[CopySpot], sizes: Sizes) -> list[CopySpot]:
    """Return the copies at their places in a pattern.

    Args:
        repeat: The pattern.
        spots: The copies, each at its body's own position and orientation.
        sizes: Bounds of the copies, for stacks and packings.

    Raises:
        PatternError: if the pattern cannot be made of these copies.
        AssetError: if a font or picture cannot be used.
    """
    if isinstance(repeat, Divided):
        return divided(repeat, spots, sizes.folder)
    if isinstance(repeat, Packing):
        return _packed(repeat, spots, sizes)
    if isinstance(repeat, Stack):
        return _stacked(repeat, spots, sizes)
    if isinstance(repeat, RunningBond):
        return _bonded(repeat, spots)
    start = repeat.start if isinstance(repeat, Line) else None
    if start is not None and any(any(spot.pos) for spot in spots):
        raise PatternError("a line with a `start` begins there; leave out `start` or `pos`", "pose", "pos")
    starts = again(start) if start is not None else (spot.pos for spot in spots)
    return [
        spot._replace(
            pos=vector_plus(base, slot.offset),
            quat=spot.quat if slot.turn == IDENTITY else quat_multiply(slot.turn, spot.quat),
        )
        for spot, base, slot in zip(spots, starts, pattern_slots(repeat), strict=False)
    ]


def _stacked(stack: Stack, spots: Sequence[CopySpot], sizes: Sizes) -> list[CopySpot]:
    """Stack copies: each keeps its own x and y, and the first one its height."""
    found: list[CopySpot] = []
    top = None
    for spot in spots:
        low, high = sizes.of(spot)
        z = spot.pos[2] if top is None else top + stack.gap - low[2]
        top = z + high[2]
        found.append(spot._replace(pos=(spot.pos[0], spot.pos[1], z)))
    return found


def _bonded(bond: RunningBond, spots: Sequence[CopySpot]) -> list[CopySpot]:
    box = spots[0].shape
    if not isinstance(box, Box):
        raise PatternError("a running bond is made of boxes", "shape")
    try:
        slots = bond_slots(bond, box)
    except ValueError as error:
        raise PatternError(str(error), "repeat", "gap") from None
    halves: dict[Vec, Box] = {}
    found = []
    for spot, slot in zip(spots, slots, strict=True):
        offset = slot.offset if spot.quat == IDENTITY else quat_rotate(spot.quat, slot.offset)
        shape = spot.shape
        if slot.size is not None:
            shape = halves.setdefault(slot.size, Box.model_construct(kind="box", size=slot.size))
        found.append(spot._replace(pos=vector_plus(spot.pos, offset), shape=shape))
    return found


def _packed(packing: Packing, spots: Sequence[CopySpot], sizes: Sizes) -> list[CopySpot]:
    if any(any(spot.pos) for spot in spots):
        raise PatternError("a packing lies in its region, which is in the world; leave out `pos`", "pose", "pos")
    grains = [grain_of(None if s.shape is None else s.shape.kind, sizes.of(s, IDENTITY)) for s in spots]
    try:
        packed = pack(packing, grains, [spot.quat for spot in spots])
    except SpaceError as error:
        raise PatternError(str(error), "repeat", "region") from None
    except PackingError as error:
        raise PatternError(str(error), "repeat") from None
    return [spot._replace(pos=pos, quat=quat) for spot, (pos, quat) in zip(spots, packed, strict=True)]
