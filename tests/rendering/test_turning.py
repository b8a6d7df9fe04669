"""Turning of plain round bodies, which pictures do not show."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from filmed import MakeRun

from text2sim.legibility.film import Watcher
from text2sim.legibility.summary import summarise
from text2sim.legibility.turning import PLAIN_FINISHES
from text2sim.recording.film_record import read_recording
from text2sim.rendering.finishes import FINISHES

STEP = 1.2
"""Angle from one frame to the next [rad]; the four pictures of the film are 3.6 rad apart, 0.6 turns."""


def spinning(make_run: MakeRun, mesh: Any, axis: tuple[float, float, float], **look: Any) -> Path:
    """Write a run of a body that spins in place about an axis of its own."""
    run = make_run({"body": {"half": 0.5, "pos": (0, 0, 0.5), "velocity": (0, 0, 0)} | look})
    np.savez(run / "geometry" / "body.npz", vertices=mesh.vertices, faces=mesh.faces)
    chunk = run / "states" / "chunk_00000.npz"
    with np.load(chunk) as arrays:
        states = dict(arrays)
    halves = STEP / 2 * np.arange(5)
    quats = np.column_stack([np.cos(halves), np.sin(halves)[:, None] * axis])
    states["links_quat"] = quats[:, None].astype(np.float32)
    np.savez(chunk, **states)
    return run


def remarks(run: Path) -> str:
    return "\n".join(row for row in summarise(Watcher(read_recording(run)))["remarks"] if "turns" in row)


BALL = trimesh.creation.icosphere(3, 0.3)
ROLLER = trimesh.creation.cylinder(0.2, 0.8, sections=32)
CRATE = trimesh.creation.box((0.5, 0.5, 0.5)).subdivide().subdivide()
NUT = trimesh.creation.cylinder(0.2, 0.2, sections=6)


@pytest.mark.parametrize(
    ("mesh", "axis", "unseen"),
    [
        (BALL, (0.0, 0.6, 0.8), True),
        (trimesh.creation.icosphere(3, 0.02), (0.0, 0.6, 0.8), False),  # a pattern would not be seen, either
        (ROLLER, (0.0, 0.0, 1.0), True),
        (ROLLER, (1.0, 0.0, 0.0), False),
        (CRATE, (0.0, 0.0, 1.0), False),
        (NUT, (0.0, 0.0, 1.0), False),
    ],
)
def test_only_round_bodies_hide_their_turning(make_run: MakeRun, mesh: Any, axis: Any, unseen: bool) -> None:
    found = remarks(spinning(make_run, mesh, axis))
    assert found == ("`body` turns 0.6 times, which a plain round surface does not show: give its `look` a `pattern`"
                     if unseen else "")  # fmt: skip


@pytest.mark.parametrize(("spin", "unseen"), [(12.0, False), (0.0, True)])
def test_a_link_that_turns_along_shows_it(make_run: MakeRun, spin: float, unseen: bool) -> None:
    still = {"velocity": (0, 0, 0)}
    mark = {"of": "body", "half": 0.1, "pos": (0.3, 0, 0.5), "spin": spin} | still
    run = make_run({"body": {"half": 0.5, "pos": (0, 0, 0.5), "spin": 12.0} | still, "mark": mark})
    np.savez(run / "geometry" / "body.npz", vertices=BALL.vertices, faces=BALL.faces)
    assert bool(remarks(run)) == unseen


def test_grain_shows_that_a_ball_turns(make_run: MakeRun) -> None:
    assert not remarks(spinning(make_run, BALL, (0.0, 1.0, 0.0), finish="wood"))
    assert remarks(spinning(make_run, BALL, (0.0, 1.0, 0.0), finish="polished_metal"))


def test_plain_finishes_have_no_texture_that_shows_the_turning() -> None:
    opaque = {name for name, finish in FINISHES.items() if finish.texture in ("", "streaks")}
    assert opaque >= PLAIN_FINISHES
    assert {name for name in opaque if FINISHES[name].kind == "solid"} <= PLAIN_FINISHES
