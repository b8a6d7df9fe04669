"""Physics lint: faults of a simulation, found in the resolved case, without the engine.

A rule is a row of `rules.RULES`: an id, a severity, documentation, and a function that checks the `Facts` of a case. A
case can waive a rule by its id, with a reason, at one place or everywhere.
"""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from text2sim.compiler.build import Resolution
from text2sim.spec_schema.errors import Problem, nearest, sort_problems
from text2sim.spec_schema.loaded import LoadedCase

__all__ = ["LintReport", "Waived", "lint_case", "waiver_of"]

AT = "@"
"""Mark before the place for which alone a rule is waived."""


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
    cost: str = ""
    """What makes the run of deformable bodies dear: points, substeps, and what coarser ones would save."""

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
    idle = set(reasons)
    for problem in sort_problems(found):
        fitting = [key for key in reasons if problem.rule in known and _holds_for(key, problem)]
        if fitting:
            waived.append(Waived(problem, reasons[max(fitting, key=len)]))
            idle -= set(fitting)
        else:
            problems.append(problem)
    for key in reasons:
        rule, _, place = key.partition(AT)
        if rule not in known:
            message = f"there is no rule `{rule}` to waive; `text2sim check --rules` lists them"
            hint = nearest(rule, known)
            problems.append(loaded.problem(("waive", key), message, key=True, rule="unknown-rule", hint=hint))
        elif key in idle:
            message = f"`{rule}` reports nothing {f'at `{place}`' if place else 'here'}; remove the waiver"
            problem = loaded.problem(("waive", key), message, key=True, rule="unused-waiver", severity="warning")
            problems.append(problem)
    return LintReport(sort_problems(problems), waived)


def waiver_of(problem: Problem) -> str:
    """Return the key of a waiver for a problem with what it is about: `overlap@bodies.pin`."""
    path = problem.path.strip("/").split("/")
    return AT.join([problem.rule, ".".join(path[: 2 if path[0] == "bodies" else 3])])


def _holds_for(key: str, problem: Problem) -> bool:
    rule, _, place = key.partition(AT)
    return rule == problem.rule and f"{problem.path}/".startswith(f"/{place}/".replace(".", "/") if place else "")


def lint_case(resolution: Resolution) -> LintReport:
    """Return the report on a resolved case.

    It includes the warnings of earlier stages, so that a case can waive them too.
    """
    from text2sim.lint.facts import Facts
    from text2sim.lint.rules import EARLIER_RULES, RETIRED_RULES, RULES
    from text2sim.lint.script.at_rest import held_at_start
    from text2sim.lint.soft.cost import cost, expected_wall_time

    facts = Facts(resolution)
    rules = [rule for rule in RULES if facts.own_contact or not rule.own_contact]
    found = [problem for rule in rules for problem in rule.run(facts)]
    known = [*(rule.id for rule in RULES), *EARLIER_RULES, *RETIRED_RULES]
    report = sift(resolution.loaded, [*resolution.plan.warnings, *found], known)
    return replace(report, held=held_at_start(facts), seconds=expected_wall_time(facts), cost=cost(facts))
