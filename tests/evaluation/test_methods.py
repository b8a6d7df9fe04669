"""Methods: command lines, text2sim, and the coding agent, which runs code written by a model."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from tests.agents.models.chat_server import ChatServer, completion
from tests.evaluation.conftest import SUITE, write_film
from text2sim.evaluation import genesis_docs
from text2sim.evaluation.bare_agent import ProgramTrial, left_text, shown_log
from text2sim.evaluation.method_folder import read_made, read_method
from text2sim.evaluation.methods import Allowance, parse_method, run_method
from text2sim.evaluation.suite import read_suite
from text2sim.spec_schema.errors import RunError

COMMAND = """
import json, os, pathlib, shutil, sys
prompt, folder, film = sys.argv[1:]
folder = pathlib.Path(folder)
assert os.environ["TEXT2SIM_PROMPT"] == prompt and folder.name in ("drop", "sag")
print("said", prompt)
if folder.name == "sag":
    sys.exit(7)
shutil.copy(film, folder / "film.mp4")
"""
PROGRAM = """Here it is:

```python
import os, pathlib, shutil, sys
out = pathlib.Path(sys.argv[2])
print("keys:", [name for name in os.environ if "KEY" in name or "TOKEN" in name])
{body}
```
"""


def run(suite: Path, word: str, out: Path, models: list[str] | None = None, **allowance: Any) -> Path:
    read, _ = read_suite(suite)
    return run_method(
        read, read.prompts, parse_method(word), models or [], Allowance(**allowance), out, lambda line: None
    )


def test_any_command_fills_a_method_folder(suite: Path, tmp_path: Path) -> None:
    (tmp_path / "it.py").write_text(COMMAND)
    film = write_film(tmp_path / "a film.mp4")
    word = f"other={sys.executable} {tmp_path / 'it.py'} {{prompt}} {{folder}} '{film}'"
    method = read_method(run(suite, word, tmp_path / "out"))
    drop, sag = method.made["drop"], method.made["sag"]
    assert (method.name, method.record.suite) == ("other", "small")
    assert (drop.result.status, drop.result.film, drop.result.log) == ("finished", "film.mp4", "log.txt")
    assert drop.result.wall_s
    assert drop.result.total is None, "nobody counted"
    assert "said A red ball falls" in (drop.folder / "log.txt").read_text()
    assert (sag.result.status, sag.result.why) == ("failed", "it ended with exit code 7")


def test_generate_ends_with_an_evaluation_that_is_stopped(suite: Path, tmp_path: Path) -> None:
    mail = tmp_path / "mail"
    words = [
        "evaluate",
        "run",
        str(suite),
        "--method",
        "text2sim",
        "--out",
        str(tmp_path),
        "--model",
        f"mailbox:{mail}",
    ]
    parent = subprocess.Popen([sys.executable, "-m", "text2sim", *words], stderr=subprocess.DEVNULL)
    limit = time.monotonic() + 60
    while not list(mail.rglob("*.request.md")) and time.monotonic() < limit:
        time.sleep(0.1)
    (child,) = psutil.Process(parent.pid).children()
    parent.send_signal(signal.SIGTERM)
    parent.wait(30)
    assert not child.is_running() or child.status() == psutil.STATUS_ZOMBIE


def test_prompts_are_neither_placeholders_nor_shell_code(suite: Path, tmp_path: Path) -> None:
    text = suite.read_text().replace("A red ball falls", "A {folder} $(touch pwned); `touch pwned` falls")
    suite.write_text(text)
    code = "import pathlib, sys; pathlib.Path(sys.argv[2], 'film.mp4').write_text(sys.argv[1])"
    folder = run(suite, f'other={sys.executable} -c "{code}" {{prompt}} {{folder}}', tmp_path / "out")
    assert (folder / "drop" / "film.mp4").read_text().startswith("A {folder} $(touch pwned); `touch pwned` falls")


def test_a_command_that_takes_too_long_is_ended(suite: Path, tmp_path: Path) -> None:
    folder = run(suite, f'slow={sys.executable} -c "import time; time.sleep(60)"', tmp_path / "out", minutes=0.01)
    assert "took longer than 0.01 minutes" in read_made(folder / "drop").result.why


def test_existing_answers_are_kept(suite: Path, tmp_path: Path) -> None:
    word = f"other={sys.executable} -c \"open('{tmp_path / 'count'}', 'a').write('x')\""
    for _ in range(2):
        run(suite, word, tmp_path / "out")
    assert (tmp_path / "count").read_text() == "xx", "two prompts, once each"


@pytest.mark.parametrize("word", ["text3sim", "text2sim:cards", "a b=ls", "x=", "x='"])
def test_words_that_are_no_method_are_refused(word: str) -> None:
    with pytest.raises(RunError, match="is not a method"):
        parse_method(word)


def test_the_agent_reads_runs_repairs_and_is_done(suite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOME_API_KEY", "secret")
    film = write_film(tmp_path / "made.mp4")
    replies = [
        "```yaml\nread: [gs.morphs.Box, Scene.add_entity, gs.morphs.Bax]\n```",
        PROGRAM.format(body="raise ValueError('not yet')"),
        PROGRAM.format(body=f"shutil.copy({str(film)!r}, out / 'film.mp4')"),
        PROGRAM.format(body="(out / 'film.mp4').write_bytes(b'stopped while it was written')"),
        "```yaml\ndone: true\n```",
    ]
    with ChatServer(*(completion(reply) for reply in replies)) as server:
        models = [f"openai/agent@{server.url},vision=yes"]
        folder = run(suite, "agent:with-cards", tmp_path / "out", models, attempts=5)
        asked = server.requests[:4]
    result = read_made(folder / "drop").result
    assert (result.status, result.accepted, result.attempts) == ("finished", True, 3)
    assert result.film == "attempts/02/film.mp4"
    assert result.total is not None
    assert (result.total.calls, result.total.tokens_in) == (5, 60)
    first = asked[0]["messages"][1]["content"]
    assert "A red ball falls onto a flat floor." in first
    assert "gs.morphs.Sphere(" in first
    assert "Lessons from earlier failures" in first
    assert "extents" in asked[1]["messages"][-1]["content"] or "size" in asked[1]["messages"][-1]["content"]
    assert "there is `Box`" in asked[1]["messages"][-1]["content"]
    failed = asked[2]["messages"][-1]["content"]
    assert "ValueError: not yet" in failed
    assert "keys: []" in failed
    assert "4 more programs" in failed
    seen = asked[3]["messages"][-1]["content"]
    assert sum(part["type"] == "image_url" for part in seen) == 10


@pytest.mark.parametrize(
    ("minutes", "wall", "told"),
    [
        (None, 9.0, "29 more programs"),
        (20.0, 30.0, "29 more programs, and 20 minutes for everything"),
        (12.0, 240.0, "12 minutes for everything, enough for 3 more that take as long as this one"),
        (0.3, 240.0, "hardly a minute, enough for no more that take as long as this one"),
    ],
)
def test_the_agent_is_told_the_limit_that_comes_first(minutes: float | None, wall: float, told: str) -> None:
    assert left_text(29, ProgramTrial(Path(), 0, "ended", wall, minutes)) == told


def test_lines_about_speed_do_not_push_out_what_a_program_printed() -> None:
    speed = "\x1b[38;5;159m[Genesis] [23:57:09] [INFO] Running at \x1b[38;5;121m26.32\x1b[0m FPS.\x1b[0m\n"
    assert shown_log("built\n" + 500 * speed + "\x1b[31mend\x1b[0m\n") == "built\nend"


def test_the_agent_goes_on_after_an_interruption_without_paying_or_running_twice(suite: Path, tmp_path: Path) -> None:
    body = f"open({str(tmp_path / 'count')!r}, 'a').write('x')"
    replies = [PROGRAM.format(body=body), PROGRAM.format(body=body + " ")]
    models: list[str] = []
    with ChatServer(*(completion(reply) for reply in replies)) as server:
        models.append(f"openai/agent@{server.url}")
        folder = run(suite, "agent:no-cards", tmp_path / "out", models, attempts=2)
        count = len(server.requests)
        assert read_made(folder / "drop").result.why == "its attempts are spent"
        for prompt in ("drop", "sag"):
            (folder / prompt / "result.json").unlink()
        run(suite, "agent:no-cards", tmp_path / "out", models, attempts=2)
        assert len(server.requests) == count
    assert (tmp_path / "count").read_text() == "x" * 4
    assert "Lessons" not in server.requests[0]["messages"][1]["content"]


def test_code_is_run_only_if_somebody_allows_it(
    suite: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from typer.testing import CliRunner

    from text2sim.cli.main import app

    words = ["evaluate", "run", str(suite), "--method", "agent", "--out", str(tmp_path / "out"), "--model", "mailbox:x"]
    answer = CliRunner().invoke(app, words)
    assert isinstance(answer.exception, RunError)
    assert "--allow-code" in str(answer.exception)
    assert not (tmp_path / "out").exists()


def test_the_digest_is_of_the_installed_genesis() -> None:
    digest = genesis_docs.digest()
    assert 20_000 < len(digest) < 60_000
    for name in (
        "gs.options.vis.PointLight(",
        "gs.force_fields.Drag(linear=",
        "gs.init(",
        "Scene.add_entity(",
        "gs.materials.MPM.Elastic(",
        "RigidEntity.control_dofs_position(",
        "PBDEntity.get_particles_pos(",
        "FEMEntity.get_state(",
        "FEMEntity.set_vertex_constraints(",
        "scene.rigid_solver.add_weld_constraint(",
        "PBDEntity.fix_particles_to_link(",
    ):
        assert name in digest
    for line in digest.splitlines():
        assert "vvert_start" not in line, "what a scene makes needs no constructor"
        assert "_ckpt(" not in line
    assert "Young" in genesis_docs.docstrings_of(["MPM.Elastic"])
    assert "link1_idx" in genesis_docs.docstrings_of(["RigidSolver.add_weld_constraint"]), "by the class's name, too"


def test_text2sim_is_called_as_a_user_calls_it(suite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A request that cannot be put is no failure of the prompt: it stops, with the reason, and nothing is written."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), os.getcwd()])))
    with pytest.raises(RunError, match="drop: text2sim generate: .*nobody"):
        run(suite, "text2sim:no-cards", tmp_path / "out", ["nobody/nothing"])
    assert not (tmp_path / "out" / "text2sim-no-cards" / "drop" / "result.json").exists()


def test_the_result_has_the_resources_of_text2sim_and_the_reason_for_a_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recorded loop about something impossible, played again by the command: planned, counted, and given up."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), os.getcwd()])))
    recorded = Path(__file__).parents[1] / "agents" / "recorded" / "perpetual"
    shutil.copytree(recorded, tmp_path / "letters" / "text2sim-no-cards" / "wheel")
    request = json.loads((recorded / "expected.json").read_text())["request"]
    (tmp_path / "wheel.yaml").write_text(SUITE[: SUITE.index("  sag:")].replace("drop:", "wheel:").replace(
        "A red ball falls onto a flat floor.", json.dumps(request)
    ))  # fmt: skip
    folder = run(tmp_path / "wheel.yaml", "text2sim:no-cards", tmp_path / "out", [f"replay:{tmp_path / 'letters'}"])
    result = read_made(folder / "wheel").result
    assert (result.status, result.accepted, result.film, result.run) == ("failed", False, None, None)
    assert result.why.startswith("impossible: ")
    assert result.roles is not None
    assert set(result.roles) == {"planner"}
    assert result.roles["planner"].tokens_in > 1000
    assert result.roles["planner"].cost is None, "nobody knows the price of a replay"
