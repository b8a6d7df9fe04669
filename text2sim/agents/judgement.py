"""Types of the Critic's answers: marks, failures, and proposed patches."""

from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, Field, StringConstraints, ValidationError, model_validator

from text2sim.agents.replies import Answer, Line, Lines, Name, Where

MAX_PATCHES = 10
"""Largest number of patches in a judgement."""

Cites = Annotated[list[Annotated[str, StringConstraints(max_length=120)]], Field(max_length=20)]


class Failure(Answer):
    """A difference between the run and the request."""

    what: Line
    cites: Cites = []
    """Evidence: `expect:`, `measure:`, `event:`, `body:` or `diagnostic:` and a name, `frame:N`, or `run`."""
    section: Where


class Patch(Answer):
    """A change to one section, or to values of parameters (`plan`), that fixes a failure."""

    section: Where
    why: Line
    operations: Annotated[list[dict[str, Any]], Field(min_length=1, max_length=100)]
    """RFC 6902, with paths from the root of the case."""


def _a_mark(value: float) -> float:
    if value not in (0, 0.5, 1):
        raise ValueError("a mark is 0, 1/2 or 1")
    return value


class Mark(Answer):
    """Mark of one requirement: 1, 1/2 or 0."""

    mark: Annotated[float, AfterValidator(_a_mark)]
    cites: Cites = []
    why: Line = ""
    """What is missing; empty if nothing is."""

    @model_validator(mode="before")
    @classmethod
    def _short(cls, data: Any) -> Any:
        """Accept a bare mark, or a list of mark, citations and reason, and any spelling of a half."""
        if not isinstance(data, dict | list):
            data = [data]
        if isinstance(data, list):
            texts = [str(row) for row in data[1:]]
            cites = [row for row in texts if row.partition(" ")[0] == row]
            data = {"mark": data[0] if data else None, "cites": cites}
            data["why"] = " ".join(row for row in texts if row not in cites)
        mark = data.get("mark")
        return data | {"mark": _MARKS.get(str(mark).strip().lower(), mark)}


_MARKS = {
    "1": 1, "1.0": 1, "yes": 1, "true": 1, "met": 1, "½": 0.5, "1/2": 0.5, "half": 0.5, "0.5": 0.5, "0": 0, "0.0": 0,
    "no": 0, "false": 0,
}  # fmt: skip


class Critique(Answer):
    """The Critic's judgement of a run."""

    seen: Line
    """Description of the pictures, in the order of time."""
    requirements: dict[Name, Mark] = {}
    """Mark of each requirement."""
    score: Annotated[float, Field(ge=0, le=100)] = 0
    """Agreement with the request; computed from the marks, if there are any."""
    verdict: Literal["pass", "repair", "cannot_judge"]
    failures: Annotated[list[Failure], Field(max_length=20)] = []
    responsible: Where | None = None
    summary: Line = ""
    """What to change, for the Planner."""
    patches: Annotated[list[Patch], Field(max_length=MAX_PATCHES)] = []
    unfaithful: Lines = []
    """Restated expectations that ask for less than the request did."""
    refused: Lines = []
    """Patches that could not be applied, and why."""

    @model_validator(mode="before")
    @classmethod
    def _slips(cls, data: Any) -> Any:
        """Ignore an unknown `responsible`, and accept synonyms of a verdict."""
        if not isinstance(data, dict):
            return data
        data = dict(data)
        if data.get("responsible") not in get_args(Where):
            data.pop("responsible", None)
        word = str(data.get("verdict", "")).strip().lower()
        return _with_usable_patches(data) | {"verdict": _VERDICTS.get(word, word)}


_VERDICTS = {"passed": "pass", "accept": "pass", "accepted": "pass", "fail": "repair", "failed": "repair",
             "cannot judge": "cannot_judge"}  # fmt: skip


class Amendment(Answer):
    """Corrected parts of a judgement."""

    requirements: dict[Name, Mark] = {}
    failures: Annotated[list[Failure], Field(max_length=20)] = []
    patches: Annotated[list[Patch], Field(max_length=MAX_PATCHES)] = []
    refused: Lines = []

    @model_validator(mode="before")
    @classmethod
    def _usable(cls, data: Any) -> Any:
        return _with_usable_patches(data) if isinstance(data, dict) else data


def _with_usable_patches(data: dict[str, Any]) -> dict[str, Any]:
    """Move malformed patches to `refused`, with the reason: they must not cost the rest of a judgement."""
    if not isinstance(rows := data.get("patches"), list):
        return data
    usable: list[Any] = []
    given = data.get("refused")
    refused = list(given) if isinstance(given, list) else []
    for number, row in enumerate(rows, 1):
        if len(usable) == MAX_PATCHES:
            refused.append(f"patch {number}: a judgement has at most {MAX_PATCHES}")
            continue
        try:
            Patch.model_validate(row)
        except ValidationError as error:
            fault = error.errors(include_url=False, include_input=False)[0]
            refused.append(f"patch {number}: /{'/'.join(map(str, fault['loc']))}: {fault['msg']}")
        else:
            usable.append(row)
    return data | {"patches": usable, "refused": refused}
