"""Which cases a command is about."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path

from text2sim.cli.output import say, say_problems
from text2sim.service.examined import CASE_FILE, Examined
from text2sim.service.wording import shown

SKIPPED = frozenset({"runs", "program", "assets", "__pycache__", "node_modules"})
"""Folders in which no cases are looked for: they hold what was made from cases."""
DEPTH = 6


def say_examined(case: Examined) -> None:
    """Print what is wrong with a case."""
    if case.failure:
        say(f"{shown(case.path)}: {case.failure}", to=sys.stderr)
    say_problems(case.problems, case.sources)


def find_cases(paths: Iterable[Path]) -> list[Path]:
    """Return the cases that paths mean; a folder that is no case itself means all cases below it."""
    found: dict[Path, None] = {}
    for path in paths:
        below = [path] if not path.is_dir() or (path / CASE_FILE).is_file() else list(_below(path, DEPTH))
        # A folder without cases is kept, so that reading it says so.
        found |= dict.fromkeys(below or [path])
    return list(found)


def _below(folder: Path, depth: int) -> Iterable[Path]:
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except OSError:
        return
    for entry in entries:
        if entry.name.startswith(".") or entry.name in SKIPPED or not entry.is_dir(follow_symlinks=False):
            continue
        path = Path(entry.path)
        if (path / CASE_FILE).is_file():
            yield path
        elif depth > 0:
            yield from _below(path, depth - 1)
