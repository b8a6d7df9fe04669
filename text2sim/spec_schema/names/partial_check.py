"""Checks of the references of a case with invalid values.

Invalid values are removed; if that is not enough, the whole entry (a control, a measure) is removed or replaced by a
plain one (a body). For changed entries, only unknown names are reported; for references to them, nothing.
"""

import copy
import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.names.event_references import NEVER
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.document import Path, find_value, parse_pointer, pointer

Validate = Callable[[dict[str, Any]], tuple[Any, list[Problem]]]
"""Validates data; returns the case, or its problems."""

BALL = {"shape": {"kind": "sphere", "radius": 0.1}}
PLAIN: dict[Path, Any] = {
    ("bodies",): {"kind": "rigid", **BALL},
    ("scene", "statics"): BALL,
    ("actions", "controls"): None,
    ("actions", "measures"): None,
    ("actions", "events"): None,
    ("actions", "expect"): None,
    ("render", "cameras"): None,
    ("render", "lights"): None,
    ("render", "shots"): None,
}
"""Sections of named entries, and replacements of entries that cannot be repaired."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,47}")
DURATION: Path = ("scene", "duration")
LONGEST = 600.0
"""Longest duration [s]."""
ROUNDS = 4
"""Rounds: remove a value, then an entry except its place, then its place; each may reveal further problems."""
MAX_PROBLEMS = 200
"""Most invalid values for which references are checked."""


def further_problems(loaded: LoadedCase, problems: Iterable[Problem], validate: Validate) -> list[Problem]:
    """Return the problems of the references of a case with an invalid form.

    Args:
        loaded: The case, without models.
        problems: The problems of its form.
        validate: Makes the models of other data.
    """
    data = copy.deepcopy(loaded.data)
    changed: set[Path] = set()
    plain: set[Path] = set()
    wrong = {parse_pointer(problem.path) for problem in problems} | set(loaded.resolver.broken)
    for _ in range(ROUNDS):
        before = set(changed)
        ordered = sorted(wrong, key=len, reverse=True)
        if len(wrong) > MAX_PROBLEMS or not all([_leave_out(data, path, before, changed, plain) for path in ordered]):
            return []
        case, found = validate(data)
        if case is not None:
            varying = frozenset(path for path in loaded.varying if _entry(path) not in changed)
            valid = replace(loaded, case=case, data=data, varying=varying)
            found = check_references(valid)
            return [problem for problem in found if problem.severity == "error" and _holds(problem, data, changed)]
        wrong = {parse_pointer(problem.path) for problem in found}
    return []


def _entry(path: Path) -> Path | None:
    """Return the path of the named entry with a value."""
    for section in PLAIN:
        if path[: len(section)] == section and len(path) > len(section):
            return path[: len(section) + 1]
    return None


def _leave_out(data: dict[str, Any], path: Path, before: set[Path], changed: set[Path], plain: set[Path]) -> bool:
    """Remove a value, or else its entry; return whether there was something to remove.

    Args:
        data: The case, which is changed.
        path: Path of the invalid value.
        before: Entries that were changed in earlier rounds.
        changed: Changed entries and values, to which this one is added.
        plain: Bodies that were made plain except for their place, to which this one may be added.
    """
    entry = _entry(path)
    if path == DURATION:
        data["scene"]["duration"] = LONGEST
    elif entry is None:
        if not path or not _delete(data, path):
            return False
    elif entry == path or entry in before or not _delete(data, path):
        holder = find_value(data, entry[:-1])
        if not isinstance(holder, dict) or not isinstance(entry[-1], str):
            return False
        substitute, old = PLAIN[entry[:-1]], holder.get(entry[-1])
        if substitute is None or not NAME.fullmatch(entry[-1]):
            holder.pop(entry[-1], None)
        else:
            place = old.get("place") if isinstance(old, dict) and entry not in plain else None
            holder[entry[-1]] = copy.deepcopy(substitute) | ({"place": place} if isinstance(place, dict) else {})
            plain.add(entry)
    changed.add(path if entry is None else entry)
    return True


def _delete(data: dict[str, Any], path: Path) -> bool:
    """Delete a key of a mapping; for an item of a list, the key of the list."""
    for depth in range(len(path), 0, -1):
        holder = find_value(data, path[: depth - 1])
        if isinstance(holder, dict) and path[depth - 1] in holder:
            del holder[path[depth - 1]]
            return True
        if isinstance(holder, dict):
            return False
    return False


def _holds(problem: Problem, data: dict[str, Any], changed: set[Path]) -> bool:
    """Return whether a problem does not follow from the changes."""
    path = parse_pointer(problem.path)
    names = {str(entry[-1]) for entry in changed}
    if _entry(path) is None:
        return not any(pointer(entry).startswith(("/scene", "/render")) for entry in changed)
    value = find_value(data, path)
    if isinstance(value, str) and body_of(value) in names:
        return False
    if problem.rule == NEVER and any(entry[:2] == ("actions", "controls") for entry in changed):
        return False  # one of those may release it
    if problem.rule.startswith("unknown"):
        return True
    return _entry(path) not in changed and not any(f"`{name}`" in problem.message for name in names)
