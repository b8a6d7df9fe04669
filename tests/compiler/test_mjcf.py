"""Model files say what their trees say."""

from xml.etree import ElementTree as ET

import pytest

from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.trees.mjcf import write_mjcf
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeJoint, TreeLink, TreeLoop


@pytest.mark.parametrize("self_collision", [False, True])
def test_a_piece_that_is_only_drawn_touches_nothing(self_collision: bool) -> None:
    ball = Piece("sphere", size=(0.1,))
    geoms = (TreeGeom(ball, 1000.0, 0.5), TreeGeom(ball, 0.0, 0.5, touches=False))
    text = write_mjcf(Tree((TreeLink("a", geoms=geoms),), self_collision=self_collision), "model", {})
    solid, drawn = ET.fromstring(text).iter("geom")
    # MuJoCo: two geoms may touch if the contype of one and the conaffinity of the other share a bit; both are 1 unless given.
    assert solid.get("contype") != "0" and solid.get("conaffinity") != "0"
    assert (drawn.get("contype"), drawn.get("conaffinity")) == ("0", "0")


@pytest.mark.parametrize(("friction", "solimp"), [(0.0, None), (2.0, "0.9999 0.9999")])
def test_dry_friction_is_firm(friction: float, solimp: str | None) -> None:
    pad = (TreeGeom(Piece("sphere", size=(0.1,)), 1000.0, 0.5),)
    link = TreeLink("wheel", joint=TreeJoint("hinge", friction=friction), geoms=pad)
    (joint,) = ET.fromstring(write_mjcf(Tree((link,)), "model", {})).iter("joint")
    assert (joint.get("solimplimit"), joint.get("solimpfriction")) == (solimp, solimp)


@pytest.mark.parametrize(("kind", "solimp"), [("gear", "0.9999 0.9999"), ("connect", None)])
def test_gears_are_firm(kind: str, solimp: str | None) -> None:
    pad = (TreeGeom(Piece("sphere", size=(0.1,)), 1000.0, 0.5),)
    wheels = tuple(TreeLink(name, joint=TreeJoint("hinge"), geoms=pad) for name in ("a", "b"))
    tree = Tree((TreeLink("root", geoms=pad, children=wheels),), (TreeLoop(kind, "a", "b", (0, 0, 0), 2.0),))
    (section,) = ET.fromstring(write_mjcf(tree, "model", {})).iter("equality")
    assert [loop.get("solimp") for loop in section] == [solimp]
