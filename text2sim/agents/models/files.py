"""Atomic writing of files, and safe reading of files from untrusted writers."""

import os
import stat
from pathlib import Path

from text2sim.spec_schema.whole_files import replacing


class UnfitFileError(OSError):
    """Error: a file exists but is refused; the message says why."""


def write_durably(path: Path, content: str | bytes) -> None:
    """Write a file atomically and durably: it is either complete or absent, even after a loss of power."""
    data = content.encode() if isinstance(content, str) else content
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as part, part.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def read_plain(path: Path, limit: int) -> str:
    """Return the text of an ordinary file of at most `limit` bytes.

    Links are not followed, and only regular files are read: a pipe may never end.

    Raises:
        UnfitFileError: If it is a link, not a regular file, too large, or not UTF-8.
        OSError: If it cannot be read.
    """
    # O_NONBLOCK: opening a pipe without a writer would block forever.
    if path.is_symlink():
        raise UnfitFileError("it is a link, and links are not followed")
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise UnfitFileError("it is not a regular file")
    with os.fdopen(descriptor, "rb") as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise UnfitFileError(f"it has more than {limit:,} bytes")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UnfitFileError(f"it is not UTF-8 text: byte {error.start} is 0x{data[error.start]:02x}") from None
