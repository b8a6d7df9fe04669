"""What is found among many pieces is what is found pair by pair."""

import math
import random

import pytest

from text2sim.compiler.shapes.gjk import distance
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import quat_normalize, vector_unit
from text2sim.compiler.shapes.solid import Solid, shrunk
from text2sim.compiler.shapes.sweep import least_distance, sweep


def crowd(chance, count, middle):
    """Boxes, balls and rods about a point."""
    made = []
    for _ in range(count):
        kind, size = chance.choice([("box", (0.2, 0.1, 0.3)), ("sphere", (0.1,)), ("cylinder", (0.05, 0.4))])
        pos = tuple(m + chance.uniform(-2, 2) for m in middle)
        made.append(Solid(Piece(kind, size=size), pos, quat_normalize([chance.gauss(0, 1) for _ in range(4)])))
    return made


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("gap", [0.0, 0.05])
def test_a_sweep_of_many_is_the_shortest_of_all(seed, gap):
    chance = random.Random(seed)
    direction = vector_unit([chance.gauss(0, 1) for _ in range(3)]) if seed else (0.0, 0.0, -1.0)
    others = crowd(chance, 60, (0, 0, 0))
    movers = crowd(chance, 30, tuple(-8 * c for c in direction))
    start = (0.3, -0.2, 0.1)
    ways = [sweep([m], [o], direction, gap=gap, start=start) for m in movers for o in others]
    shortest = min(way for way in ways if way is not None)
    assert sweep(movers, others, direction, gap=gap, start=start) == pytest.approx(shortest, abs=1e-6)
    assert sweep(movers, others, tuple(-c for c in direction), gap=gap, start=start) is None


def test_the_least_distance_is_that_of_the_nearest_pair():
    chance = random.Random(7)
    others, movers = crowd(chance, 1100, (0, 0, 0)), crowd(chance, 3, (3, 2, 2))
    nearest = min(distance(m, o, (0.5, 0, 0)) for m in movers for o in others)
    assert nearest > 0
    assert least_distance(movers, others, start=(0.5, 0, 0)) == pytest.approx(nearest, abs=1e-7)
    assert least_distance(movers, others[:9], start=(0.5, 0, 0), enough=1e-3) == 1e-3
    assert least_distance(movers, [*others, movers[0]]) == 0.0


def test_a_span_is_how_far_a_solid_reaches():
    solid = Solid(Piece("capsule", size=(0.1, 1.0)), (1, 2, 3), (math.sqrt(0.5), 0, math.sqrt(0.5), 0))
    assert solid.span((1.0, 0.0, 0.0)) == pytest.approx((0.4, 1.6))
    assert solid.span((0.0, 0.0, 1.0)) == pytest.approx((2.9, 3.1))
    assert shrunk(solid, 0.5).span((1.0, 0.0, 0.0)) == pytest.approx((0.7, 1.3))
