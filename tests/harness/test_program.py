"""Programs in processes of their own: how they end, what they may use, and what the user is told."""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from text2sim.runtime.child import Limits
from text2sim.runtime.outcome import outcome_of
from text2sim.runtime.program import Finished, run_program
from text2sim.runtime.progress import Clock, Progress, ignore
from text2sim.runtime.stop import Stop

LIMITS = Limits(timeout=20.0, grace=5.0)

PREAMBLE = """
import json, os, signal, sys, time
from pathlib import Path

OUT = Path(sys.argv[sys.argv.index("--out") + 1])

def say(**record):
    with (OUT / "progress.jsonl").open("a") as stream:
        stream.write(json.dumps(record) + "\\n")

def status(**record):
    (OUT / "status.json").write_text(json.dumps(record))
"""

MakeRun = Callable[..., Path]


@pytest.fixture
def make_run(tmp_path: Path) -> MakeRun:
    """Return a function that makes a run folder whose program does `body`; `files` are its other modules."""

    def make(body: str, **files: str) -> Path:
        program = tmp_path / "run" / "program"
        program.mkdir(parents=True)
        (program / "main.py").write_text(PREAMBLE + body)
        for name, text in files.items():
            (program / f"{name}.py").write_text(text)
        return program.parent

    return make


def run(folder: Path, limits: Limits = LIMITS, stop: Stop | None = None, clock: Clock | None = None) -> Finished:
    return run_program(folder, flags=(), limits=limits, stop=stop or Stop(), clock=clock or Clock(ignore))


def request_when(path: Path, stop: Stop, times: int = 1) -> threading.Thread:
    """Ask to stop as soon as a file is there."""

    def wait() -> None:
        while not path.exists():
            time.sleep(0.02)
        for _ in range(times):
            stop.request()

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    return thread


def test_a_program_that_ends_well_is_finished(make_run):
    folder = make_run("print('hello'); status(state='finished', time=1.5)")
    done = run(folder)
    assert (done.outcome.state, done.outcome.time, done.outcome.message) == ("finished", 1.5, "")
    assert (folder / "log.txt").read_text() == "hello\n"


def test_a_program_that_says_nothing_about_its_end_has_failed(make_run):
    outcome = run(make_run("")).outcome
    assert outcome.state == "failed"
    assert "without a status" in outcome.message


def test_divergence_is_named(make_run):
    folder = make_run("status(state='diverged', time=0.4, message='ball is at 3e8 m'); sys.exit(3)")
    outcome = run(folder).outcome
    assert (outcome.state, outcome.time, outcome.message) == ("diverged", 0.4, "ball is at 3e8 m")


def test_an_engine_error_leads_to_the_line_of_the_case(make_run):
    bodies = "def add_ball(scene):\n    # case.yaml:23\n    return scene.add(\n        radius=-1,\n    )\n"
    body = """
import bodies
class Scene:
    def add(self, radius):
        raise ValueError("input should be greater than 0. Got -1.")
try:
    bodies.add_ball(Scene())
except ValueError:
    import traceback; traceback.print_exc(); sys.exit(4)
"""
    done = run(make_run(body, bodies=bodies))
    assert done.outcome.state == "failed"
    assert done.outcome.message == "ValueError: input should be greater than 0. Got -1."
    assert done.blame == (23, "return scene.add(")


def test_a_crash_of_native_code_is_named_and_traced(make_run):
    actions = "import ctypes\n\n\ndef act():\n    # case.yaml:31\n    ctypes.string_at(0)\n"
    done = run(make_run("import actions\nactions.act()", actions=actions))
    assert done.outcome.state == "crashed"
    assert "SIGSEGV" in done.outcome.message
    assert done.blame == (31, "ctypes.string_at(0)")


def test_a_timeout_lets_the_program_write_down_what_it_has(make_run):
    body = """
def end(number, frame):
    status(state="interrupted", time=0.7); sys.exit(130)
signal.signal(signal.SIGTERM, end)
time.sleep(60)
"""
    outcome = run(make_run(body), Limits(timeout=1.0, grace=5.0)).outcome
    assert (outcome.state, outcome.time) == ("timeout", 0.7)
    assert outcome.message == "it took longer than 1 s"


@pytest.mark.parametrize(("step", "frames", "hopeless"), [(1e-4, 600, True), (1e-1, 60, False)])
def test_a_simulation_that_cannot_end_in_time_is_not_waited_for(make_run, monkeypatch, step, frames, hopeless):
    monkeypatch.setattr("text2sim.runtime.program.SPEED_SETTLES_AFTER", 0.3)
    body = f"""
with (OUT / "progress.jsonl").open("a", buffering=1) as progress:
    for k in range({frames}):
        print(json.dumps({{"phase": "simulate", "t": {step} * k, "duration": 10.0}}), file=progress)
        time.sleep(0.02)
"""
    done = run(make_run(body), Limits(timeout=20.0, grace=2.0))
    assert (done.outcome.state == "timeout") == hopeless
    assert ("all would take" in done.outcome.message and "the limit is 20 s" in done.outcome.message) == hopeless
    assert ("s per simulated second" in done.outcome.message and "can be simulated" in done.outcome.message) == hopeless
    assert done.ended.wall < 10


def test_a_simulation_is_stopped_early_where_patience_is_shorter_than_the_timeout(make_run, monkeypatch):
    monkeypatch.setattr("text2sim.runtime.program.SPEED_SETTLES_AFTER", 0.3)
    body = """
with (OUT / "progress.jsonl").open("a", buffering=1) as progress:
    for k in range(300):  # 10 s at this pace take 20 s
        print(json.dumps({"phase": "simulate", "t": 0.01 * k, "duration": 10.0}), file=progress)
        time.sleep(0.02)
"""
    done = run(make_run(body), Limits(timeout=60.0, patience=8.0, grace=2.0))
    assert done.outcome.state == "timeout"
    assert "the limit is 8 s" in done.outcome.message
    assert done.ended.wall < 5


def test_a_program_that_ignores_the_timeout_is_killed_with_its_children(make_run):
    body = """
import subprocess
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
(OUT / "pid").write_text(str(child.pid))
signal.signal(signal.SIGTERM, signal.SIG_IGN)
time.sleep(60)
"""
    folder = make_run(body)
    done = run(folder, Limits(timeout=1.0, grace=0.3))
    assert done.outcome.state == "timeout"
    assert done.ended.wall < 10
    pid = int((folder / "pid").read_text())
    wait_until(lambda: is_gone(pid))  # killed with its group


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux ends a program with its parent")
def test_a_program_dies_with_a_parent_that_is_killed(make_run):
    folder = make_run('(OUT / "pid").write_text(str(os.getpid()))\ntime.sleep(60)')
    watch = (
        "from pathlib import Path; from text2sim.runtime.child import *; from text2sim.runtime.stop import Stop; "
        f"run_child((sys.executable, 'main.py', '--out', {str(folder)!r}), folder=Path({str(folder / 'program')!r}), "
        f"log=Path({str(folder / 'log.txt')!r}), limits=Limits(), stop=Stop(), on_poll=lambda: None)"
    )
    parent = subprocess.Popen([sys.executable, "-c", f"import sys; {watch}"])
    wait_until(lambda: (folder / "pid").is_file() and (folder / "pid").read_text() != "")
    pid = int((folder / "pid").read_text())
    assert not is_gone(pid)
    parent.kill()
    parent.wait()
    wait_until(lambda: is_gone(pid))


def wait_until(holds: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def is_gone(pid: int) -> bool:
    """Whether a process has ended; when it is gone for good is up to whoever inherits it."""
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def test_a_first_request_to_stop_is_gentle(make_run):
    body = """
def end(number, frame):
    status(state="interrupted", time=0.2); sys.exit(130)
signal.signal(signal.SIGINT, end)
(OUT / "ready").touch()
time.sleep(60)
"""
    folder, stop = make_run(body), Stop()
    request_when(folder / "ready", stop)
    outcome = run(folder, stop=stop).outcome
    assert (outcome.state, outcome.time) == ("interrupted", 0.2)


def test_a_second_request_to_stop_kills(make_run):
    body = "signal.signal(signal.SIGINT, signal.SIG_IGN)\n(OUT / 'ready').touch()\ntime.sleep(60)"
    folder, stop = make_run(body), Stop()
    request_when(folder / "ready", stop, times=2)
    done = run(folder, Limits(timeout=20.0, grace=15.0), stop)
    assert done.outcome.state == "interrupted"
    assert done.ended.wall < 10


def test_too_much_memory_is_noticed(make_run):
    body = "hoard = bytearray(300_000_000)\nfor i in range(0, len(hoard), 4096): hoard[i] = 1\ntime.sleep(60)"
    outcome = run(make_run(body), Limits(timeout=20.0, memory=200_000_000)).outcome
    assert outcome.state == "out_of_memory"
    assert "GB of memory" in outcome.message


def test_a_flood_of_output_keeps_its_beginning_and_its_end(make_run):
    body = "print('first')\nfor _ in range(400): print('x' * 10_000)\nprint('last'); status(state='finished')"
    folder = make_run(body)
    done = run(folder, Limits(timeout=20.0, log=1_000_000))
    log = (folder / "log.txt").read_text()
    assert log.startswith("first\n")
    assert log.endswith("last\n")
    assert "bytes left out" in log
    assert len(log) < 1_100_000
    assert done.ended.log_left_out > 2_900_000


def test_a_program_sees_no_keys_and_a_fixed_hash_seed(make_run, monkeypatch):
    for name in ("OPENAI_API_KEY", "XDG_SECRET", "GS_TOKEN", "EDITOR"):
        monkeypatch.setenv(name, "hidden")
    monkeypatch.setenv("QD_OFFLINE_CACHE", "1")
    folder = make_run("print(json.dumps(dict(os.environ))); print(sys.stdin.read() == '')")
    run(folder)
    log = (folder / "log.txt").read_text()
    assert "hidden" not in log
    assert '"QD_OFFLINE_CACHE": "1"' in log
    assert '"PYTHONHASHSEED": "0"' in log
    assert '"PATH"' in log
    assert log.endswith("True\n")


def test_progress_is_passed_on_with_speed_and_phases(make_run):
    body = """
for phase in ("build", "simulate"):
    say(phase=phase, t=0.0); time.sleep(0.3)
for k in range(4):
    say(phase="simulate", t=0.5 * (k + 1)); time.sleep(0.3)
(OUT / "progress.jsonl").open("a").write("half a line")
status(state="finished", time=2.0)
"""
    seen: list[Progress] = []
    clock = Clock(seen.append, 4.0)
    run(make_run(body), clock=clock)
    assert list(dict.fromkeys(p.phase for p in seen)) == ["start", "build", "simulate"]
    last = seen[-1]
    assert last.t == 2.0
    assert last.fraction == 0.5
    assert last.speed is not None
    assert 0.1 < last.speed < 3.0
    assert last.eta == pytest.approx(2.0 / last.speed)
    assert set(clock.finish()) == {"start", "build", "simulate"}


def test_a_listener_that_fails_leaves_no_process_behind(make_run):
    folder = make_run("(OUT / 'pid').write_text(str(os.getpid())); say(phase='build'); time.sleep(60)")

    def listener(progress: Progress) -> None:
        if progress.phase == "build":
            raise RuntimeError("the display broke")

    with pytest.raises(RuntimeError, match="the display broke"):
        run(folder, clock=Clock(listener))
    assert not psutil.pid_exists(int((folder / "pid").read_text()))


def test_a_failed_film_does_not_undo_the_simulation(make_run):
    folder = make_run("status(state='finished', time=2.0)\nraise OSError('no display')")
    outcome = run(folder).outcome
    assert (outcome.state, outcome.message) == ("finished", "")
    assert outcome.film_message == "OSError: no display"


def test_colours_of_a_message_do_not_reach_the_terminal(make_run):
    outcome = run(make_run("raise ValueError('\\x1b[31mred\\x1b[0m \\x07 bell')")).outcome
    assert outcome.message == "ValueError: red \ufffd bell"


def test_the_log_of_a_second_program_follows_that_of_the_first(make_run):
    folder = make_run("print(os.getpid() > 0); status(state='finished', time=1)")
    run(folder)
    run(folder)
    assert (folder / "log.txt").read_text() == "True\nTrue\n"


@pytest.mark.skipif(os.name != "posix", reason="signals of other systems")
@pytest.mark.parametrize(("used", "state"), [(0.3, "crashed"), (3.0, "out_of_memory")])
def test_a_kill_is_explained(make_run, used, state):
    ended = run(make_run("os.kill(os.getpid(), signal.SIGKILL)")).ended
    ended = replace(ended, peak_memory=round(used * 1e9), memory_limit=4 * 10**9)
    outcome = outcome_of(ended, Limits(), {}, "", 0.0)
    assert outcome.state == state
    assert "SIGKILL" in outcome.message


def test_a_program_may_use_no_more_than_is_free(make_run, monkeypatch):
    left = psutil.virtual_memory()._replace(available=2 * 10**9)
    monkeypatch.setattr("text2sim.runtime.child.psutil.virtual_memory", lambda: left)
    ended = run(make_run("status(state='finished', time=1)")).ended
    assert ended.memory_limit == int(0.85 * 2 * 10**9)
