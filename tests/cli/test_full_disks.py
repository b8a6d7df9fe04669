"""Disks that are full or read-only, and standard output that is: a line that names them, one exit code, no traceback."""

import errno
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exchange.recorded import write_run
from handmade import Cli

from text2sim.agents.journal import Journal
from text2sim.agents.models.exchange import Message, ModelError, ModelRequest
from text2sim.agents.models.mailbox import Mailbox
from text2sim.assets.safe_write import write_asset
from text2sim.cli import failure
from text2sim.evidence.evidence import judge
from text2sim.evidence.plots import PlotLine, plot_series
from text2sim.rendering.frames import save
from text2sim.revision import installation
from text2sim.revision.installation import install
from text2sim.revision.repository import run_git
from text2sim.service import exits
from text2sim.service.examined import Examined
from text2sim.service.phrases import user_message
from text2sim.spec_schema.errors import MachineError, RunError
from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.whole_files import naming, write_atomically
from text2sim.templates.video import Video

CASE = (
    "text2sim: 2\nname: drop\nscene: {duration: 0.1}\nbodies:\n  b: {kind: rigid, shape: {kind: sphere, radius: 0.1}}\n"
)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
@pytest.mark.parametrize("words", [["check", "--json"], ["schema"]])
def test_standard_output_that_is_full(tmp_path: Path, words: list[str]) -> None:
    (tmp_path / "case.yaml").write_text(CASE)
    command = [sys.executable, "-m", "text2sim", *words, *([str(tmp_path)] if "check" in words else [])]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == exits.MACHINE
    assert "Traceback" not in done.stderr
    assert "No space left" in done.stderr


def test_a_full_disk_names_the_file_and_leaves_nothing_of_it(tmp_path: Path, monkeypatch: Any) -> None:
    def full(self: Path, *args: Any, **kwargs: Any) -> None:
        self.touch()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="No space left") as met:
        write_atomically(tmp_path / "case.yaml", "x")
    assert met.value.filename == str(tmp_path / "case.yaml")
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("number", [errno.EROFS, errno.ENOSPC])
def test_every_command_ends_alike_on_a_disk_that_takes_nothing(capsys: Any, number: int) -> None:
    """`fmt` and `check` take note of an error for each case; `patch` and the others end with it."""
    error = OSError(number, os.strerror(number), "case.yaml")
    row = Examined(Path("case.yaml"))
    row.blame(error)
    assert row.exit == failure.fail(error, as_json=False) == exits.MACHINE
    assert "case.yaml: " in capsys.readouterr().err


def test_what_is_whose_fault() -> None:
    assert exits.exit_of_error(MachineError("no memory")) == exits.MACHINE
    assert exits.exit_of_error(RunError("no such run")) == exits.INPUT
    assert exits.exit_of_error(FileNotFoundError(errno.ENOENT, "gone", "x")) == exits.INPUT


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
def test_a_reader_that_has_enough_is_no_failure() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "text2sim", "check", "--rules"]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (exits.OK, "")


def test_a_reader_that_has_enough_stays_one() -> None:
    with pytest.raises(BrokenPipeError), naming("standard output"):
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")


@pytest.fixture
def full_disk() -> Iterator[None]:
    """No file gets larger than 100 bytes: every writer fails in the middle, with an error that names none."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


OLD = CASE.replace("text2sim: 2", "text2sim: 1")
WRITERS = {
    "new x --cases .": "x/case.yaml",
    "schema -o s.json": "s.json",
    "fmt messy.yaml": "messy.yaml",
    "patch old.yaml patch.json": "old.yaml",
    "migrate old.yaml": "old.yaml",
    "compile CASE -o program": "scene.py",
    "show CASE --png drawn.png": "drawn.png",
    "compare RUN RUN --html page.html": "0.png",
    "export REC --gltf a.glb": "a.glb",
    "export REC --usd a.usdc": "a.usdc",
    "export REC --usd a.usdz": "a.usdz",
    "run CASE": "scene.py",
}


@pytest.mark.parametrize("words", WRITERS)
def test_every_command_names_the_file_that_a_full_disk_does_not_take(
    cli: Cli, case: Path, folder: Path, tmp_path: Path, request: pytest.FixtureRequest, words: str
) -> None:
    recorded = write_run(tmp_path / "rec")
    (tmp_path / "old.yaml").write_text(OLD)
    (tmp_path / "messy.yaml").write_text(OLD.replace("name: ", "name:   "))
    (tmp_path / "patch.json").write_text('[{"op": "replace", "path": "/scene/duration", "value": 0.2}]')
    cli("check", case)  # everything is imported
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file() and ".git" not in path.parts}
    request.getfixturevalue("full_disk")
    answer = cli(*(str({"CASE": case, "RUN": folder, "REC": recorded}.get(word, word)) for word in words.split()))
    assert answer.code == exits.MACHINE, answer.err
    assert "Traceback" not in answer.err
    assert WRITERS[words] in answer.err.splitlines()[-1]
    assert "File too large" in answer.err
    after = [path for path in tmp_path.rglob("*") if path.is_file() and ".git" not in path.parts]
    left = [path for path in after if before.get(path) != path.read_bytes() and path.name not in (".lock", folder.name)]
    assert left == []


def _judge(folder: Path, case: Path) -> None:
    judge(folder, load_case(case).case)


def _plot(folder: Path, case: Path) -> None:
    plot_series(folder / "z.png", np.arange(3.0), [PlotLine("z", np.arange(3.0))], title="z", unit="m")


def _film(folder: Path, case: Path) -> None:
    video = Video(folder / "z.mp4", (64, 64), 10)
    for _ in range(200):
        video.write(np.random.default_rng(0).integers(0, 255, (64, 64, 3)).astype(np.uint8))
    video.close()


def _letter(folder: Path, case: Path) -> None:
    Mailbox(folder / "box").complete(ModelRequest("planner", (Message("user", "x" * 200),)), lambda: True)


INSIDE = {
    "measures.csv": _judge,
    "z.png": _plot,
    "z.mp4": _film,
    "legibility.json": lambda folder, case: save(folder / "legibility.json", lambda part: part.write_text("x" * 200)),
    "journal.jsonl": lambda folder, case: Journal(folder / "journal.jsonl")("asked", text="x" * 200),
    "planner-01.request.md": _letter,
    "assets/it.obj": lambda folder, case: write_asset(folder, "assets/it.obj", b"v 0 0 0\n" * 100),
}


@pytest.mark.parametrize("name", INSIDE)
def test_every_writer_names_its_file(
    case: Path, folder: Path, cli: Cli, request: pytest.FixtureRequest, name: str
) -> None:
    request.getfixturevalue("full_disk")
    with pytest.raises((OSError, ModelError)) as met:
        INSIDE[name](folder, case)
    error = met.value
    assert name in (user_message(error) if isinstance(error, OSError) else str(error))
    assert not [path for path in folder.rglob("*") if path.name.endswith(".part")]


def test_radiance_names_its_file(tmp_path: Path, request: pytest.FixtureRequest, tracer: None) -> None:
    from text2sim.rendering.frames import write_radiance

    picture = np.random.default_rng(0).random((20, 20, 4), np.float32)
    save(tmp_path / "a.exr", lambda part: write_radiance(part, picture))
    assert (tmp_path / "a.exr").stat().st_size > 1000
    request.getfixturevalue("full_disk")
    with pytest.raises(OSError, match="File too large") as met:
        save(tmp_path / "b.exr", lambda part: write_radiance(part, picture))
    assert met.value.filename == str(tmp_path / "b.exr")
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_git_that_cannot_write_is_the_machine(tmp_path: Path) -> None:
    run_git(["init", "-q"], tmp_path)
    run_git(["-c", "user.name=a", "-c", "user.email=a@b.c", "commit", "-q", "--allow-empty", "-m", "x"], tmp_path)
    with pytest.raises(MachineError, match="No space left"):
        run_git(["log", "--output=/dev/full"], tmp_path)


def test_attributes_of_git_are_whole_or_as_they_were(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", str(tmp_path / "config"))
    install(tmp_path, everywhere=True)
    rows = "*.bin binary\n" * 20
    (tmp_path / "git/attributes").write_text(rows)
    request.getfixturevalue("full_disk")
    with pytest.raises(OSError, match="File too large") as met:
        installation._write(tmp_path / "git/attributes", ["x" * 200])
    assert met.value.filename == str(tmp_path / "git/attributes")
    assert (tmp_path / "git/attributes").read_text() == rows
