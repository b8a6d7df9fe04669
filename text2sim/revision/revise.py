"""Application of a patch to a case: the result is valid, or the patch is refused."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from text2sim.spec_schema.changes.diff import Change, difference
from text2sim.spec_schema.changes.edit import edit_source
from text2sim.spec_schema.changes.operation import Operation, split_pointer
from text2sim.spec_schema.changes.patch import PatchError, apply_operations, inverse, same
from text2sim.spec_schema.errors import Problem, SpecError, Text2SimError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

OWNERS = ("scene", "bodies", "actions", "render")
"""Owners of sections; each may change the section of its name."""


@dataclass(frozen=True)
class Revision:
    """Result of a patch."""

    source: Source
    """The text before."""
    text: str
    """The text after."""
    changes: list[Change]
    undo: list[Operation]
    """The inverse patch."""
    warnings: list[Problem] = field(default_factory=list)
    """Lint warnings that are new."""
    remaining: list[Problem] = field(default_factory=list)
    """Lint errors that the case had before."""


class RefusedPatch(SpecError):
    """A patch whose result is not a valid case.

    Attributes:
        problems: Problems of the result, with positions in `text`.
        text: The text that the patch would have produced.
        blame: For each problem the index of the operation that probably caused it, or None.
    """

    def __init__(self, problems: Sequence[Problem], text: str, operations: Sequence[Operation]) -> None:
        super().__init__(problems)
        self.text = text
        self.blame = [_blamed(problem, operations) for problem in self.problems]


def revise(source: Source, path: Path, operations: Sequence[Operation], owner: str | None = None) -> Revision:
    """Apply a patch to the text of a case and check the result; no file is written.

    Args:
        source: The text. It may be invalid: a patch may repair it.
        path: Path of the case, which files in it are relative to.
        operations: The patch.
        owner: One of `OWNERS`, to allow changes in this section only; None allows all changes.

    Raises:
        PatchError: If the patch cannot be applied, or changes another owner's section.
        RefusedPatch: If the result is not a valid case, or has new lint errors.
        SpecError: If the text is not YAML that the language accepts.
    """
    data = parse_document(source).data
    wanted = apply_operations(data, operations) if owner is None else apply_owned(data, operations, owner)
    text = edit_source(source, operations)
    try:
        found = _examine(text, path)
    except SpecError as error:
        raise RefusedPatch(error.problems, text, operations) from None
    except Text2SimError as error:
        raise RefusedPatch([Problem("", str(error), file=str(path), rule="asset")], text, operations) from None
    try:
        before = _examine(source.text, path)
    except (Text2SimError, OSError):
        before = []
    new = _new_problems(found, before)
    errors = [problem for problem in new if problem.severity == "error"]
    if errors:
        raise RefusedPatch(errors, text, operations)
    return Revision(
        source,
        text,
        difference(data, wanted),
        inverse(data, operations),
        [problem for problem in new if problem.severity == "warning"],
        [problem for problem in found if problem.severity == "error"],
    )


def apply_owned(data: Any, operations: Sequence[Operation], owner: str) -> Any:
    """Return a document with a patch applied that may change one section only.

    Args:
        data: The document.
        operations: The patch.
        owner: One of `OWNERS`.

    Raises:
        PatchError: If the patch cannot be applied, or changes another owner's section.
    """
    wanted = apply_operations(data, operations)
    _check_ownership(data, wanted, operations, owner)
    return wanted


def _check_ownership(data: Any, wanted: Any, operations: Sequence[Operation], owner: str) -> None:
    """Raise a `PatchError` for the first operation outside the owner's section."""
    assert owner in OWNERS
    for index, operation in enumerate(operations):
        members = {"test": (), "move": ("from", "path")}.get(operation["op"], ("path",))
        for member in members:
            steps = split_pointer(operation[member])
            if steps[:1] != (owner,):
                place = f"/{steps[0]}" if steps else "the whole case"
                reason = f"{place} is outside /{owner}, the only section that `--owner {owner}` may change"
                raise PatchError(index, reason, member, f" ({operation['op']} {operation['path']})")
    for section in data.keys() | wanted.keys() if isinstance(data, dict) else ():
        assert section == owner or same(data.get(section), wanted.get(section)), section


def _examine(text: str, path: Path) -> list[Problem]:
    """Lint problems of a case, without waived ones."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case

    return list(lint_case(resolve_case(load_text(text, path))).problems)


def _new_problems(found: list[Problem], before: list[Problem]) -> list[Problem]:
    """New problems, counted by rule and path: a problem whose line has moved is not new."""
    known = Counter((problem.rule, problem.path) for problem in before)
    new = []
    for problem in found:
        known[problem.rule, problem.path] -= 1
        if known[problem.rule, problem.path] < 0:
            new.append(problem)
    return new


def _blamed(problem: Problem, operations: Sequence[Operation]) -> int | None:
    """Index of the last operation that wrote at the problem's path, above or below it, or at a name in its message."""
    writing = [index for index, operation in enumerate(operations) if operation["op"] != "test"]
    if len(writing) == 1:
        return writing[0]
    place = split_pointer(problem.path) if problem.path.startswith("/") else ()
    named = set(_NAMED.findall(problem.message))
    touched = [(index, steps) for index in reversed(writing) for steps in _places(operations[index])]
    for index, steps in touched:
        if steps and place and (steps[: len(place)] == place or place[: len(steps)] == steps):
            return index
    return next((index for index, steps in touched if steps and steps[-1] in named), None)


def _places(operation: Operation) -> list[tuple[str, ...]]:
    members = ("path", "from") if operation["op"] == "move" else ("path",)
    return [split_pointer(operation[member]) for member in members]


_NAMED = re.compile(r"`(\w+)")
