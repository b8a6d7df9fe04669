"""Disks that are full or read-only, and standard output that is: a line that names them, one exit code, no traceback."""

import errno
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from text2sim.cli import failure
from text2sim.recording.record import write_atomically
from text2sim.service import exits
from text2sim.service.examined import Examined
from text2sim.spec_schema.errors import MachineError, RunError, naming

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

    monkeypatch.setattr(Path, "write_text", full)
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


def test_a_reader_that_has_enough_stays_one() -> None:
    with pytest.raises(BrokenPipeError), naming("standard output"):
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")
