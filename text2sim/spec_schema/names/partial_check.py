"""References of a case of which some values are wrong in form: what is sound of it is checked all the same.

Wrong values are left out; where that is not enough, so is the whole entry (a control, a measure), or it is replaced by
something plain (a body). Of what is changed in that way, nothing is said but that a name in it means nothing; and
nothing is said of what refers to it.
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
from text2sim.spec_schema.text.document import Path, parse_pointer, pointer

Validate = Callable[[dict[str, Any]], tuple[Any, list[Problem]]]
"""Data to a case, or to what is wrong with it."""

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
"""Where named entries stand, and what takes the place of one that cannot be repaired."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,47}")
DURATION: Path = ("scene", "duration")
LONGEST = 600.0
"""[s]: nothing comes after that."""
ROUNDS = 4
"""Leaving out a value, then an entry but for its place, then that; what it hides may come to light once."""
MAX_PROBLEMS = 200
"""Where more is wrong than this, there is enough to do."""


def further_problems(loaded: LoadedCase, problems: Iterable[Problem], validate: Validate) -> list[Problem]:
    """Return what is wrong with the references of a case whose form is wrong.

    Args:
        loaded: All but its models, which could not be made.
        problems: What is wrong with its form.
        validate: Makes the models of other data.
    """
    data = copy.deepcopy(loaded.data)
    spoilt: set[Path] = set()
    hopeless: set[Path] = set()
    wrong = {parse_pointer(problem.path) for problem in problems} | set(loaded.resolver.broken)
    for _ in range(ROUNDS):
        before = set(spoilt)
        ordered = sorted(wrong, key=len, reverse=True)
        if len(wrong) > MAX_PROBLEMS or not all([_leave_out(data, path, before, spoilt, hopeless) for path in ordered]):
            return []
        case, found = validate(data)
        if case is not None:
            varying = frozenset(path for path in loaded._varying if _entry(path) not in spoilt)
            sound = replace(loaded, case=case, data=data, _varying=varying)
            return [one for one in check_references(sound) if one.severity == "error" and _stands(one, data, spoilt)]
        wrong = {parse_pointer(problem.path) for problem in found}
    return []


def _entry(path: Path) -> Path | None:
    """The named entry in which a value stands."""
    for section in PLAIN:
        if path[: len(section)] == section and len(path) > len(section):
            return path[: len(section) + 1]
    return None


def _leave_out(data: dict[str, Any], path: Path, before: set[Path], spoilt: set[Path], hopeless: set[Path]) -> bool:
    """Take a value away, or else its entry; return whether there was something to take.

    Args:
        data: The case, which is changed.
        path: Of what is wrong.
        before: Entries of which something was taken earlier, which was not enough.
        spoilt: Entries, and other values, of which something was taken: added to.
        hopeless: Bodies that were made plain, and keep no more than their place: added to.
    """
    entry = _entry(path)
    if path == DURATION:
        data["scene"]["duration"] = LONGEST
    elif entry is None:
        if not path or not _delete(data, path):
            return False
    elif entry == path or entry in before or not _delete(data, path):
        holder = _at(data, entry[:-1])
        if not isinstance(holder, dict) or not isinstance(entry[-1], str):
            return False
        plain, old = PLAIN[entry[:-1]], holder.get(entry[-1])
        if plain is None or not NAME.fullmatch(entry[-1]):
            holder.pop(entry[-1], None)
        else:
            place = old.get("place") if isinstance(old, dict) and entry not in hopeless else None
            holder[entry[-1]] = copy.deepcopy(plain) | ({"place": place} if isinstance(place, dict) else {})
            hopeless.add(entry)
    spoilt.add(path if entry is None else entry)
    return True


def _at(data: Any, path: Path) -> Any:
    for step in path:
        if isinstance(data, dict) and step in data:
            data = data[step]
        elif isinstance(data, list) and isinstance(step, int) and step < len(data):
            data = data[step]
        else:
            return None
    return data


def _delete(data: dict[str, Any], path: Path) -> bool:
    """Delete a key of a mapping; elements of lists do not go alone."""
    for depth in range(len(path), 0, -1):
        holder = _at(data, path[: depth - 1])
        if isinstance(holder, dict) and path[depth - 1] in holder:
            del holder[path[depth - 1]]
            return True
        if isinstance(holder, dict):
            return False
    return False


def _stands(problem: Problem, data: dict[str, Any], spoilt: set[Path]) -> bool:
    """Whether a problem does not follow from what was left out."""
    path = parse_pointer(problem.path)
    names = {str(entry[-1]) for entry in spoilt}
    if _entry(path) is None:
        return not any(pointer(entry).startswith(("/scene", "/render")) for entry in spoilt)
    value = _at(data, path)
    if isinstance(value, str) and value.split("[")[0].split(".")[0] in names:
        return False
    if problem.rule == NEVER and any(entry[:2] == ("actions", "controls") for entry in spoilt):
        return False  # one of those may release it
    if problem.rule.startswith("unknown"):
        return True
    return _entry(path) not in spoilt and not any(f"`{name}`" in problem.message for name in names)
