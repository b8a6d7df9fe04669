"""Errors that are shown to the user as a message, without a traceback."""

import difflib
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from text2sim.spec_schema.plain import plain_line

Severity = Literal["error", "warning"]

MAX_SHOWN_PROBLEMS = 100
"""Most problems that are shown to people; machines get all."""


@dataclass(frozen=True)
class Problem:
    """A problem of a case, with its position."""

    path: str
    """JSON Pointer to the value, such as `/bodies/ball/shape/radius`."""
    message: str
    """What is wrong, in the words of the language."""
    line: int = 1
    """Line in the file, from 1."""
    column: int = 1
    """Column in the line, from 1, in characters."""
    file: str = "case.yaml"
    """The file, as the user named it."""
    hint: str | None = None
    """The nearest valid word."""
    rule: str = "invalid"
    """Stable id of the violated rule."""
    severity: Severity = "error"

    def __post_init__(self) -> None:
        # It may quote any text: of a file, or of a library's message.
        object.__setattr__(self, "message", plain_line(self.message))

    def __str__(self) -> str:
        text = f"{plain_line(self.file)}:{self.line}:{self.column}: {self.severity}: {self.message}"
        if self.hint is not None:
            text += f"; did you mean `{self.hint}`?"
        return f"{text} [{self.rule}]"

    def as_dict(self) -> dict[str, Any]:
        """Return the problem as plain data."""
        return asdict(self)


class Text2SimError(Exception):
    """An error that the user can correct, in a line of plain text."""

    def __init__(self, message: str = "") -> None:
        super().__init__(plain_line(message))


class SpecError(Text2SimError):
    """An invalid case.

    Attributes:
        problems: All problems, in the order of the file.
    """

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = sort_problems(problems)
        Exception.__init__(self, "\n".join(map(str, self.problems)))


class AssetError(Text2SimError):
    """A mesh, model or picture that is missing or unusable."""


class RunError(Text2SimError):
    """A program that failed."""


class MachineError(Text2SimError):
    """A requirement that this machine does not meet."""


class EngineError(MachineError):
    """An engine that does not start."""


def sort_problems(problems: Iterable[Problem]) -> list[Problem]:
    """Return the problems in the order of the file, without duplicates."""
    return sorted(dict.fromkeys(problems), key=lambda p: (p.file, p.line, p.column, p.path, p.message))


def nearest(word: object, allowed: Iterable[str]) -> str | None:
    """Return the allowed word that is most similar to `word`, or None if none is similar."""
    if not isinstance(word, str) or not word or len(word) > 100:
        return None
    words = list(allowed)
    found = difflib.get_close_matches(word, words, n=1, cutoff=0.6)
    if not found:
        lower = {w.lower(): w for w in words}
        found = [lower[w] for w in difflib.get_close_matches(word.lower(), list(lower), n=1, cutoff=0.6)]
    return found[0] if found and found[0] != word else None


def did_you_mean(word: object, allowed: Iterable[str]) -> str:
    """Return the end of a message that suggests the nearest allowed word, if there is one."""
    hint = nearest(word, allowed)
    return f"; did you mean `{hint}`?" if hint else ""


def there_are(names: Collection[str], most: int | None = 12) -> str:
    """Return the end of a message that lists the allowed names; empty if there are none, or more than `most`."""
    return f"; there are {', '.join(names)}" if names and (most is None or len(names) <= most) else ""


def format_problems(problems: Iterable[Problem], source: Any = None) -> str:
    """Format problems for people: position, message, the nearest valid word, and the line with a caret.

    Args:
        problems: The problems.
        source: The `Source` of the case or its text (or a mapping of file name to either); without it there are no
            excerpts.

    Returns:
        Lines for the first `MAX_SHOWN_PROBLEMS` problems, and the number of further ones.
    """
    blocks, lines = [], dict[str, list[str]]()
    found = sort_problems(problems)
    for problem in found[:MAX_SHOWN_PROBLEMS]:
        block = str(problem)
        if problem.file not in lines:
            lines[problem.file] = _lines(source, problem.file)
        if problem.line <= len(lines[problem.file]):
            block += "\n" + _excerpt(lines[problem.file][problem.line - 1], problem)
        blocks.append(block)
    if len(found) > MAX_SHOWN_PROBLEMS:
        blocks.append(f"… and {len(found) - MAX_SHOWN_PROBLEMS} more problems")
    return "\n".join(blocks)


def _lines(source: Any, file: str) -> list[str]:
    if isinstance(source, Mapping):
        source = source.get(file)
    text = getattr(source, "text", source)
    return re.split(r"\r\n|\r|\n", text) if isinstance(text, str) else []


def _excerpt(line: str, problem: Problem) -> str:
    column, width = problem.column - 1, 110
    # A window around the column of a long line.
    first = max(0, column - width * 2 // 3) if len(line) > width else 0
    shown = plain_line(line[first : first + width])
    at = f"  at {plain_line(problem.path)}" if problem.path else ""
    return f"    {shown.rstrip()}\n    {' ' * (column - first)}^{at}"
