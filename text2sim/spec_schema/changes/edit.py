"""Patches on the text of a case: comments and order of what they do not touch stay."""

from collections.abc import Sequence
from typing import Any

from text2sim.spec_schema.changes.amendment import DocumentLayout, Origin, identical
from text2sim.spec_schema.changes.operation import Operation
from text2sim.spec_schema.changes.patch import apply_operations
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source, check_source


def edit_text(text: str, operations: Sequence[Operation], file: str = "case.yaml") -> str:
    """Apply a patch to the text of a case.

    The result is in canonical form, with the comments; a patch without operations changes nothing.

    Args:
        text: Text of the case.
        operations: The patch.
        file: Name of the file, for messages.

    Raises:
        SpecError: If the text is not YAML that the language accepts, before or after. It need not be a valid case.
        PatchError: If the patch cannot be applied.
    """
    return edit_source(check_source(Source(text, file)), operations)


def edit_source(source: Source, operations: Sequence[Operation], origin: Origin | None = None) -> str:
    """Apply a patch to a file that was read; see `edit_text`.

    Args:
        source: The text.
        operations: The patch.
        origin: Where what is added has its comments from.
    """
    document = parse_document(source)
    wanted = apply_operations(document.data, operations)
    if not operations:
        return source.text
    amendment = DocumentLayout(document, origin)
    amendment.apply(operations)
    return write_amended(source, amendment, wanted)


def write_amended(source: Source, amendment: DocumentLayout, wanted: Any) -> str:
    """Return an amended text in canonical form, with its comments.

    Args:
        source: The text.
        amendment: Its layout, amended.
        wanted: What the text has to say.
    """
    text = amendment.dump()
    if not identical(parse_document(check_source(Source(text, source.file))).data, wanted):
        raise AssertionError("the edited text says something else than the patched data")
    return text
