"""The folder that the tools may touch: names become paths below it, and no link leads out of it."""

import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock

from text2sim.spec_schema.errors import RunError

CASE_FILE = "case.yaml"
RUNS = Path("runs")
CASES = Path("cases")
LONGEST = 300
"""Characters of a path."""
_PART = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+=,@ -]{0,119}\Z")
"""One step of a path: nothing hidden, nothing that a shell or a file system could take for something else."""


class Workspace:
    """Paths below the working directory of the server.

    All paths are relative, so that messages name files as the agent does, and nobody learns where they lie.

    Args:
        root: The folder; the process works in it from now on.
    """

    def __init__(self, root: Path) -> None:
        os.chdir(root)
        self._editing = Lock()

    @contextmanager
    def editing(self) -> Iterator[None]:
        """While this lasts, no other tool writes: what was read is what will be replaced."""
        with self._editing:
            yield

    def case_file(self, name: str) -> Path:
        """Return the `case.yaml` that a name means, which is there: a folder, or one in `cases`.

        Raises:
            RunError: if it is not, or not below the root.
        """
        folder = self.case_folder(name)
        file = folder / CASE_FILE
        _check_ordinary(file, f"there is no case `{name}`: no file {file}")
        return file

    def case_folder(self, name: str) -> Path:
        """Return the folder that a case has, or would have: as it was named, or in `cases` if it is one word.

        Raises:
            RunError: if it is not below the root.
        """
        parts = _parts(name)
        if len(parts) > 1 and parts[-1] == CASE_FILE:
            parts = parts[:-1]
        path = Path(*parts)
        if len(parts) == 1 and not (path / CASE_FILE).is_file():
            path = CASES / path
        _refuse_links(path)
        return path

    def refuse_runs(self, path: Path) -> None:
        """Refuse to write where runs lie: what is there says what happened, and nobody else's word for it.

        Raises:
            RunError: if the path lies in a run folder, or in the folder of all runs.
        """
        inside = next((step for step in (path, *path.parents) if step == RUNS or (step / "run.json").exists()), None)
        if inside is not None:
            raise RunError(f"{path} lies in {inside}, where runs are kept: tools only read there; write to {CASES}")

    def runs(self) -> Path:
        """Return the folder of run folders.

        Raises:
            RunError: if it is a link.
        """
        _refuse_links(RUNS)
        return RUNS

    def run_folder(self, name: str) -> Path:
        """Return a run folder by its name, or the newest one of a case by the name of the case.

        Raises:
            RunError: if there is none.
        """
        parts = _parts(name)
        if len(parts) == 2 and parts[0] == RUNS.name:
            parts = parts[1:]
        if len(parts) != 1:
            raise RunError(f"`{name}` is not the name of a run: one is like bounce-1a2b3c4d5e, a folder in {RUNS}")
        folder = self.runs() / parts[0]
        if not folder.is_dir():
            folder = self._newest(parts[0])
        _refuse_links(folder)
        return folder

    def _newest(self, case: str) -> Path:
        """The run folder of a case that was written last."""
        found = [
            path
            for path in self.runs().glob(f"{case}-*")
            if (path / "run.json").is_file() and not path.is_symlink() and not path.name.endswith(".previous")
        ]
        if not found:
            raise RunError(f"there is no run `{case}` in {RUNS}, and none of a case of that name")
        return max(found, key=lambda path: (path / "run.json").stat().st_mtime)


def read_file(path: Path, limit: int) -> bytes | None:
    """Return what a file of a run holds; None if there is none.

    Raises:
        RunError: if it is a link, no ordinary file, or larger than `limit` [bytes].
    """
    _refuse_links(path)
    try:
        with path.open("rb") as stream:
            if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                raise RunError(f"{path} is no ordinary file")
            data = stream.read(limit + 1)
    except OSError:
        return None
    if len(data) > limit:
        raise RunError(f"{path} is larger than {limit // 1_000_000} MB, more than is read here")
    return data


def is_file(path: Path, limit: int) -> bool:
    """Whether an ordinary file is there that may be opened.

    Raises:
        RunError: if it is a link, or larger than `limit` [bytes].
    """
    _refuse_links(path)
    if not path.is_file():
        return False
    if path.stat().st_size > limit:
        raise RunError(f"{path} is larger than {limit // 1_000_000} MB, more than is read here")
    return True


def _parts(name: str) -> list[str]:
    text = name.strip()
    parts = text.removeprefix("./").rstrip("/").split("/")
    if len(text) > LONGEST or not all(_PART.match(part) for part in parts):
        shown = text if len(text) <= 80 else text[:80] + "…"
        raise RunError(
            f"{shown!r} is not a path that is allowed here: name a folder below the root, such as cases/bounce, "
            "without `..`, hidden folders or a leading slash"
        )
    return parts


def _refuse_links(path: Path) -> None:
    for step in (*reversed(path.parents), path):
        if step.is_symlink():
            raise RunError(f"{step} is a symbolic link, and links are not followed here")


def _check_ordinary(file: Path, missing: str) -> None:
    if file.is_symlink():
        raise RunError(f"{file} is a symbolic link, and links are not followed here")
    if not file.is_file():
        raise RunError(missing)
