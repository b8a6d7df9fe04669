"""Report of the lint: problems, and problems that the case waives."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from text2sim.spec_schema.errors import Problem, nearest, sort_problems
from text2sim.spec_schema.loaded import LoadedCase


@dataclass(frozen=True)
class Waived:
    """A problem that the case waives."""

    problem: Problem
    reason: str
    """The author's reason."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {"rule": self.problem.rule, "path": self.problem.path, "reason": self.reason, **asdict(self.problem)}


@dataclass(frozen=True)
class LintReport:
    """Problems in the order of the file."""

    problems: list[Problem] = field(default_factory=list)
    """Problems; an error prevents the case from running."""
    waived: list[Waived] = field(default_factory=list)
    """Waived problems."""
    held: list[str] = field(default_factory=list)
    """Expectations that would hold if nothing moved."""
    seconds: float = 0.0
    """Estimated wall time [s] of a run on two idle cores; 0 if it is not known."""

    @property
    def ok(self) -> bool:
        """Whether there are no errors."""
        return all(problem.severity != "error" for problem in self.problems)


def sift(loaded: LoadedCase, found: Iterable[Problem], known: Iterable[str]) -> LintReport:
    """Separate the problems that the case waives from the rest.

    Args:
        loaded: The case, with its `waive`.
        found: All problems.
        known: Ids that can be waived.
    """
    reasons: Mapping[str, str] = loaded.data.get("waive") or {}
    known = list(known)
    problems, waived = [], []
    for problem in sort_problems(found):
        if problem.rule in reasons and problem.rule in known:
            waived.append(Waived(problem, reasons[problem.rule]))
        else:
            problems.append(problem)
    idle = set(reasons) - {entry.problem.rule for entry in waived}
    for rule in reasons:
        if rule not in known:
            message = f"there is no rule `{rule}` to waive; `text2sim check --rules` lists them"
            hint = nearest(rule, known)
            problems.append(loaded.problem(("waive", rule), message, key=True, rule="unknown-rule", hint=hint))
        elif rule in idle:
            message = f"`{rule}` reports nothing here; remove the waiver"
            problem = loaded.problem(("waive", rule), message, key=True, rule="unused-waiver", severity="warning")
            problems.append(problem)
    return LintReport(sort_problems(problems), waived)
