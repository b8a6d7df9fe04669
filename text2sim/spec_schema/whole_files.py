"""Atomic writes of files, with errors that name the file, and the user's cache folder."""

import errno
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any


def user_cache() -> Path:
    """Return the folder for caches of this user's programs.

    Raises:
        RuntimeError: if the user has no home.
    """
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """Add the path to a system error in this context; some, such as a full disk, name no file.

    Raises:
        OSError: with the path, in place of the original one.
    """
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path that replaces `path` at the end.

    Raises:
        OSError: with the name of `path`, if it cannot be written; then the temporary file is removed.
    """
    if not path.name:  # such as `.`
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    # The suffix hides the file from programs that watch the folder.
    partial = path.with_name(f".{os.getpid()}-{path.name}.part")
    try:
        with naming(path):
            yield partial
            os.replace(partial, path)
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file atomically; see `replacing`."""
    with replacing(path) as partial:
        partial.write_bytes(content.encode() if isinstance(content, str) else content)


def write_json(path: Path, data: Any) -> None:
    """Write data as JSON atomically; its folder is created when needed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
