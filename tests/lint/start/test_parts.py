"""Bounding boxes of pieces, pairs of near boxes, and translations that resolve overlaps."""

import random

import pytest

from text2sim.compiler.shapes.boxes import Bounds, apart, union
from text2sim.compiler.shapes.piece import Piece, cone_piece, ring_pieces, wall_pieces
from text2sim.compiler.shapes.rotation import quat_from_euler_deg
from text2sim.lint.parts import StandingPart, near
from text2sim.lint.start.escape import AXES, Effort, axes_first, overlap_of, overlapping


def boxes(seed: int, count: int) -> list[Bounds]:
    rng = random.Random(seed)
    found = []
    for _ in range(count):
        size = 3.0 if rng.random() < 0.05 else rng.uniform(0.01, 0.3)
        low = tuple(rng.uniform(-1, 1) for _ in range(3))
        found.append((low, tuple(a + size for a in low)))
    return found


@pytest.mark.parametrize("count", [0, 1, 2, 60, 300])
def test_no_pair_is_missed_and_none_comes_twice(count: int) -> None:
    some = boxes(count, count)
    wanted = [(i, j) for i in range(count) for j in range(i + 1, count) if not apart(some[i], some[j])]
    found = list(near(some, 0.0))
    assert len(set(found)) == len(found)
    assert sorted(found) == wanted


def test_boxes_that_touch_are_apart() -> None:
    a, b = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((1.0, 0.0, 0.0), (2.0, 1.0, 1.0))
    assert apart(a, b)
    assert not apart(a, ((0.9, 0.0, 0.0), (2.0, 1.0, 1.0)))
    assert apart(a, ((0.9, 0.0, 0.0), (2.0, 1.0, 1.0)), slack=0.11)
    assert union([a, b]) == ((0.0, 0.0, 0.0), (2.0, 1.0, 1.0))


def test_a_turned_piece_has_its_exact_box() -> None:
    part = StandingPart(
        Piece("box", size=(1.0, 1.0, 1.0)), (5.0, 0.0, 0.0), quat_from_euler_deg((0, 0, 45)), True, None
    )
    low, high = part.box
    assert low == pytest.approx((5 - 0.5**0.5, -(0.5**0.5), -0.5))
    assert high == pytest.approx((5 + 0.5**0.5, 0.5**0.5, 0.5))
    assert part.lowest((1.0, 0.0, 0.0)) == pytest.approx(5 - 0.5**0.5)


def standing(pieces: list[Piece], x: float) -> list[StandingPart]:
    return [StandingPart(piece, (x, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), True, None) for piece in pieces]


def test_the_way_out_of_a_hollow_leads_past_every_piece() -> None:
    # A ball in the bar of a ring: the ring goes up by ball and bar, or outwards into the hole.
    ring, ball = standing(ring_pieces(0.5, 0.1, 32), 0.0), standing([Piece("sphere", size=(0.05,))], 0.5)
    pairs = [(a, b) for a in ring for b in ball if overlapping(a, b)]
    overlap = overlap_of(ring, ball, pairs, Effort(10_000))
    best = axes_first(overlap.escapes)[0]
    assert best.length == pytest.approx(0.15, abs=0.002)
    assert best.words in AXES.values()


def test_a_way_out_ends_free() -> None:
    tube = standing(wall_pieces((0.4, 0.5), (0.4, 0.5), -0.5, 0.5, 24), 0.0)
    rod = standing([Piece("box", size=(1.2, 0.05, 0.05))], 0.1)
    pairs = [(a, b) for a in rod for b in tube if overlapping(a, b)]
    overlap = overlap_of(rod, tube, pairs, Effort(10_000))
    for escape in overlap.escapes:
        shift = tuple((escape.length + 1e-5) * c for c in escape.direction)
        moved = [
            StandingPart(a.piece, tuple(p + s for p, s in zip(a.pos, shift, strict=True)), a.quat, True, None)
            for a in rod
        ]
        assert not any(overlapping(a, b) for a in moved for b in tube), escape


def test_thickness_of_hulls() -> None:
    cone = StandingPart(cone_piece(0.1, 0.3), (0.0, 0.0, 0.0), quat_from_euler_deg((20, 30, 40)), True, None)
    assert cone.thickness == pytest.approx(0.19, abs=0.01), "across its flank, not the side of its polygon"
    (stave, *_) = wall_pieces((0.4, 0.41), (0.4, 0.41), -0.5, 0.5, 24)
    assert standing([stave], 0.0)[0].thickness < 0.0101
