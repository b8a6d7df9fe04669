import itertools
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from text2sim.compiler.placing.group import EXACT_SHAPES
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.geometry import inner_floor, pieces, visual_mesh, volume
from text2sim.compiler.shapes.gjk import distance
from text2sim.compiler.shapes.inertials import piece_inertial
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rings import ROUND_ABOUT_Z
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    quat_between,
    quat_from_axis_angle,
    quat_from_euler_deg,
    quat_multiply,
    quat_normalize,
    quat_of,
    quat_rotate,
    quat_to_rows,
)
from text2sim.compiler.shapes.solid import Solid, solids
from text2sim.compiler.shapes.surface import surface
from text2sim.compiler.shapes.sweep import sweep
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.base import Pose
from text2sim.spec_schema.models.faceted import Rock
from text2sim.spec_schema.models.shapes import Shape
from text2sim.spec_schema.published.language_reference import section_kinds

HERE = Path(".")
SHAPES = {
    "box": {"size": (0.2, 0.4, 0.6)},
    "sphere": {"radius": 0.3},
    "cylinder": {"radius": 0.2, "height": 0.5},
    "capsule": {"radius": 0.1, "length": 0.4},
    "cone": {"radius": 0.2, "height": 0.6},
    "polyhedron": {
        "points": [
            (-0.2, -0.1, 0),
            (0.2, -0.1, 0),
            (-0.2, 0.1, 0),
            (0.2, 0.1, 0),
            (0.2, -0.1, 0.3),
            (0.2, 0.1, 0.3),
            (0.1, 0, 0.1),
        ]
    },
    "rock": {"size": (0.3, 0.4, 0.2), "seed": 3},
    "ellipsoid": {"radii": (0.1, 0.2, 0.3)},
    "torus": {"radius": 0.3, "bar_radius": 0.05, "segments": 24},
    "tube": {"outer_radius": 0.3, "inner_radius": 0.25, "height": 0.4},
    "cup": {"radius": 0.3, "height": 0.4, "thickness": 0.03},
    "funnel": {"top_radius": 0.4, "bottom_radius": 0.1, "height": 0.5, "thickness": 0.04},
}
ELSEWHERE = {
    "mesh": "TestMeshFiles",
    "compound": "TestExtents",
    "sculpt": "test_sculpt.py",
    "text": "test_glyphs.py",
    "sketch": "test_sketching.py",
    "extrusion": "test_extrusion.py",
}
"""Shapes that are tested in their own way, and where."""
VOLUMES = {
    "box": 0.048,
    "sphere": 0.113097,
    "cylinder": 0.0628319,
    "capsule": 0.0125664 + 0.00418879,
    "cone": 0.0251327,
    "polyhedron": 0.4 * 0.2 * 0.3 / 2,  # the last point lies inside
    "rock": ConvexHull(Rock(kind="rock", **SHAPES["rock"]).points).volume,
    "ellipsoid": 0.0251327,
    "torus": 0.0148044,
    "tube": 0.0345575,
    "cup": math.pi * (0.09 * 0.4 - 0.27**2 * 0.37),
    "funnel": math.pi * 0.5 * 0.04 * 0.54,
}
"""Volumes [m3] of these shapes, by their formulas."""
TURNS = [
    IDENTITY,
    quat_from_euler_deg((30, 40, 50)),
    quat_from_euler_deg((90, 0, 0)),
    quat_from_euler_deg((200, -70, 10)),
]


def make(kind, **fields):
    return TypeAdapter(Shape).validate_python({"kind": kind, **(fields or SHAPES[kind])})


def test_every_shape_stands_in_the_table():
    assert {*SHAPES, *ELSEWHERE} == set(section_kinds(Shape))


def test_an_unknown_kind_is_said():
    with pytest.raises(TypeError, match="pieces of a shape of kind pretzel are not known"):
        pieces(SimpleNamespace(kind="pretzel"), HERE)
    with pytest.raises(TypeError, match="inertia of a piece of kind pretzel is not known"):
        piece_inertial(Piece("pretzel", size=(1.0, 1.0)), 1000.0)


def test_shapes_are_listed_by_what_they_are():
    eighth = quat_from_axis_angle("z", math.pi / 4)
    around_z, exact = set(), {"mesh"}  # a mesh is what its own file has
    for kind in SHAPES:
        shape = make(kind)
        if np.allclose(extents(shape, eighth, HERE), extents(shape, IDENTITY, HERE)):
            around_z.add(kind)
        if pieces(shape, HERE)[0].kind == kind:
            exact.add(kind)
    assert around_z - {"sphere"} == ROUND_ABOUT_Z  # a ball has no axis of its own
    assert exact == set(EXACT_SHAPES)


def scipy_turn(quat):
    return Rotation.from_quat(quat, scalar_first=True)


class TestRotation:
    def test_angles_turn_about_the_fixed_x_then_y_then_z(self):
        quat = quat_from_euler_deg((30, -50, 110))
        expected = Rotation.from_euler("xyz", (30, -50, 110), degrees=True)
        np.testing.assert_allclose(quat_to_rows(quat), expected.as_matrix(), atol=1e-12)
        assert quat_rotate(quat_from_euler_deg((90, 0, 90)), (0, 0, 1)) == pytest.approx((1, 0, 0))

    def test_a_product_does_the_right_factor_first(self):
        a, b = quat_from_axis_angle((1, 2, 3), 0.7), quat_from_axis_angle("y", -1.1)
        expected = scipy_turn(a) * scipy_turn(b)
        np.testing.assert_allclose(quat_to_rows(quat_multiply(a, b)), expected.as_matrix(), atol=1e-12)

    @pytest.mark.parametrize("to", [(0, 0, -2), (1, 0, 0), (0.1, -3, 2), (0, 0, 5)])
    def test_between_turns_one_direction_into_the_other(self, to):
        unit = np.array(to) / np.linalg.norm(to)
        assert quat_rotate(quat_between((0, 0, 1), to), (0, 0, 1)) == pytest.approx(unit)

    def test_two_orientations_are_refused(self):
        with pytest.raises(ValueError, match="not both"):
            quat_of(Pose(quat=(1, 0, 0, 0), euler_deg=(0, 0, 0)))
        with pytest.raises(ValueError, match="zero"):
            quat_normalize((0, 0, 0, 0))


class TestVolume:
    @pytest.mark.parametrize("kind", SHAPES)
    def test_is_that_of_the_formula(self, kind):
        assert volume(make(kind), HERE) == pytest.approx(VOLUMES[kind], rel=1e-5)

    @pytest.mark.parametrize("kind", SHAPES)
    def test_the_drawn_surface_is_closed_and_encloses_it(self, kind):
        mesh = surface(make(kind))
        edges = np.round(mesh.vertices, 9)[mesh.faces[:, [0, 1, 1, 2, 2, 0]]].reshape(-1, 6)
        there, back = ({tuple(edge) for edge in ends + 0.0} for ends in (edges, edges[:, [3, 4, 5, 0, 1, 2]]))
        assert there == back, "each edge belongs to a triangle on either side"
        a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
        cross = np.cross(b - a, c - a)
        assert np.einsum("ij,ij->", a, cross) / 6 == pytest.approx(volume(make(kind), HERE), rel=0.01)
        assert (np.einsum("ij,ij->i", cross, mesh.normals[mesh.faces[:, 0]]) > 0).all()
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1)

    def test_a_drawn_surface_is_written_and_known_by_its_content(self):
        (one,), (same,), (other,) = (visual_mesh(make(kind), HERE) for kind in ("cup", "cup", "tube"))
        assert one.digest == same.digest != other.digest
        lines = one.obj().splitlines()
        assert [sum(line.startswith(f"{key} ") for line in lines) for key in ("v", "vn", "f")] == [
            len(one.vertices),
            len(one.normals),
            len(one.faces),
        ]
        corners = [line.split()[1:] for line in lines if line.startswith("v ")]
        np.testing.assert_allclose(np.array(corners, float), one.vertices, atol=1e-7)

    @pytest.mark.parametrize("kind", ["cone", "polyhedron", "tube", "cup", "funnel"])
    def test_of_a_hull_is_what_its_corners_enclose(self, kind):
        for piece in pieces(make(kind), HERE):
            if piece.kind == "hull":
                assert piece.volume() == pytest.approx(ConvexHull(piece.vertices).volume)

    def test_only_round_shapes_without_edges_draw_themselves(self):
        assert {kind for kind in SHAPES if visual_mesh(make(kind), HERE) is None} == {"sphere", "capsule", "ellipsoid"}

    def test_boxes_are_drawn_with_sharp_edges(self):
        (mesh,) = visual_mesh(make("box"), HERE)
        assert len(mesh.vertices) == 24 and set(abs(mesh.normals).max(axis=1)) == {1.0}


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0, 0)] * 4,
        [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)],
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0.3, 0.4, 1e-6)],
        [(0, 0, 0), (1e-7, 0, 0), (0, 1e-7, 0), (0, 0, 1e-7)],
        [(0, 0, 0), (1e9, 0, 0), (0, 1e9, 0), (0, 0, 1e9)],
        [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
    ],
)
def test_points_that_enclose_nothing_are_no_polyhedron(points):
    with pytest.raises(ValidationError, match="enclose no volume|m from the first|at least 4"):
        make("polyhedron", points=points)


class TestExtents:
    @pytest.mark.parametrize(("kind", "quat"), list(itertools.product(SHAPES, TURNS)))
    def test_hold_the_pieces_tightly(self, kind, quat):
        """Against a dense sample of the pieces' support: never smaller, and larger by facets only."""
        shape = make(kind)
        low, high = extents(shape, quat, HERE)
        placed = solids(pieces(shape, HERE), (0, 0, 0), quat)
        for k in range(3):
            for sign, bound in ((1, high), (-1, low)):
                way = tuple(sign * (j == k) for j in range(3))
                reach = max(sign * s.support(way)[k] + s.rounding for s in placed)
                assert reach <= sign * bound[k] + 1e-12
                assert reach >= sign * bound[k] - 0.012 * 0.4

    def test_of_a_leaning_cylinder_are_exact(self):
        _, high = extents(make("cylinder"), quat_from_euler_deg((0, 30, 0)), HERE)
        assert high == pytest.approx(
            (0.2 * math.cos(math.pi / 6) + 0.25 * 0.5, 0.2, 0.25 * math.cos(math.pi / 6) + 0.1)
        )

    def test_of_a_lying_cone_reach_from_tip_to_base(self):
        low, high = extents(make("cone"), quat_from_euler_deg((0, 90, 0)), HERE)
        assert (low, high) == (pytest.approx((-0.3, -0.2, -0.2)), pytest.approx((0.3, 0.2, 0.2)))

    def test_of_a_rock_are_its_size(self):
        low, high = extents(make("rock"), IDENTITY, HERE)
        assert (low, high) == (pytest.approx((-0.15, -0.2, -0.1)), pytest.approx((0.15, 0.2, 0.1)))

    def test_of_a_compound_cover_its_turned_parts(self):
        dumbbell = make(
            "compound",
            parts={
                "bar": {
                    "shape": {"kind": "capsule", "radius": 0.02, "length": 0.3},
                    "pose": {"euler_deg": (0, 90, 0)},
                },
                "left": {"shape": {"kind": "sphere", "radius": 0.1}, "pose": {"pos": (-0.15, 0, 0)}},
                "cup": {
                    "shape": {"kind": "cup", "radius": 0.1, "height": 0.2, "thickness": 0.01},
                    "pose": {"pos": (0.15, 0, 0.1)},
                },
            },
        )
        low, high = extents(dumbbell, quat_from_euler_deg((0, 0, 90)), HERE)
        assert low == pytest.approx((-0.1, -0.25, -0.1))
        assert high == pytest.approx((0.1, 0.25, 0.2))
        assert {mesh.part for mesh in visual_mesh(dumbbell, HERE)} == {"cup"}
        assert {piece.part for piece in pieces(dumbbell, HERE)} == {"bar", "left", "cup"}
        assert volume(dumbbell, HERE) == pytest.approx(
            math.pi * 0.0004 * 0.3 + 4 / 3 * math.pi * (0.02**3 + 0.1**3) + math.pi * (0.01 * 0.2 - 0.09**2 * 0.19)
        )


class TestHollows:
    @pytest.mark.parametrize(("kind", "segments"), list(itertools.product(["tube", "cup", "funnel"], [6, 7, 24, 64])))
    def test_staves_never_narrow_the_free_space(self, kind, segments):
        shape = make(kind, **SHAPES[kind], segments=segments)
        for piece in pieces(shape, HERE):
            if piece.kind == "hull":
                v = np.array(piece.vertices)
                # The inner face is a plane; its distance from the axis is its distance at the middle.
                for corners, height in ((v[[0, 3]], v[0, 2]), (v[[4, 7]], v[4, 2])):
                    radius = {"tube": 0.25, "cup": 0.27, "funnel": 0.1 + 0.3 * (height + 0.25) / 0.5}[kind]
                    assert np.linalg.norm(corners.mean(0)[:2]) == pytest.approx(radius)

    def test_staves_meet_and_do_not_overlap(self):
        tube = make("tube", outer_radius=0.3, inner_radius=0.25, height=0.4, segments=12)
        staves = pieces(tube, HERE)
        assert len(staves) == 12
        for one, following in zip(staves, staves[1:] + staves[:1], strict=True):
            shared = {tuple(np.round(v, 9)) for v in one.vertices} & {tuple(np.round(v, 9)) for v in following.vertices}
            assert len(shared) == 4
        # A ring of twelve trapezoids: with circumscribed inner and inscribed outer polygon.
        inner = 12 * math.tan(math.pi / 12) * 0.25**2
        outer = 12 * math.sin(math.pi / 6) / 2 * 0.3**2
        assert sum(s.volume() for s in staves) == pytest.approx((outer - inner) * 0.4)

    def test_a_thin_wall_with_few_staves_keeps_half_its_thickness(self):
        staves = pieces(make("tube", outer_radius=0.3, inner_radius=0.297, height=0.1, segments=6), HERE)
        v = np.array(staves[0].vertices)
        thickness = np.linalg.norm(v[[1, 2]].mean(0)[:2]) - np.linalg.norm(v[[0, 3]].mean(0)[:2])
        assert thickness == pytest.approx(0.0015)

    def test_floors(self):
        assert inner_floor(make("cup"))[:2] == pytest.approx((-0.17, 0.27))
        assert inner_floor(make("tube"))[:2] == pytest.approx((-0.2, 0.25))
        assert inner_floor(make("funnel"))[:2] == pytest.approx((-0.25, 0.1))
        assert inner_floor(make("box")) is None
        glass = make("compound", parts={
            "foot": {"shape": {"kind": "cylinder", "radius": 0.1, "height": 0.02}},
            "bowl": {"shape": {"kind": "cup", **SHAPES["cup"]}, "pose": {"pos": (0.5, 0, 1)}},
        })  # fmt: skip
        assert inner_floor(glass) == (pytest.approx(0.83), pytest.approx(0.27), (0.5, 0))


class TestSweep:
    def test_a_ball_falls_on_a_slope(self):
        slope = quat_from_euler_deg((0, 30, 0))
        ramp = Solid(pieces(make("box", size=(2, 2, 0.2)), HERE)[0], (0, 0, 0), slope)
        ball = Solid(pieces(make("sphere"), HERE)[0], (0, 0, 2), IDENTITY)
        # The centre ends at 0.1 + 0.3 from the middle plane, measured along its normal.
        assert sweep([ball], [ramp], (0, 0, -1)) == pytest.approx(2 - 0.4 / math.cos(math.pi / 6), abs=2e-7)
        assert sweep([ball], [ramp], (0, 0, -1), gap=0.1) == pytest.approx(2 - 0.5 / math.cos(math.pi / 6), abs=2e-7)
        assert sweep([ball], [ramp], (0, 0, 1)) is None

    def test_what_is_found_touches_and_does_not_overlap(self):
        """Random pairs of all kinds of pieces, judged by FCL, which knows nothing of our support points."""
        fcl = pytest.importorskip("fcl")
        rng = np.random.default_rng(5)
        kinds = ["box", "sphere", "cylinder", "capsule", "cone", "ellipsoid"]
        hits = 0
        for _ in range(150):
            one, other = (pieces(make(kinds[k]), HERE)[0] for k in rng.integers(0, len(kinds), 2))
            quats = [quat_normalize(rng.normal(size=4)) for _ in range(2)]
            start = (*(rng.normal(size=2) * 0.2).tolist(), 2.0)
            a, b = Solid(one, start, quats[0]), Solid(other, (0, 0, 0), quats[1])
            way = sweep([a], [b], (0, 0, -1))

            def apart(z, one=one, other=other, quats=quats, start=start):
                objects = [
                    fcl.CollisionObject(fcl_shape(fcl, piece), fcl.Transform(np.array(quat), np.array(at)))
                    for piece, quat, at in ((one, quats[0], (*start[:2], z)), (other, quats[1], (0, 0, 0)))
                ]
                result = fcl.DistanceResult()
                fcl.distance(*objects, fcl.DistanceRequest(), result)
                return result.min_distance

            if way is None:
                assert min(apart(z) for z in np.linspace(-1, 2, 40)) > 0
            else:
                hits += 1
                assert abs(apart(2 - way)) < 2e-5
                assert distance(Solid(one, (*start[:2], 2 - way), quats[0]), b) < 1e-6
        assert hits > 100


def fcl_shape(fcl, piece):
    if piece.kind == "hull":
        faces = np.array(piece.faces)
        packed = np.concatenate([np.full((len(faces), 1), 3), faces], axis=1).ravel()
        return fcl.Convex(np.array(piece.vertices), len(faces), packed)
    return {
        "box": fcl.Box,
        "sphere": fcl.Sphere,
        "cylinder": fcl.Cylinder,
        "capsule": fcl.Capsule,
        "ellipsoid": fcl.Ellipsoid,
    }[piece.kind](*piece.size)


class TestMeshFiles:
    WEDGE = "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

    def test_a_mesh_is_read_scaled_and_bounded(self, tmp_path):
        (tmp_path / "wedge.obj").write_text(self.WEDGE)
        mesh = make("mesh", file="wedge.obj", scale=0.5)
        assert volume(mesh, tmp_path) == pytest.approx(0.5)
        assert extents(mesh, IDENTITY, tmp_path) == (pytest.approx((0, 0, 0)), pytest.approx((1, 1.5, 2)))
        (piece,) = pieces(mesh, tmp_path)
        assert piece.file == "wedge.obj"
        assert len(piece.vertices) == 4
        assert piece.volume() == pytest.approx(0.5)

    @pytest.mark.parametrize(
        ("file", "content", "said"),
        [
            ("../secret.obj", WEDGE, "outside"),
            ("missing.obj", None, "does not exist"),
            ("notes.txt", "hello", "must end in"),
            ("empty.obj", "", "is empty"),
            ("page.stl", "\n<!DOCTYPE html><html>", "is a web page"),
            ("pointer.obj", "version https://git-lfs.github.com/spec/v1\noid sha256:0a\nsize 9\n", "git lfs pull"),
            ("beyond.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "vertices that are not in the file"),
            ("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no area"),
            ("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "finite"),
        ],
    )
    def test_what_cannot_be_used_is_refused(self, tmp_path, file, content, said):
        folder = tmp_path / "case"
        folder.mkdir()
        if content is not None:
            (folder / file).write_text(content)
        with pytest.raises(AssetError, match=said):
            pieces(make("mesh", file=file), folder)
