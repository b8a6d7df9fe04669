"""`flush_deg`: bodies that lie with a whole face on what leans."""

import math

import pytest
from place_words import CUBE, HEAD, placed

from text2sim.compiler.shapes.rotation import quat_rotate
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references

BRICK = "kind: rigid, shape: {kind: box, size: [0.3, 0.2, 0.1]}"
FACES = {"ramp": ((0, 30, 0), (-9, 0, 1), 0.05), "hill": ((20, 0, 0), (0, 0, -9), 0.0)}
"""Euler angles [deg] and position [m] of what leans, and how high its face is above that [m]."""


def turn_of(target):
    """The quaternion of what leans, about one axis."""
    leans = FACES[target][0]
    axis = next(k for k in range(3) if leans[k])
    half = math.radians(leans[axis]) / 2
    return [math.cos(half), *(math.sin(half) if k == axis else 0.0 for k in range(3))]


def heights_above(target, copies):
    """How high the middles of copies are above the face of what leans [m]."""
    _, base, face = FACES[target]
    normal = quat_rotate(turn_of(target), (0, 0, 1))
    return [sum(n * (p - q) for n, p, q in zip(normal, copy.pos, base, strict=True)) - face for copy in copies]


@pytest.mark.parametrize("target", FACES)
def test_flush_lies_flat_on_what_leans_turned_about_its_normal(target):
    copies = placed(
        f"level: {{{BRICK}, place: {{on: {target}, flush_deg: 0}}}}",
        f"turned: {{{BRICK}, place: {{on: {target}, flush_deg: 25}}}}",
    )
    (level,), (turned,) = copies["level"], copies["turned"]
    assert level.quat == pytest.approx(turn_of(target))
    assert quat_rotate(turned.quat, (0, 0, 1)) == pytest.approx(quat_rotate(level.quat, (0, 0, 1)))
    a, b = (quat_rotate(copy.quat, (1, 0, 0)) for copy in (level, turned))
    assert sum(x * y for x, y in zip(a, b, strict=True)) == pytest.approx(math.cos(math.radians(25)))
    assert heights_above(target, (level, turned)) == pytest.approx([0.05] * 2, abs=2e-6), "its whole face touches"


@pytest.mark.parametrize(("at", "side"), [("[0, -9.5]", -1), ("[0, -8.6]", 1), ("{face: left}", -1)])
def test_flush_lies_on_the_face_that_is_there(at: str, side: int):
    """On a gable roof, whose ridge runs along x after its turn, the face depends on the place."""
    (copy,) = placed(f"brick: {{{BRICK}, place: {{on: roof, at: {at}, flush_deg: 25}}}}")["brick"]
    normal = (0.0, side / math.sqrt(5), 2 / math.sqrt(5))
    assert quat_rotate(copy.quat, (0, 0, 1)) == pytest.approx(normal)
    height = sum(n * (p - q) for n, p, q in zip(normal, copy.pos, (0, -9, 1.5), strict=True))
    assert height == pytest.approx(0.05, abs=2e-6), "its whole face touches"


@pytest.mark.parametrize("target", FACES)
@pytest.mark.parametrize(
    "pattern", ["{kind: line, count: 3, step: [0.35, 0.1, 0]}", "{kind: grid, counts: [2, 2], spacing: 0.4}"]
)
def test_copies_that_lie_flush_all_touch(target, pattern):
    copies = placed(f"row: {{{BRICK}, place: {{on: {target}, flush_deg: 10}}, repeat: {pattern}}}")["row"]
    assert heights_above(target, copies) == pytest.approx([0.05] * len(copies), abs=2e-6)


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("{touching: ramp, flush_deg: 0}", "it belongs to on and above"),
        ("{on: ramp, flush_deg: 0, euler_deg: [0, 0, 5]}", "`flush_deg` and `euler_deg` both determine"),
    ],
)
def test_flush_goes_with_what_it_can_lie_on(words, why):
    loaded = load_text(HEAD + f"  one: {{{CUBE}, place: {words}}}\n")
    (problem,) = check_references(loaded)
    assert problem.path.endswith("/place/flush_deg")
    assert why in problem.message
