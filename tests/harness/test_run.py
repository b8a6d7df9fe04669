"""From a case to a run folder: what is done, what is not done twice, and what is kept.

The programs are real processes, but of plain Python: they copy a recording that was made by hand.
"""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from text2sim.harness.folder import Work
from text2sim.harness.result import RunResult
from text2sim.harness.run import run_case
from text2sim.runtime.lock import RunLock
from text2sim.runtime.progress import PHASES, Progress
from text2sim.spec_schema.errors import MachineError, RunError
from text2sim.spec_schema.load import load_case

CASE = """\
text2sim: 1
name: fall
scene: {duration: 1.0}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}
actions:
  measures:
    height: {kind: position, of: ball, axis: z}
  expect:
    falls: {measure: height, at: end, below: 1.0}
    answers: {measure: height, at: start, above: 4.0}
render: {fps: 25}
"""

MAIN = """
import json, os, shutil, sys, time
from pathlib import Path
OUT = Path(sys.argv[sys.argv.index("--out") + 1])
with open(CALLS, "a") as stream:
    stream.write(" ".join(sys.argv[3:]) + ".\\n")
"""
SIMULATE = """
with (OUT / "progress.jsonl").open("a") as stream:
    for phase, t in (("build", 0), ("simulate", 0), ("simulate", 1.0)):
        stream.write(json.dumps({"phase": phase, "t": t, "duration": 1.0}) + "\\n")
if "--film-only" not in sys.argv:
    shutil.copytree(RECORDING, OUT, dirs_exist_ok=True)
if "--no-film" not in sys.argv:
    (OUT / "video.mp4").write_bytes(b"film")
"""


class Stage:
    """A case, a compiler that makes stand-in programs for it, and a folder of runs."""

    def __init__(self, folder: Path, recording: Path) -> None:
        self.file, self.runs, self.calls = folder / "case.yaml", folder / "runs", folder / "calls.txt"
        self.file.write_text(CASE)
        self.head = f"CALLS, RECORDING = {str(self.calls)!r}, {str(recording)!r}\n" + MAIN
        self.body = SIMULATE

    def edit(self, old: str, new: str) -> None:
        text = self.file.read_text()
        assert old in text
        self.file.write_text(text.replace(old, new))

    def compile(self, loaded: Any, out: Path) -> Any:
        out.mkdir()
        for name in ("scene", "bodies", "recorder"):
            (out / f"{name}.py").write_text(f"# the {name}\n")
        (out / "main.py").write_text(self.head + self.body)
        scene = repr((loaded.case.scene, loaded.case.bodies))
        return SimpleNamespace(
            sim_digest=sha256(scene.encode()).hexdigest(),
            render_digest=repr(loaded.case.render),
            seed=7,
            notes=("substeps = 1: it is enough",),
            settings=SimpleNamespace(substeps=9),
            warnings=(),
        )

    def run(self, **options: Any) -> RunResult:
        return run_case(load_case(self.file), runs=self.runs, compile_to=self.compile, **options)

    @property
    def programs(self) -> list[str]:
        """The flags of the programs that were started."""
        return self.calls.read_text().splitlines() if self.calls.exists() else []


@pytest.fixture
def silent(stage: Stage, tmp_path: Path) -> Stage:
    """A stage whose programs record no frames, so that no time goes into judging them."""
    for chunk in tmp_path.glob("run*/states/chunk_*.npz"):
        chunk.unlink()
    return stage


@pytest.fixture
def stage(tmp_path: Path, new_run: Callable[..., Any]) -> Stage:
    recording = new_run()
    t = recording.time
    fall = np.stack([0 * t, 0 * t, 5 - 4.905 * t**2], axis=1)
    recording.add_link("ball", pos=fall)
    recording.write()
    return Stage(tmp_path, recording.folder)


def record(result: RunResult) -> dict[str, Any]:
    return json.loads((result.folder / "run.json").read_text())


def test_a_first_run_simulates_judges_and_reports(stage: Stage):
    seen: list[Progress] = []
    result = stage.run(on_progress=seen.append)
    assert (result.work, result.state, result.time, result.passed) == (Work.SIMULATE, "finished", 1.0, True)
    assert result.folder.parent == stage.runs
    assert result.folder.name.startswith("fall-")
    assert list(result.expectations) == ["falls", "answers"]
    assert result.film == result.folder / "video.mp4"
    assert result.report is not None
    assert result.report.is_file()
    assert (result.folder / "case.yaml").read_text() == CASE
    assert json.loads((result.folder / "resolved.json").read_text())["name"] == "fall"
    phases = list(dict.fromkeys(p.phase for p in seen))
    assert phases == [phase for phase in PHASES if phase in phases]
    written = record(result)
    assert (written["state"], written["seed"], written["exit_code"]) == ("finished", 7, 0)
    assert written["case_digest"] == sha256(CASE.encode()).hexdigest()
    assert {"compile", "start", "judge", "report"} <= set(written["timings"])
    assert not any(path.name.startswith(".staging") for path in stage.runs.iterdir())


def test_what_is_done_is_not_done_again(stage: Stage):
    first = stage.run()
    evidence = (first.folder / "evidence.json").read_bytes()

    again = stage.run()
    assert (again.work, again.passed, list(again.expectations)) == (Work.NOTHING, True, ["falls", "answers"])
    assert again.film == first.film

    stage.edit("below: 1.0", "below: 0.05")
    judged = stage.run()
    assert (judged.work, judged.passed, judged.folder) == (Work.JUDGE, False, first.folder)
    assert "below: 0.05" in (first.folder / "case.yaml").read_text()

    stage.edit("below: 0.05", "below: 1.0")
    assert stage.run().work is Work.JUDGE
    assert (first.folder / "evidence.json").read_bytes() == evidence

    stage.edit("fps: 25", "fps: 50")
    (first.folder / "visibility.json").write_text("{}")
    (first.folder / "video_top.mp4").write_bytes(b"of another camera")
    assert stage.run(film=False).work is Work.JUDGE, "how well bodies are seen goes with the cameras"
    outdated = [first.folder / name for name in ("video.mp4", "video_top.mp4", "visibility.json")]
    assert not any(file.exists() for file in outdated), "evidence and report would be about the previous cameras"
    filmed = stage.run()
    assert (filmed.work, filmed.passed, filmed.folder) == (Work.FILM, True, first.folder)
    assert stage.programs == [".", "--film-only."]

    stage.edit("duration: 1.0", "duration: 0.9")
    other = stage.run()
    assert (other.work, other.folder != first.folder) == (Work.SIMULATE, True)


def test_new_code_does_again_what_depends_on_it(stage: Stage, monkeypatch: pytest.MonkeyPatch):
    stage.run()
    monkeypatch.setattr("text2sim.harness.run.film_code", lambda: "other cameras")
    assert [stage.run().work for _ in range(2)] == [Work.FILM, Work.NOTHING]
    monkeypatch.setattr("text2sim.harness.run.judge_code", lambda: "other evidence")
    assert [stage.run().work for _ in range(2)] == [Work.JUDGE, Work.NOTHING]
    monkeypatch.setattr("text2sim.harness.run.simulation_code", lambda: "another recorder")
    assert [stage.run().work for _ in range(2)] == [Work.SIMULATE, Work.NOTHING]


def test_a_film_that_was_not_wanted_is_made_later(stage: Stage):
    assert stage.run(film=False).film is None
    later = stage.run()
    assert (later.work, later.film) == (Work.FILM, later.folder / "video.mp4")
    assert stage.programs == ["--no-film.", "--film-only."]


def test_a_film_that_fails_is_reported_and_tried_again(stage: Stage):
    stage.body = SIMULATE.replace('write_bytes(b"film")', "missing()")
    result = stage.run()
    assert (result.state, result.passed, result.film) == ("finished", True, None)
    assert "AttributeError" in result.film_message
    stage.body = SIMULATE.replace('(OUT / "video.mp4").write_bytes(b"film")', "print('no film: cannot draw')")
    again = stage.run()
    assert (again.work, again.film_message) == (Work.FILM, "cannot draw")


def test_force_simulates_again_and_keeps_what_was_there(silent: Stage):
    first = silent.run(film=False)
    chunk = Path("states/chunk_00000.npz")
    (first.folder / chunk).write_text("much work")
    for _ in range(2):  # what replaced it recorded nothing, and does not push it out
        assert silent.run(film=False, force=True).work is Work.SIMULATE
        assert not (first.folder / chunk).exists()
        assert (silent.runs / f"{first.folder.name}.previous" / chunk).read_text() == "much work"


def test_a_damaged_run_is_simulated_again_and_that_is_said(stage: Stage):
    first = stage.run()
    chunk = first.folder / "states" / "chunk_00001.npz"
    whole = chunk.read_bytes()
    for damage in (lambda: chunk.unlink(), lambda: chunk.write_bytes(whole[:-9])):
        damage()
        again = stage.run()
        assert (again.work, again.passed, chunk.read_bytes() == whole) == (Work.SIMULATE, True, True)
        assert again.damage.startswith("states/chunk_00001.npz is ")
        assert not first.folder.with_name(f"{first.folder.name}.previous").exists()
    chunk.write_bytes(whole[:-300] + bytes(300))
    assert stage.run().work is Work.NOTHING, "its length is right, and nothing is made of it"
    stage.edit("below: 1.0", "below: 2.0")
    assert stage.run().work is Work.SIMULATE


def test_a_run_that_was_killed_while_it_was_filmed_is_only_filmed(stage: Stage):
    first = stage.run()
    (first.folder / "run.json").write_text(
        json.dumps(record(first) | {"state": "running", "render_digest": "", "judge_digest": "", "recorded": {}})
    )
    (first.folder / "video.mp4").unlink()
    again = stage.run()
    assert (again.work, again.state, again.time, again.passed) == (Work.FILM, "finished", 1.0, True)
    assert stage.programs == [".", "--film-only."]


def test_folders_of_dead_processes_are_swept_away(silent: Stage):
    silent.runs.mkdir()
    dead = subprocess.Popen(["true"])
    dead.wait()
    stale, alive = (silent.runs / f".staging-{pid}-x" for pid in (dead.pid, os.getpid()))
    young = silent.runs / f".staging-{dead.pid}-y"
    for folder in (stale, young, alive):
        (folder / "run").mkdir(parents=True)
    for folder in (stale, alive):
        os.utime(folder, (1e9, 1e9))
    silent.run(film=False)
    assert [folder.exists() for folder in (stale, young, alive)] == [False, True, True]


@pytest.mark.parametrize("contents", ['{"state": "fini', '{"case": "fall", "state": "finished", "key": 3}'])
def test_a_run_folder_that_cannot_be_trusted_is_set_aside(silent: Stage, contents: str):
    first = silent.run(film=False)
    (first.folder / "run.json").write_text(contents)
    assert silent.run(film=False).work is Work.SIMULATE


def test_a_run_whose_parent_died_starts_afresh(silent: Stage):
    first = silent.run(film=False)
    (first.folder / "run.json").write_text(json.dumps(record(first) | {"state": "running"}))
    (first.folder / "states" / "chunk_00099.npz").touch()
    assert silent.run(film=False).work is Work.SIMULATE
    assert not (first.folder / "states" / "chunk_00099.npz").exists()


def test_nothing_is_written_through_links(silent: Stage, tmp_path: Path):
    first = silent.run(film=False)
    precious = tmp_path / "precious"
    precious.write_text("mine")
    (first.folder / "log.txt").unlink()
    (first.folder / "log.txt").symlink_to(precious)
    assert silent.run(film=False).work is Work.SIMULATE
    assert precious.read_text() == "mine"
    assert not (first.folder / "log.txt").is_symlink()


def test_a_linked_run_folder_is_refused(silent: Stage, tmp_path: Path):
    first = silent.run(film=False)
    elsewhere = tmp_path / "elsewhere"
    first.folder.rename(elsewhere)
    first.folder.symlink_to(elsewhere)
    with pytest.raises(RunError, match="symbolic link"):
        silent.run(film=False)


def test_two_runs_of_one_case_do_not_meet(silent: Stage):
    first = silent.run(film=False)
    with RunLock(silent.runs, first.folder.name), pytest.raises(MachineError, match="by another text2sim"):
        silent.run(film=False)
    with RunLock(silent.runs, first.folder.name) as lock:
        os.pwrite(lock.fileno, b"9" * 40, 0)  # the number of no process
        with pytest.raises(MachineError, match="by another text2sim;"):
            silent.run(film=False)
    assert silent.run(film=False).work is not Work.SIMULATE


def test_a_lock_lasts_as_long_as_a_program_that_inherited_it(tmp_path: Path):
    with RunLock(tmp_path, "case") as lock:
        command = [sys.executable, "-c", "input()"]
        child = subprocess.Popen(command, stdin=subprocess.PIPE, pass_fds=(lock.fileno,))
    with pytest.raises(MachineError), RunLock(tmp_path, "case"):
        pass
    child.communicate(b"\n")
    with RunLock(tmp_path, "case"):
        pass


def test_an_engine_error_is_told_at_its_line(stage: Stage):
    stage.body = """
sys.path.insert(0, str(Path(__file__).parent))
Path(__file__).with_name("bodies.py").write_text("# case.yaml:5\\nraise ValueError('radius is negative')\\n")
import bodies
"""
    result = stage.run()
    assert (result.state, result.passed, result.evidence) == ("failed", False, None)
    assert result.problem is not None
    assert (result.problem.file, result.problem.line) == (str(stage.file), 5)
    assert result.problem.message == "engine: ValueError: radius is negative"
    assert record(result)["where"]["line"] == 5
    assert "Traceback" in (result.folder / "log.txt").read_text()


def test_a_stopped_run_is_judged_by_what_was_recorded(stage: Stage):
    stage.body = SIMULATE + "\n(OUT / 'status.json').unlink(); sys.exit(130)\n"
    result = stage.run()
    assert (result.state, result.passed) == ("interrupted", False)
    assert result.evidence is not None
    assert result.evidence["verdict"] == "incomplete"
    assert result.report is not None
    assert stage.run().work is Work.SIMULATE


def test_ctrl_c_stops_the_program_gently_and_a_case_is_judged_by_what_it_recorded(stage: Stage, tmp_path: Path):
    ready = tmp_path / "ready"
    stage.body = f"""
import signal
def end(number, frame):
    (OUT / "status.json").write_text('{{"state": "interrupted"}}')
    sys.exit(130)
signal.signal(signal.SIGINT, end)
shutil.copytree(RECORDING, OUT, dirs_exist_ok=True)
(OUT / "progress.jsonl").write_text('{{"phase": "simulate", "t": 0.5}}\\n')
Path({str(ready)!r}).touch()
time.sleep(60)
"""

    def press() -> None:
        while not ready.exists():
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    # A background job of a shell inherits an ignored SIGINT, which Python then leaves ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    before, notes = signal.getsignal(signal.SIGINT), []
    threading.Thread(target=press, daemon=True).start()
    result = stage.run(film=False, on_progress=lambda progress: notes.append(progress.note))
    assert (result.state, result.stopped, result.time) == ("interrupted", True, 0.5)
    assert result.evidence is not None
    assert any("once more to kill" in note for note in notes)
    assert signal.getsignal(signal.SIGINT) is before


def test_a_diverged_run_is_not_simulated_again(stage: Stage):
    said = "{'state': 'diverged', 'message': 'speed of ball is 1e9', 'where': {'body': 'ball'}}"
    stage.body = SIMULATE + f"\n(OUT / 'status.json').write_text(json.dumps({said})); sys.exit(3)\n"
    result = stage.run()
    assert (result.state, result.message, result.passed) == ("diverged", "speed of ball is 1e9", False)
    assert result.problem is not None
    assert (result.problem.path, result.problem.rule) == ("/bodies/ball", "diverged")
    assert stage.run().work is Work.NOTHING


def test_a_rope_that_flew_apart_is_advised_to_take_shorter_steps(stage: Stage):
    stage.edit("bodies:\n", "bodies:\n  line: {kind: rope, length: 1, radius: 0.01, pose: {pos: [3, 0, 3]}}\n")
    said = "{'state': 'diverged', 'message': 'diverged: speed of line is 1e9', 'where': {'body': 'line'}}"
    stage.body = SIMULATE + f"\n(OUT / 'status.json').write_text(json.dumps({said})); sys.exit(3)\n"
    problem = stage.run().problem
    assert problem is not None
    assert problem.path == "/bodies/line"
    assert "scene.substeps of 36" in problem.message
