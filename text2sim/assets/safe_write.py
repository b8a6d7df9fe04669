"""Safe access to files of a case's folder: inside it, never through a link, written atomically."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path, PurePosixPath

from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.whole_files import naming

FOLDER = "assets"
"""Folder of the assets in a case's folder."""
LOCK = ".lock"
NAME = r"[A-Za-z][A-Za-z0-9_]{0,47}"
"""Pattern for names of assets, which become names of files."""
MAX_FILE = 64 * 1024 * 1024
"""Size [bytes] of a file that is read or written."""


def case_folder(case: Path) -> Path:
    """Return the folder of a case, given the folder or the file in it.

    Raises:
        AssetError: if there is no such folder.
    """
    folder = case.parent if case.is_file() else case
    if not folder.is_dir():
        raise AssetError(f"{case}: there is no such folder")
    return folder


def place_in(folder: Path, file: str) -> Path:
    """Return the path of a file of a case, which must be below its folder and not behind a link.

    Args:
        folder: The case's folder.
        file: Path inside it, with forward slashes.

    Raises:
        AssetError: if it is not.
    """
    path = folder
    for part in parts_of(file):
        path = path / part
        if path.is_symlink():
            raise AssetError(f"`{file}` leads through a symbolic link (`{path.name}`); put the file itself there")
    return path


def parts_of(file: str) -> tuple[str, ...]:
    """Return the parts of a path inside a case's folder.

    Raises:
        AssetError: if it is not such a path.
    """
    pure = PurePosixPath(file)
    odd = "\\" in file or not file.isprintable() or ":" in file or file.startswith("~")
    if not file or odd or pure.is_absolute() or ".." in pure.parts or not pure.name:
        raise AssetError(f"`{file[:80]}` must be a path inside the case's folder, with forward slashes")
    return pure.parts


def read_kept(folder: Path, file: str) -> bytes:
    """Return the content of a file of a case.

    Raises:
        AssetError: if it is missing, too large, or not a plain file of this folder.
    """
    path = place_in(folder, file)
    if not path.is_file():
        raise AssetError(f"`{file}` does not exist in the case's folder")
    return read_file(path)


def read_file(path: Path) -> bytes:
    """Return the content of a file that the user named.

    Raises:
        AssetError: if it is missing, a link, not a plain file, or too large.
    """
    if path.is_symlink():
        raise AssetError(f"`{path}` is a symbolic link; name the file itself")
    if not path.is_file():
        raise AssetError(f"`{path}` {'is not a plain file' if path.exists() else 'does not exist'}")
    with path.open("rb") as stream:
        content = stream.read(MAX_FILE + 1)
    if len(content) > MAX_FILE:
        raise AssetError(f"`{path.name}` is too large (at most {MAX_FILE // 2**20} MiB)")
    return content


def write_asset(folder: Path, file: str, content: bytes) -> Path:
    """Write a file in a case's folder atomically, and return its path.

    Args:
        folder: Folder of the case.
        file: Path in that folder.
        content: Content of the file.

    Raises:
        AssetError: if its path is outside of the folder, or behind a link.
    """
    path = place_in(folder, file)
    path.parent.mkdir(parents=True, exist_ok=True)
    place_in(folder, file)  # again, because another process may have made a link in the meantime
    handle, partial = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
    try:
        with naming(path), os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(partial, 0o644)
        os.replace(partial, path)
    except BaseException:
        Path(partial).unlink(missing_ok=True)
        raise
    return path


def digest(content: bytes) -> str:
    """Return the SHA-256 of a file's content in hexadecimal."""
    return sha256(content).hexdigest()


@contextmanager
def only_me(folder: Path) -> Iterator[None]:
    """Keep other threads and processes from changing the records of a case's assets."""
    path = place_in(folder, f"{FOLDER}/{LOCK}")
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o644)
    try:
        if os.name == "posix":
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
