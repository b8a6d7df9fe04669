"""Rules of the lint: documentation, an example, and a function that reports problems."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import wraps
from typing import TYPE_CHECKING

from text2sim.lint.words import more_copies
from text2sim.spec_schema.errors import Problem, Severity

if TYPE_CHECKING:
    from text2sim.lint.facts import Facts

Find = Callable[["Facts"], Iterator[Problem]]
"""Function of a rule: yields the problems of a case, made with `Facts.problem`."""

SEVERITIES: dict[str, Severity] = {}
"""Severity of each rule by its id; rules register themselves."""


@dataclass(frozen=True, kw_only=True)
class Rule:
    """A fault of simulations that can be found in a case before it runs."""

    id: str
    """Stable id in kebab case, for `waive` and `check --explain`."""
    severity: Severity = "warning"
    """Severity of its problems, unless one says another; an `error` stops a run."""
    title: str
    """The fault, in one line."""
    reason: str
    """Why it is a fault: what the engine does, with numbers."""
    remedy: str
    """How to correct it."""
    example: str
    """Parts of a case, in YAML, that break the rule; `EXAMPLE_BASE` has the rest."""
    run: Find
    """Yields its problems."""
    fix: str
    """JSON Merge Patch that fixes the example."""
    own_contact: bool = False
    """Whether it is about the engine's own contacts between rigid bodies, which contact models sap and ipc replace."""

    def __post_init__(self) -> None:
        SEVERITIES[self.id] = self.severity


EXAMPLE_BASE = """\
text2sim: 2
name: example
scene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}
bodies: {}
"""
"""The case to which the examples are JSON Merge Patches."""


def one_per_place(find: Find) -> Find:
    """Let a rule report one problem for each place of the case, with the number of further ones there."""

    @wraps(find)
    def run(facts: "Facts") -> Iterator[Problem]:
        places: dict[str, list[Problem]] = {}
        for problem in find(facts):
            places.setdefault(problem.path, []).append(problem)
        for group in places.values():
            yield replace(group[0], message=group[0].message + more_copies(len(group), "in the same way"))

    return run


def first_per_place(find: Find) -> Find:
    """Let a rule report only the first problem at each place of the case."""

    @wraps(find)
    def run(facts: "Facts") -> Iterator[Problem]:
        places: set[str] = set()
        for problem in find(facts):
            if problem.path not in places:
                places.add(problem.path)
                yield problem

    return run
