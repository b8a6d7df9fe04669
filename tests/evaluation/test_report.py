"""From method folders to page and tables, by the command."""

import csv
import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.evaluation.conftest import PHYSICAL, VISUAL, Judge
from text2sim.cli.main import app
from text2sim.spec_schema.errors import RunError

Make = Callable[..., Path]


def rows(out: Path, name: str) -> list[dict[str, str]]:
    with (out / "tables" / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


def test_the_command_judges_and_writes_page_and_tables(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    ours, bare = make_method("ours", tokens=1000), make_method("bare", tokens=3000)
    (bare / "drop" / "film.mp4").write_bytes(b"nothing")
    out = tmp_path / "out"
    judge.replies["physical"] = (
        PHYSICAL.replace("frame 2", "line 20").replace("frame 10", "line 3").replace("frame 1", "line 1")
    )
    judge.replies["visual"] = VISUAL.replace("polish", 'why: "<b>frame 3</b>: =1+1"\npolish')
    words = ["evaluate", "judge", str(suite), str(ours), str(bare), "--out", str(out), "--repeats", "2"]
    words += ["--judge", judge.model, "--judge", judge.model.replace("judge@", "other@")]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 0, answer.output
    asked = len(judge.requests)

    scores = {row["method"]: row for row in rows(out, "scores")}
    drop = 0.20 * 100 + 0.275 * 100 * 5 / 6 + 0.275 * 50 + 0.25 * (0.7 * 87.5 + 18) - 10
    sag = 75 + 0.25 * 85
    assert float(scores["ours"]["physical"]) == pytest.approx((drop + sag) / 2)
    assert float(scores["bare"]["physical"]) == pytest.approx((20 + sag) / 2), "capped without a film"
    assert float(scores["ours"]["visual"]) == pytest.approx(55)
    assert float(scores["bare"]["visual"]) == pytest.approx(27.5)
    assert float(scores["ours"]["physical_rigid"]) == pytest.approx(drop)
    kept = [json.loads(path.read_text()) for path in (out / "drop" / "ours").glob("physical-*/judgement.json")]
    assert len(kept) == 4
    assert [row["total"] for row in kept] == pytest.approx([drop] * 4)
    difference = next(row for row in rows(out, "differences") if row["score"] == "visual")
    assert (float(difference["mean"]), difference["count"]) == (pytest.approx(27.5), "2")
    resources = {row["method"]: row for row in rows(out, "resources")}
    assert float(resources["bare"]["tokens_in"]) == 3000, "over the cases that are counted"
    assert (float(resources["ours"]["wall_s"]), float(resources["ours"]["without_simulation_s"])) == (40, 40)
    assert float(resources["ours"]["attempts"]) == 3
    assert {row["role"] for row in rows(out, "resources_by_case")} == {"all", "planner"}
    assert len(rows(out, "judgements")) == 2 * 2 * 2 * 4
    assert len([row for row in rows(out, "requirements") if row["prompt"] == "drop"]) == 9 * 2 * 4
    assert {row["between"] for row in rows(out, "agreement")} == {"repeats of one judge", "judges 1 and 2"}

    page = (out / "report.html").read_text()
    assert "<b>frame 3</b>" not in page
    assert "&lt;b&gt;frame 3" in page
    assert "Text2Sim (paper)" in page
    assert "the film does not decode" in page
    assert "it ends above the floor" in page
    assert not re.search(r"https?://", page.replace(judge.url, "")), "nothing from elsewhere"
    films = re.findall(r'<video[^>]* src="([^"]+)"', page)
    assert (out / films[0]).resolve() == ours / "drop" / "film.mp4"

    assert isinstance(CliRunner().invoke(app, words).exception, RunError), "only --resume goes on"
    assert CliRunner().invoke(app, [*words, "--resume"]).exit_code == 0
    assert len(judge.requests) == asked


def test_a_suite_that_has_changed_since_is_refused(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    words = ["evaluate", "judge", str(suite), str(make_method("ours")), "--out", str(out), "--repeats", "1"]
    judge.replies["sag"] = "I cannot say."
    answer = CliRunner().invoke(app, [*words, "--judge", judge.model])
    assert answer.exit_code == 1
    assert "1 of 4 judgements are missing" in answer.output
    assert "physical: not judged" in (out / "report.html").read_text()
    suite.write_text(suite.read_text().replace("a flat floor", "a round floor"))
    answer = CliRunner().invoke(app, ["evaluate", "report", str(suite), str(out)])
    assert isinstance(answer.exception, RunError)
    assert "another version of small" in str(answer.exception)


def test_after_a_kill_only_missing_judgements_are_made(
    suite: Path, make_method: Make, judge: Judge, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), os.getcwd()])))
    words = ["evaluate", "judge", str(suite), str(make_method("ours")), "--out", str(tmp_path / "out")]
    words += ["--judge", judge.model]
    killed = subprocess.Popen([sys.executable, "-m", "text2sim", *words], stderr=subprocess.DEVNULL)
    until = time.monotonic() + 120
    while len(judge.requests) < 6 and time.monotonic() < until:
        time.sleep(0.02)
    killed.kill()
    killed.wait()
    before = len(judge.requests)
    assert 6 <= before < 13, "it was killed in between"
    assert CliRunner().invoke(app, [*words, "--resume"]).exit_code == 0
    assert len(judge.requests) <= 13 + 1, "the one that was on its way may be asked again"
    assert len(rows(tmp_path / "out", "judgements")) == 12
