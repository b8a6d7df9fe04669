"""Repair of an attempt before its run: owners of sections fix what the check finds."""

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from text2sim.agents import revising
from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import Examination, examine, format_problem, owner_of
from text2sim.agents.attempt import Attempt
from text2sim.agents.replies import SECTIONS
from text2sim.agents.writer_team import Workshop
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.errors import Problem

MAX_REPAIRS = 3
"""Number of repairs by owners before the Planner is asked."""
REPAIR_INSTRUCTION = (
    "Mend what the check found in your section, and change nothing else. What is intended is waived by "
    "`patch: []` with `why: …`."
)
WARNINGS_INSTRUCTION = (
    "These are warnings: the case can be run as it is. Fix what is really wrong, and change nothing else; answer "
    "`patch: []` with `why: …` if all of it is intended."
)

LEFT_OUT_INSTRUCTION = (
    "Make this change again in a way that the check accepts, or answer `patch: []` with `why: …` to leave it."
)
MIN_REASON_LENGTH = 10
"""Shortest reason that a case may give for a waiver [characters]."""
MAX_QUOTED_CHANGES = 12
"""Largest number of changes of a Writer that are quoted to it."""

WarningKey = tuple[str, str, frozenset[str]]
"""Subject of a warning: its rule and path, or for a camera its rule and the names in its message."""


class Mending:
    """Sends the findings of the check to the owners of the sections concerned.

    Args:
        workshop: The owners, with the plan and its contract.
    """

    def __init__(self, workshop: Workshop) -> None:
        self.workshop, self.path, self.emit = workshop, workshop.path, workshop.emit
        self._warned: set[WarningKey] = set()
        """Warnings that owners were told of."""
        self._meant: dict[WarningKey, str] = {}
        """Owners' reasons for intended warnings."""

    @property
    def agreement(self) -> Agreement:
        """The plan and its contract."""
        return self.workshop.agreement

    def inherit(self, warnings: Sequence[Problem]) -> None:
        """Accept the warnings that an existing case has before any change."""
        self._meant |= {_key_of(problem): "it was there before" for problem in warnings}

    def intended(self, warnings: Sequence[Problem]) -> dict[tuple[str, str], str]:
        """Return the owners' reasons for intended warnings, by rule and path."""
        return {(p.rule, p.path): self._meant[_key_of(p)] for p in warnings if _key_of(p) in self._meant}

    def check(self, attempt: Attempt) -> tuple[Examination, list[str]]:
        """Check an attempt and send its errors to their owners, a few times; return those that remain."""
        referrals: dict[str, list[str]] = {}
        for mend in range(MAX_REPAIRS + 1):
            examined = examine(attempt.text, self.path)
            self.workshop.derived = examined.derived or self.workshop.derived
            errors = examined.errors or self.agreement.breaches(examined)
            if not errors and not referrals:
                return examined, []
            owners = self._owners(errors, referrals)
            if mend == MAX_REPAIRS or "plan" in owners:
                self.workshop.referred += [row for rows in referrals.values() for row in rows]
                return examined, [format_problem(problem) for problem in errors]
            self.emit("mending", number=attempt.number, problems=[format_problem(problem) for problem in errors][:20])
            before = attempt.text
            attempt.text, referrals = self.workshop.fix_sections(before, owners, REPAIR_INSTRUCTION)
            self.workshop.referred += [*referrals.pop("plan", []), *self.workshop.refusals()]
            attempt.text = revising.with_waivers(attempt.text, self._owners_reasons(errors))
            if attempt.text == before and not referrals:  # the same question would get the same answer
                return examined, [format_problem(problem) for problem in errors]
        raise AssertionError("the last round returns")

    def consider_warnings(
        self, attempt: Attempt, examined: Examination, known: Collection[str]
    ) -> tuple[Examination, list[str]]:
        """Give owners one chance to fix the lint's warnings, which is cheaper before a run than after it.

        Args:
            attempt: An attempt without errors; it gets the repaired text.
            examined: Result of its check.
            known: Rules to ignore.

        Returns:
            The result of the check afterwards, and the warnings about the plan.
        """
        known_keys = {*self._warned, *self._meant}
        fresh = [p for p in examined.warnings if _key_of(p) not in known_keys and p.rule not in known]
        self._warned |= {_key_of(p) for p in fresh}
        owners = self._owners(fresh, {})
        doubts = [
            format_problem(p)
            for p in fresh
            if owner_of(p, self.agreement.pointers) == "plan" and "/actions/" in p.path and not self._has_to_stay(p)
        ]
        owners.pop("plan", None)
        if owners:
            self.emit("mending", number=attempt.number, problems=[format_problem(problem) for problem in fresh][:20])
            text, referred = self.workshop.fix_sections(
                attempt.text, owners, f"{WARNINGS_INSTRUCTION}\n\nLeft: {self.workshop.left()}"
            )
            said_so = {p: self.workshop.unchanged.get(owner_of(p, self.agreement.pointers)) for p in fresh}
            self._meant |= {_key_of(p): why for p, why in said_so.items() if why is not None}
            text = self.workshop.pass_on(text, referred)
            if text != attempt.text:
                examined = self.adopt(attempt, text) or examined
        return examined, doubts

    def _owners_reasons(self, errors: Sequence[Problem]) -> dict[str, str]:
        """Reasons why owners left errors of the lint as they are, by rule and place; only rules can be waived."""
        from text2sim.lint import waiver_of
        from text2sim.lint.rules import find_rule

        found = [(p, self.workshop.unchanged.get(owner_of(p, self.agreement.pointers), "")) for p in errors]
        return {waiver_of(p): why for p, why in found if len(why) >= MIN_REASON_LENGTH and find_rule(p.rule)}

    def _has_to_stay(self, problem: Problem) -> bool:
        """Whether a measure never changes, and all that is expected of it is planned to hold from the start."""
        if problem.rule != "dead-measure":
            return False
        plan, name = self.agreement.plan, problem.path.split("/")[3]
        users = [key for key, row in plan.checks.expect.items() if row.get("measure") == name]
        return bool(users) and set(users) <= set(plan.keeps)

    def adopt(self, attempt: Attempt, text: str, base: str | None = None) -> Examination | None:
        """Adopt the changed sections of a text that hold together; those that do not go back to their Writers, once.

        Args:
            attempt: The attempt that gets the text.
            text: The text, with sections that several Writers may have changed.
            base: The text before they did; by default that of the attempt.

        Returns:
            The result of the check of what was adopted; None if the text before has errors, too, and so nothing was.
        """
        base = attempt.text if base is None else base
        kept, adopted = self._hold_together(base, text)
        if left_out := {name: data for name, data in sections_changed(base, text).items() if name not in kept}:
            now = base if adopted is None else adopted.text
            owners = {name: self._why_left_out(now, name, data) for name, data in left_out.items()}
            self.emit("mending", number=attempt.number, problems=[row for rows in owners.values() for row in rows][:20])
            again, referred = self.workshop.fix_sections(now, owners, LEFT_OUT_INSTRUCTION)
            self.workshop.referred += [row for rows in referred.values() for row in rows]
            kept, case = self._hold_together(now, again)
            adopted = case or adopted
            for name, data in sections_changed(now, again).items():
                if name not in kept:
                    self.workshop.referred.append(f"{name}: {'; '.join(self._why_left_out(now, name, data))}")
        if adopted is not None:
            attempt.text = adopted.text
        return adopted

    def _hold_together(self, base: str, text: str) -> tuple[Collection[str], Examination | None]:
        """The changed sections that can be put into a text together (perhaps none), and the check of that."""
        changed = sections_changed(base, text)

        def attempt(names: Sequence[str]) -> Examination | None:
            examined = examine(revising.with_sections(base, {name: changed[name] for name in names}), self.path)
            return None if examined.errors or self.agreement.breaches(examined) else examined

        return revising.most_that_hold(changed, attempt) or ((), attempt(()))

    def _why_left_out(self, text: str, section: str, data: dict[str, Any]) -> list[str]:
        """What a Writer changed in its section, and what the check finds of that."""
        changed = revising.with_sections(text, {section: data})
        examined = examine(changed, self.path)
        errors = examined.errors or self.agreement.breaches(examined)
        changes = "; ".join(revising.change_lines(text, changed)[:MAX_QUOTED_CHANGES])
        return [f"your change ({changes}) was left out, because of what follows", *map(format_problem, errors)]

    def _owners(self, errors: Sequence[Problem], referrals: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
        owners: dict[str, list[str]] = {name: list(rows) for name, rows in referrals.items()}
        for problem in errors:
            owners.setdefault(owner_of(problem, self.agreement.pointers), []).append(format_problem(problem))
        return owners


def sections_changed(before: str, after: str) -> dict[str, dict[str, Any]]:
    """Return the sections that differ between two texts of a case, as they are afterwards."""
    old, new = revising.data_of(before), revising.data_of(after)
    return {name: revising.mapping(new, name) for name in SECTIONS if not same(old.get(name), new.get(name))}


def _key_of(problem: Problem) -> WarningKey:
    """Subject of a warning; the same for all cameras that do not see a body."""
    film, steps = problem.path.startswith("/render/cameras"), problem.path.split("/")
    names = frozenset(re.findall(r"`([^`]+)`", problem.message))
    return problem.rule, "" if film else problem.path, names - set(steps) if film else frozenset()
