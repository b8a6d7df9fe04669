"""Regions on bodies mean the vertices that they say, and a middle where one point is needed."""

import math
from pathlib import Path

import numpy as np
import pytest
from pydantic import TypeAdapter

from text2sim.compiler.build import resolve_case
from text2sim.compiler.shapes.geometry import pieces, volume
from text2sim.compiler.shapes.regions import RegionError, region_middle, region_points
from text2sim.compiler.shapes.skin import skin_of
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.regions import BodyRegion
from text2sim.spec_schema.models.shapes import Shape

HERE = Path(".")
STILL = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))


def region(text):
    return BodyRegion.model_validate(text)


def skin(**shape):
    made = TypeAdapter(Shape).validate_python(shape)
    return skin_of([(piece, *STILL) for piece in pieces(made, HERE)])


BOX = {"kind": "box", "size": (0.2, 0.4, 0.6)}
SHEET = np.array([(x, y, 0.0) for y in np.linspace(-0.5, 0.5, 11) for x in np.linspace(0, 2, 21)])
"""A sheet of 21 by 11 vertices, 10 cm apart, flat in z."""


class TestVertices:
    """The words as they are used of cloth and soft bodies: which vertices are meant."""

    @pytest.mark.parametrize(
        ("words", "count", "where"),
        [
            ({"edge": "left"}, 11, (0, None, 0)),
            ({"edge": "back"}, 21, (None, 0.5, 0)),
            ({"corner": ["right", "front"]}, 1, (2, -0.5, 0)),
            ({"edge": ["left", "front"]}, 1, (0, -0.5, 0)),
            ({"face": "top"}, 231, (None, None, 0)),
            ({"box": {"min": [0.45, -0.05, -1], "max": [0.75, 0.15, 1]}}, 6, (None, None, 0)),
            ({"sphere": {"center": [1, 0, 0], "radius": 0.11}}, 5, (None, None, 0)),
            ({"nearest": [0.94, 0.27, 3]}, 1, (0.9, 0.3, 0)),
        ],
    )
    def test_of_a_sheet(self, words, count, where):
        found = region_points(region(words), SHEET)
        assert len(found) == count
        assert sorted(set(found.tolist())) == found.tolist()
        for k, wanted in enumerate(where):
            if wanted is not None:
                assert SHEET[found][:, k] == pytest.approx(wanted)

    def test_of_a_solid_corners_and_edges_are_where_sides_meet(self):
        cube = np.array([(x, y, z) for x in (0, 1, 2) for y in (0, 1, 2) for z in (0, 1, 2)], float)
        assert len(region_points(region({"face": "top"}), cube)) == 9
        assert len(region_points(region({"edge": ["top", "left"]}), cube)) == 3
        assert cube[region_points(region({"corner": ["left", "back", "bottom"]}), cube)].tolist() == [[0, 2, 0]]

    @pytest.mark.parametrize(
        ("words", "said"),
        [
            ({"sphere": {"center": [1, 0, 0.5], "radius": 0.1}}, "the nearest point of it is 0.4 m away"),
            ({"box": {"min": [2.03, 0, 0], "max": [3, 0.01, 1]}}, "the nearest point of it is 30 mm away"),
            ({"edge": "top"}, "it is flat, and has no top; it has left, right, front, back"),
            ({"corner": ["left", "front", "bottom"]}, "it is flat, and has no bottom"),
        ],
    )
    def test_where_nothing_is_it_is_said_how_far(self, words, said):
        with pytest.raises(RegionError, match=said):
            region_points(region(words), SHEET)


class TestMiddles:
    @pytest.mark.parametrize(
        ("shape", "words", "middle"),
        [
            (BOX, {"face": "top"}, (0, 0, 0.3)),
            (BOX, {"edge": ["left", "top"]}, (-0.1, 0, 0.3)),
            (BOX, {"corner": ["right", "back", "bottom"]}, (0.1, 0.2, -0.3)),
            (BOX, {"corner": ["right", "back"]}, (0.1, 0.2, 0)),
            (BOX, {"nearest": [9, 0.05, 0.07]}, (0.1, 0.05, 0.07)),
            (BOX, {"nearest": [0.02, 0, 0]}, (0.1, 0, 0)),
            ({"kind": "cylinder", "radius": 0.1, "height": 0.5}, {"face": "top"}, (0, 0, 0.25)),
            ({"kind": "cylinder", "radius": 0.1, "height": 0.5}, {"face": "left"}, (-0.1, 0, 0)),
            ({"kind": "cylinder", "radius": 0.1, "height": 0.5}, {"edge": ["left", "top"]}, (-0.1, 0, 0.25)),
            ({"kind": "sphere", "radius": 0.3}, {"face": "back"}, (0, 0.3, 0)),
            ({"kind": "capsule", "radius": 0.1, "length": 0.4}, {"face": "bottom"}, (0, 0, -0.3)),
            ({"kind": "ellipsoid", "radii": (0.1, 0.2, 0.3)}, {"face": "right"}, (0.1, 0, 0)),
            ({"kind": "cone", "radius": 0.2, "height": 0.6}, {"face": "top"}, (0, 0, 0.3)),
            ({"kind": "cup", "radius": 0.1, "height": 0.2, "thickness": 0.01}, {"face": "top"}, (0, 0, 0.1)),
            ({"kind": "torus", "radius": 0.3, "bar_radius": 0.05}, {"face": "right"}, (0.35, 0, 0)),
        ],
    )
    def test_lie_on_the_surface(self, shape, words, middle):
        assert region_middle(region(words), skin(**shape)) == pytest.approx(middle, abs=1e-6)

    def test_of_a_ball_it_is_that_of_the_surface_in_it(self):
        middle = region_middle(region({"sphere": {"center": [0.1, 0.1, 0], "radius": 0.05}}), skin(**BOX))
        assert middle == pytest.approx((0.1, 0.1, 0), abs=5e-3)
        # Smaller than the points are apart, but the surface is there.
        tiny = region_middle(region({"sphere": {"center": [0.1001, 0.103, 0.007], "radius": 0.001}}), skin(**BOX))
        assert tiny == pytest.approx((0.1, 0.103, 0.007))

    def test_a_sphere_has_no_corner(self):
        with pytest.raises(RegionError, match="nearest point of it is 0.2"):
            region_middle(region({"corner": ["left", "front", "top"]}), skin(kind="sphere", radius=0.3))

    @pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule", "ellipsoid"])
    def test_skins_are_closed_and_face_outwards(self, kind):
        sizes = {
            "box": {"size": (0.2, 0.4, 0.6)},
            "sphere": {"radius": 0.3},
            "cylinder": {"radius": 0.2, "height": 0.5},
            "capsule": {"radius": 0.1, "length": 0.4},
            "ellipsoid": {"radii": (0.1, 0.2, 0.3)},
        }
        shape = TypeAdapter(Shape).validate_python({"kind": kind, **sizes[kind]})
        made = skin_of([(piece, *STILL) for piece in pieces(shape, HERE)])
        a, b, c = (made.triangles[:, k] for k in range(3))
        assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(volume(shape, HERE), rel=5e-3)
        _, areas = made.samples
        assert areas.sum() == pytest.approx(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


CASE = """\
text2sim: 1
name: points
scene: {duration: 1, statics: {post: {shape: {kind: box, size: [0.2, 0.2, 1]}, pose: {pos: [3, 0, 0.5]}}}}
bodies:
  brick:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.1, 0.1]}
    pose: {pos: [0, 0, 1], euler_deg: [0, 0, 90]}
    repeat: {kind: line, count: 3, step: [1, 0, 0]}
  arm:
    kind: articulated
    links:
      base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      elbow:
        parent: base
        shape: {kind: capsule, radius: 0.02, length: 0.3}
        pose: {pos: [0, 0, 0.25]}
        joint: {kind: hinge, axis: y, anchor: [0, 0, -0.25]}
    initial: {elbow: 1.5707963267948966}
    pose: {pos: [2, 0, 0.05]}
actions:
  controls:
    push: {kind: force, body: brick, force: [0, 1, 0], point: {edge: [left, top]}}
    blow: {kind: impulse, body: "brick[1]", impulse: [0, 1, 0], at: 0.5, point: {nearest: [9, 0.02, 0]}}
    sway: {kind: force, body: arm.elbow, force: [0, 1, 0], point: {face: top}}
    each: {kind: force, body: brick, force: [0, 1, 0], point: ["${0.01 * i}", 0, 0]}
render:
  cameras:
    all: {kind: still, from: [9, 9, 9], look_at: "brick[*]"}
    one: {kind: still, from: [9, 9, 9], look_at: "brick[2]"}
    some: {kind: orbit, look_at: "brick[1:3]", radius: 2, height: 1}
    link: {kind: still, from: [9, 9, 9], look_at: arm.elbow}
    static: {kind: dolly, from: [9, 9, 9], to: [8, 9, 9], look_at: post}
    corner: {kind: still, from: [9, 9, 9], look_at: {body: post, region: {corner: [left, front, top]}}}
    ends: {kind: still, from: [9, 9, 9], look_at: {body: "brick[0:2]", region: {face: right}}}
    tip: {kind: still, from: [9, 9, 9], look_at: {body: arm.elbow, region: {face: top}}}
    whole: {kind: still, from: [9, 9, 9], look_at: {body: arm, region: {face: right}}}
"""


class TestUse:
    def test_forces_and_blows_act_there(self):
        points = {(w.entity, w.control): w.point for w in resolve_case(load_text(CASE)).plan.wrenches}
        assert points["brick[2]", "push"] == pytest.approx((-0.1, 0, 0.05))
        assert points["brick[1]", "blow"] == pytest.approx((0.1, 0.02, 0))
        assert points["arm", "sway"] == pytest.approx((0, 0, 0.17))
        assert [points[f"brick[{i}]", "each"] for i in range(3)] == [pytest.approx((0.01 * i, 0, 0)) for i in range(3)]

    @pytest.mark.parametrize(
        ("camera", "point"),
        [
            ("all", (1, 0, 1)),
            ("one", (2, 0, 1)),
            ("some", (1.5, 0, 1)),
            # Turned by 90 degrees about y, through the middle of the base.
            ("link", (2.25, 0, 0.05)),
            ("static", (3, 0, 0.5)),
            ("corner", (2.9, -0.1, 1)),
            ("ends", (0.5, 0.1, 1)),
            ("tip", (2.42, 0, 0.05)),
            ("whole", (2.42, 0, 0.05)),
        ],
    )
    def test_cameras_look_there(self, camera, point):
        cameras = resolve_case(load_text(CASE)).plan.render["cameras"]
        assert cameras[camera]["look_at"] == pytest.approx(point, abs=1e-5)

    def test_a_follow_camera_knows_copies_and_links(self):
        follow = "    all: {kind: follow, body: arm.elbow, from: [9, 9, 9]}\n    b: {kind: follow, body: 'brick[2]', offset: [1, 0, 0]}\n"
        text = CASE.split("    all:")[0] + follow
        rows = resolve_case(load_text(text)).plan.render["cameras"].values()
        assert [(row["body"], row["link"]) for row in rows] == [("arm", "elbow"), ("brick[2]", None)]

    @pytest.mark.parametrize(
        ("old", "new", "path", "said", "hint"),
        [
            ("point: {edge: [left, top]}", "point: {sphere: {center: [0, 0, 1], radius: 0.05}}", "/actions/controls/push/point", "`brick`: nothing of it lies in this region; the nearest point of it is 0.9 m away", None),
            ("region: {corner: [left, front, top]}", "region: {box: {min: [1, 1, 1], max: [2, 2, 2]}}", "/render/cameras/corner/look_at/region", "post: nothing of it lies in this region", None),
            ("look_at: arm.elbow", "look_at: arm.elbwo", "/render/cameras/link/look_at", "`arm` has no link `elbwo`", "elbow"),
            ("body: arm.elbow, region", "body: arn.elbow, region", "/render/cameras/tip/look_at/body", "there is no body or static `arn`", "arm"),
            ('look_at: "brick[2]"', 'look_at: "brick[3]"', "/render/cameras/one/look_at", "`brick` has 3 copies", None),
            ("look_at: post}", "look_at: psot}", "/render/cameras/static/look_at", "there is no body or static `psot`", "post"),
        ],
    )  # fmt: skip
    def test_what_is_not_there_is_located(self, old, new, path, said, hint):
        assert old in CASE
        with pytest.raises(SpecError) as caught:
            resolve_case(load_text(CASE.replace(old, new)))
        (problem,) = caught.value.problems
        assert (problem.path, problem.hint) == (path, hint)
        assert said in problem.message


class TestForm:
    @pytest.mark.parametrize(
        ("words", "said"),
        [
            ("{}", "exactly one of face, edge, corner, box, sphere, nearest is needed (got none)"),
            ("{face: top, edge: left}", "exactly one of"),
            ("{corner: [left, right]}", "left and right do not meet: they are opposite"),
            ("{edge: [left, left]}", "left is named twice"),
            ("{corner: [left]}", "needs at least 2 entries (got 1)"),
            ("{edge: lft}", "(got `lft`)"),
            ("{corner: [left, tpo]}", "(got `tpo`)"),
            ("[1, 2]", "needs 3 numbers"),
            ("{box: {min: [0, 0, 0], max: [0, 1, 1]}}", "every coordinate of max must be larger"),
        ],
    )
    def test_what_is_no_region_is_said(self, words, said):
        text = CASE.replace("point: {edge: [left, top]}", f"point: {words}")
        with pytest.raises(SpecError) as caught:
            load_text(text)
        (problem,) = caught.value.problems
        assert problem.path.startswith("/actions/controls/push/point")
        assert said in problem.message

    def test_a_region_says_its_name(self):
        assert str(region({"corner": ["left", "top"]})) == "corner left, top"


def test_turning_does_not_move_a_region_on_its_body():
    """The region is in the body's own frame: its middle turns with the body."""
    cameras = resolve_case(load_text(CASE.replace("euler_deg: [0, 0, 90]", "euler_deg: [0, 0, 30]"))).plan.render[
        "cameras"
    ]
    ends = cameras["ends"]
    half = math.radians(30)
    assert ends["look_at"] == pytest.approx((0.5 + 0.1 * math.cos(half), 0.1 * math.sin(half), 1), abs=1e-5)
