"""Physics lint: faults of a simulation, found in the resolved case, without the engine.

A rule is a row of `rules.RULES`: an id, a severity, documentation, and a function that checks the `Facts` of a case. A
case can waive a rule by its id, with a reason.
"""

from dataclasses import replace

from text2sim.compiler.build import Resolution
from text2sim.lint.report import LintReport, Waived

__all__ = ["LintReport", "Waived", "lint_case"]


def lint_case(resolution: Resolution) -> LintReport:
    """Return the report on a resolved case.

    It includes the warnings of earlier stages, so that a case can waive them too.
    """
    from text2sim.lint.facts import Facts
    from text2sim.lint.report import sift
    from text2sim.lint.rules import EARLIER_RULES, RETIRED_RULES, RULES
    from text2sim.lint.script.at_rest import held_at_start
    from text2sim.lint.soft.cost import expected_wall_time

    facts = Facts(resolution)
    rules = [rule for rule in RULES if facts.own_contact or not rule.own_contact]
    found = [problem for rule in rules for problem in rule.run(facts)]
    known = [*(rule.id for rule in RULES), *EARLIER_RULES, *RETIRED_RULES]
    report = sift(resolution.loaded, [*resolution.plan.warnings, *found], known)
    return replace(report, held=held_at_start(facts), seconds=expected_wall_time(facts))
