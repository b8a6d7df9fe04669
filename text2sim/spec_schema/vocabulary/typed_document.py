"""Documents as models, with located problems."""

from typing import TypeVar

from pydantic import BaseModel, ValidationError

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.text.document import Document
from text2sim.spec_schema.vocabulary.diagnosis import diagnose

M = TypeVar("M", bound=BaseModel)


def model_of(document: Document, model: type[M], structure: str = "") -> M:
    """Return the data of a document as a model.

    Args:
        document: The document.
        model: The type of its content.
        structure: Message for data that is not a mapping; the general one if left out.

    Raises:
        SpecError: with all problems and their places.
    """
    if structure and not isinstance(document.data, dict):
        raise SpecError([document.problem((), structure, rule="type")])
    try:
        return model.model_validate(document.data)
    except ValidationError as error:
        raise SpecError(diagnose(document, error, model, document.data)) from None
