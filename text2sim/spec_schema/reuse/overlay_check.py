"""Checks of the keys of variants and points of sweeps.

Their values are checked with the case that they change; but an unknown key would never be noticed there, nor in a
variant that is never used.
"""

import re
from typing import Any

from text2sim.spec_schema.errors import Problem, nearest, there_are
from text2sim.spec_schema.models.base import Name
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.text.document import Document, Path, mapping_at, value_at
from text2sim.spec_schema.vocabulary.slot_path import (
    ROOTS,
    MappingSlots,
    PrefabInterface,
    PrefabInterfaces,
    is_entry,
    mapping_slots,
)
from text2sim.spec_schema.vocabulary.slots import ENTRY
from text2sim.spec_schema.vocabulary.words import LanguageSlot, bounds_of, fields_of, noun_of, show, slot_of

_NAME = re.compile(bounds_of(slot_of(Name))["pattern"])
_WORD = re.compile(r"[A-Za-z_]\w*")


def check_names(document: Document, section: str, problems: list[Problem]) -> dict[str, Any]:
    """Return the valid entries of a section that is a mapping by name, and report the others.

    Args:
        document: The document.
        section: Name of the section.
        problems: Problems, to which new ones are added.
    """
    found = document.data.get(section)
    if not isinstance(found, dict):
        if section in document.data:
            message = f"needs a mapping by name (got {show(found)})"
            problems.append(document.problem((section,), message, rule="type", key=found is None))
        return {}
    for name in found:
        if not _NAME.fullmatch(name):
            message = f"`{name}` is not a name: {noun_of(slot_of(Name)).form}"
            problems.append(document.problem((section, name), message, key=True, rule="form"))
    return {name: value for name, value in found.items() if _NAME.fullmatch(name)}


def unknown_overlay(document: Document, what: str, name: str, known: Any, line: int = 1) -> Problem:
    """Return the problem of an option with a name that the case does not have.

    Args:
        document: The case.
        what: `variant` or `sweep`, which is also the name of the option.
        name: The name.
        known: The section of the case, if it has one.
        line: Number of the option, from 1.
    """
    names = list(known) if isinstance(known, dict) else []
    existing = there_are(names, None) or f": it has no {what}s"
    message = f"{document.source.file} has no {what} `{name}`{existing}"
    return Problem("", message, line, 1, f"--{what}", nearest(name, names), f"unknown-{what}")


def check_overlay(document: Document, at: Path, others: list[Any], interfaces: PrefabInterfaces) -> list[Problem]:
    """Return problems for the unknown keys of a variant.

    Args:
        document: The case.
        at: Path of the variant in it.
        others: All variants of the case, including this one: each may change entries of others.
        interfaces: Interfaces of prefabs.
    """
    walk = _Walk(document, at, interfaces)
    over = value_at(document.data, at)
    if not isinstance(over, dict):
        walk.report((), f"needs a mapping of what it changes (got {show(over)})", "type")
        return walk.problems
    for key in over:
        if key not in ROOTS:
            message = f"unknown key `{key}`; {walk.what} can change {', '.join(ROOTS)}"
            walk.report((key,), message, "unknown-key", nearest(key, ROOTS))
    bases = [document.data, *(other for other in others if isinstance(other, dict) and other is not over)]
    kept = {key: value for key, value in over.items() if key in ROOTS}
    walk.mapping([slot_of(Case)], kept, bases, ())
    walk.params(over, bases)
    return walk.problems


def check_body(document: Document, at: Path, body: dict[str, Any]) -> list[Problem]:
    """Return problems for the unknown keys of a prefab's body.

    Args:
        document: The document of the prefab.
        at: Path of the body.
        body: The body.
    """
    if "use" in body:
        return []  # checked when it is expanded
    walk = _Walk(document, at, lambda use: PrefabInterface())
    walk.skipped = 2
    walk.mapping([ENTRY], body, [body], ("bodies", "body"))
    return walk.problems


class _Walk:
    def __init__(self, document: Document, at: Path, interfaces: PrefabInterfaces) -> None:
        self.document, self.at, self.interfaces = document, at, interfaces
        self.problems: list[Problem] = []
        self.skipped = 0
        """Number of steps of a path in a case that `at` includes."""
        self.what = f"the variant `{at[-1]}`" if at[0] == "variants" else f"the point `{at[-1]}`"

    def report(self, path: Path, message: str, rule: str, hint: str | None = None, *, key: bool = True) -> None:
        where = (*self.at, *path[self.skipped :])
        self.problems.append(self.document.problem(where, message, key=key, rule=rule, hint=hint))

    def mapping(self, slots: list[LanguageSlot], over: dict[str, Any], bases: list[Any], path: Path) -> None:
        """Check the keys of a mapping that changes others."""
        own = [over] if isinstance(over.get("kind"), str) or "use" in over else []
        found = mapping_slots(slots, own or [over, *bases], path, self.interfaces)
        if found.anything or path == ("params",) or path[-1:] == ("with",):
            return
        if found.names and not found.fields:
            self.named(found, over, bases, path)
            return
        for key, value in over.items():
            inner = found.inner(key)
            if inner is None:
                known = list(found.fields)
                takes = f"`{path[-1]}` takes {', '.join(known)}" if path else "unknown"
                self.report((*path, key), f"unknown key `{key}`; {takes}", "unknown-key", nearest(key, known))
            elif isinstance(value, dict):
                self.mapping(inner, value, _inside(bases, key), (*path, key))

    def named(self, found: MappingSlots, over: dict[str, Any], bases: list[Any], path: Path) -> None:
        """Check a mapping by name, in which a new name needs a complete entry."""
        known = list(bases[0]) if isinstance(bases[0], dict) else []
        # Complete entries of other variants may be changed.
        for base in bases[1:]:
            rows = base.items() if isinstance(base, dict) else ()
            known += [name for name, value in rows if name not in known and _whole(found.names, value, (*path, name))]
        whole = {member.structure for slot in found.names for member in slot.members} <= {"number", "text", "list"}
        for name, value in over.items():
            if name not in known and not whole and not _whole(found.names, value, (*path, name)):
                message = f"there is no `{name}` in {'.'.join(map(str, path))} to change{there_are(known)}"
                self.report((*path, name), message, "unknown-name", nearest(name, known))
            elif isinstance(value, dict):
                self.mapping(found.names, value, _inside(bases, name), (*path, name))

    def params(self, over: dict[str, Any], bases: list[Any]) -> None:
        """Report parameters that neither exist in the case nor are used in the overlay."""
        known = list(mapping_at(self.document.data, "params"))
        for other in bases[1:]:
            known += mapping_at(other, "params").keys() & set(_words(other))
        used = set(_words(over))
        for name in mapping_at(over, "params"):
            if name not in known and name not in used:
                message = f"there is no parameter `{name}` to change, and nothing in {self.what} uses it"
                self.report(("params", name), message, "unknown-name", nearest(name, known))


def _inside(bases: list[Any], key: str) -> list[Any]:
    """Return the values of bases under a key; that of the case is first, and may be None."""
    first, *others = (base.get(key) if isinstance(base, dict) else None for base in bases)
    return [first, *(other for other in others if other is not None)]


def _whole(slots: list[LanguageSlot], value: Any, path: Path) -> bool:
    """Return whether a value is a complete entry, with all required fields."""
    if not isinstance(value, dict):
        return False
    if "kind" in value or (is_entry(path) and "use" in value):
        return True
    if path[:-1] == ("prefabs",):
        return "body" in value or "bodies" in value
    models = mapping_slots(slots, [value], path).models
    if models == [Expect]:
        return "measure" in value or "event" in value
    return any(
        all(
            key in value
            for key, (attribute, _) in fields_of(model).items()
            if model.model_fields[attribute].is_required()
        )
        for model in models
    )


def _words(data: Any) -> list[str]:
    """Return the words in the expressions of a value."""
    if isinstance(data, dict):
        return [word for value in data.values() for word in _words(value)]
    if isinstance(data, list):
        return [word for value in data for word in _words(value)]
    return _WORD.findall(data) if isinstance(data, str) and "${" in data else []
