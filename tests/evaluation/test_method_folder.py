"""Method folders: round trips, and as much as possible of incomplete ones."""

import json
import os
from pathlib import Path

import pytest

from text2sim.evaluation.method_folder import (
    CaseResult,
    MethodRecord,
    Resources,
    read_made,
    read_method,
    write_method,
    write_result,
)
from text2sim.spec_schema.errors import RunError


def test_a_method_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    folder = tmp_path / "m" / "tower"
    folder.mkdir(parents=True)
    (folder / "film.mp4").write_bytes(b"film")
    roles = {"planner": Resources(calls=1, tokens_in=10, cost=0.5), "critic": Resources(calls=2, tokens_out=3)}
    result = CaseResult(prompt="tower", status="finished", film="film.mp4", roles=roles, attempts=2, wall_s=9.0)
    write_result(folder, result)
    write_method(tmp_path / "m", MethodRecord(name="ours", suite="s"))
    method = read_method(tmp_path / "m")
    assert method.name == "ours"
    made = method.made["tower"]
    assert made.result == result
    assert made.problems == ()
    assert made.path("film") == folder / "film.mp4"
    assert made.path("run") is None
    total = made.result.total
    assert total is not None
    assert (total.calls, total.tokens_in, total.tokens_out, total.cost) == (3, 10, 3, 0.5)


def test_a_folder_without_a_record_is_taken_as_far_as_it_goes(tmp_path: Path) -> None:
    folder = tmp_path / "m" / "tower"
    folder.mkdir(parents=True)
    (folder / "clip.mp4").write_bytes(b"film")
    (folder / "main.py").write_text("pass")
    method = read_method(tmp_path / "m")
    made = method.made["tower"]
    assert method.name == "m"
    assert (made.result.status, made.result.film, made.result.program) == ("unknown", "clip.mp4", "main.py")
    assert made.result.total is None
    assert "no result.json" in made.problems[0].message


def test_a_result_may_be_a_link_to_a_folder_of_another_name(tmp_path: Path) -> None:
    (tmp_path / "2026-run").mkdir()
    (tmp_path / "2026-run" / "film.mp4").write_bytes(b"film")
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "drop").symlink_to(tmp_path / "2026-run")
    assert read_method(tmp_path / "theirs").made["drop"].result.prompt == "drop"


def test_problems_of_a_record_are_located(tmp_path: Path) -> None:
    folder = tmp_path / "tower"
    folder.mkdir()
    (folder / "result.json").write_text('{"prompt": "tower",\n "status": "finished",\n "flim": "a.mp4"}')
    problem = read_made(folder).problems[0]
    assert (problem.line, problem.hint) == (3, "film")


@pytest.mark.parametrize("film", ["../secret.mp4", "/etc/hostname", "gone.mp4", "link.mp4", "pipe.mp4", "."])
def test_no_path_leads_out_of_the_folder(tmp_path: Path, film: str) -> None:
    folder = tmp_path / "tower"
    folder.mkdir()
    (tmp_path / "secret.mp4").write_bytes(b"x")
    (folder / "link.mp4").symlink_to(tmp_path / "secret.mp4")
    os.mkfifo(folder / "pipe.mp4")
    text = json.dumps({"prompt": "tower", "status": "finished", "film": film})
    (folder / "result.json").write_text(text)
    made = read_made(folder)
    assert made.path("film") is None
    assert made.empty
    assert made.problems[0].path == "/film"


def test_there_must_be_something(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="no such method folder"):
        read_method(tmp_path / "none")
    with pytest.raises(RunError, match="has no results"):
        read_method(tmp_path)
