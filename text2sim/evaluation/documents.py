"""Reading of evaluation files into models; errors give line, column and the nearest valid word."""

from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel

from text2sim.spec_schema.text.document import Document, parse_document
from text2sim.spec_schema.text.source import read_source
from text2sim.spec_schema.vocabulary.typed_document import model_of

M = TypeVar("M", bound=BaseModel)


def read_model(path: Path, model: type[M], what: str) -> tuple[M, Document]:
    """Parse a YAML or JSON file into a model; return it with its source document.

    Args:
        path: The file.
        model: The type of its content.
        what: Its name in messages, such as `a suite`.

    Raises:
        SpecError: With all problems of the file.
    """
    document = parse_document(read_source(path))
    return model_of(document, model, f"{what} is a mapping with the keys {', '.join(model.model_fields)}"), document
