"""Lookup of a command's run: a run folder, or the run of a case in `runs`."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from text2sim.spec_schema.errors import RunError

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan
    from text2sim.recording.film_record import FilmRecord
    from text2sim.spec_schema.loaded import LoadedCase


@dataclass(frozen=True)
class Chosen:
    """A recorded run."""

    recording: "FilmRecord"
    loaded: "LoadedCase | None"
    """The case that the user named, if any."""
    case: Path | None
    """Its file."""


def choose(path: Path, runs: Path) -> Chosen:
    """Return the run of a path; for a case, with its current `render` section.

    Args:
        path: A run folder, a case folder, or a case file.
        runs: Folder of the runs of cases.

    Raises:
        SpecError: if the case is invalid.
        RunError: if there is no such run.
    """
    from text2sim.recording.film_record import read_recording

    if not _is_case(path):
        return Chosen(read_recording(path), None, None)
    file, loaded, plan, folder = _current_run(path, runs)
    return Chosen(read_recording(folder, plan), loaded, file)


def run_folder(path: Path, runs: Path) -> Path:
    """Return the folder of a run; for a case, that of its current run. Arguments and errors are those of `choose`."""
    return _current_run(path, runs)[-1] if _is_case(path) else path


def _is_case(path: Path) -> bool:
    """Whether a path is that of a case; raises `RunError` if there is nothing."""
    if not path.exists():
        raise RunError(f"{path}: there is no such run or case")
    return path.is_file() or (path / "case.yaml").is_file() and not (path / "states").is_dir()


def _current_run(path: Path, runs: Path) -> "tuple[Path, LoadedCase, Plan, Path]":
    from text2sim.compiler.build import plan_case
    from text2sim.service.examined import case_file
    from text2sim.spec_schema.load import load_case

    file = case_file(path)
    loaded = load_case(file)
    plan = plan_case(loaded)
    folder = runs / f"{loaded.case.name}-{plan.sim_digest[:10]}"
    if not folder.is_dir():
        raise RunError(f"{path} has no current run in {runs}: text2sim run {path}")
    return file, loaded, plan, folder
