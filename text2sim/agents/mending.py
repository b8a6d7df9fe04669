"""Mending of what the check finds in an attempt, by the owners of the sections, before it is run."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import Examination, examine, owner_of, said
from text2sim.agents.attempts import Attempt
from text2sim.agents.journal import Emit
from text2sim.agents.writer_team import Workshop
from text2sim.spec_schema.errors import Problem

MENDS = 3
"""Times that owners may mend what the check finds, before it is the Planner's turn."""
MEND = "Mend what the check found in your section, and change nothing else."
CONSIDER = (
    "These are warnings: it can be run as it is. Mend what is true of them, and change nothing else; answer "
    "`patch: []` if all of it is meant."
)


class Mending:
    """Sends the findings of the check to those whose sections they are about.

    Args:
        workshop: The owners.
        agreement: What the case has to keep to.
        path: The case's file.
        emit: Callback for journal events.
    """

    def __init__(self, workshop: Workshop, agreement: Agreement, path: Path, emit: Emit) -> None:
        self.workshop, self.agreement, self.path, self.emit = workshop, agreement, path, emit
        self._warned: set[tuple[str, str]] = set()
        """Warnings that owners were told of, by rule and path."""

    def checked(self, attempt: Attempt) -> tuple[Examination, list[str]]:
        """Check an attempt and send its errors to their owners, a few times; return those that remain."""
        told: dict[str, list[str]] = {}
        for mend in range(MENDS + 1):
            examined = examine(attempt.text, self.path)
            self.workshop.derived = examined.derived or self.workshop.derived
            errors = examined.errors or self.agreement.breaches(examined)
            if not errors and not told:
                return examined, []
            owners = self._owners(errors, told)
            if mend == MENDS or "plan" in owners:
                self.workshop.referred += [row for rows in told.values() for row in rows]
                return examined, [said(one) for one in errors]
            self.emit("mending", number=attempt.number, problems=[said(problem) for problem in errors][:20])
            before = attempt.text
            attempt.text, told = self.workshop.fixed(before, owners, MEND)
            self.workshop.referred += told.pop("plan", [])
            if attempt.text == before and not told:  # asking the same again would give the same answers
                return examined, [said(one) for one in errors]
        raise AssertionError("the last round returns")

    def considered(
        self, attempt: Attempt, examined: Examination, known: Collection[str]
    ) -> tuple[Examination, list[str]]:
        """Give owners one chance to fix the lint's warnings: that is cheaper before a run than after it.

        Args:
            attempt: An attempt without errors; its text becomes what they make of it.
            examined: What the check found in it.
            known: Rules that they need not be told of.

        Returns:
            What the check finds afterwards, and the warnings that are about the plan.
        """
        fresh = [p for p in examined.warnings if (p.rule, p.path) not in self._warned and p.rule not in known]
        self._warned |= {(p.rule, p.path) for p in fresh}
        owners = self._owners(fresh, {})
        doubts = [said(p) for p in fresh if owner_of(p, self.agreement.pointers) == "plan" and "/actions/" in p.path]
        owners.pop("plan", None)
        if owners:
            self.emit("mending", number=attempt.number, problems=[said(problem) for problem in fresh][:20])
            text = self.workshop.passed_on(*self.workshop.fixed(attempt.text, owners, CONSIDER))
            examined = self.taken(attempt, text, examined)
        return examined, doubts

    def taken(self, attempt: Attempt, text: str, before: Examination) -> Examination:
        """Adopt a repaired text, unless it is worse; return what the check finds in what is kept.

        Args:
            attempt: The attempt that gets the text.
            text: The repaired text.
            before: What the check found in its present text.
        """
        found = examine(text, self.path)
        if found.errors or self.agreement.breaches(found):
            return before
        attempt.text = text
        return found

    def _owners(self, errors: Sequence[Problem], told: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
        owners: dict[str, list[str]] = {name: list(rows) for name, rows in told.items()}
        for problem in errors:
            owners.setdefault(owner_of(problem, self.agreement.pointers), []).append(said(problem))
        return owners
