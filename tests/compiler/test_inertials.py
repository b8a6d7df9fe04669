"""Masses and inertias of pieces are those of the solids that they stand for."""

from math import pi

import pytest

from text2sim.compiler.shapes.inertials import Inertial, combined_inertial, piece_inertial
from text2sim.compiler.shapes.piece import Piece, cone_piece, wall_pieces
from text2sim.compiler.shapes.rotation import quat_from_axis_angle
from text2sim.compiler.trees.carried import carried_links
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeJoint, TreeLink

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
O = (0.0, 0.0, 0.0)  # noqa: E741
BOX = Piece("box", size=(0.2, 0.3, 0.4))
CORNERS = tuple((x, y, z) for x in (-0.1, 0.1) for y in (-0.15, 0.15) for z in (-0.2, 0.2))
FACES = (
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
)  # fmt: skip


@pytest.mark.parametrize(
    ("piece", "axis", "wanted"),
    [
        (BOX, X, (0.3**2 + 0.4**2) / 12),
        (Piece("sphere", size=(0.1,)), Y, 0.4 * 0.1**2),
        (Piece("cylinder", size=(0.1, 0.5)), Z, 0.1**2 / 2),
        (Piece("cylinder", size=(0.1, 0.5)), X, (3 * 0.1**2 + 0.5**2) / 12),
        (Piece("ellipsoid", size=(0.1, 0.2, 0.3)), Z, (0.1**2 + 0.2**2) / 5),
        (Piece("hull", vertices=CORNERS, faces=FACES), Y, (0.2**2 + 0.4**2) / 12),
    ],
)
def test_a_solid_turns_as_the_textbook_says(piece: Piece, axis: tuple, wanted: float) -> None:
    inertial = piece_inertial(piece, 1000.0)
    assert inertial.about(O, axis) == pytest.approx(wanted * inertial.mass, rel=1e-9)


def test_a_capsule_is_a_cylinder_and_a_ball() -> None:
    # Two half balls and a cylinder, by the parallel axis theorem (a half ball's centre is 3/8 r off its flat side).
    r, length, rho = 0.1, 0.4, 1000.0
    bar, half = rho * pi * r**2 * length, rho * 2 / 3 * pi * r**3
    ends = 2 * half * (83 / 320 * r**2 + (length / 2 + 3 / 8 * r) ** 2)
    wanted = bar * (3 * r**2 + length**2) / 12 + ends
    assert piece_inertial(Piece("capsule", size=(r, length)), rho).about(O, X) == pytest.approx(wanted, rel=1e-9)


def test_an_inertial_moves_and_turns_with_its_frame() -> None:
    quarter = quat_from_axis_angle(Z, pi / 2)
    inertial = piece_inertial(BOX, 1000.0).at((1.0, 2.0, 3.0), quarter)
    assert inertial.center == pytest.approx((1.0, 2.0, 3.0))
    assert inertial.about(inertial.center, Y) == pytest.approx(piece_inertial(BOX, 1000.0).about(O, X))
    # Steiner: a metre beside the axis.
    beside = inertial.about((1.0, 2.0, 2.0), Y)
    assert beside == pytest.approx(inertial.about(inertial.center, Y) + inertial.mass)


def test_inertials_together_balance_at_their_common_centre() -> None:
    a, b = Inertial(1.0, (0.0, 0.0, 0.0), (0.0,) * 6), Inertial(3.0, (1.0, 0.0, 0.0), (0.0,) * 6)
    both = combined_inertial([a, b])
    assert both.mass == 4.0
    assert both.center == pytest.approx((0.75, 0.0, 0.0))
    assert both.about(both.center, Z) == pytest.approx(1 * 0.75**2 + 3 * 0.25**2)
    assert combined_inertial([]).mass == 0.0


def test_a_tube_of_staves_and_a_cone_are_near_the_round_ones() -> None:
    staves = [piece_inertial(p, 1.0) for p in wall_pieces((0.2, 0.25), (0.2, 0.25), -0.3, 0.3, 24)]
    tube = combined_inertial(staves)
    assert tube.about(O, Z) / tube.mass == pytest.approx((0.2**2 + 0.25**2) / 2, rel=0.02)
    cone = piece_inertial(cone_piece(0.3, 0.8), 1.0)
    assert cone.center[2] == pytest.approx(-0.2)  # a quarter of its height above its foot


def test_a_joint_carries_what_its_link_says_it_weighs_not_its_pieces() -> None:
    own = Inertial(2.0, (0.0, 0.0, 0.5), (0.1, 0.2, 0.3, 0.0, 0.0, 0.0))
    link = TreeLink("a", joint=TreeJoint("hinge"), geoms=(TreeGeom(BOX, 1000.0, 0.5),), inertia=own)
    assert link.inertial is own
    [carried] = carried_links(Tree((link,)))
    # Steiner, with the largest of the three moments.
    assert carried.inertia == pytest.approx(0.3 + 2.0 * 0.5**2)
