"""Rules of the lint: documentation, an example, and a function that reports problems."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from text2sim.spec_schema.errors import Problem, Severity

if TYPE_CHECKING:
    from text2sim.lint.facts import Facts

SEVERITIES: dict[str, Severity] = {}
"""Severity of each rule by its id; rules register themselves."""


@dataclass(frozen=True)
class Rule:
    """A fault of simulations that can be found in a case before it runs."""

    id: str
    """Stable id in kebab case, for `waive` and `check --explain`."""
    severity: Severity
    """Default severity of its problems; an `error` stops a run."""
    title: str
    """The fault, in one line."""
    reason: str
    """Why it is a fault: what the engine does, with numbers."""
    remedy: str
    """How to correct it."""
    example: str
    """Parts of a case, in YAML, that break the rule; `EXAMPLE_BASE` has the rest."""
    run: Callable[["Facts"], Iterator[Problem]]
    """Yields the problems, made with `Facts.problem`."""
    fix: str = ""
    """JSON Merge Patch that fixes the example; empty without a simple fix."""
    own_contact: bool = False
    """Whether it is about the engine's own contacts between rigid bodies, which contact models sap and ipc replace."""

    def __post_init__(self) -> None:
        SEVERITIES[self.id] = self.severity


EXAMPLE_BASE = """\
text2sim: 1
name: example
scene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}
bodies: {}
"""
"""The case to which the examples are JSON Merge Patches."""


def one_per_place(problems: Iterable[Problem]) -> Iterator[Problem]:
    """Yield one problem for each place of the case, with the number of further copies that have it."""
    places: dict[tuple[str, str], list[Problem]] = {}
    for problem in problems:
        places.setdefault((problem.rule, problem.path), []).append(problem)
    for first, *more in places.values():
        note = f" (and {len(more)} more in the same way)" if more else ""
        yield replace(first, message=first.message + note)
