"""Text of a request: from the command line, a file, or standard input."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.output import say
from text2sim.spec_schema.errors import RunError

STDIN = "-"
MAX_REQUEST_SIZE = 1_000_000
"""Largest size of a request [bytes]."""

File = Annotated[Path | None, typer.Option("--file", metavar="FILE", help="Read the text from this file (UTF-8).")]


def words_of(words: str, file: Path | None) -> str:
    """Return the text of a request. The argument is never a file name: only `--file` and `-` read.

    Args:
        words: The argument; `-` for standard input.
        file: A text file instead.

    Raises:
        RunError: if both are given, or the input is not text or too long.
    """
    if file is not None and words:
        raise RunError(f"give either words or --file {file}, not both")
    if words == STDIN:
        return _text(sys.stdin.buffer.read(MAX_REQUEST_SIZE + 1), "standard input")
    if file is None:
        if _is_file(words):
            say(f"taken as words: {words} (--file {words} reads the file)", to=sys.stderr)
        return words
    if not file.is_file():
        raise RunError(f"{file}: there is no such file")
    with file.open("rb") as stream:
        return _text(stream.read(MAX_REQUEST_SIZE + 1), str(file))


def _is_file(words: str) -> bool:
    try:
        return Path(words).is_file()
    except (OSError, ValueError):  # not a valid path, or too long for one
        return False


def _text(content: bytes, name: str) -> str:
    if len(content) > MAX_REQUEST_SIZE:
        raise RunError(f"{name}: a request has at most {MAX_REQUEST_SIZE / 1e6:g} MB")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RunError(f"{name}: byte {error.start} is not UTF-8; save it as UTF-8 text") from None
