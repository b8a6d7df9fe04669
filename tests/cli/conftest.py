"""The command line called in this process."""

import os
import shutil
from pathlib import Path

import pytest
from handmade import CASE, Answer, Cli, prepare_run, write_case

from text2sim.cli.main import run


@pytest.fixture
def cli(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Cli:
    """Return a function that calls `text2sim` with arguments, in a folder of its own."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str | os.PathLike[str]) -> Answer:
        monkeypatch.setattr("sys.argv", ["text2sim", *map(str, arguments)])
        with pytest.raises(SystemExit) as stopped:
            run()
        said = capsys.readouterr()
        code = stopped.value.code
        return Answer(0 if code is None else int(code), said.out, said.err)

    return call


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """A case that is fine: its folder."""
    return write_case(tmp_path / "cases" / "fall", CASE)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run folder of the case `fall`, made once: to judge and to draw takes a second."""
    folder = tmp_path_factory.mktemp("recorded")
    return prepare_run(write_case(folder / "fall", CASE), folder / "runs")


@pytest.fixture
def folder(case: Path, recorded: Path, tmp_path: Path) -> Path:
    """The run folder of `case`, from the working directory."""
    shutil.copytree(recorded, tmp_path / "runs" / recorded.name)
    return Path("runs") / recorded.name
