"""The folder of a run: made whole in one step, reused where its contents still hold, never half replaced."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from text2sim.harness.record import COMPLETE, RunRecord
from text2sim.spec_schema.errors import RunError


class Work(Enum):
    """What has to be done, from everything to nothing."""

    SIMULATE = "simulated"
    FILM = "filmed again"
    JUDGE = "judged again"
    NOTHING = "unchanged"


@dataclass(frozen=True)
class Wanted:
    """What a run shall be a run of."""

    key: dict[str, str]
    """As in `RunRecord`."""
    render_digest: str
    judge_digest: str
    film: bool


def remaining_work(folder: Path, wanted: Wanted) -> Work:
    """Compare what lies in a run folder with what is wanted."""
    record = RunRecord.read(folder)
    if record is None or record.state not in COMPLETE or record.key != wanted.key or _has_links(folder):
        return Work.SIMULATE
    if not (folder / "states" / "layout.json").is_file():
        return Work.SIMULATE
    if wanted.film and (record.render_digest != wanted.render_digest or not (folder / "video.mp4").is_file()):
        return Work.FILM
    judged = (folder / "evidence.json").is_file() and (folder / "report.html").is_file()
    if record.judge_digest != wanted.judge_digest or not judged:
        return Work.JUDGE
    return Work.NOTHING


@contextmanager
def staging(parent: Path) -> Iterator[Path]:
    """A folder beside the final place, from which things are moved there in one step; gone afterwards."""
    try:
        parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=".staging-", dir=parent))
    except (FileExistsError, NotADirectoryError) as error:
        raise RunError(f"{parent}: not a folder") from error
    except (FileNotFoundError, PermissionError) as error:
        raise RunError(f"{parent}: cannot write there: {error.strerror}") from error
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def install_run(staged: Path, folder: Path) -> None:
    """Put a fresh run folder in place; the last one that recorded something stays as `<name>.previous`."""
    if folder.is_symlink():
        raise RunError(f"{folder} is a symbolic link; remove it, or choose another --runs")
    if any((folder / "states").glob("chunk_*.npz")):
        previous = folder.with_name(f"{folder.name}.previous")
        _discard(previous, staged.parent)
        os.rename(folder, previous)
    _discard(folder, staged.parent)
    os.rename(staged, folder)


def install_program(staged: Path, program: Path) -> None:
    """Put a program folder in place of an older one.

    Raises:
        RunError: if what is there is no program of ours: it is not ours to delete.
    """
    if program.is_symlink():
        raise RunError(f"{program} is a symbolic link; remove it, or choose another folder")
    if program.exists():
        if not program.is_dir() or (any(program.iterdir()) and not _is_program(program)):
            raise RunError(f"{program} is there and is no program of text2sim; choose another folder")
        _discard(program, staged.parent)
    os.rename(staged, program)


def _is_program(folder: Path) -> bool:
    return all((folder / name).is_file() for name in ("main.py", "scene.py", "bodies.py", "recorder.py"))


def _discard(path: Path, bin_folder: Path) -> None:
    # Renamed first: a folder that is half deleted must not be taken for one that is whole.
    if path.is_symlink() or path.exists():
        os.rename(path, Path(tempfile.mkdtemp(dir=bin_folder)) / path.name)


def _has_links(folder: Path) -> bool:
    # A run folder may come from a repository of someone else: nothing is written through links in it.
    if folder.is_symlink():
        return True
    for root, folders, files in os.walk(folder):
        if any(os.path.islink(os.path.join(root, name)) for name in (*folders, *files)):
            return True
    return False
