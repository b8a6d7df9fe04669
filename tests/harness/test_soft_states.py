"""Bodies that deform are read as far as they are whole, and what is missing is said."""

import json
import zipfile

import numpy as np
import pytest

from text2sim.recording.states import RunStates
from text2sim.spec_schema.errors import RunError

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


@pytest.fixture
def run(new_run):
    run = new_run()
    run.add_link("floor", fixed=True)
    fall = CUBE + np.outer(run.time, [0, 0, -1])[:, None]
    run.add_soft("jelly", fall, mass=2.0, surface=2 * fall, faces=np.array([[0, 1, 2]]), pos=(0.5, 0.5, 0.5))
    run.add_soft("sand[0]", fall + [5, 0, 0], kind="granular", domain=[[-1, -1, -1], [9, 9, 9]])
    return run


def test_each_body_has_its_own_columns(run):
    states = RunStates.load(run.write())
    jelly, sand = states.deformables
    assert (jelly.body, jelly.kind, jelly.count, sand.body) == ("jelly", "soft", 8, "sand[0]")
    np.testing.assert_allclose(jelly.points[:, 0, 2], -states.time, atol=1e-6)
    np.testing.assert_allclose(sand.points[:, :, 0], np.broadcast_to(CUBE[:, 0] + 5, (101, 8)), atol=1e-6)
    np.testing.assert_allclose(jelly.seen, 2 * jelly.points, atol=1e-6)
    assert sand.faces is None
    assert sand.domain == ((-1, -1, -1), (9, 9, 9))
    np.testing.assert_allclose(jelly.own, CUBE - 0.5)
    np.testing.assert_allclose(sand.masses, 1 / 8)


def test_other_bodies_are_not_read_into_memory(run):
    states = RunStates.load(run.write())
    points = states.deformables[1].points
    views = states.chunks._views  # type: ignore[reportPrivateUsage]
    assert len(views) == 3
    assert all(isinstance(view, np.memmap) for view in views.values())
    assert points.base is None or points.size < sum(view.size for view in views.values())


def test_a_compressed_recording_is_read_too(run):
    folder = run.write()
    for path in (folder / "states").glob("chunk_*.npz"):
        with np.load(path) as chunk:
            arrays = dict(chunk)
        np.savez_compressed(path, **arrays)
    np.testing.assert_allclose(RunStates.load(folder).deformables[0].points[-1, 0, 2], -1, atol=1e-6)


def test_recordings_without_such_bodies_have_none(new_run):
    run = new_run()
    run.add_link("ball")
    assert RunStates.load(run.write()).deformables == ()


def test_a_chunk_without_the_points_is_left_out(run):
    folder = run.write()
    path = folder / "states" / "chunk_00002.npz"
    with np.load(path) as chunk:
        arrays = {name: array for name, array in chunk.items() if name != "soft_points"}
    np.savez(path, **arrays)
    states = RunStates.load(folder)
    assert states.frames == len(states.deformables[0].points) == 80
    assert "chunk_00002.npz" in states.losses[0]
    assert "soft_points" in states.losses[0]


def test_a_flipped_bit_in_the_points_is_said(run):
    folder = run.write()
    path = folder / "states" / "chunk_00001.npz"
    data = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        at = archive.getinfo("soft_points.npy").header_offset + 1000
    data[at] ^= 0xFF
    path.write_bytes(data)
    states = RunStates.load(folder)
    with pytest.raises(RunError, match="chunk_00001.npz: damaged"):
        _ = states.deformables[0].points


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"faces": np.array([[0, 1, 99]])}, "names points that are not there"),
        ({"faces": np.array([[0, 1, -1]])}, "names points that are not there"),
        ({"tets": np.array([[0.0, 1, 2, 3]])}, "tets has shape"),
        ({"rest": CUBE[:3]}, "rest has shape"),
        ({"rest": np.full((8, 3), np.nan)}, "not finite"),
        ({"masses": np.zeros(8)}, "not positive"),
        ({"masses": np.array([{}] * 8, dtype=object)}, "damaged"),
    ],
)
def test_geometry_that_does_not_fit_is_left_out_and_said(run, change, said):
    folder = run.write()
    path = folder / "geometry" / "soft_0.npz"
    with np.load(path) as data:
        arrays = dict(data)
    np.savez(path, **(arrays | change))
    states = RunStates.load(folder)
    jelly = states.deformables[0]
    assert [loss for loss in states.losses if said in loss and "soft_0.npz" in loss]
    np.testing.assert_allclose(jelly.rest, CUBE, atol=1e-6)
    np.testing.assert_allclose(jelly.masses, 0.25)
    assert jelly.tets is None


@pytest.mark.parametrize("bytes_", [b"", b"PK", b"not a file of arrays" * 9])
def test_geometry_that_is_no_file_of_arrays(run, bytes_):
    folder = run.write()
    (folder / "geometry" / "soft_1.npz").write_bytes(bytes_)
    states = RunStates.load(folder)
    assert "geometry/soft_1.npz: damaged" in states.losses[0]
    np.testing.assert_allclose(states.deformables[1].rest, CUBE + [5, 0, 0], atol=1e-6)


def test_geometry_that_is_missing(run):
    folder = run.write()
    (folder / "geometry" / "soft_0.npz").unlink()
    assert RunStates.load(folder).losses == ("geometry/soft_0.npz: missing",)


@pytest.mark.parametrize(
    "change",
    [
        {"points": [4, 4]},
        {"points": [-3, 5]},
        {"points": [0, 10**12]},
        {"points": None},
        {"surface": [8, 0]},
        {"mass": 0},
        {"spacing": float("inf")},
        {"quat": [1, 0]},
        {"quat": [1, 0, 0, float("nan")]},
        {"domain": [[0, 0], [1, 1]]},
        {"body": None, "mass": None},
    ],
)
def test_a_layout_that_makes_no_sense_is_an_error_for_the_user(run, change):
    folder = run.write()
    path = folder / "states" / "layout.json"
    layout = json.loads(path.read_text())
    layout["deformables"][0] |= change
    path.write_text(json.dumps(layout))
    with pytest.raises(RunError, match="layout.json"):
        RunStates.load(folder)


def test_a_layout_with_more_points_than_were_recorded(run):
    folder = run.write()
    path = folder / "states" / "layout.json"
    layout = json.loads(path.read_text())
    layout["deformables"][1]["points"] = [8, 400]
    path.write_text(json.dumps(layout))
    states = RunStates.load(folder)
    assert states.frames == 0
    assert "soft_points has shape (40, 16, 3)" in states.losses[0]
    assert states.deformables[1].points.shape == (0, 392, 3)
