"""A patch on a case: it leaves a valid case behind, or nothing happens."""

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
"""Who may own a part of a case: the one who writes the section of this name."""


@dataclass(frozen=True)
class Revision:
    """What a patch makes of a case."""

    source: Source
    """The text as it was."""
    text: str
    """The text as it is to be."""
    changes: list[Change]
    undo: list[Operation]
    """The patch that leads back."""
    warnings: list[Problem] = field(default_factory=list)
    """What the lint finds that it did not find before."""
    remaining: list[Problem] = field(default_factory=list)
    """Errors of the lint that were there before."""


class RefusedPatch(SpecError):
    """A patch whose result is no case that could be run.

    Attributes:
        problems: What would be wrong, at its place in `text`.
        text: The text as it would have been.
        blame: For each problem the operation that it may come from, from 0; None where that cannot be told.
    """

    def __init__(self, problems: Sequence[Problem], text: str, operations: Sequence[Operation]) -> None:
        super().__init__(problems)
        self.text = text
        self.blame = [_blamed(problem, operations) for problem in self.problems]


def revise(source: Source, path: Path, operations: Sequence[Operation], owner: str | None = None) -> Revision:
    """Apply a patch to the text of a case and check what comes out; no file is written.

    Args:
        source: The text. It need not be a valid case: a patch may mend it.
        path: Where it stands, for the files that it names.
        operations: The patch.
        owner: One of `OWNERS`, who may change their own section only; anybody may change anything if left out.

    Raises:
        PatchError: If the patch cannot be applied, or changes what is not its owner's.
        RefusedPatch: If the result would not be a valid case, or the lint would find an error that is new.
        SpecError: If the text is not YAML that the language accepts.
    """
    data = parse_document(source).data
    wanted = apply_operations(data, operations)
    if owner is not None:
        _check_ownership(data, wanted, operations, owner)
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
    new = _beyond(found, before)
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


def _check_ownership(data: Any, wanted: Any, operations: Sequence[Operation], owner: str) -> None:
    """Refuse a patch that changes more than one section.

    Raises:
        PatchError: With the first operation that does.
    """
    assert owner in OWNERS
    for index, operation in enumerate(operations):
        members = {"test": (), "move": ("from", "path")}.get(operation["op"], ("path",))
        for member in members:
            steps = split_pointer(operation[member])
            if steps[:1] != (owner,):
                place = f"/{steps[0]}" if steps else "the whole case"
                reason = f"{place} is not the owner's: `--owner {owner}` may change what is below /{owner} only"
                raise PatchError(index, reason, member, f" ({operation['op']} {operation['path']})")
    for section in data.keys() | wanted.keys() if isinstance(data, dict) else ():
        assert section == owner or same(data.get(section), wanted.get(section)), section


def _examine(text: str, path: Path) -> list[Problem]:
    """What the lint finds in a valid case, waived problems left out."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case

    return list(lint_case(resolve_case(load_text(text, path))).problems)


def _beyond(found: list[Problem], before: list[Problem]) -> list[Problem]:
    """Problems of which there were not as many before: a moved line does not make one new."""
    known = Counter((problem.rule, problem.path) for problem in before)
    new = []
    for problem in found:
        known[problem.rule, problem.path] -= 1
        if known[problem.rule, problem.path] < 0:
            new.append(problem)
    return new


def _blamed(problem: Problem, operations: Sequence[Operation]) -> int | None:
    """The last operation that wrote the value that is wrong, something in it, or what it stands in or names."""
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
