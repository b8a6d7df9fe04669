"""Rods that driven bodies hang from."""

from typing import Any

import numpy as np
import pytest
from filmed import MakeRun

from text2sim.recording.film_record import read_recording
from text2sim.rendering.hangers import Rods, hangers
from text2sim.templates.cameras import View

EYE = View(np.array([0.0, -4.0, 2.0]), np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]), 40.0, 4.0, 0.0)
STILL = {"velocity": (0, 0, 0)}
RAM = {"half": 0.2, "pos": (0, 0, 1.0), "velocity": (0, 0, -1.0)}


def rods_of(make_run: MakeRun, *driven: str, **boxes: Any) -> tuple[Rods | None, Any]:
    recording = read_recording(make_run(boxes))
    return hangers(recording, list(driven), 0.0, [EYE]), recording.states


def test_a_press_hangs_from_a_rod_that_moves_with_it(make_run: MakeRun) -> None:
    found, states = rods_of(make_run, "ram", ram=RAM, cake=STILL | {"half": 0.2, "pos": (0, 0, 0.2)})
    assert found is not None
    for t in (0.0, 0.4):
        vertices = found.placed(*states.poses(t)).vertices
        assert vertices[:, 2].min() == pytest.approx(1.2 - t, abs=1e-5), "it begins at the top of the ram"
        assert np.abs(vertices[:, :2]).max() < 0.05
        assert vertices[:, 2].max() > 3.0


def test_free_bodies_and_those_on_the_floor_get_none(make_run: MakeRun) -> None:
    assert rods_of(make_run, ram=RAM)[0] is None
    plough = {"half": 0.2, "pos": (0, 0, 0.2), "velocity": (1.0, 0, 0)}
    assert rods_of(make_run, "plough", plough=plough)[0] is None
    gate = {"half": 0.2, "pos": (0, 0, 0.2), "velocity": (0, 0, 1.0)}
    assert rods_of(make_run, "gate", gate=gate)[0] is not None, "it is lifted"


def test_what_has_something_to_hold_it_gets_none(make_run: MakeRun) -> None:
    wall = {"half": 0.5, "pos": (0.7, 0, 0.8)}
    assert rods_of(make_run, "ram", ram=RAM, wall=wall)[0] is None
    finger = RAM | {"half": 0.05, "pos": (0.1, 0, 0.75)}
    found, _ = rods_of(make_run, "ram", "finger", ram=RAM, finger=finger)
    assert found is not None
    assert set(found.links) == {0}, "the finger is part of the ram"


def test_no_rod_goes_through_what_is_above(make_run: MakeRun) -> None:
    lid = {"half": 0.3, "pos": (0, 0, 2.2)}
    assert rods_of(make_run, "ram", ram=RAM, lid=lid)[0] is None
    bird = {"half": 0.1, "pos": (-1.0, 0, 2.2), "velocity": (5.0, 0, 0)}
    assert rods_of(make_run, "ram", ram=RAM, bird=bird)[0] is None


@pytest.mark.parametrize(("axis", "ends"), [((1.0, 0.0, 0.0), {0}), ((0.0, 1.0, 0.0), {1}), ((0.0, 0.0, 1.0), {2})])
def test_a_spinning_body_has_its_rod_along_the_axis(make_run: MakeRun, axis: Any, ends: set[int]) -> None:
    run = make_run({"drill": STILL | {"half": 0.1, "pos": (0, 0, 1.0)}})
    chunk = run / "states" / "chunk_00000.npz"
    with np.load(chunk) as arrays:
        states = dict(arrays)
    halves = 0.6 * np.arange(5)
    quats = np.column_stack([np.cos(halves), np.sin(halves)[:, None] * axis])
    states["links_quat"] = quats[:, None].astype(np.float32)
    np.savez(chunk, **states)
    recording = read_recording(run)
    found = hangers(recording, ["drill"], 0.0, [EYE])
    assert found is not None
    start, later = (found.placed(*recording.states.poses(t)).vertices for t in (0.0, 0.3))
    assert set(np.flatnonzero(np.ptp(start, axis=0) > 0.5)) == ends
    assert np.ptp(start, axis=0) == pytest.approx(np.ptp(later, axis=0), abs=0.01), "it turns about itself"
    assert start[:, 1].min() > -0.1, "not towards the camera"
