"""Runs in which bodies sink into each other, and that are repeated with finer steps."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from text2sim.agents import attempts as attempts_module
from text2sim.agents.assembly import examine
from text2sim.agents.attempt import Attempt
from text2sim.agents.attempts import Attempts
from text2sim.agents.refinement import with_finer_steps
from text2sim.spec_schema.load import load_text

CASE = """
text2sim: 2
name: drop
params: {fine: 2}
scene: {duration: 0.4, dt: 0.005, statics: {tray: {shape: {kind: box, size: [1, 1, 0.006]}}}}
bodies:
  bead: {kind: rigid, shape: {kind: sphere, radius: 0.01}, pose: {pos: [0, 0, 0.2056]}}
"""


@pytest.mark.parametrize(
    ("given", "factor", "substeps"),
    [
        ("", 3, 3),  # of one that is derived
        ("substeps: 4, ", 3, 12),
        ('substeps: "${3 * fine}", ', 2, 12),
        ("substeps: 40, ", 3, 50),  # and no more
        ("substeps: 60, ", 3, None),
        ("", None, None),
    ],
)
def test_the_steps_become_as_fine_as_the_overlap_asks_for(given: str, factor: int | None, substeps: int | None) -> None:
    path = Path("case.yaml")
    text = CASE.replace("dt: 0.005, ", f"dt: 0.005, {given}")
    finer, ratio = with_finer_steps(text, load_text(text, path), {"substeps_factor": factor})
    assert (finer == text) is (substeps is None)
    assert (ratio > 1) is (substeps is not None)
    if substeps is not None:
        assert load_text(finer, path).case.scene.substeps == substeps


@pytest.mark.parametrize(("recorded", "runs"), [(20.0, 1), (400.0, 0)])
def test_a_run_that_is_only_judged_again_is_not_taken_for_a_quick_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recorded: float, runs: int
) -> None:
    """With three times the substeps it takes three times as long as when it was recorded, and 100 s are allowed."""
    seen: list[Any] = []
    finer = SimpleNamespace(state="finished")
    record = SimpleNamespace(read=lambda folder: SimpleNamespace(wall=recorded))
    monkeypatch.setattr(attempts_module, "RunRecord", record)
    attempts, attempt = Attempts(tmp_path), Attempt(2, CASE, "another film")
    monkeypatch.setattr(attempts, "_simulated", lambda loaded, **options: seen.append((loaded, options)) or finer)
    judged: Any = SimpleNamespace(wall=0.5, folder=tmp_path, evidence={"substeps_factor": 3})
    examined = examine(CASE, tmp_path / "case.yaml")
    _, result = attempts._refined(attempt, examined, judged, 100.0, {})
    assert len(seen) == runs
    assert result is (finer if runs else judged)


def test_what_lacks_its_pictures_is_run_again_from_its_own_text(tmp_path: Path) -> None:
    attempts, kept = Attempts(tmp_path), Attempt(1, CASE.replace("dt: 0.005", "dt: 0.001"), "x", coarse_text=CASE)
    kept.pictures, kept.state, kept.run = ["frames.png"], "finished", "runs/a"
    attempts.keep(kept)
    again = Attempt(1, CASE, "x")
    assert not attempts.recall(again)
    assert again == Attempt(1, CASE, "x")
    (attempts.folder_of(1) / "frames.png").touch()
    assert attempts.recall(again)
    assert (again.text, again.coarse_text) == (kept.text, CASE)


@pytest.mark.usefixtures("engine")
def test_a_run_is_repeated_with_finer_steps_and_a_resumed_loop_knows_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After 39 steps of 5 ms the bead is 1.3 mm above the tray of 6 mm, after 40 it is 8.5 mm deep in it."""
    monkeypatch.setattr(attempts_module, "frame_sheet", lambda run, preview: (None, 0, ""))  # pictures take longer
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    attempts, attempt = Attempts(tmp_path), Attempt(1, CASE, "first version")
    try:
        attempts.run(attempt, examine(CASE, path), (), 600.0, lambda progress: None, finer_within=600.0)
    finally:
        attempts.close()
    assert attempt.state == "finished"
    assert attempt.coarse_text == CASE
    assert load_text(attempt.text, path).case.scene.substeps == 3
    assert "overlap by" not in attempt.evidence
    again = Attempt(1, CASE, "first version")
    assert Attempts(tmp_path).recall(again)
    assert again.text == attempt.text
