"""Loop of the agents: plan, write, check, run, judge, decide, until a case is accepted or the budget is used up."""

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import Examination, case_text, examine
from text2sim.agents.attempt import Attempt, best_of, stalled_best
from text2sim.agents.attempt_report import AttemptReport
from text2sim.agents.attempts import DURATION_RULE, MAX_FINER_SHARE, Attempts
from text2sim.agents.cinematography import Cinematography, best_treatment
from text2sim.agents.contract import Contract
from text2sim.agents.conversation import BudgetSpent, Conversation, RoleFailed
from text2sim.agents.critic_view import critic_exhibit, with_effects
from text2sim.agents.criticism import criticise
from text2sim.agents.deciding import Deciding
from text2sim.agents.history import History
from text2sim.agents.journal import Emit
from text2sim.agents.loop_result import LoopLimits, LoopOutcome, State, impossible_parts
from text2sim.agents.mending import Mending
from text2sim.agents.models.exchange import ModelError, StoppedError
from text2sim.agents.offered_cards import OfferedCards
from text2sim.agents.planning import Request, TriedPlan, make_plan
from text2sim.agents.rehearsal import held_at_start
from text2sim.agents.replies import CasePlan, Fragments
from text2sim.agents.requirements import Requirement, extract_requirements
from text2sim.agents.revising import change_lines
from text2sim.agents.writer_team import Workshop

STYLE_MINUTES = 4.0
"""Minutes that are reserved for the search for the best film once all expectations are true."""
JUDGING_OVERTIME = 5.0
"""Minutes beyond the limit of time within which the last run is still judged, if all expectations are true."""
HURRY = 2.0
"""Time left, in durations of the latest attempt, below which warnings wait."""
MAX_UNASKED_SHARE = 0.25
"""Largest estimated share of the time left for a first run about which the Planner is not asked."""
UNLIMITED_MINUTES = 60.0
"""Minutes that count as left if there is no limit, for a run with finer steps."""
UNASKED_MINUTES = 5.0
"""Minutes left below which no question delays a first run: what ran can be judged and filmed."""


class AgentLoop:
    """The loop for one case.

    Args:
        case: The case folder.
        request: The request.
        chat: The conversation with the models.
        offered: The Debug Cards.
        emit: Callback for journal events.
        limits: Bounds of attempts and time.
    """

    def __init__(
        self, case: Path, request: Request, chat: Conversation, offered: OfferedCards, emit: Emit, limits: LoopLimits
    ) -> None:
        self.case, self.path = case, case / "case.yaml"
        self.chat, self.offered, self.emit, self.limits = chat, offered, emit, limits
        self.progress = lambda now: emit("progress", live=True, phase=now.phase, t=now.t, duration=now.duration)
        self.attempts = Attempts(case)
        self.history = History(self.attempts, limits)
        nothing_yet = Agreement(CasePlan.model_construct(name=case.name, event="", checks=Fragments()), emit)
        self.workshop = Workshop(chat, offered, nothing_yet, request, self.path, emit, left=self.history.left)
        self.mending = Mending(self.workshop)
        self.deciding = Deciding(self.workshop, self.history, self.attempts, limits, self.progress)
        self.style = False
        """Whether the best film of the final version is searched for."""
        self.prewarm = False
        """Whether the engine starts while the Writers still write."""
        self._faithful: list[str] = []
        """Restated expectations that the Critic was told of and did not call unfaithful."""
        self._known_doubts: set[tuple[str, str]] = set()
        """Doubts that the Planner was asked about, by kind and name."""

    @property
    def request(self) -> Request:
        """The request, with its requirements once they are known."""
        return self.workshop.request

    @property
    def agreement(self) -> Agreement:
        """The plan and its binding expectations."""
        return self.workshop.agreement

    # --- entry points -----------------------------------------------------------------------------------------

    def generate(self) -> LoopOutcome:
        """Generate a case from the request."""
        return self.ending(self._generated)

    def _generated(self) -> LoopOutcome:
        self.emit("stage", name="plan")
        self.require(extract_requirements(self.chat, self.request.text, self.request.images))
        plan = make_plan(self.chat, self.request, self.offered, self.path)
        self.agreement.adopt_plan(plan, plan.checks.expect)
        self._emit_plan(plan)
        if plan.possible == "no":
            return LoopOutcome("impossible", plan.why, plan=plan)
        if self.prewarm:
            self.attempts.runner.start()
        return self.work(self._draft_sections(), "first version")

    def require(self, requirements: dict[str, Requirement]) -> None:
        """Record the requirements, before anything is built."""
        self.workshop.request = replace(self.request, requirements=requirements)
        self.emit("requirements", rows={name: one.what for name, one in requirements.items()})

    def ending(self, attempt_it: Callable[[], LoopOutcome]) -> LoopOutcome:
        """Run an entry point of the loop, and turn whatever ends it into an outcome.

        Raises:
            KeyboardInterrupt: If the user stopped it.
        """
        try:
            return attempt_it()
        except BudgetSpent as spent:
            return self.outcome("spent", str(spent))
        except StoppedError:
            raise KeyboardInterrupt from None
        except (RoleFailed, ModelError) as failed:
            ended = self.outcome("failed", str(failed))
            ended.unresolved = list(dict.fromkeys([*ended.unresolved, *getattr(failed, "reasons", ())]))
            return ended
        finally:
            self.attempts.close()

    def work(self, text: str, cause: str) -> LoopOutcome:
        """Improve a case until it is accepted or a limit is reached; `cause` says why this version was made."""
        while True:
            attempt = self.history.begin(text, cause)
            self.chat.attempt = attempt.number
            report = self._try_attempt(attempt)
            if (ended := self._ended_with(attempt)) is not None:
                return ended
            decision = self.deciding.decide(attempt, report)
            if decision.action == "plan_anew":
                try:
                    plan = self._planned_anew(decision.why)
                except RoleFailed as failed:  # keep the present plan
                    self.agreement.replanned = True
                    self.workshop.referred.append(f"Planning anew came to nothing: {failed}")
                    decision = self.deciding.decide(attempt, report)
                else:
                    if plan.possible == "no":
                        return self.outcome("gave_up", plan.why)
                    text, cause = self._draft_sections(), f"planned anew: {decision.why}"
                    continue
            if decision.action == "give_up":
                return self.outcome("gave_up", decision.why)
            text, left_out = self.deciding.carry_out(attempt, decision)
            cause = "; ".join([decision.why, *left_out])
            if decision.back_to is not None:
                cause = f"attempt {decision.back_to} again, changed: {cause}"

    def _ended_with(self, attempt: Attempt) -> LoopOutcome | None:
        """Return the outcome if the loop ends with this attempt, after the search for the best film; None otherwise."""
        if attempt.accepted:
            self._choose_film(attempt)
            came_true = "the Critic passed it and everything expected came true"
            if self.agreement.plan.possible == "partly":
                return self.outcome("accepted_in_part", f"{came_true}, as far as it is possible")
            return self.outcome("accepted", came_true)
        attempts, names = self.history.made, self.agreement.names
        if (stalled := stalled_best(attempts, names)) is not None:
            best, why = stalled
            if not self.history.base:
                self._choose_film(best)
            return self.outcome("gave_up", why)
        best = best_of(attempts, names)
        filmed = best.sound(names) and not self.history.base
        left, reserve = self.limits.minutes_left(), STYLE_MINUTES if filmed and self.style else 0.0
        why = f"{attempt.number} attempts were made" if attempt.number >= self.limits.attempts else ""
        if self.attempts.too_late(attempt, left, reserve):
            why = f"{left:.0f} minutes are left, and a run took {attempt.wall:.0f} s"
        if not why:
            return None
        if filmed:
            self._choose_film(best)
        return self.outcome("spent", why)

    def _choose_film(self, attempt: Attempt) -> None:
        """Film the final attempt in several ways, and keep the best; its folder keeps what the Critic saw."""
        if not self.style:
            return
        self.emit("stage", name="style")
        cinematography = Cinematography(self.chat, self.request.text, self.path, self.case / attempt.run, self.emit)
        attempt.text = best_treatment(cinematography, attempt.text, self.attempts.refilm, self.path, self.emit)

    def _planned_anew(self, why: str) -> CasePlan:
        """Have a new plan made, once; the expectations stay."""
        self.emit("stage", name="plan")
        tried = TriedPlan(why, self.history.rows(), self.agreement.plan, self.agreement.first, self.history.left())
        plan = make_plan(self.chat, replace(self.request, minutes=None), self.offered, self.path, tried)
        if plan.possible != "no":
            self.agreement.replace_plan(plan)
        self._emit_plan(plan)
        return plan

    def _emit_plan(self, plan: CasePlan) -> None:
        about = {"possible": plan.possible, "why": plan.why, "assumptions": plan.assumptions, "says": plan.says}
        self.emit("planned", goal=plan.event, **about)

    # --- first version ----------------------------------------------------------------------------------------

    def _draft_sections(self) -> str:
        """Have the sections written; if a Writer fails, have a simpler plan made, once."""
        try:
            sections = self.workshop.draft_sections()
        except RoleFailed as failed:
            if self.agreement.replanned:
                raise
            try:
                plan = self._planned_anew(f"{failed}. Plan it in a simpler way, so that this can be written.")
            except RoleFailed as again:
                raise RoleFailed(failed.role, [*failed.reasons, f"planned anew: {again}"]) from None
            if plan.possible == "no":
                raise
            sections = self.workshop.draft_sections()
        plan = self.agreement.plan
        return case_text(plan, self.request.text, plan.params, sections)

    # --- one attempt ------------------------------------------------------------------------------------------

    def _try_attempt(self, attempt: Attempt) -> AttemptReport:
        """Check, repair and run an attempt, and have it judged."""
        self.emit("attempt", number=attempt.number, cause=attempt.cause, changes=attempt.changes[:20])
        examined, problems = self.mending.check(attempt)
        if not problems:
            examined = self._considered(attempt, examined)
        rules = frozenset(problem.rule for problem in [*examined.errors, *examined.warnings])
        if problems:
            attempt.problems = problems
            self.attempts.keep(attempt)
            self.emit("unsound", number=attempt.number, problems=problems[:20])
            return AttemptReport(problems=problems, rules=rules)
        assert examined.loaded is not None
        self.agreement.adopt_values(attempt.text)
        contract = self.agreement.record_examined(examined)
        self.history.record_agreement(attempt, self.agreement)
        examined = self._simulate(attempt, examined)
        self.emit(
            "ran", number=attempt.number, state=attempt.state, expect={n: r["ok"] for n, r in attempt.expect.items()}
        )
        if not attempt.evidence:
            self.attempts.keep(attempt)
            problems = attempt.problems or [f"the run ended without evidence: {attempt.state}"]
            return AttemptReport(problems=problems, rules=rules)
        assert examined.loaded is not None
        if all(row.get("about_cause") for row in attempt.facts):  # recalled ones stay: a later film changes the run's
            self.attempts.record_facts(attempt, self.agreement.plan, examined.loaded)
        if attempt.sound(()):
            now, timeout = self.limits.minutes_left(), self.limits.timeout()
            earlier = self.history.made[:-1]
            self.attempts.rerun_without_causes(attempt, self.agreement.plan, timeout, self.progress, now, earlier)
        report = AttemptReport(evidence=with_effects(self.history.made), rules=rules)
        if attempt.state == "finished" or attempt.pictures:
            report.critique = self._judge(attempt, report.evidence, contract)
        self.attempts.keep(attempt)
        return report

    def _simulate(self, attempt: Attempt, examined: Examination) -> Examination:
        """Run an attempt, with finer steps if these are needed and the case is new; return its check."""
        text = attempt.text
        if not self.attempts.recall(attempt):
            guess = 0.0 if self.history.timed else examined.seconds
            self.emit("running", live=True, number=attempt.number, seconds=guess)
            examined.intended = self.mending.intended(examined.warnings)
            now, names = self.limits.minutes_left(), self.agreement.names
            left = UNLIMITED_MINUTES if now is None else now
            finer_within = 0.0 if self.history.base else MAX_FINER_SHARE * 60 * left
            limit, patience = self.limits.timeout(), self.history.patience()
            self.attempts.run(attempt, examined, names, limit, self.progress, patience, finer_within)
        if attempt.text == text:
            return examined
        refined = [f"{line} (by the program: bodies sank into each other)" for line in change_lines(text, attempt.text)]
        attempt.changes += refined
        self.emit("refined", number=attempt.number, changes=refined)
        return examine(attempt.text, self.path)

    def _judge(self, attempt: Attempt, evidence: str, contract: Contract) -> dict[str, Any]:
        """Have the Critic judge a run, and accept the attempt if nothing speaks against it; return the judgement."""
        images, sound = self.attempts.images(attempt), attempt.sound(self.agreement.names)
        evidence = f"{evidence}\n\n## Left\n\n{self.history.left()}"
        shown = critic_exhibit(self.history.made, evidence, images, self.history.base, self.path)
        with self.chat.overtime(JUDGING_OVERTIME if sound else 0.0):
            restated = [row for row in self.agreement.restated if row not in self._faithful]
            critique = criticise(self.chat, self.request, self.agreement.plan, shown, contract, restated, self.path)
        self._faithful += [] if critique.unfaithful else restated
        attempt.critique = critique.model_dump(mode="json")
        attempt.accepted = critique.verdict == "pass" and not critique.unfaithful and sound
        judgement = {"verdict": critique.verdict, "score": critique.score, "summary": critique.summary}
        failures = [failure.what for failure in critique.failures]
        self.emit("judged", number=attempt.number, **judgement, failures=failures, accepted=attempt.accepted)
        return attempt.critique

    def _considered(self, attempt: Attempt, examined: Examination) -> Examination:
        """Have warnings fixed and doubts resolved; estimates of the duration are ignored after a first run.

        Where the time left is less than `HURRY` times that of the latest attempt, letters would cost the run.
        """
        left, took = self.history.time_left()[1], self.history.made[-1].took if self.history.made else 0.0
        if left is not None and 60 * left < HURRY * took:
            return examined
        known, waiting = {DURATION_RULE} if self.history.timed else set(), [*self.workshop.referred]
        examined, doubts = self.mending.consider_warnings(attempt, examined, known)
        return self._settle_doubts(attempt, examined, doubts, referred=self.workshop.referred != waiting)

    def _settle_doubts(
        self, attempt: Attempt, examined: Examination, doubts: list[str], *, referred: bool = False
    ) -> Examination:
        """Ask the Planner once, before the run, about doubtful expectations, a long run, and what Writers referred."""
        assert examined.loaded is not None
        left = self.limits.minutes_left()
        if (
            left is not None
            and left < UNASKED_MINUTES
            and not self.history.timed
            and not self.attempts.repeats(attempt)
        ):
            return examined
        plan = self.agreement.plan
        held = held_at_start(examined.loaded, [name for name in self.agreement.names if name not in plan.keeps])
        fresh = {name: row for name, row in held.items() if ("held-at-start", name) not in self._known_doubts}
        self._known_doubts |= {("held-at-start", name) for name in fresh}
        doubts = [*doubts, *fresh.values(), *self._expensive_run(attempt, examined)]
        if not doubts and not referred:
            return examined
        self.emit("doubted", number=attempt.number, doubts=[*self.workshop.referred, *doubts][:20])
        rules = frozenset(problem.rule for problem in examined.warnings)
        decision = self.deciding.decide(attempt, AttemptReport(doubts=doubts, rules=rules), before_run=True)
        if decision.action == "give_up":
            return examined  # run it anyway, since the doubts may be wrong
        agreed, (alone, _) = copy(self.agreement), self.agreement.changed(attempt.text, decision)
        text, _ = self.deciding.carry_out(attempt, decision)
        if (adopted := self.mending.adopt(attempt, text, alone)) is not None:  # contract and case change together
            return adopted
        self.agreement.restore(agreed)
        self.workshop.referred.append(f"Not done before the run, because it left the case wrong: {decision.why}")
        return examined

    def _expensive_run(self, attempt: Attempt, examined: Examination) -> list[str]:
        """Report once, before the first run, that it may take too much of the time left."""
        now = self.limits.minutes_left()
        if now is None or "expensive" in {rule for rule, _ in self._known_doubts} or self.history.timed:
            return []
        left, crowding = self.attempts.minutes_left(attempt, now), self.attempts.crowding(attempt)
        # Other work comes and goes: the run meets something between all of it and none, here their geometric mean.
        needed = crowding**0.5 * examined.seconds / 60
        if left is None or needed <= MAX_UNASKED_SHARE * left:
            return []
        self._known_doubts.add(("expensive", ""))
        crowd = f", whose cores have {crowding:.1f} times as much to do as they can" if crowding > 1.2 else ""
        estimate = (
            f"a run is estimated at {needed:.0f} minutes (within a factor of three) of the {left:.0f} that are left on "
            f"this machine{crowd}{f' ({examined.cost})' if examined.cost else ''}"
        )
        return [f"{estimate}; several may be needed: shorten it, coarsen the cells, or take a cheaper solver"]

    # --- outcome ----------------------------------------------------------------------------------------------

    def outcome(self, state: State, why: str) -> LoopOutcome:
        """Publish the best attempt, and return the outcome."""
        made = self.history.made
        best = best_of(made, self.agreement.names) if made else None
        unresolved: list[str] = []
        if best is not None:
            if best.accepted or not self.history.base:  # only an accepted version may replace an existing case
                self.attempts.publish(best)
            missed = best.missed(self.agreement.names)
            unresolved = [f"{name}: {self.agreement.plan.says.get(name, '')}" for name in missed]
            plan, wished = self.agreement.plan, self.request.requirements
            unresolved += best.shortcomings({name: one for name, one in wished.items() if name not in plan.cannot})
            unresolved += impossible_parts(plan, wished)
        self.emit("ended", state=state, why=why, best=best.number if best else None)
        return LoopOutcome(state, why, best, unresolved, self.agreement.plan)
