"""What the command line says: plain text that cannot rewrite a terminal, or one JSON document."""

import json
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TextIO

from text2sim.spec_schema.errors import Problem, format_problems
from text2sim.spec_schema.plain import escaped, plain


def say(text: str = "", *, to: TextIO | None = None) -> None:
    """Print a line, without whatever could move the cursor or change colours."""
    print(plain(text), file=to or sys.stdout)


def say_problems(problems: Iterable[Problem], sources: Mapping[str, str]) -> None:
    """Print problems with their lines to the error stream."""
    if text := format_problems(problems, sources):
        say(text, to=sys.stderr)


def say_json(document: object) -> None:
    """Print the one JSON document of a command."""
    print(escaped(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False, default=str)))


def shown(path: Path) -> str:
    """Return a path relative to the working directory where it lies below it."""
    try:
        return os.path.relpath(path) if path.absolute().is_relative_to(Path.cwd()) else str(path)
    except OSError:  # the working directory is gone
        return str(path)


def reason(error: Exception) -> str:
    """Return what an error says to a user who can put it right."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error)


def seconds(value: float | None) -> str:
    """Return a span of time for people: `0.4 s`, `41 s`, `3 min 5 s`."""
    if value is None:
        return "?"
    if value < 10:
        return f"{value:.1f} s"
    minutes, rest = divmod(round(value), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def expectation_rows(expectations: dict[str, dict[str, Any]]) -> list[tuple[bool | None, str, str]]:
    """Return (came true, name, what was wanted and found) of each expectation; None where it stayed open."""
    return [(row["ok"], name, f"{row['wanted']}: {row['why']}") for name, row in expectations.items()]
