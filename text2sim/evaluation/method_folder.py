"""Method folders: a method's results, one folder for each prompt of a suite, as read by judges, tables and studies.

METHOD/method.json                the method and the suite
METHOD/<prompt id>/result.json    the result (`CaseResult`); paths in it are relative to this folder
METHOD/<prompt id>/prompt.txt     the prompt that it answers
METHOD/<prompt id>/…              other files: film, case or program, run folder, calls

A folder from another tool may lack `result.json`: then film and program are searched for (`discover_result`), and
their cost is unknown.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints

from text2sim.evaluation.documents import read_model
from text2sim.spec_schema.errors import Problem, RunError, SpecError
from text2sim.spec_schema.models.base import Model, Name, Noun
from text2sim.spec_schema.whole_files import write_json

RESULT, METHOD = "result.json", "method.json"
FILM, CASE, PROMPT_FILE = "film.mp4", "case.yaml", "prompt.txt"
_ID = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,47}$")

MethodName = Annotated[
    str,
    StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,47}$"),
    Noun("a method's name", "methods' names", "letters, digits, `-`, `_` or `.`, at most 48 in all"),
]
RelativePath = Annotated[str, StringConstraints(min_length=1, max_length=1000)]
Amount = Annotated[float, Field(ge=0)]
Number = Annotated[int, Field(ge=0)]


class Resources(Model):
    """Resources used by model calls."""

    calls: Number = 0
    tokens_in: Number = 0
    tokens_out: Number = 0
    tokens_cached: Number = 0
    """Part of `tokens_in` that a prompt cache can serve."""
    cost: Amount | None = None
    """Cost [US$]; None if it is unknown."""
    seconds: Amount = 0.0
    """Time that models took to answer [s]."""

    def __add__(self, other: "Resources") -> "Resources":
        cost = None if self.cost is None and other.cost is None else (self.cost or 0.0) + (other.cost or 0.0)
        rows = {name: getattr(self, name) + getattr(other, name) for name in type(self).model_fields if name != "cost"}
        return Resources(**rows, cost=cost)


class CaseResult(Model):
    """Result of a method for one prompt."""

    format: Literal[1] = 1
    prompt: Name
    """Its id in the suite."""
    status: Literal["finished", "failed", "unknown"]
    """`finished`: there is something to judge; `failed`: there is nothing; `unknown`: not reported."""
    accepted: bool | None = None
    """The method's own verdict, if it gives one."""
    why: Annotated[str, StringConstraints(max_length=4000)] = ""
    """Why it failed, or was not accepted."""
    film: RelativePath | None = None
    program: RelativePath | None = None
    """The case (`.yaml`), or the program."""
    run: RelativePath | None = None
    """Run folder of text2sim, with recorded states and evidence."""
    log: RelativePath | None = None
    """Output of the program, if there is no run folder."""
    roles: dict[str, Resources] | None = None
    """Resources used by models, by role; None if they were not counted."""
    attempts: Number | None = None
    """Number of versions."""
    wall_s: Amount | None = None
    """Wall time from the prompt to the end [s]."""
    simulation_s: Amount | None = None
    """Part of `wall_s` in which simulations ran and the film was rendered [s]."""

    @property
    def total(self) -> Resources | None:
        """Resources used by all models."""
        return None if self.roles is None else sum(self.roles.values(), Resources())


class MethodRecord(Model):
    """Record of the method and suite of a folder."""

    format: Literal[1] = 1
    name: MethodName
    suite: Annotated[str, StringConstraints(max_length=200)]
    """The suite's name."""
    digest: Annotated[str, StringConstraints(max_length=64)] = ""
    """Digest of the suite's prompts (`Suite.prompts_digest`)."""
    made_by: dict[str, Any] = {}
    """Method, models, budget and version of text2sim."""


@dataclass(frozen=True)
class PromptResult:
    """The result for a prompt, with its folder."""

    folder: Path
    result: CaseResult
    problems: tuple[Problem, ...] = ()
    """Faults of the folder; what can be read is judged all the same."""

    def path(self, name: Literal["film", "program", "run", "log"]) -> Path | None:
        """Return the path of a part of the result; None if it is missing or outside of the folder."""
        path = getattr(self.result, name)
        found = self.folder / path if path else None
        if found is None or not found.resolve().is_relative_to(self.folder.resolve()):
            return None
        return found if (found.is_dir() if name == "run" else found.is_file()) else None

    @property
    def empty(self) -> bool:
        """Whether there is nothing to judge."""
        return not any(self.path(name) for name in ("film", "program", "run"))


@dataclass(frozen=True)
class MethodFolder:
    """A method and its results for the prompts of a suite."""

    folder: Path
    record: MethodRecord
    made: Mapping[str, PromptResult] = field(default_factory=dict)
    """Results by prompt; prompts without a folder are missing."""

    @property
    def name(self) -> str:
        """The method's name."""
        return self.record.name


def read_method(folder: Path) -> MethodFolder:
    """Read a method folder; faults of single results are stored with them.

    Raises:
        RunError: If there is no such folder, or it is empty.
        SpecError: If its `method.json` is invalid.
    """
    if not folder.is_dir():
        raise RunError(f"{folder}: there is no such method folder")
    if (folder / METHOD).is_file():
        record, _ = read_model(folder / METHOD, MethodRecord, "a method's record")
    else:
        record = MethodRecord(name=folder.resolve().name, suite="")
    made = {path.name: read_made(path) for path in sorted(folder.iterdir()) if path.is_dir() and _ID.match(path.name)}
    if not made:
        raise RunError(f"{folder}: this method folder has no results")
    return MethodFolder(folder, record, made)


def read_made(folder: Path) -> PromptResult:
    """Read the result for a prompt; never raises, because no result may be dropped silently."""
    if not (folder / RESULT).is_file():
        problem = Problem("", f"there is no {RESULT}, so its cost is unknown", file=str(folder), rule="no-record")
        return PromptResult(folder, discover_result(folder), (problem,))
    try:
        result, document = read_model(folder / RESULT, CaseResult, "a result")
    except SpecError as error:
        return PromptResult(folder, discover_result(folder), tuple(error.problems))
    prompt_result = PromptResult(folder, result)
    missing = [
        name for name in ("film", "program", "run", "log") if getattr(result, name) and not prompt_result.path(name)
    ]
    problems = [document.problem((name,), "there is no such file in the folder", rule="no-file") for name in missing]
    return PromptResult(folder, result, tuple(problems))


def discover_result(folder: Path) -> CaseResult:
    """Return the result found in a folder without `result.json`."""
    found: dict[str, str] = {}
    programs = sorted(path.name for path in folder.glob("*.py"))
    films = sorted(path.name for path in folder.glob("*.mp4"))
    for name, files in (
        ("film", [FILM] if FILM in films else films),
        ("program", [CASE] if (folder / CASE).is_file() else programs[:1]),
        ("log", ["log.txt"] if (folder / "log.txt").is_file() else []),
        ("run", ["run"] if (folder / "run" / "run.json").is_file() else []),
    ):
        if files:
            found[name] = files[0]
    return CaseResult.model_validate({"prompt": folder.name, "status": "unknown", **found})


def resources_of(spent: Mapping[str, Any]) -> Resources:
    """Convert an account of the agents (`Spent`) to the resources of a result."""
    known = spent["cost"] > 0 or not spent["unpriced"]
    return Resources(
        calls=spent["calls"] + spent["cached"], tokens_in=spent["tokens_in"], tokens_out=spent["tokens_out"],
        tokens_cached=spent["again"], cost=spent["cost"] if known else None, seconds=spent["seconds"],
    )  # fmt: skip


def write_result(folder: Path, result: CaseResult) -> None:
    """Write the result for a prompt."""
    write_json(folder / RESULT, result.model_dump(mode="json"))


def write_method(folder: Path, record: MethodRecord) -> None:
    """Write the record of a method folder."""
    write_json(folder / METHOD, record.model_dump(mode="json"))
