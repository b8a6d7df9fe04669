"""Files that come into being whole or not at all, and errors that say which could not be written."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """While this lasts, an error of the system names what is written: where a disk is full it names none.

    Raises:
        OSError: in place of any other.
    """
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A file to write beside `path`, which takes its place at the end: what is there is whole.

    Raises:
        OSError: with the name of `path`, if it cannot be written; then nothing is left of it.
    """
    # Whoever watches the folder for names with a certain ending must not see it before it is whole.
    partial = path.with_name(f".{os.getpid()}-{path.name}.part")
    try:
        with naming(path):
            yield partial
            os.replace(partial, path)
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file that is complete from the moment on at which it is there; see `replacing`."""
    with replacing(path) as partial:
        partial.write_bytes(content.encode() if isinstance(content, str) else content)
