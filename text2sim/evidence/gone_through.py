"""Detection of rigid bodies that are inside others, or tunnelled through them between two frames.

If the centre of a convex piece is inside another piece or below a ground, no contact brings it back to the side that
it came from. Hollow bodies with a single surface are skipped, because their inside is undefined.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from text2sim.evidence.leaks import half_size
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.rigid_shapes import world_frames
from text2sim.evidence.selection import RecordedTarget
from text2sim.evidence.solids import LinkSolid
from text2sim.recording.states import Array
from text2sim.spec_schema.models.bodies import Driven, Rigid
from text2sim.spec_schema.models.controls import Attach
from text2sim.spec_schema.names.selectors import body_of

MAX_PAIRS = 10_000
"""Most pairs of pieces whose paths are compared; the rest of a huge heap is left out."""
MAX_TURN = 0.3
"""Turn [rad] between two frames beyond which paths in the turning frame are no longer straight."""
MAX_LISTED_PAIRS = 5
"""Most pairs of bodies that are listed."""


@dataclass(frozen=True)
class _Piece:
    target: RecordedTarget
    solid: LinkSolid
    pos: Array
    """Position of its frame [m], (F, 3)."""
    turn: Array
    """Rotation matrices of its frame, (F, 3, 3)."""
    middle: Array
    """Its centre [m], (F, 3); for a ground, the origin of its frame."""
    box: tuple[Array, Array]
    """Lowest and highest corner [m] of everywhere it was; infinite for a ground."""


def gone_through(recording: RecordedCase) -> list[str]:
    """Return a message for each pair of bodies one of which is wholly inside or beyond the other."""
    if not recording.states.frames:
        return []
    pieces = [*_pieces(recording)]
    loose, links = recording.names.loose, recording.states.links
    movers = [piece for piece in pieces if piece.target in loose and not links[piece.target.root].fixed]
    found: dict[frozenset[str], tuple[int, str, str, str]] = {}
    held = _held_together(recording)
    for mover, other in _pairs_in_reach(movers, pieces):
        names = frozenset(body_of(piece.target.copy) for piece in (mover, other))
        if names in held:
            continue
        seen = _first_below(recording, mover, other) if other.solid.kind == "plane" else _inside(mover, other)
        if seen is not None and seen[0] < found.get(names, (recording.states.frames,))[0]:
            found[names] = (*seen, mover.target.copy, other.target.copy)
    rows = sorted(found.values())
    sentences = [_sentence(recording, *row) for row in rows[:MAX_LISTED_PAIRS]]
    return sentences + (
        [f"{len(rows) - MAX_LISTED_PAIRS} more pairs of bodies do the same"] if len(rows) > MAX_LISTED_PAIRS else []
    )


def _sentence(recording: RecordedCase, frame: int, what: str, mover: str, other: str) -> str:
    if not frame:
        return f"`{mover}` {what} `{other}` from the start"
    advice = "more substeps, or less difference in mass and size, would prevent it"
    return f"`{mover}` {what} `{other}` at {recording.states.time[frame]:.3g} s: {advice}"


def _pieces(recording: RecordedCase) -> Iterator[_Piece]:
    """Yield the rigid pieces: convex bodies, or the convex pieces that a body is made of."""
    for name, target in recording.names.copies.items():
        model = recording.case.bodies.get(body_of(name))
        if target.soft is not None or not (model is None or isinstance(model, Rigid | Driven)):
            continue
        for link, solid in recording.shapes.of_links(target.links):
            if solid.kind == "surface":
                continue
            pos, turn = world_frames(recording.states, link, solid)
            if solid.kind == "plane":
                yield _Piece(target, solid, pos, turn, pos, (np.full(3, -np.inf), np.full(3, np.inf)))
                continue
            low, high = solid.bounds
            middle = pos + turn @ ((low + high) / 2)
            reach = np.abs(turn) @ ((high - low) / 2)
            with np.errstate(invalid="ignore"):
                box = np.fmin.reduce(middle - reach), np.fmax.reduce(middle + reach)  # nan after leaving the scene
            yield _Piece(target, solid, pos, turn, middle, box)


def _pairs_in_reach(movers: Sequence[_Piece], pieces: Sequence[_Piece]) -> Iterator[tuple[_Piece, _Piece]]:
    """Yield pairs of pieces of different bodies where the first's centre enters the swept box of the second."""
    if not movers:
        return
    low = np.array([piece.box[0] for piece in pieces])
    high = np.array([piece.box[1] for piece in pieces])
    count = 0
    for mover in movers:
        first, last = np.fmin.reduce(mover.middle), np.fmax.reduce(mover.middle)
        for k in np.flatnonzero(((low < last) & (high > first)).all(axis=1)).tolist():
            if pieces[k].target is not mover.target and count < MAX_PAIRS:
                count += 1
                yield mover, pieces[k]


def _held_together(recording: RecordedCase) -> set[frozenset[str]]:
    """Return pairs of bodies that the case welds together, which do not collide."""
    holds = [control for control in recording.case.actions.controls.values() if isinstance(control, Attach)]
    return {frozenset(body_of(name) for name in (hold.body, hold.to)) for hold in holds}


def _first_below(recording: RecordedCase, mover: _Piece, ground: _Piece) -> tuple[int, str] | None:
    """Return the first frame with a centre below a ground, unless it came from the side, and how it got there."""
    own = _seen_from(ground, mover.middle)
    low, high = mover.solid.bounds
    # Half its extent along the ground's normal.
    half = np.abs(ground.turn[:, None, :, 2] @ mover.turn)[:, 0] @ ((high - low) / 2)
    size = half_size(recording, ground.target.root)
    over = np.all(np.abs(own[:, :2]) < size, axis=1)
    if own[0, 2] < -half[0]:
        return (0, "is under") if over[0] else None
    under = (own[:, 2] < 0.0) & over
    if not under.any():
        return None
    frame = int(np.argmax(under))
    if frame and not over[frame - 1]:
        return None  # it came in from the side
    wholly = np.flatnonzero(own[frame:, 2] < -half[frame:])
    return (frame + int(wholly[0]), "is through") if len(wholly) else (frame, "is more than half in")


def _inside(mover: _Piece, other: _Piece) -> tuple[int, str] | None:
    """Return the first frame with a centre inside a piece, or through it since the last, and how it got there."""
    own = _seen_from(other, mover.middle)
    low, high = other.solid.bounds
    with np.errstate(invalid="ignore"):
        near = np.flatnonzero(((own > low) & (own < high)).all(axis=1))
    inside = near[other.solid.distance(own[near]) < 0.0] if len(near) else near
    if len(inside):
        return int(inside[0]), "is inside"
    passed = _passes(own, other, low, high)
    return None if passed is None else (passed, "is through")


def _passes(own: Array, other: _Piece, low: Array, high: Array) -> int | None:
    """Return the first frame before which a point went through a box, from one side to the opposite one."""
    a, b = own[:-1], own[1:]
    with np.errstate(all="ignore"):
        to_low, to_high = (low - a) / (b - a), (high - a) / (b - a)
        enters, leaves = np.minimum(to_low, to_high), np.maximum(to_low, to_high)
        at, till = enters.max(axis=1), leaves.min(axis=1)
        straight = enters.argmax(axis=1) == leaves.argmin(axis=1)
        rows = np.flatnonzero((at > 0.0) & (till < 1.0) & (at < till) & straight)
    for k in rows.tolist():
        cosine = (np.trace(other.turn[k].T @ other.turn[k + 1]) - 1) / 2
        middle = a[k] + (b[k] - a[k]) * (at[k] + till[k]) / 2
        if cosine > np.cos(MAX_TURN) and other.solid.distance(middle[None])[0] < 0.0:
            return k + 1
    return None


def _seen_from(piece: _Piece, points: Array) -> Array:
    """Return points (F, 3) in the frame of a piece."""
    return ((points - piece.pos)[:, None] @ piece.turn)[:, 0]
