"""Models of Debug Cards: lessons from reproduced failures and their tested repairs."""

from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints, model_validator

from text2sim.spec_schema.models.base import Model, Noun

Mode = Literal["rigid", "articulated", "soft", "cloth", "rope", "granular", "liquid", "snow", "driven", "film"]
"""Physical mode of a simulation."""
Role = Literal["planner", "scene", "bodies", "actions", "render", "critic", "articulation", "mesh"]
"""Reader of a card: the writer of a section, or another role in the making of a case."""

MAX_TOKENS = 350
"""Largest size of a card, which adds to the cost of every call that it is attached to."""
MAX_INDEX_TOKENS = 30
"""Largest size of the line of a card in the index."""
CHARACTERS_PER_TOKEN = 4.0
"""Mean of plain English; common tokenisers differ from it by about a tenth."""

CardId = Annotated[
    str,
    StringConstraints(pattern=r"^[a-z][a-z0-9]*(-[a-z0-9]+)*$", max_length=48),
    Noun("a card's id", "cards' ids", "lower case words with hyphens, such as `ball-without-bounce`"),
]
Line = Annotated[str, StringConstraints(min_length=3, max_length=300)]
Word = Annotated[str, StringConstraints(min_length=2, max_length=40)]
Outcome = Annotated[
    str,
    StringConstraints(pattern=r"^(passed|suspicion|state:diverged|lint:[a-z][a-z0-9-]*|missed:[A-Za-z][A-Za-z0-9_]*)$"),
    Noun("an outcome", "outcomes", "`lint:RULE`, `state:diverged`, `missed:EXPECTATION`, `suspicion` or `passed`"),
]
"""Outcome of checking and running a case. `lint:RULE`: the lint reports this rule. `state:diverged`: the run stops as
diverged. `missed:NAME`: the run finishes, and misses this expectation. `suspicion`: the run finishes, and its evidence
reports that something looks wrong. `passed`: the run finishes, and meets all expectations."""


class Applies(Model):
    """Circumstances to which a card applies."""

    modes: Annotated[list[Mode], Field(min_length=1, max_length=5)]
    """Physical modes of the scene."""
    tags: Annotated[list[Word], Field(max_length=10)] = []
    """Topics of the task: `throw`, `stack`, `gripper`."""
    signatures: Annotated[list[Word], Field(max_length=6)] = []
    """Signs of the failure: ids of lint rules, `diverged`, words of the evidence such as `measure never crosses`."""
    roles: Annotated[list[Role], Field(min_length=1, max_length=5)]
    """Roles that need it."""


class CardFinding(Model):
    """Result of one of the two cases."""

    outcome: Outcome
    """Outcome in the form that `text2sim cards verify` compares with a run."""
    observed: Line
    """Observation, with numbers."""


class Experience(Model):
    """Source of the lesson: two cases, `failing.yaml` and `repaired.yaml` beside the card."""

    case: Line
    """The scene, in words."""
    failing: CardFinding
    repaired: CardFinding
    measured_on: Annotated[dict[Word, Word], Field(min_length=1, max_length=5)]
    """Versions of the packages that ran it."""

    @model_validator(mode="after")
    def _a_failure_and_a_repair(self) -> "Experience":
        if self.failing.outcome == "passed":
            raise ValueError("the failing case must not have passed")
        if self.repaired.outcome != "passed":
            raise ValueError("the repaired case must have passed")
        return self


class Card(Model):
    """A Debug Card."""

    id: CardId
    """Its name, which is also that of its folder."""
    title: Annotated[str, StringConstraints(min_length=10, max_length=80)]
    """The lesson in a few words."""
    applies: Applies
    symptoms: Annotated[list[Line], Field(min_length=1, max_length=4)]
    """Observations in a run with this failure."""
    likely_causes: Annotated[list[Line], Field(min_length=1, max_length=4)]
    """Causes of the failure."""
    checks: Annotated[list[Line], Field(max_length=4)] = []
    """Distinctions from similar failures."""
    repair: Annotated[list[Line], Field(min_length=1, max_length=4)]
    """Changes that repair it, the best first."""
    forbidden: Annotated[list[Line], Field(max_length=4)] = []
    """Shortcuts that only hide the failure."""
    evidence: Experience

    @model_validator(mode="after")
    def _affordable(self) -> "Card":
        if (tokens := count_tokens(self.brief())) > MAX_TOKENS:
            raise ValueError(f"a card has at most {MAX_TOKENS} tokens (this one about {tokens}): say it in fewer words")
        return self

    def brief(self, role: Role | None = None) -> str:
        """Return the text for a prompt.

        Args:
            role: The reader. Planner and Critic, who have to find the cause, get the whole card, as does an
                unknown reader; writers get symptoms, causes, repair and shortcuts.
        """
        seen = self.evidence
        whole = role in (None, "planner", "critic")
        rows = [f"[{self.id}] {self.title}"]
        rows += _row("symptoms", self.symptoms)
        rows += _row("causes", self.likely_causes)
        rows += _row("tell by", self.checks) if whole else []
        rows += _row("repair", self.repair)
        rows += _row("never", self.forbidden)
        if whole:
            rows += _row("seen", [f"{seen.case}: {seen.failing.observed}; repaired: {seen.repaired.observed}"])
        return "\n".join(rows)

    def index_line(self) -> str:
        """Return the card in one line: id, title, roles, and as many signatures as its length allows."""
        line = f"{self.id}: {self.title} [{', '.join(self.applies.roles)}]"
        shown: list[str] = []
        for signature in self.applies.signatures:
            if count_tokens(f"{line} {{{'; '.join([*shown, signature])}}}") > MAX_INDEX_TOKENS:
                break
            shown.append(signature)
        return f"{line} {{{'; '.join(shown)}}}" if shown else line


def count_tokens(text: str) -> int:
    """Estimate the number of tokens in a text, without a tokeniser."""
    return -int(-len(text) // CHARACTERS_PER_TOKEN)


def card_schema() -> dict[str, Any]:
    """Return the JSON Schema of a card for a prompt, without titles and references."""
    schema = Card.model_json_schema()
    return _inlined({key: value for key, value in schema.items() if key != "$defs"}, schema.get("$defs", {}))


def _row(name: str, items: list[str]) -> list[str]:
    return [f"{name}: {' | '.join(items)}"] if items else []


def _inlined(node: Any, definitions: dict[str, Any], *, names: bool = False) -> Any:
    """A part of a schema without references; `names` means that its keys are names of fields."""
    if isinstance(node, list):
        return [_inlined(item, definitions) for item in node]
    if not isinstance(node, dict):
        return node
    if "$ref" in node:
        return _inlined(definitions[node["$ref"].rpartition("/")[2]], definitions)
    kept = {key: value for key, value in node.items() if names or key not in ("title", "description", "default")}
    return {key: _inlined(value, definitions, names=key == "properties") for key, value in kept.items()}
