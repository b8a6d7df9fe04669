"""A patch on the text of a case: comments, order and format of what it does not touch stay."""

from collections.abc import Sequence
from typing import Any

from text2sim.spec_schema.changes.amendment import Amendment, Origin, identical
from text2sim.spec_schema.changes.operation import Operation
from text2sim.spec_schema.changes.patch import apply_operations
from text2sim.spec_schema.changes.splice import splice
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.text.canonical import format_source
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source, check_source


def edit_text(text: str, operations: Sequence[Operation], file: str = "case.yaml") -> str:
    """Apply a patch to the text of a case.

    Text in canonical form stays canonical; otherwise only what is touched is brought into it.

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
    amendment = Amendment(document, origin)
    amendment.apply(operations)
    return write_amended(source, amendment, wanted)


def write_amended(source: Source, amendment: Amendment, wanted: Any) -> str:
    """Return the text with all that was amended in its layout.

    Args:
        source: The text.
        amendment: Its layout, amended.
        wanted: What the text has to say.
    """
    text = splice(source, amendment)
    if text is None or not says(text, wanted):
        # A way of writing YAML that splicing does not know: all is written anew, with the comments.
        text = amendment.dump()
        if not identical(parse_document(check_source(Source(text, source.file))).data, wanted):
            raise AssertionError("the edited text says something else than the patched data")
    return format_source(Source(text, source.file)) if amendment.canonical else text


def says(text: str, data: Any) -> bool:
    """Whether a text is YAML for just this data."""
    try:
        return identical(parse_document(check_source(Source(text))).data, data)
    except SpecError:
        return False
