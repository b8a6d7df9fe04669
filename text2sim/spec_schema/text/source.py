"""Text of a case: decoded, checked for forbidden characters, with lines and columns."""

import re
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from os.path import realpath, sep
from pathlib import Path

from text2sim.spec_schema.errors import Problem, SpecError

MAX_BYTES = 2_000_000

# The printable characters of YAML 1.2, except the private use area (for masks), byte order marks, and bidirectional
# marks (which hide text).
_FORBIDDEN = re.compile(
    "[^\t\n\r\x20-\x7e\x85\xa0-\u2029\u202f-\u2065\u206a-\ud7ff\uf900-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"
)
_BREAK = re.compile(r"\r\n|\r|\n")


@dataclass(frozen=True)
class Source:
    """The text of a case and the name of its file."""

    text: str
    file: str = "case.yaml"

    @cached_property
    def lines(self) -> list[str]:
        """The lines, without line breaks."""
        return _BREAK.split(self.text)

    @cached_property
    def _starts(self) -> list[int]:
        """Index of the first character of every line."""
        return [0, *(found.end() for found in _BREAK.finditer(self.text))]

    def place(self, index: int) -> tuple[int, int]:
        """Return the line and column, both from 1, of a character of the text."""
        line = bisect_right(self._starts, index)
        return line, index - self._starts[line - 1] + 1

    def error(self, index: int, message: str, rule: str) -> SpecError:
        """Return a problem of the whole document at the position of a character.

        Args:
            index: Index of the character.
            message: What is wrong.
            rule: Id of the rule.
        """
        line, column = self.place(index)
        return SpecError([Problem("", message, line, column, self.file, rule=rule)])


def plain_text(text: str) -> str:
    """Return a text with a blank for each forbidden character."""
    return _FORBIDDEN.sub(" ", text)


def read_source(path: Path, file: str | None = None) -> Source:
    """Read a file.

    Raises:
        SpecError: If it cannot be read, is too large, or is not plain UTF-8 text.
    """
    file = file if file is not None else str(path)
    try:
        # In a foreign folder, a link must not expose other files.
        if path.is_symlink() and not realpath(path).startswith(f"{realpath(path.parent)}{sep}"):
            raise OSError(0, "it is a link that leads out of the folder; name the file that it points to")
        # Reading a pipe or a device may never end.
        if path.exists() and not path.is_dir() and not path.is_file():
            raise OSError(0, "it is not a regular file")
        with path.open("rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise SpecError([Problem("", f"cannot read the file: {reason}", file=file, rule="unreadable")]) from None
    return decode_source(data, file)


def decode_source(data: bytes, file: str = "case.yaml") -> Source:
    """Decode and check the bytes of a file; see `read_source`.

    Raises:
        SpecError: If the file is too large, is not UTF-8, or has a character that is not allowed.
    """
    if len(data) > MAX_BYTES:
        problem = Problem("", f"the file is larger than {MAX_BYTES // 1_000_000} MB", file=file, rule="too-large")
        raise SpecError([problem])
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise SpecError([Problem("", "the file is UTF-16; save it as UTF-8", file=file, rule="encoding")])
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        good = Source(data[: error.start].decode("utf-8-sig"), file)
        message = f"byte 0x{data[error.start]:02x} is not UTF-8"
        raise good.error(len(good.text), message, "encoding") from None
    return check_source(Source(text, file))


def check_source(source: Source) -> Source:
    """Return the source, unless it is too large or has forbidden characters.

    Raises:
        SpecError: If it is too large or has forbidden characters.
    """
    if len(source.text) > MAX_BYTES:
        raise source.error(0, f"the text is larger than {MAX_BYTES // 1_000_000} MB", "too-large")
    found = _FORBIDDEN.search(source.text)
    if found:
        message = f"the character U+{ord(found[0]):04X} is not allowed"
        raise source.error(found.start(), message, "character")
    return source
