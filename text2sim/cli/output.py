"""Output of the command line: plain text without terminal control codes, or one JSON document."""

import json
import sys
from collections.abc import Iterable, Mapping
from typing import Any, TextIO

from text2sim.spec_schema.errors import Problem, format_problems
from text2sim.spec_schema.plain import escaped, plain


def say(text: str = "", *, to: TextIO | None = None) -> None:
    """Print a line without control codes."""
    print(plain(text), file=to or sys.stdout)


def say_problems(problems: Iterable[Problem], sources: Mapping[str, str]) -> None:
    """Print problems with their lines to the error stream."""
    if text := format_problems(problems, sources):
        say(text, to=sys.stderr)


def say_json(document: object) -> None:
    """Print the one JSON document of a command."""
    print(escaped(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False, default=str)))


def expectation_rows(expectations: dict[str, dict[str, Any]]) -> list[tuple[bool | None, str, str]]:
    """Return (result, name, expected and found values) of each expectation; the result is None if undecided."""
    return [(row["ok"], name, f"{row['wanted']}: {row['why']}") for name, row in expectations.items()]
