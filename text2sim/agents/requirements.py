"""Requirements of a request: listed before anything is built, and marked one by one by the Critic.

Without such a list, expectations and the Critic's verdict alone decide.
"""

from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import Field

from text2sim.agents.conversation import Conversation, RoleFailed, Wrong, typed_parser
from text2sim.agents.models.exchange import Image, ModelError, StoppedError
from text2sim.agents.replies import Answer, Line, Name
from text2sim.agents.roles import ROLES, render, system_prompt

MAX_REQUIREMENTS = 24
SHORT_WISH, SHORT_WISH_LENGTH = 12, 100
"""Largest numbers of words, and of characters, of a change request that counts as a single requirement."""


class Requirement(Answer):
    """A single requirement of a request."""

    what: Line
    """In the words of the request."""
    importance: Annotated[int, Field(ge=1, le=5)] = 3
    optional: bool = False
    """Whether it is wished only if it is possible."""

    @property
    def needed(self) -> float:
        """Smallest mark of an accepted case."""
        return 0.5 if self.optional else 1.0


class ExtractedRequirements(Answer):
    """The requirements of a request, as answered by a model."""

    requirements: Annotated[dict[Name, Requirement], Field(max_length=MAX_REQUIREMENTS)]


class MissingRequirements(Answer):
    """Requirements that a list omits."""

    missing: Annotated[dict[Name, Requirement], Field(max_length=MAX_REQUIREMENTS)] = {}


Requirements = Mapping[str, Requirement]


def extract_requirements(chat: Conversation, text: str, images: tuple[Image, ...] = ()) -> dict[str, Requirement]:
    """Have a model list the requirements of a request, and another check for omissions.

    Args:
        chat: The conversation with the models.
        text: The request.
        images: Pictures that belong to the request.

    Returns:
        Requirements by name; empty if no answer was usable.

    Raises:
        StoppedError: If the user stopped it.
    """
    reader = ROLES["reader"]

    def some(answer: ExtractedRequirements) -> None:
        if not answer.requirements:
            raise Wrong(["/requirements: every request asks for something"])

    try:
        question = render("apart_ask", request=text, found="")
        found = chat.ask(
            "reader", system_prompt(reader), question, typed_parser(ExtractedRequirements, some), images
        ).requirements
        question = render("apart_ask", request=text, found=requirement_rows(found))
        more = chat.ask(
            "reader", system_prompt(reader, "missing"), question, typed_parser(MissingRequirements), images
        ).missing
    except StoppedError:
        raise
    except (RoleFailed, ModelError):
        return {}  # an unreachable model is reported by the next question
    for name, requirement in list(more.items())[: MAX_REQUIREMENTS - len(found)]:
        found[name if name not in found else f"{name}_too"] = requirement
    return found


def requirements_of_change(text: str, extract: Callable[[], dict[str, Requirement]]) -> dict[str, Requirement]:
    """Return the requirements of a change request; a short one is its own requirement."""
    if len(text.split()) <= SHORT_WISH and len(text) <= SHORT_WISH_LENGTH:  # some scripts have no spaces
        return {"wish": Requirement(what=text, importance=5)}
    return extract()


def requirement_rows(requirements: Requirements) -> str:
    """Return one row for each requirement."""
    return "\n".join(requirement_row(name, one) for name, one in requirements.items())


def requirement_row(name: str, one: Requirement) -> str:
    """Return a requirement as a row of a list, with its importance."""
    return f"- `{name}` ({one.importance}{', optional' if one.optional else ''}): {one.what}"


def weighted_score(requirements: Requirements, marks: Mapping[str, Any]) -> float:
    """Return the score, 0 to 100: the mean of the marks (0, 1/2, 1), weighted by importance."""
    whole = sum(one.importance for one in requirements.values())
    return round(100 * sum(one.importance * marks.get(name, 0.0) for name, one in requirements.items()) / whole, 1)
