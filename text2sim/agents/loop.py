"""The loop: plan, write, check, run, judge, decide, until a case is accepted or nothing more may be spent."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeVar

from text2sim.agents import revising
from text2sim.agents.asking import BudgetSpent, Desk, RoleFailed
from text2sim.agents.attempts import Attempt, Attempts, changed
from text2sim.agents.brief import history_row
from text2sim.agents.casework import Examination, case_text, examine, owner_of, said
from text2sim.agents.contract import Contract
from text2sim.agents.criticism import Exhibit, criticise
from text2sim.agents.deck import Deck
from text2sim.agents.journal import Emit
from text2sim.agents.models.exchange import ModelError
from text2sim.agents.planning import Report, Request, decide, make_plan
from text2sim.agents.replies import SECTIONS, Decision, Plan, Refer, Route
from text2sim.agents.supplying import Supplies, merged, supply
from text2sim.agents.writing import change_section, write_section
from text2sim.spec_schema.errors import Problem

State = Literal["accepted", "impossible", "gave_up", "spent", "failed"]
T = TypeVar("T")

MENDS = 3
"""Times that owners may mend what the check finds, before it is the Planner's turn."""
MEND = "Mend what the check found in your section, and change nothing else."
CONSIDER = (
    "These are warnings: it can be run as it is. Mend what is true of them, and change nothing else; answer "
    "`patch: []` if all of it is meant."
)
TOGETHER = 4
"""Questions that are put at the same time."""


@dataclass(frozen=True)
class Limits:
    """What a loop may use, besides tokens, money and time."""

    attempts: int = 30
    sim_timeout: float = 3600.0
    """Wall time [s] of one simulation."""


@dataclass
class Outcome:
    """What came of it."""

    state: State
    why: str
    best: Attempt | None = None
    unresolved: list[str] = field(default_factory=list)
    plan: Plan | None = None


class Loop:
    """Works on one case.

    Args:
        case: Its folder.
        request: What is wanted.
        desk: Where roles are asked.
        deck: The Debug Cards.
        emit: Told what happens.
        limits: What may be used.
    """

    def __init__(self, case: Path, request: Request, desk: Desk, deck: Deck, emit: Emit, limits: Limits) -> None:
        self.case, self.path, self.request = case, case / "case.yaml", request
        self.desk, self.deck, self.emit, self.limits = desk, deck, emit, limits
        self.attempts = Attempts(case)
        self.made: list[Attempt] = []
        self.plan = Plan.model_construct(name=case.name)
        self.names: tuple[str, ...] = ()
        """Expectations that come from the request."""
        self.restated: list[str] = []
        self._contract: Contract | None = None
        self._warned: set[tuple[str, str]] = set()

    # --- ways in ----------------------------------------------------------------------------------------------

    def generate(self) -> Outcome:
        """Make a case from the request."""
        self.emit("stage", name="plan")
        self.plan = make_plan(self.desk, self.request, self.deck, self.path)
        self.names = tuple(self.plan.checks.expect)
        self.emit("planned", goal=self.plan.event, possible=self.plan.possible, why=self.plan.why,
                  assumptions=self.plan.assumptions, says=self.plan.says)  # fmt: skip
        if self.plan.possible == "no":
            return Outcome("impossible", self.plan.why, plan=self.plan)
        try:
            text = self._drafted()
        except RoleFailed as failed:
            return Outcome("failed", str(failed), None, [str(failed)], self.plan)
        return self.work(text, "first version")

    def work(self, text: str, cause: str) -> Outcome:
        """Bring a case to acceptance, beginning with a version of it.

        Args:
            text: The version.
            cause: Why it was made.
        """
        before = self.made[-1].text if self.made else None
        try:
            while True:
                attempt = Attempt(len(self.made) + 1, text, cause)
                attempt.changes = revising.change_lines(before, text) if before is not None else []
                self.made.append(attempt)
                self.desk.attempt = attempt.number
                report = self._try(attempt)
                if attempt.accepted:
                    return self._outcome("accepted", "the Critic passed it and everything expected came true")
                if attempt.number >= self.limits.attempts:
                    return self._outcome("spent", f"{attempt.number} attempts were made")
                decision = self._decided(attempt, report)
                if decision.action == "give_up":
                    return self._outcome("gave_up", decision.why)
                before, (text, left_out) = attempt.text, self._revised(attempt, decision)
                cause = "; ".join([decision.why, *left_out])
        except BudgetSpent as spent:
            return self._outcome("spent", str(spent))
        except (RoleFailed, ModelError) as failed:
            return self._outcome("failed", str(failed))

    # --- first version ----------------------------------------------------------------------------------------

    def _drafted(self) -> str:
        plan = self.plan
        supplies = Supplies()
        if plan.assets:
            self.emit("stage", name="assets")
            jobs = [
                lambda asset=asset: supply(self.desk, asset, plan, self.request, self.case) for asset in plan.assets
            ]
            # One after the other: they are numbered calls of the same roles.
            supplies = merged([job() for job in jobs])
        self.emit("stage", name="write")
        asked = self.request.text + "".join(f"\nGiven with it: {row}" for row in self.request.inputs)
        words = "\n".join(f"- {row}" for row in supplies.words)

        def written(section: str) -> dict[str, Any]:
            cards = self.deck.deal(section, plan.cards.get(section, ()), "first version")
            return write_section(self.desk, section, plan, asked, words, cards, self.path)

        sections = self._together({name: lambda name=name: written(name) for name in SECTIONS})
        sections["bodies"] |= supplies.bodies
        return case_text(plan, self.request.text, plan.params, sections)

    # --- one attempt ------------------------------------------------------------------------------------------

    def _try(self, attempt: Attempt) -> Report:
        """Check an attempt, mend it, run it and have it judged."""
        self.emit("attempt", number=attempt.number, cause=attempt.cause, changes=attempt.changes[:20])
        examined, problems = self._sound(attempt)
        if problems:
            attempt.problems = problems
            self.attempts.keep(attempt)
            self.emit("unsound", number=attempt.number, problems=problems[:20])
            return Report(problems=problems)
        assert examined.loaded is not None
        if self._contract is None:
            self._contract = Contract.of(examined.loaded, self.names)
        if not self.attempts.recall(attempt):
            self.emit("running", live=True, number=attempt.number)
            self.attempts.run(attempt, examined, self.names, self.limits.sim_timeout, self._progress)
        self.emit(
            "ran", number=attempt.number, state=attempt.state, expect={n: r["ok"] for n, r in attempt.expect.items()}
        )
        if not attempt.evidence:
            self.attempts.keep(attempt)
            return Report(problems=attempt.problems or [f"the run ended without evidence: {attempt.state}"])
        report = Report(evidence=self._with_effects(attempt))
        if attempt.state == "finished" or attempt.pictures:
            exhibit = self._exhibit(attempt, report.evidence)
            critique = criticise(
                self.desk, self.request, self.plan, exhibit, self._contract, self.restated, self.path
            )  # fmt: skip
            attempt.critique = report.critique = critique.model_dump(mode="json")
            attempt.accepted = (
                critique.verdict == "pass"
                and attempt.state == "finished"
                and not critique.unfaithful
                and not attempt.missed(list(attempt.expect))
            )
            said = {"verdict": critique.verdict, "score": critique.score, "summary": critique.summary}
            failures = [failure.what for failure in critique.failures]
            self.emit("judged", number=attempt.number, **said, failures=failures, accepted=attempt.accepted)
        self.attempts.keep(attempt)
        return report

    def _sound(self, attempt: Attempt) -> tuple[Examination, list[str]]:
        """Check an attempt; what is wrong goes to its owners, a few times. Returns what is left."""
        told: dict[str, list[str]] = {}
        for mend in range(MENDS + 1):
            examined = examine(attempt.text, self.path)
            errors = examined.errors or self._breaches(examined)
            if not errors:
                return self._considered(attempt, examined), []
            owners = self._owners(errors, told)
            if mend == MENDS or "plan" in owners:
                return examined, [said(problem) for problem in errors]
            self.emit("mending", number=attempt.number, problems=[said(problem) for problem in errors][:20])
            attempt.text, told = self._mended(attempt.text, owners, MEND)
        raise AssertionError("the last round returns")

    def _considered(self, attempt: Attempt, examined: Examination) -> Examination:
        """Give owners one chance to mend what the lint warns of: that is cheaper before a run than after it."""
        fresh = [p for p in examined.warnings if (p.rule, p.path) not in self._warned]
        self._warned |= {(p.rule, p.path) for p in fresh}
        owners = self._owners(fresh, {})
        owners.pop("plan", None)
        if not owners:
            return examined
        self.emit("mending", number=attempt.number, problems=[said(problem) for problem in fresh][:20])
        text, _ = self._mended(attempt.text, owners, CONSIDER)
        mended = examine(text, self.path)
        if mended.errors or self._breaches(mended):
            return examined  # it made things worse
        attempt.text = text
        return mended

    def _breaches(self, examined: Examination) -> list[Problem]:
        assert examined.loaded is not None
        if self._contract is None:
            # The first version: nothing can be weaker than what was never checked, but subjects have to stay dynamic.
            contract = Contract.of(examined.loaded, self.names)
            missing = [name for name in self.names if name not in contract.values["expect"]]
            rows = [f"/actions/expect/{name} comes from the request and must stay" for name in missing]
        else:
            rows = self._contract.breaches(examined.loaded)
        return [Problem(row.split(":")[0].split(" ")[0], row, rule="from-the-request") for row in rows]

    def _owners(self, errors: Sequence[Problem], told: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
        frozen = self._contract.pointers if self._contract is not None else self._planned_pointers()
        owners: dict[str, list[str]] = {name: list(rows) for name, rows in told.items()}
        for problem in errors:
            owners.setdefault(owner_of(problem, frozen), []).append(said(problem))
        return owners

    def _planned_pointers(self) -> tuple[str, ...]:
        checks = self.plan.checks
        return tuple(
            f"/actions/{part}/{name}" for part in ("measures", "events", "expect") for name in getattr(checks, part)
        )

    def _mended(
        self, text: str, owners: Mapping[str, Sequence[str]], instruction: str
    ) -> tuple[str, dict[str, list[str]]]:
        """Have owners mend their sections; return the text, and what they say others have to mend."""
        case = revising.data_of(text)

        def mended(section: str) -> dict[str, Any] | Refer:
            return change_section(self.desk, section, self.plan, case, instruction, owners[section], "", self.path)

        answers = self._together({name: lambda name=name: mended(name) for name in SECTIONS if name in owners})
        told: dict[str, list[str]] = {}
        for section, answer in answers.items():
            if isinstance(answer, Refer):
                told.setdefault(answer.section, []).append(f"the Writer of {section} says: {answer.why}")
        return revising.with_sections(text, _written(answers)), told

    def _exhibit(self, attempt: Attempt, evidence: str) -> Exhibit:
        images, missed = self.attempts.images(attempt), attempt.missed(list(attempt.expect))
        return Exhibit(attempt.number, attempt.text, evidence, frozenset(attempt.cites), images, missed)

    def _with_effects(self, attempt: Attempt) -> str:
        """The evidence, and what was changed since the attempt before and what that did."""
        earlier = [other for other in self.made[:-1] if other.expect]
        if not earlier or not attempt.changes:
            return attempt.evidence
        turned = changed(earlier[-1].expect, attempt.expect)
        rows = [f"- changed: {line}" for line in attempt.changes[:15]] + [f"- {row}" for row in turned]
        return f"{attempt.evidence}\n\n## Since attempt {earlier[-1].number}\n\n" + "\n".join(rows)

    def _progress(self, progress: Any) -> None:
        self.emit("progress", live=True, phase=progress.phase, t=progress.t, duration=progress.duration)

    # --- what is done next ------------------------------------------------------------------------------------

    def _decided(self, attempt: Attempt, report: Report) -> Decision:
        rules = frozenset(
            row.rsplit("[", 1)[-1].rstrip("]") for row in [*report.problems, *attempt.evidence.splitlines()]
        )
        failures = [failure["what"] for failure in (report.critique or {}).get("failures", ())]
        text = " ".join([*report.problems, *failures, (report.critique or {}).get("summary", ""), attempt.state])
        offer = self.deck.offer(text, self.plan.mode, {*rules, attempt.state})
        decision = decide(self.desk, self.request, self.plan, self._history(), report, offer, rules)
        self.emit("decided", number=attempt.number, action=decision.action, why=decision.why, take=decision.take,
                  routes={route.section: route.instruction for route in decision.routes})  # fmt: skip
        return decision

    def _history(self) -> str:
        rows = []
        for one in self.made:
            outcome = one.state if not one.problems else "refused: " + "; ".join(one.problems[:2])
            rows.append(history_row(one.number, one.cause, outcome, one.expect, one.critique))
        return "\n".join(rows)

    def _revised(self, attempt: Attempt, decision: Decision) -> tuple[str, list[str]]:
        """Do what was decided. Returns the text, and what could not be done."""
        text, left_out = self.apply_plan(attempt.text, decision)
        patches = (attempt.critique or {}).get("patches", [])
        text, refused = revising.with_patches(text, [patches[k - 1] for k in dict.fromkeys(decision.take)], self.path)
        return self.routed(text, decision.routes), [*left_out, *refused]

    def apply_plan(self, text: str, decision: Decision) -> tuple[str, list[str]]:
        """Do what the Planner may do by itself: parameters, waivers, expectations said anew."""
        text = revising.with_waivers(revising.with_params(text, decision.params), decision.waive)
        self.plan = self.plan.model_copy(update={"params": self.plan.params | decision.params})
        if decision.restate is not None:
            checks = self.plan.checks
            merged_checks = checks.model_copy(
                update={
                    part: getattr(checks, part) | getattr(decision.restate.checks, part)
                    for part in ("measures", "events", "expect")
                }
            )
            self.plan = self.plan.model_copy(update={"checks": merged_checks})
            text = revising.with_checks(text, decision.restate.checks)
        return text, self._renew_contract(text, decision.restate.why if decision.restate else "a parameter has changed")

    def _renew_contract(self, text: str, why: str) -> list[str]:
        """Take down what the expectations say now, and keep what they said before, for the Critic."""
        found = examine(text, self.path)
        if self._contract is None or found.loaded is None:
            return []
        fresh = Contract.of(found.loaded, self.names)
        for part, rows in self._contract.values.items():
            for name, old in rows.items():
                if (new := fresh.values[part].get(name)) != old:
                    row = f"{part} `{name}` was {old}, is {new} ({why})"
                    if row not in self.restated:
                        self.restated.append(row)
                        self.emit("restated", part=part, name=name, old=old, new=new, why=why)
        subjects = self._contract.subjects | fresh.subjects
        self._contract = Contract(fresh.names, fresh.values, subjects)
        return []

    def routed(self, text: str, routes: Sequence[Route]) -> str:
        """Have Writers change their sections."""
        case = revising.data_of(text)
        by_section: dict[str, list[Route]] = {}
        for route in routes:
            by_section.setdefault(route.section, []).append(route)

        def done(section: str) -> dict[str, Any] | Refer:
            instruction = "\n".join(route.instruction for route in by_section[section])
            cards = self.deck.deal(
                section, [card for route in by_section[section] for card in route.cards], instruction[:80]
            )
            return change_section(self.desk, section, self.plan, case, instruction, (), cards, self.path)

        answers = self._together({name: lambda name=name: done(name) for name in SECTIONS if name in by_section})
        for section, answer in answers.items():
            if isinstance(answer, Refer):
                self.emit("referred", section=section, to=answer.section, why=answer.why)
        return revising.with_sections(text, _written(answers))

    # --- ends -------------------------------------------------------------------------------------------------

    def _outcome(self, state: State, why: str) -> Outcome:
        best = max(self.made, key=lambda one: one.rank(self.names), default=None)
        unresolved = []
        if best is not None:
            self.attempts.publish(best)
            unresolved += [f"{name}: {self.plan.says.get(name, '')}" for name in best.missed(self.names)]
            unresolved += best.problems
            if not best.accepted:
                unresolved += [failure["what"] for failure in (best.critique or {}).get("failures", ())]
        self.emit("ended", state=state, why=why, best=best.number if best else None)
        return Outcome(state, why, best, unresolved, self.plan)

    @staticmethod
    def _together(jobs: Mapping[str, Callable[[], T]]) -> dict[str, T]:
        """Do independent things at the same time; the first that fails is raised when all are over."""
        with ThreadPoolExecutor(max_workers=TOGETHER) as pool:
            futures = {name: pool.submit(job) for name, job in jobs.items()}
        return {name: future.result() for name, future in futures.items()}


def _written(answers: Mapping[str, dict[str, Any] | Refer]) -> dict[str, dict[str, Any]]:
    """The sections that were written, without those whose Writers refer to others."""
    return {name: answer for name, answer in answers.items() if not isinstance(answer, Refer)}
