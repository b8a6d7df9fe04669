"""Report of the lint: what is wrong, and what is wrong and meant."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from text2sim.spec_schema.errors import Problem, nearest, sort_problems
from text2sim.spec_schema.loaded import LoadedCase


@dataclass(frozen=True)
class Waived:
    """A finding that the case says is meant."""

    problem: Problem
    reason: str
    """Why it is meant, in the author's words."""

    def as_dict(self) -> dict[str, Any]:
        """Return the finding as plain data, for machines."""
        return {"rule": self.problem.rule, "path": self.problem.path, "reason": self.reason, **asdict(self.problem)}


@dataclass(frozen=True)
class LintReport:
    """Findings in the order of the file."""

    problems: list[Problem] = field(default_factory=list)
    """What is wrong; an error among them keeps the case from running."""
    waived: list[Waived] = field(default_factory=list)
    """What is meant."""
    held: list[str] = field(default_factory=list)
    """Expectations that would hold if nothing moved."""
    seconds: float = 0.0
    """Wall time that a run takes on two idle cores; 0 if that is not known."""

    @property
    def ok(self) -> bool:
        """Whether nothing keeps the case from running."""
        return all(problem.severity != "error" for problem in self.problems)


def sift(loaded: LoadedCase, found: Iterable[Problem], known: Iterable[str]) -> LintReport:
    """Divide findings into those that the case waives and the rest.

    Args:
        loaded: The case, with its `waive`.
        found: All findings.
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
    idle = set(reasons) - {one.problem.rule for one in waived}
    for rule in reasons:
        if rule not in known:
            message = f"there is no rule `{rule}` that could be waived; `text2sim check --rules` lists them"
            hint = nearest(rule, known)
            problems.append(loaded.problem(("waive", rule), message, key=True, rule="unknown-rule", hint=hint))
        elif rule in idle:
            message = f"`{rule}` finds nothing here: the waiver can go"
            problems.append(
                loaded.problem(("waive", rule), message, key=True, rule="unused-waiver", severity="warning")
            )
    return LintReport(sort_problems(problems), waived)
