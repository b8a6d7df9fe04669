"""Requirements of a request, one at a time: taken apart before anything is built, marked by the Critic at the end.

A list that nobody can make leaves the judgement to expectations and verdict alone; it stops no loop.
"""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from text2sim.agents.conversation import Conversation, RoleFailed, Wrong, typed
from text2sim.agents.models.exchange import Image, ModelError, StoppedError
from text2sim.agents.replies import Answer, Line, Name
from text2sim.agents.roles import ROLES, render, system_prompt

Sort = Literal["objects", "count", "appearance", "relation", "actuation", "action", "order", "final", "never", "other"]
MOST = 24
SHORT_WISH = 12
"""Words of a wish about a case that is one requirement by itself."""


class Requirement(Answer):
    """One thing that a request asks for."""

    what: Line
    """As the request says it."""
    sort: Sort = "other"
    importance: Annotated[int, Field(ge=1, le=5)] = 3


class Apart(Answer):
    """A request, taken apart."""

    requirements: Annotated[dict[Name, Requirement], Field(max_length=MOST)]


class Missing(Answer):
    """What a list of requirements leaves out."""

    missing: Annotated[dict[Name, Requirement], Field(max_length=MOST)] = {}


Requirements = Mapping[str, Requirement]


def take_apart(desk: Conversation, text: str, images: tuple[Image, ...] = ()) -> dict[str, Requirement]:
    """Have a request taken apart, and have somebody look for what was left out.

    Returns:
        Requirements by name; none if nobody could do it.
    """
    reader = ROLES["reader"]

    def some(answer: Apart) -> None:
        if not answer.requirements:
            raise Wrong(["/requirements: every request asks for something"])

    try:
        question = render("apart_ask", request=text, found="")
        found = desk.ask("reader", system_prompt(reader), question, typed(Apart, some), images).requirements
        question = render("apart_ask", request=text, found=rows(found))
        more = desk.ask("reader", system_prompt(reader, "missing"), question, typed(Missing)).missing
    except StoppedError:
        raise
    except (RoleFailed, ModelError):
        return {}  # if nobody can be reached, the next question says so
    for name, requirement in list(more.items())[: MOST - len(found)]:
        found[name if name not in found else f"{name}_too"] = requirement
    return found


def of_wish(text: str, apart: Callable[[], dict[str, Requirement]]) -> dict[str, Requirement]:
    """Return the requirements of a wish about a case: a short one is its own."""
    if len(text.split()) <= SHORT_WISH:
        return {"wish": Requirement(what=text, importance=5)}
    return apart()


def rows(requirements: Requirements) -> str:
    """A line for each requirement."""
    return "\n".join(f"- `{name}` ({one.importance}): {one.what}" for name, one in requirements.items())


def score(requirements: Requirements, marks: Mapping[str, Any]) -> float:
    """Return 0 to 100: the marks (0, 1/2, 1), weighed by importance."""
    whole = sum(one.importance for one in requirements.values())
    return round(100 * sum(one.importance * marks.get(name, 0.0) for name, one in requirements.items()) / whole, 1)
