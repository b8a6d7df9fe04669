"""Patch in a JSON file, with the positions of its operations."""

import json
from dataclasses import dataclass
from typing import Any, NoReturn

from text2sim.spec_schema.changes.operation import Operation
from text2sim.spec_schema.changes.patch import PatchError
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.text.document import Document, parse_document, pointer
from text2sim.spec_schema.text.source import Source


@dataclass(frozen=True)
class PatchFile:
    """Operations of a patch and the text that they were read from."""

    source: Source
    operations: list[Operation]
    _document: Document | None
    """The parsed text with positions; None if its JSON is not valid YAML with the same meaning."""

    def problem(self, error: PatchError) -> Problem:
        """Return an error with its position in the text."""
        path = () if error.index is None else (error.index, error.member)
        line, column = self._document.place(path) if self._document is not None else (1, 1)
        return Problem(pointer(path), str(error), line, column, self.source.file, rule="patch")


def read_patch(source: Source) -> PatchFile:
    """Read the JSON text of a patch.

    Raises:
        SpecError: If it is not a list in strict JSON; duplicate keys, NaN and Infinity are errors.
    """
    try:
        data = json.loads(source.text, object_pairs_hook=_unique_keys, parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        message = f"not valid JSON: {error.msg[0].lower()}{error.msg[1:]}"
        raise SpecError([Problem("", message, error.lineno, error.colno, source.file, rule="syntax")]) from None
    except (ValueError, RecursionError) as error:
        message = "nested too deep" if isinstance(error, RecursionError) else str(error)
        raise SpecError([Problem("", message, file=source.file, rule="patch")]) from None
    if not isinstance(data, list):
        message = (
            'a patch is a list of operations: [{"op": "replace", "path": "/bodies/ball/shape/radius", "value": 0.2}]'
        )
        raise SpecError([Problem("", message, file=source.file, rule="patch")])
    try:
        document = parse_document(source)
    except SpecError:
        document = None
    return PatchFile(source, data, document if document is not None and document.data == data else None)


def _unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    mapping = dict(pairs)
    if len(mapping) < len(pairs):
        twice = next(key for i, (key, _) in enumerate(pairs) if key in dict(pairs[:i]))
        raise ValueError(f"the key `{twice[:40]}` is given twice in one mapping")
    return mapping


def _refuse_constant(word: str) -> NoReturn:
    raise ValueError(f"{word} is not a finite number")
