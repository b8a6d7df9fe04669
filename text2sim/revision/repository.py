"""Contents of a git repository, read without a shell, without filters, and without changing it."""

import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from text2sim.spec_schema.errors import MachineError, RunError
from text2sim.spec_schema.whole_files import naming

TIMEOUT = 60.0
MAX_BYTES = 64_000_000
"""Largest case folder that is extracted as a whole [bytes]; of a larger one, only YAML files and the case are."""
SKIPPED = frozenset({"runs", "program"})
_REVISION = re.compile(r"[A-Za-z0-9_@][A-Za-z0-9_./@{}^~+#-]{0,199}")
_FILES = ("100644", "100755")
_FULL = ("No space left", "Read-only file system", "failed to write", "quota exceeded")
"""Git's messages when the disk is full or read-only."""


@dataclass(frozen=True)
class Repository:
    """A repository, and a commit in it."""

    root: Path
    commit: str


@dataclass(frozen=True)
class _Blob:
    path: PurePosixPath
    """Relative to the root of the repository."""
    name: str
    size: int


def run_git(arguments: list[str], folder: Path, data: bytes = b"") -> bytes:
    """Return the output of a git command.

    Args:
        arguments: Arguments of the command.
        folder: Folder in which it runs.
        data: Standard input.

    Raises:
        RunError: If it fails.
        MachineError: If git is not installed, or the disk is full or read-only.
    """
    done = _call(arguments, folder, data)
    if done.returncode:
        complaint = done.stderr.decode("utf-8", "replace").strip().splitlines() or [f"exit code {done.returncode}"]
        full = next((line for line in complaint if any(word in line for word in _FULL)), None)
        kind = RunError if full is None else MachineError
        raise kind(f"git {arguments[0]}: {full or complaint[0]}")
    return done.stdout


def run_git_status(arguments: list[str], folder: Path) -> tuple[bytes, int]:
    """Return the output of a git command, and its exit code."""
    done = _call(arguments, folder, b"")
    return done.stdout, done.returncode


def _call(arguments: list[str], folder: Path, data: bytes) -> "subprocess.CompletedProcess[bytes]":
    git = shutil.which("git")
    if git is None:
        raise MachineError("git is not installed here")
    env = os.environ | {"LC_ALL": "C", "GIT_OPTIONAL_LOCKS": "0", "GIT_TERMINAL_PROMPT": "0", "GIT_NO_LAZY_FETCH": "1"}
    command = [git, "-C", str(folder), *arguments]
    try:
        return subprocess.run(command, input=data, capture_output=True, env=env, timeout=TIMEOUT, check=False)
    except subprocess.TimeoutExpired:
        raise RunError(f"git {arguments[0]} took longer than {TIMEOUT:.0f} s") from None


def find_commit(path: Path, revision: str) -> Repository:
    """Return the repository of a path, and the commit of a revision in it.

    Raises:
        RunError: If there is no such repository or revision.
    """
    if not _REVISION.fullmatch(revision) or ".." in revision:
        raise RunError(f"`{revision[:80]}` is not the name of a revision, such as HEAD~1, a branch, or a tag")
    folder = _existing(path)
    try:
        root = run_git(["rev-parse", "--show-toplevel"], folder).decode().rstrip("\n")
    except RunError as error:
        raise RunError(f"{path} is not in a git repository ({error})") from None
    try:
        commit = run_git(["rev-parse", "--verify", "--quiet", f"{revision}^{{commit}}"], folder).decode().strip()
    except RunError:
        raise RunError(f"there is no revision `{revision}` in {root}") from None
    return Repository(Path(root), commit)


def extract(repository: Repository, path: Path, target: Path) -> Path:
    """Write a case of a commit into a folder: its file, and the files beside it.

    Args:
        repository: The repository and its commit.
        path: The case's folder or its file; it may no longer exist in the work tree.
        target: An empty folder.

    Returns:
        `target` if the path is a folder, else the file in it.

    Raises:
        RunError: If the commit has no such file or folder.
    """
    place = _inside(repository, path)
    found = _list(repository, [str(place)] if place.parts else [], deep=False)
    folder = not place.parts or any(kind == "tree" for kind, _ in found)
    if not found and place.parts:
        raise RunError(f"{path} is not in revision {repository.commit[:10]}")
    home = place if folder else place.parent
    blobs = [blob for _, blob in _list(repository, [str(home)] if home.parts else [], deep=True)]
    blobs = [blob for blob in blobs if blob.path.relative_to(home).parts[0] not in SKIPPED]
    if sum(blob.size for blob in blobs) > MAX_BYTES:
        blobs = [blob for blob in blobs if blob.path.suffix in (".yaml", ".yml") or blob.path == place]
    for blob, content in zip(blobs, _contents(repository, blobs), strict=True):
        file = target.joinpath(*blob.path.relative_to(home).parts)
        file.parent.mkdir(parents=True, exist_ok=True)
        with naming(file):
            file.write_bytes(content)
    return target if folder else target / place.name


def _existing(path: Path) -> Path:
    """A folder itself, or the nearest existing folder above a path."""
    folder = path.absolute()
    while not folder.is_dir() and folder != folder.parent:
        folder = folder.parent
    return folder


def _inside(repository: Repository, path: Path) -> PurePosixPath:
    above = _existing(path)
    real = Path(os.path.realpath(above), os.path.relpath(path.absolute(), above))
    try:
        return PurePosixPath(Path(os.path.normpath(real)).relative_to(os.path.realpath(repository.root)).as_posix())
    except ValueError:
        raise RunError(f"{path} is outside the repository {repository.root}") from None


def _list(repository: Repository, places: list[str], *, deep: bool) -> list[tuple[str, _Blob]]:
    """Regular files and folders of a commit, as (kind, entry); `deep` lists all files below the places."""
    options = ["ls-tree", "-z", "-l", *(["-r"] if deep else []), repository.commit]
    rows = run_git(["--literal-pathspecs", *options, "--", *places], repository.root).split(b"\0")
    found = []
    for row in rows:
        facts, _, name = row.partition(b"\t")
        if not name:
            continue
        mode, kind, blob, size = facts.decode().split()
        path = PurePosixPath(name.decode("utf-8", "surrogateescape"))
        # Links are skipped, since their targets are not part of the case, and names that lead out of the folder.
        if (kind == "blob" and mode in _FILES or kind == "tree") and ".." not in path.parts and not path.is_absolute():
            found.append((kind, _Blob(path, blob, 0 if size == "-" else int(size))))
    return found


def _contents(repository: Repository, blobs: list[_Blob]) -> list[bytes]:
    if not blobs:
        return []
    asked = "".join(f"{blob.name}\n" for blob in blobs).encode()
    answer = run_git(["cat-file", "--batch"], repository.root, asked)
    contents, at = [], 0
    for blob in blobs:
        end = answer.index(b"\n", at) + 1
        contents.append(answer[end : end + blob.size])
        at = end + blob.size + 1
    return contents
