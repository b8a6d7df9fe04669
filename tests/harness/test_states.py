"""Recordings are read as far as they are whole, and what is missing is said."""

import json

import numpy as np
import pytest

from text2sim.recording.states import RunStates
from text2sim.spec_schema.errors import RunError


@pytest.fixture
def folder(new_run):
    run = new_run()
    run.add_link("ball", mass=2.0, com=(0.1, 0, 0), pos=np.outer(run.time, [1, 0, 0]))
    run.add_joint("drum", "drum", "hinge", q=run.time, limits=(-1.0, 2.0))
    return run.write(chunk=40)


def test_chunks_become_one(folder):
    states = RunStates.load(folder)
    assert states.frames == 101
    assert states.end == pytest.approx(1.0)
    assert states.pos.shape == (101, 1, 3)
    np.testing.assert_allclose(states.pos[:, 0, 0], states.time, atol=1e-6)
    np.testing.assert_array_equal(states.steps, np.arange(101))
    assert (states.links[0].mass, states.links[0].com) == (2.0, (0.1, 0.0, 0.0))
    assert states.joints[0].limits == (-1.0, 2.0)
    assert states.losses == ()


def test_a_chunk_that_was_cut_off_is_left_out_and_said(folder):
    last = folder / "states" / "chunk_00002.npz"
    last.write_bytes(last.read_bytes()[:-100])
    states = RunStates.load(folder)
    assert states.frames == 80
    assert len(states.losses) == 1
    assert "chunk_00002.npz" in states.losses[0]


def test_nothing_after_a_gap_is_used(folder):
    (folder / "states" / "chunk_00001.npz").unlink()
    states = RunStates.load(folder)
    assert states.frames == 40
    assert "1 of 2 chunks left out" in states.losses[0]


def test_a_chunk_of_another_scene_is_left_out(folder):
    layout = json.loads((folder / "states" / "layout.json").read_text())
    layout["links"].append(layout["links"][0])
    (folder / "states" / "layout.json").write_text(json.dumps(layout))
    states = RunStates.load(folder)
    assert states.frames == 0
    assert "links_pos has shape (40, 1, 3)" in states.losses[0]


def test_pickled_objects_are_not_loaded(folder):
    path = folder / "states" / "chunk_00000.npz"
    with np.load(path) as chunk:
        arrays = dict(chunk)
    np.savez(path, **(arrays | {"time": np.array([{}] * 40, dtype=object)}))  # type: ignore[arg-type]
    states = RunStates.load(folder)
    assert states.frames == 0
    assert "damaged" in states.losses[0]


def test_a_last_chunk_may_hold_contacts_alone(folder):
    whole = RunStates.load(folder)
    with np.load(folder / "states" / "chunk_00002.npz") as chunk:
        contacts = {name: array for name, array in chunk.items() if name.startswith("contact_")}
    np.savez(folder / "states" / "chunk_00003.npz", **contacts)
    states = RunStates.load(folder)
    assert (states.frames, states.losses) == (whole.frames, ())
    assert states.contact("force").shape == (0, 3)


def test_without_frames_the_arrays_are_empty(new_run):
    run = new_run()
    run.add_link("ball")
    states = RunStates.load(run.write(upto=0))
    assert (states.frames, states.end, states.pos.shape, states.contact("links").shape) == (
        0,
        0.0,
        (0, 1, 3),
        (0, 2),
    )


@pytest.mark.parametrize(
    "text",
    [
        None,
        "{",
        "[]",
        '{"links": 3}',
        '{"dt": 0, "every": 1, "links": [], "joints": [], "gravity": [0, 0, 0]}',
    ],
)
def test_what_is_no_recording_is_an_error_for_the_user(tmp_path, text):
    if text is not None:
        (tmp_path / "states").mkdir()
        (tmp_path / "states" / "layout.json").write_text(text)
    with pytest.raises(RunError, match="layout.json"):
        RunStates.load(tmp_path)
