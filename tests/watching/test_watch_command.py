"""`text2sim watch` as a user runs it, with the real engine, and a real browser if there is one."""

import http.client
import json
import re
import signal
import subprocess
import sys
import threading
import time

import chromium
import numpy as np
import psutil
import pytest

from text2sim.recording.states import CONTACT_FIELDS, FRAME_FIELDS, RunStates

CASE = """\
text2sim: 2
name: knock
params: {height: 0.5}
scene: {duration: 1.0, dt: 0.01, max_speed: 150.0, statics: {floor: {shape: {kind: plane}}}}
bodies:
  block:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    repeat: {kind: line, count: 3, step: [0.3, 0, 0], start: [0, 0, "${height}"]}
    look: {color: red}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {restitution: 0.5}, pose: {pos: [0.02, 0, 1]}}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  expect: {falls: {measure: height, at: end, below: 0.6}}
"""
PATIENCE = 500.0
"""Time [s] for the first take: a bare machine compiles the engine's kernels on the way."""
SAVES = 15
GROWTH = 5e6
"""Memory [bytes] that a take of this case may leave behind."""


class Command:
    """A command that runs, and the lines that it printed."""

    def __init__(self, folder, *options):
        self.case = folder / "knock" / "case.yaml"
        self.case.parent.mkdir()
        self.case.write_text(CASE)
        self.runs = folder / "runs"
        self.lines = []
        self._more = threading.Condition()
        command = [sys.executable, "-m", "text2sim", "watch", str(self.case.parent), "--runs", str(self.runs)]
        self.process = subprocess.Popen(
            [*command, "--no-browser", *options],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            # Whoever runs the tests may have told them to ignore Ctrl-C.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler) and None,
        )  # fmt: skip
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.process.stdout:
            with self._more:
                self.lines.append(line.rstrip())
                self._more.notify_all()

    def wait(self, pattern, after=0, timeout=30.0):
        """Wait for a line after the first `after`; return its match."""
        until = time.monotonic() + timeout
        with self._more:
            while True:
                for line in self.lines[after:]:
                    if match := re.search(pattern, line):
                        return match
                assert self.process.poll() is None, self.lines
                assert time.monotonic() < until, self.lines[after:]
                self._more.wait(0.1)

    def save(self, **values):
        """Save the case with other values of keys; return the match of the line that says that all is done."""
        text, said = self.case.read_text(), len(self.lines)
        for key, value in values.items():
            text, count = re.subn(rf"\b{key}: (?!{{)[^,}}\n]+", f"{key}: {value}", text, count=1)
            assert count == 1, key
        self.case.write_text(text)
        return self.wait(r"^take (\d+): (.*)", said)

    @property
    def url(self):
        return self.wait(r"page: (\S+)")[1]

    def get(self, path):
        host, _, token = self.url.removeprefix("http://").partition("/")
        connection = http.client.HTTPConnection(host, timeout=10)
        connection.request("GET", f"/{token}{path}")
        return connection.getresponse().read()

    @property
    def state(self):
        return json.loads(self.get("state"))

    @property
    def children(self):
        return psutil.Process(self.process.pid).children(recursive=True)

    @property
    def take(self):
        (folder,) = (self.runs / "watch-knock").glob("take-*")
        return folder

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(30)


@pytest.fixture(scope="module")
def command(engine, tmp_path_factory):
    command = Command(tmp_path_factory.mktemp("watch"))
    yield command
    if command.process.poll() is None:
        command.stop()


@pytest.fixture(scope="module")
def warm(command):
    """The command with a warm engine."""
    command.wait(r"^take 1: ", timeout=PATIENCE)
    return command


def content(folder):
    """Every recorded array, joined: a watched take is written in more chunks."""
    chunks = [np.load(path) for path in RunStates.load(folder).chunks.paths]
    arrays = {
        name: np.concatenate([chunk[name] for chunk in chunks if name in chunk]).tobytes()
        for name in (*FRAME_FIELDS, *CONTACT_FIELDS)
    }
    return arrays | {"layout": (folder / "states/layout.json").read_bytes()}


@pytest.mark.usefixtures("engine")
def test_a_save_gives_new_states_judgement_and_scene(warm):
    done = warm.save(height=0.6)
    assert "simulated in" in done[2]
    assert "shown" in done[2]
    assert done[2].endswith("finished, 1 of 1 expectations came true")
    state = warm.state
    assert state["tone"] == "good"
    scene = json.loads(warm.get("scene/" + state["scene"]["name"]))["contents"]
    assert (scene["expect"][0]["ok"], scene["measures"][0]["name"]) == (True, "height")
    assert {piece["body"] for piece in scene["pieces"]} == {"floor", "ball", *(f"block[{k}]" for k in range(3))}


@pytest.mark.usefixtures("engine")
def test_the_states_are_those_of_a_fresh_process(warm, tmp_path):
    """Bit for bit: what a warm engine says can be relied on."""
    warm.save(height=0.7)
    done = subprocess.run(
        [sys.executable, warm.take / "program/main.py", "--out", tmp_path, "--no-film"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert len(RunStates.load(warm.take).contact("step")) > 50
    assert content(warm.take) == content(tmp_path)
    assert (warm.take / "status.json").read_text() == (tmp_path / "status.json").read_text()
    for path in (tmp_path / "geometry").iterdir():
        assert path.read_bytes() == (warm.take / "geometry" / path.name).read_bytes()


@pytest.mark.usefixtures("engine")
def test_problems_are_reported_at_once(warm):
    said = len(warm.lines)
    text = warm.case.read_text()
    begun = time.monotonic()
    warm.case.write_text(text.replace("radius: 0.1", "raduis: 0.1"))
    warm.wait("error: unknown key `raduis`", said)
    assert time.monotonic() - begun < 30.0, "0.1 s on a quiet machine"
    assert warm.state["scene"], "the scene stays"
    said = len(warm.lines)
    warm.case.write_text(text)
    warm.wait("nothing to do", said)


@pytest.mark.usefixtures("engine")
def test_a_divergence_is_reported_and_survived(warm):
    done = warm.save(max_speed=1.0)
    assert "diverged" in done[2]
    assert "speed of " in warm.state["words"]
    assert "finished" in warm.save(max_speed=150.0)[2]


@pytest.mark.usefixtures("engine")
def test_another_look_is_drawn_without_another_simulation(warm):
    before = warm.state["scene"]["name"]
    take = warm.take
    done = warm.save(color="blue")
    assert "simulated" not in done[2]
    assert warm.take == take
    assert warm.state["scene"]["name"] != before


@pytest.mark.usefixtures("engine")
def test_a_model_file_is_built_in_the_warm_engine_too(warm):
    """Bodies that go into the engine as a tree, with kernels that were not loaded yet."""
    text, said = warm.case.read_text(), len(warm.lines)
    doll = "  doll: {kind: ragdoll, height: 1.0, pose: {pos: [3, 0, 1]}}\n"
    warm.case.write_text(text.replace("actions:\n", f"{doll}actions:\n"))
    assert "finished" in warm.wait(r"^take \d+: (.*)", said, timeout=PATIENCE)[1]
    warm.save(height=0.65)
    said = len(warm.lines)
    warm.case.write_text(text)
    warm.wait(r"^take \d+: ", said)


@pytest.mark.usefixtures("engine")
def test_memory_does_not_grow_without_bound(warm):
    engine = max(warm.children, key=lambda child: child.memory_info().rss)
    for i in range(3):
        warm.save(duration=0.4 + 0.02 * i)
    before = engine.memory_info().rss
    for i in range(SAVES):
        warm.save(duration=0.5 + 0.02 * i)
    assert engine.is_running(), "it was not replaced meanwhile"
    assert engine.memory_info().rss - before < SAVES * GROWTH


@pytest.mark.usefixtures("engine", "browser")
@pytest.mark.skipif(chromium.find() is None, reason="no Chromium here")
def test_the_page_in_a_real_browser(warm, tmp_path):
    warm.save(height=0.45, duration=1.0)
    page = chromium.Chromium(tmp_path / "profile", "--use-angle=swiftshader --enable-unsafe-swiftshader")
    try:
        page.go(warm.url)
        page.wait("window.replay.drawn > 0", timeout=60)
        assert page.ask("document.getElementById('trouble').textContent") == ""
        assert page.ask("document.querySelectorAll('#expect li.good').length") == 1
        assert page.ask("document.querySelector('#plots .name').textContent") == "height"
        assert page.ask("document.getElementById('status').className") == "verdict good"
        page.ask("replay.pause(), replay.seek(0.3)")
        before = page.ask("document.documentElement.dataset.scene")
        warm.save(height=0.4, below=-1)
        page.wait(f"document.documentElement.dataset.scene != '{before}'")
        page.wait("document.querySelectorAll('#expect li.bad').length == 1")
        assert page.ask("replay.time") == pytest.approx(0.3), "the same moment"
        assert page.ask("replay.playing") is not True
        text = warm.case.read_text()
        warm.case.write_text(text.replace("kind: sphere", "kind: shpere"))
        page.wait("document.querySelectorAll('#problems li.error').length == 1")
        assert "did you mean `sphere`?" in page.ask("document.getElementById('problems').textContent")
        assert "11:" in page.ask("document.querySelector('#problems b').textContent")
        page.shoot(tmp_path / "page.png")
        warm.case.write_text(text)
        page.wait("document.querySelectorAll('#problems li').length == 0")
    finally:
        page.close()


@pytest.mark.usefixtures("engine")
def test_nothing_but_a_preview_lies_in_its_folder(warm):
    assert not list(warm.runs.rglob("run.json"))
    assert {path.name for path in warm.runs.iterdir()} == {"watch-knock", ".locks"}
    done = subprocess.run(
        [sys.executable, "-m", "text2sim", "watch", str(warm.case.parent), "--runs", str(warm.runs), "--no-browser"],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 3
    assert "watch-knock is being run by another text2sim" in done.stderr


@pytest.mark.usefixtures("engine")
def test_ctrl_c_ends_everything(warm):
    """The last test of the warm one."""
    children = warm.children
    assert len(children) == 1
    assert warm.stop() == 130
    _, alive = psutil.wait_procs(children, timeout=5)
    assert not alive


@pytest.mark.usefixtures("engine")
def test_ctrl_c_while_the_engine_starts(tmp_path):
    command = Command(tmp_path)
    command.wait("knock: ok", timeout=60)
    children = command.children
    assert command.stop() == 130
    _, alive = psutil.wait_procs(children, timeout=5)
    assert not alive
    assert not any("Traceback" in line for line in command.lines)


@pytest.mark.usefixtures("engine")
def test_processes_do_not_outlive_a_session_that_is_killed(tmp_path):
    command = Command(tmp_path)
    command.wait("knock: ok", timeout=60)
    children = command.children
    assert len(children) == 1
    command.process.kill()
    command.process.wait()
    _, alive = psutil.wait_procs(children, timeout=30)
    assert not alive


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["no/such/case"], "no/such/case"),
        (["CASE", "--port", "99999"], "65535"),
    ],
)
def test_cases_that_cannot_be_watched(tmp_path, options, words):
    case = tmp_path / "case.yaml"
    case.write_text(CASE)
    options = [str(case) if word == "CASE" else word for word in options]
    done = subprocess.run(
        [sys.executable, "-m", "text2sim", "watch", *options, "--no-browser", "--runs", str(tmp_path / "runs")],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "runs").exists()
