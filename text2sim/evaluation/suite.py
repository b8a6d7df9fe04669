"""Suites: prompts, each with its source and its requirements."""

import json
import re
import unicodedata
from collections.abc import Iterable, Mapping
from difflib import SequenceMatcher
from hashlib import sha256
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints

from text2sim.evaluation.documents import read_model
from text2sim.spec_schema.errors import Problem, SpecError, nearest
from text2sim.spec_schema.models.base import Model, Name
from text2sim.spec_schema.text.document import Document

BUILT_IN = Path(__file__).resolve().parent / "suites"
CATEGORIES = ("scene", "body", "action", "render")
Family = Literal["rigid", "deformable", "cloth"]
MAX_REQUIREMENTS = 12
"""Largest number of requirements of one category, and of prohibitions."""
SAME_TITLE, SAME_PROMPT = 0.9, 0.8
"""Similarity (difflib, 0 to 1) at which titles name the same source, and prompts ask for the same thing."""

Line = Annotated[str, StringConstraints(min_length=3, max_length=400, strip_whitespace=True)]
Importance = Annotated[int, Field(ge=1, le=5, strict=True)]


class PromptSource(Model):
    """The publication or demonstration that a prompt is drawn from."""

    title: Line
    authors: Line
    year: Annotated[int, Field(ge=1900, le=2100, strict=True)]
    venue: Line


class Requirement(Model):
    """A single requirement of a prompt, which can be seen or measured by itself."""

    what: Line
    importance: Importance


class Prohibition(Model):
    """Something that the prompt excludes."""

    what: Line
    weight: Importance


class Requirements(Model):
    """Requirements of a prompt by category."""

    scene: Annotated[dict[Name, Requirement], Field(min_length=1, max_length=MAX_REQUIREMENTS)]
    """Surroundings, supports, and their arrangement."""
    body: Annotated[dict[Name, Requirement], Field(min_length=1, max_length=MAX_REQUIREMENTS)]
    """Shapes, counts and materials of moving bodies."""
    action: Annotated[dict[Name, Requirement], Field(min_length=1, max_length=MAX_REQUIREMENTS)]
    """Events, their causes, order and outcome."""
    render: Annotated[dict[Name, Requirement], Field(min_length=1, max_length=MAX_REQUIREMENTS)]
    """What the film must show, and appearance."""

    def rows(self) -> dict[str, tuple[str, Requirement]]:
        """Return the category and the requirement by `category.name`."""
        return {
            f"{kind}.{name}": (kind, requirement)
            for kind in CATEGORIES
            for name, requirement in getattr(self, kind).items()
        }


class Prompt(Model):
    """One prompt of a suite."""

    family: Family
    source: PromptSource
    prompt: Annotated[str, StringConstraints(min_length=10, max_length=4000, strip_whitespace=True)]
    requirements: Requirements | None = None
    """None until they are drafted."""
    prohibitions: Annotated[dict[Name, Prohibition], Field(max_length=MAX_REQUIREMENTS)] = {}

    def digest(self) -> str:
        """Return the SHA-256 of prompt, requirements and prohibitions, which judgements depend on."""
        return _digest(self.model_dump(mode="json", include={"prompt", "requirements", "prohibitions"}))


class Suite(Model):
    """Prompts on which methods are judged."""

    text2sim_suite: Literal[1]
    """Version of the format."""
    name: Name
    frozen: Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")] | None = None
    """`digest` at the time when it was frozen."""
    prompts: Annotated[dict[Name, Prompt], Field(min_length=1, max_length=1000)]

    def digest(self) -> str:
        """Return the SHA-256 of all prompts, requirements and prohibitions."""
        return _digest({name: prompt.digest() for name, prompt in self.prompts.items()})

    def prompts_digest(self) -> str:
        """Return the SHA-256 of the prompts alone, which methods see."""
        return _digest({name: prompt.prompt for name, prompt in self.prompts.items()})


def read_suite(path: Path) -> tuple[Suite, Document]:
    """Read a suite; a plain name without folder and extension is one of those included in text2sim.

    Raises:
        SpecError: With all problems of the file, including changes after it was frozen.
    """
    if not path.suffix and len(path.parts) == 1 and (BUILT_IN / f"{path}.yaml").is_file():
        path = BUILT_IN / f"{path}.yaml"
    suite, document = read_model(path, Suite, "a suite")
    if suite.frozen is not None and suite.frozen != suite.digest():
        message = f"its prompts, requirements or prohibitions have changed since it was frozen: now {suite.digest()}"
        raise SpecError([document.problem(("frozen",), message, rule="frozen")])
    return suite, document


def check_complete(suite: Suite, document: Document) -> None:
    """Check that every prompt of a suite has requirements.

    Raises:
        SpecError: With the prompts that have no requirements.
    """
    lacking = [name for name, prompt in suite.prompts.items() if prompt.requirements is None]
    message = "it has no requirements; `text2sim evaluate draft` has them drafted"
    if lacking:
        raise SpecError([document.problem(("prompts", name), message, key=True, rule="incomplete") for name in lacking])


def shared_sources(suite: Suite, other: Suite, document: Document) -> list[Problem]:
    """Report the prompts of a suite that share a source or the wording with a prompt of another suite.

    Titles and prompts are compared without case, accents and punctuation, so that citations of one source match.

    Args:
        suite: The suite to check.
        other: The suite from which it must be disjoint.
        document: Source document of the first.
    """
    found = []
    for (name, prompt), (other_name, other_prompt) in product(suite.prompts.items(), other.prompts.items()):
        if _are_similar(_normalised(prompt.source.title), _normalised(other_prompt.source.title), SAME_TITLE):
            message = f"`{other.name}` uses this source, too, for `{other_name}`: {other_prompt.source.title}"
            place: tuple[str, ...] = ("prompts", name, "source", "title")
        elif _are_similar(_normalised(prompt.prompt), _normalised(other_prompt.prompt), SAME_PROMPT):
            message = f"`{other.name}` asks for the same in `{other_name}`"
            place = ("prompts", name, "prompt")
        else:
            continue
        found.append(document.problem(place, message, rule="shared-source"))
    return found


def select_prompts(suite: Suite, only: Iterable[str]) -> Mapping[str, Prompt]:
    """Return the prompts with these names; all, if none is named.

    Raises:
        SpecError: If a name is unknown.
    """
    wanted = list(only)
    unknown = [name for name in wanted if name not in suite.prompts]
    if unknown:
        rows = [
            Problem("", f"there is no prompt `{name[:60]}`", file=suite.name, hint=nearest(name, suite.prompts))
            for name in unknown
        ]
        raise SpecError(rows)
    return {name: prompt for name, prompt in suite.prompts.items() if not wanted or name in wanted}


def _are_similar(one: str, other: str, threshold: float) -> bool:
    """Whether two texts are similar; the quick bounds of difflib come first, because there are many pairs."""
    if one == other or (min(len(one), len(other)) > 12 and (one in other or other in one)):
        return True
    matcher = SequenceMatcher(None, one, other, autojunk=False)
    return (
        matcher.real_quick_ratio() >= threshold and matcher.quick_ratio() >= threshold and matcher.ratio() >= threshold
    )


def _normalised(text: str) -> str:
    """Letters and digits of a text, without case and accents."""
    return re.sub(r"[\W_]+", "", unicodedata.normalize("NFKD", text).casefold())


def _digest(data: Any) -> str:
    return sha256(json.dumps(data, sort_keys=True, ensure_ascii=True, allow_nan=False).encode()).hexdigest()
