"""The folder of a run: put in place in one step, reused where its contents are still valid, never half replaced."""

import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import psutil

from text2sim.recording.inventory import first_fault
from text2sim.recording.record import COMPLETE, RunRecord
from text2sim.recording.run_files import read_evidence
from text2sim.spec_schema.errors import RunError

_STAGING = ".staging-"
_STALE = 86_400.0
"""Age [s] above which a folder of a process that is gone is deleted."""


class Work(Enum):
    """The work that a run takes, from all to none."""

    SIMULATE = "simulated"
    FILM = "filmed again"
    JUDGE = "judged again"
    NOTHING = "unchanged"


@dataclass(frozen=True)
class Wanted:
    """What a run folder should contain."""

    key: dict[str, str]
    """As in `RunRecord`."""
    render_digest: str
    judge_digest: str
    film: bool


def remaining_work(folder: Path, wanted: Wanted) -> tuple[Work, str]:
    """Compare what lies in a run folder with what is wanted.

    Returns:
        The work to do; and a message about damage, if that is why.
    """
    record = RunRecord.read(folder)
    if record is None or record.state not in COMPLETE or record.key != wanted.key or _has_links(folder):
        return Work.SIMULATE, ""
    if not (folder / "states" / "layout.json").is_file():
        return Work.SIMULATE, "states/layout.json is missing"
    if damage := first_fault(folder, record.recorded, content=False):
        return Work.SIMULATE, damage
    work, why = _beyond_states(folder, record, wanted)
    # Reading all states takes a moment, and is only needed if something new is made from them.
    if work is not Work.NOTHING and (damage := first_fault(folder, record.recorded)):
        return Work.SIMULATE, damage
    return work, why


def _beyond_states(folder: Path, record: RunRecord, wanted: Wanted) -> tuple[Work, str]:
    if wanted.film and (record.render_digest != wanted.render_digest or not (folder / "video.mp4").is_file()):
        return Work.FILM, ""
    if record.judge_digest != wanted.judge_digest or not (folder / "report.html").is_file():
        return Work.JUDGE, ""
    if not record.judged or read_evidence(folder) is None:
        return Work.JUDGE, "evidence.json is missing or damaged"
    damage = first_fault(folder, record.judged)
    return (Work.JUDGE if damage else Work.NOTHING), damage


@contextmanager
def staging(parent: Path) -> Iterator[Path]:
    """Make a folder beside the final place, from which things are moved there in one step; delete it afterwards.

    Raises:
        RunError: if the folder cannot be made.
        OSError: from the body of the `with`; a file in the folder is named as in its final place.
    """
    try:
        parent.mkdir(parents=True, exist_ok=True)
        _sweep(parent)
        folder = Path(tempfile.mkdtemp(prefix=f"{_STAGING}{os.getpid()}-", dir=parent))
    except (FileExistsError, NotADirectoryError) as error:
        raise RunError(f"{parent}: not a folder") from error
    except (FileNotFoundError, PermissionError) as error:
        raise RunError(f"{parent}: cannot write there: {error.strerror}") from error
    try:
        yield folder
    except OSError as error:
        if not str(error.filename).startswith(str(folder)):
            raise
        # The user knows a file by the name of its final place.
        name = parent / Path(error.filename).relative_to(folder)
        raise OSError(error.errno, error.strerror, str(name)) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _sweep(parent: Path) -> None:
    """Delete what killed processes left behind, after a day: processes of other machines may use the same disk."""
    for stale in parent.glob(f"{_STAGING}*"):
        with suppress(OSError, ValueError):
            holder = int(stale.name.removeprefix(_STAGING).partition("-")[0])
            if time.time() - stale.stat().st_mtime > _STALE and not psutil.pid_exists(holder):
                shutil.rmtree(stale, ignore_errors=True)


def install_run(staged: Path, folder: Path) -> None:
    """Put a fresh run folder in place; an older recording stays as `<name>.previous` until the run is complete.

    Raises:
        RunError: if there is a symbolic link in its place.
    """
    if folder.is_symlink():
        raise RunError(f"{folder} is a symbolic link; remove it, or choose another --runs")
    if any((folder / "states").glob("chunk_*.npz")):
        _discard(_previous(folder), staged.parent)
        os.rename(folder, _previous(folder))
    _discard(folder, staged.parent)
    os.rename(staged, folder)


def drop_previous(folder: Path, bin_folder: Path) -> None:
    """Delete what `install_run` set aside, once the run that replaced it is complete."""
    _discard(_previous(folder), bin_folder)


def _previous(folder: Path) -> Path:
    return folder.with_name(f"{folder.name}.previous")


def install_program(staged: Path, program: Path) -> None:
    """Put a program folder in place of an older one.

    Raises:
        RunError: if something else is there, which we must not delete.
    """
    if program.is_symlink():
        raise RunError(f"{program} is a symbolic link; remove it, or choose another folder")
    if program.exists():
        if not program.is_dir() or (any(program.iterdir()) and not _is_program(program)):
            raise RunError(f"{program} exists and is not a program of text2sim; choose another folder")
        _discard(program, staged.parent)
    os.rename(staged, program)


def _is_program(folder: Path) -> bool:
    return all((folder / name).is_file() for name in ("main.py", "scene.py", "bodies.py", "recorder.py"))


def _discard(path: Path, bin_folder: Path) -> None:
    # Renamed first, so that nobody takes a half-deleted folder for a complete one.
    if path.is_symlink() or path.exists():
        os.rename(path, Path(tempfile.mkdtemp(dir=bin_folder)) / path.name)


def _has_links(folder: Path) -> bool:
    # A run folder may come from somebody else's repository: nothing is written through links in it.
    if folder.is_symlink():
        return True
    for root, folders, files in os.walk(folder):
        if any(os.path.islink(os.path.join(root, name)) for name in (*folders, *files)):
            return True
    return False
