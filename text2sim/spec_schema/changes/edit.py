"""Patches on the text of a case, which keep the comments and the order of unchanged entries."""

from collections.abc import Sequence

from text2sim.spec_schema.changes.amendment import DocumentLayout, EntryLookup
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
        SpecError: If the text is not YAML that the language accepts, before or after. The case may be invalid.
        PatchError: If the patch cannot be applied.
    """
    return edit_source(check_source(Source(text, file)), operations)


def edit_source(source: Source, operations: Sequence[Operation], lookup: EntryLookup | None = None) -> str:
    """Apply a patch to a source; see `edit_text`.

    Args:
        source: The text.
        operations: The patch.
        lookup: Returns entries from which added values take their comments.
    """
    document = parse_document(source)
    wanted = apply_operations(document.data, operations)
    if not operations:
        return source.text
    layout = DocumentLayout(document, lookup)
    layout.apply(operations)
    return layout.dump(wanted)
