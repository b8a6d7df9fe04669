"""Signed distances to solids, against what they must be and against brute force."""

import json

import numpy as np
import pytest
from soft_shapes import lattice, sphere

from text2sim.evidence.gaps import Cloud, nearest_cloud
from text2sim.evidence.leaks import depth_on_the_way
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.solids import LinkSolid, solid_of_mesh

ZERO, ONE = np.zeros(3), np.eye(3)
BOX = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-2.0, 2.0) for z in (-3.0, 3.0)])


@pytest.mark.parametrize(
    ("solid", "point", "expected"),
    [
        (LinkSolid("plane", ZERO, ONE), (7, 8, -2), -2),
        (LinkSolid("box", ZERO, ONE, (2, 4, 6)), (0, 0, 2.5), -0.5),
        (LinkSolid("box", ZERO, ONE, (2, 4, 6)), (4, 6, 3), 5),
        (LinkSolid("sphere", ZERO, ONE, (2,)), (0, 3, 4), 3),
        (LinkSolid("sphere", ZERO, ONE, (2,)), (0, 0, 0.5), -1.5),
        (LinkSolid("cylinder", ZERO, ONE, (1, 4)), (0, 0, 1.9), -0.1),
        (LinkSolid("cylinder", ZERO, ONE, (1, 4)), (0, 4, 6), 5),
        (LinkSolid("cylinder", ZERO, ONE, (1, 4)), (0.8, 0, 0), -0.2),
        (LinkSolid("capsule", ZERO, ONE, (1, 4)), (0, 3, 6), 4),
        (LinkSolid("capsule", ZERO, ONE, (1, 4)), (0, 0.25, 1), -0.75),
    ],
)
def test_primitives(solid, point, expected):
    assert solid.distance(np.array([point], float))[0] == pytest.approx(expected)


def test_a_hull_is_what_its_box_is():
    hull = solid_of_mesh(BOX, np.zeros((0, 3), int))
    assert hull is not None
    assert hull.kind == "hull"
    points = np.random.default_rng(0).normal(size=(500, 3)) * 3
    np.testing.assert_allclose(
        hull.distance(points), LinkSolid("box", ZERO, ONE, (2, 4, 6)).distance(points), atol=1e-9
    )


def test_a_mesh_that_is_not_convex_has_an_inside_where_it_is_solid():
    vertices, faces = sphere(1.0)
    vertices = np.concatenate([vertices, 0.5 * vertices])  # a hollow ball
    faces = np.concatenate([faces, faces[:, ::-1] + len(vertices) // 2])
    solid = solid_of_mesh(vertices, faces)
    assert solid is not None
    assert solid.kind == "surface"
    points = np.array([[0, 0, 0.75], [0, 0, 0.1], [0, 0, 3.0], [0.6, 0, 0]])
    np.testing.assert_allclose(solid.distance(points), [-0.25, 0.4, 2.0, -0.1], atol=0.02)


@pytest.mark.parametrize("faces", [[[0, 1, 99]], [[0, -1, 2]]])
def test_a_mesh_that_makes_no_sense_is_none(faces):
    assert solid_of_mesh(BOX, np.array(faces)) is None
    assert solid_of_mesh(np.zeros((0, 3)), np.zeros((0, 3), int)) is None
    assert solid_of_mesh(np.full((4, 3), np.nan), np.zeros((0, 3), int)) is None


@pytest.fixture
def scene(new_run, make_case):
    """Return a function that records a body about moving solids: it gives the recording, and the file of solids."""

    def write(rows):
        run = new_run(duration=0.1)
        random = np.random.default_rng(2)
        quat = random.normal(size=(11, 4))
        run.add_link("cup", pos=random.normal(size=(11, 3)) * 0.3, quat=quat / np.linalg.norm(quat, axis=1)[:, None])
        run.add_soft("jelly", lattice(6, 0.2) + random.normal(size=(11, 216, 3)) * 0.02)
        folder = run.write()
        np.savez(folder / "geometry" / "hull.npz", vertices=BOX / 6, faces=np.zeros((0, 3), int))
        (folder / "geometry" / "solids.json").write_text(json.dumps({"0": rows}))
        ball = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 1}}
        soft = {"kind": "soft", "shape": {"kind": "box", "size": [1, 1, 1]}}
        return RecordedCase.load(folder, make_case(bodies={"cup": ball, "jelly": soft}))

    return write


ROWS = [
    {"kind": "box", "pos": [0.4, 0, 0], "quat": [0.8, 0.6, 0, 0], "size": [0.1, 0.2, 0.3]},
    {"kind": "capsule", "pos": [0, 0.4, 0], "quat": [0.8, 0.6, 0, 0], "size": [0.1, 0.3]},
    {"kind": "mesh", "pos": [0, 0, 0.9], "quat": [0.6, 0, 0.8, 0], "mesh": "hull.npz"},
    {"kind": "cylinder", "pos": [2, 0, 0], "quat": [1, 0, 0, 0], "size": [0.1, 0.3]},
    {"kind": "sphere", "pos": [0, 0, -2], "quat": [1, 0, 0, 0], "size": [0.3]},
]


@pytest.mark.parametrize("number", range(len(ROWS) + 1))
def test_the_nearest_of_moving_solids_is_that_of_brute_force(scene, number):
    recording = scene(ROWS if number == len(ROWS) else [ROWS[number]])
    states, body = recording.states, recording.states.deformables[0]
    from text2sim.evidence.gaps import nearest_solid
    from text2sim.evidence.rigid_shapes import world_frames

    solids = recording.shapes.of_links([0])
    expected = np.full(states.frames, np.inf)
    for link, solid in solids:
        pos, turn = world_frames(states, link, solid)
        for frame, points in enumerate(body.points.astype(float)):
            expected[frame] = min(expected[frame], solid.distance((points - pos[frame]) @ turn[frame]).min())
    found = nearest_solid(recording.cloud(body), states, solids)
    np.testing.assert_allclose(found.value, expected, atol=1e-6)
    near = nearest_solid(recording.cloud(body), states, solids, 0.02)
    np.testing.assert_allclose(near.value, np.minimum(expected, 0.02), atol=1e-6)
    assert np.isfinite(near.pos).all(axis=1).tolist() == (expected < 0.02).tolist()
    assert (expected < 0).any() or number in (3, 4), "a test of gaps needs something that goes in"


@pytest.mark.parametrize(
    "row",
    [
        {"kind": "box", "size": [1]},
        {"kind": "box", "size": [1, -1, 1]},
        {"kind": "sphere", "size": ["wide"]},
        {"kind": "mesh", "mesh": "../../states/chunk_00000.npz"},
        {"kind": "mesh", "mesh": "none.npz"},
        {"kind": "sphere", "size": [1], "pos": [0, 0]},
        {"kind": "sphere", "size": [1], "quat": [1, 0]},
        "sphere",
        None,
    ],
)
def test_solids_that_make_no_sense_are_left_out(scene, row):
    assert scene([row, {"kind": "sphere", "size": [1]}]).shapes.of(0)[0].size == (1.0,)


def test_without_a_file_of_solids_what_is_drawn_counts(scene):
    recording = scene([])
    folder = recording.shapes._folder  # type: ignore[reportPrivateUsage]
    (folder / "solids.json").unlink()
    (folder / "index.json").write_text(
        json.dumps({"0": [{"mesh": "hull.npz", "pos": [0, 0, 1], "quat": [1, 0, 0, 0]}]})
    )
    states, case = recording.states, recording.case
    from text2sim.evidence.rigid_shapes import RigidShapes

    shapes = RigidShapes(folder.parent, states, case)
    (solid,) = shapes.of(0)
    assert (solid.kind, solid.pos[2]) == ("hull", 1.0)


def test_a_mesh_whose_middle_is_outside_is_not_leaked_into_by_a_touch():
    import trimesh

    two = [trimesh.creation.box((0.2, 1, 1), trimesh.transformations.translation_matrix((x, 0, 0))) for x in (-1, 1)]
    both = trimesh.util.concatenate(two)
    solid = solid_of_mesh(np.asarray(both.vertices), np.asarray(both.faces))
    assert solid is not None
    assert solid.kind == "surface"
    assert depth_on_the_way(solid, 0.02) == pytest.approx(0.02)
    assert depth_on_the_way(LinkSolid("box", ZERO, ONE, (0.02, 1, 1)), 0.02) == pytest.approx(0.8 * 0.01)


def test_a_point_that_is_no_number_hides_no_other():
    """Its group has no box, so that the distances of all others count."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 8)] * 3), axis=-1).reshape(-1, 3)
    one, other = (np.float32([grid + [x, 0, 0]]) for x in (0, 3))
    for points in (one, other):
        points[0, np.linalg.norm(grid - [0.5, 0.5, 0.5], axis=1).argmin()] = np.nan
    clouds = [
        Cloud(p, np.arange(0, 512, 8), *(f.reduceat(p, np.arange(0, 512, 8), axis=1) for f in (np.minimum, np.maximum)))
        for p in (one, other)
    ]
    assert nearest_cloud(*clouds).value == pytest.approx(2.0)
