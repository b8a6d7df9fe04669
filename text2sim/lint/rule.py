"""Rules of the lint: a row with everything that is said about one, and the function that finds it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from text2sim.spec_schema.errors import Problem, Severity

if TYPE_CHECKING:
    from text2sim.lint.facts import Facts

SEVERITIES: dict[str, Severity] = {}
"""What the findings of each rule are, by its id: rules enter themselves."""


@dataclass(frozen=True)
class Rule:
    """One thing that goes wrong in simulations, and that a case shows before it runs."""

    id: str
    """Stable, in kebab case: what `waive` and `check --explain` name."""
    severity: Severity
    """What a finding is unless it says otherwise; an `error` stops a run."""
    title: str
    """What is found, in one line."""
    reason: str
    """Why it goes wrong: what the engine does, with numbers."""
    remedy: str
    """What to do."""
    example: str
    """Parts of a case, in YAML, that break the rule; `EXAMPLE_BASE` gives what they leave out."""
    run: Callable[["Facts"], Iterator[Problem]]
    """Yields the findings, made with `Facts.problem`."""
    fix: str = ""
    """What fixes the example when it is laid over it (as JSON Merge Patch has it); empty without a simple cure."""
    own_contact: bool = False
    """Whether it is about the engine's own contacts between rigid bodies: it is not asked where contact models sap and
    ipc take their place."""

    def __post_init__(self) -> None:
        SEVERITIES[self.id] = self.severity


EXAMPLE_BASE = """\
text2sim: 1
name: example
scene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}
bodies: {}
"""
"""What examples are laid over (as JSON Merge Patch has it)."""
