"""Workspace of the tools: names become paths below its folder, and links are refused."""

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
MAX_PATH_LENGTH = 300
"""Largest length of a path [characters]."""
_PART = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+=,@ -]{0,119}\Z")
"""A step of a path: not hidden, without characters that are special to a shell or a file system."""


class Workspace:
    """Paths below the working directory of the server.

    All paths are relative, so that messages name files as the agent does, and do not reveal where the root is.

    Args:
        root: The folder, which becomes the working directory of the process.
    """

    def __init__(self, root: Path) -> None:
        os.chdir(root)
        self._editing = Lock()

    @contextmanager
    def editing(self) -> Iterator[None]:
        """Keep other tools from writing, so that a text does not change between reading and replacing it."""
        with self._editing:
            yield

    def case_file(self, name: str) -> Path:
        """Return the `case.yaml` of a case, by its folder or the name of a folder in `cases`.

        Raises:
            RunError: if it does not exist, or is not below the root.
        """
        file = self.case_folder(name) / CASE_FILE
        _refuse_links(file)
        if not file.is_file():
            raise RunError(f"there is no case `{name}`: no file {file}")
        return file

    def case_folder(self, name: str) -> Path:
        """Return the folder of an existing or new case: the given one, or one in `cases` if the name is one word.

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
        """Refuse to write to folders of runs, whose records must not be changed.

        Raises:
            RunError: if the path is in a run folder, or in the folder of all runs.
        """
        inside = next((step for step in (path, *path.parents) if step == RUNS or (step / "run.json").exists()), None)
        if inside is not None:
            raise RunError(f"{path} is in {inside}, where runs are kept: tools only read there; write to {CASES}")

    def runs(self) -> Path:
        """Return the folder of run folders.

        Raises:
            RunError: if it is a link.
        """
        _refuse_links(RUNS)
        return RUNS

    def run_folder(self, name: str) -> Path:
        """Return a run folder by its name, or the newest run folder of a case, which is named as in `case_file`.

        Raises:
            RunError: if there is none.
        """
        parts = _parts(name)
        if len(parts) == 2 and parts[0] == RUNS.name:
            parts = parts[1:]
        elif len(parts) > 1 and (case := self.case_folder(name) / CASE_FILE).is_file():
            parts = [case.parent.name]
        if len(parts) != 1:
            raise RunError(f"`{name}` is neither a run, such as bounce-1a2b3c4d5e, a folder in {RUNS}, nor a case")
        folder = self.runs() / parts[0]
        if not folder.is_dir():
            folder = self._newest(parts[0])
        _refuse_links(folder)
        return folder

    def _newest(self, case: str) -> Path:
        """The newest run folder of a case."""
        found = [
            path
            for path in self.runs().glob(f"{case}-*")
            if (path / "run.json").is_file() and not path.is_symlink() and not path.name.endswith(".previous")
        ]
        if not found:
            raise RunError(f"there is no run `{case}` in {RUNS}, nor one of a case of that name")
        return max(found, key=lambda path: (path / "run.json").stat().st_mtime)


def read_file(path: Path, limit: int) -> bytes | None:
    """Return the content of a file of a run; None if there is none.

    Raises:
        RunError: if it is a link, not an ordinary file, or larger than `limit` [bytes].
    """
    _refuse_links(path)
    try:
        with path.open("rb") as stream:
            if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                raise RunError(f"{path} is not an ordinary file")
            data = stream.read(limit + 1)
    except OSError:
        return None
    if len(data) > limit:
        raise RunError(f"{path} is larger than {limit // 1_000_000} MB, the limit for reading")
    return data


def is_file(path: Path, limit: int) -> bool:
    """Whether there is an ordinary file that may be opened.

    Raises:
        RunError: if it is a link, or larger than `limit` [bytes].
    """
    _refuse_links(path)
    if not path.is_file():
        return False
    if path.stat().st_size > limit:
        raise RunError(f"{path} is larger than {limit // 1_000_000} MB, the limit for reading")
    return True


def _parts(name: str) -> list[str]:
    text = name.strip()
    parts = text.removeprefix("./").rstrip("/").split("/")
    if len(text) > MAX_PATH_LENGTH or not all(_PART.match(part) for part in parts):
        shown = text if len(text) <= 80 else text[:80] + "…"
        raise RunError(
            f"{shown!r} is not an allowed path: name a folder below the root, such as cases/bounce, "
            "without `..`, hidden folders or a leading slash"
        )
    return parts


def _refuse_links(path: Path) -> None:
    for step in (*reversed(path.parents), path):
        if step.is_symlink():
            raise RunError(f"{step} is a symbolic link, and links are not followed here")
