"""Files that are put into a case's folder: inside it, never through a link, whole or not at all."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path, PurePosixPath

from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.whole_files import naming

FOLDER = "assets"
"""Where a case keeps what it was given or what was made for it."""
LOCK = ".lock"
NAME = r"[A-Za-z][A-Za-z0-9_]{0,47}"
"""What an asset may be called; its files are called after it."""
MAX_FILE = 64 * 1024 * 1024
"""Bytes of a file that is read or kept."""


def case_folder(case: Path) -> Path:
    """Return the folder of a case, which is named by itself or by the file in it.

    Raises:
        AssetError: if there is no such folder.
    """
    folder = case.parent if case.is_file() else case
    if not folder.is_dir():
        raise AssetError(f"{case}: there is no such folder")
    return folder


def place_in(folder: Path, file: str) -> Path:
    """Return where a file of a case lies: below its folder, with no link on the way.

    Args:
        folder: The case's folder.
        file: Path inside it, with forward slashes.

    Raises:
        AssetError: if it leads out of the folder, or through a link.
    """
    pure = PurePosixPath(file)
    odd = "\\" in file or not file.isprintable() or ":" in file or file.startswith("~")
    if not file or odd or pure.is_absolute() or ".." in pure.parts or not pure.name:
        raise AssetError(f"`{file[:80]}` must be a path inside the case's folder, with forward slashes")
    path = folder
    for part in pure.parts:
        path = path / part
        if path.is_symlink():
            raise AssetError(f"`{file}` leads through a symbolic link (`{path.name}`); put the file itself there")
    return path


def read_kept(folder: Path, file: str) -> bytes:
    """Return what lies in a file of a case.

    Raises:
        AssetError: if it is not there, too large, or not a plain file of this folder.
    """
    path = place_in(folder, file)
    if not path.is_file():
        raise AssetError(f"`{file}` does not exist in the case's folder")
    return read_file(path)


def read_file(path: Path) -> bytes:
    """Return what lies in a file that a person named.

    Raises:
        AssetError: if it is missing, a link, no plain file, or too large.
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


def keep(folder: Path, file: str, content: bytes) -> Path:
    """Put a file into a case's folder in one step, and return where it lies.

    Args:
        folder: Folder of the case.
        file: Path in that folder.
        content: What the file is to hold.

    Raises:
        AssetError: if its place is outside of the folder, or a link.
    """
    path = place_in(folder, file)
    path.parent.mkdir(parents=True, exist_ok=True)
    place_in(folder, file)  # what was made in the meantime by somebody else may be a link
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
    """Return the SHA-256 of a file's content, in hexadecimal digits."""
    return sha256(content).hexdigest()


@contextmanager
def only_me(folder: Path) -> Iterator[None]:
    """Keep other threads and processes from changing what a case's folder has on its assets."""
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
