"""Loop of the agents: plan, write, check, run, judge, decide, until a case is accepted or the budget is used up."""

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from pathlib import Path

from text2sim.agents import revising
from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import Examination, case_text
from text2sim.agents.attempt import Attempt, best_of, unbettered
from text2sim.agents.attempt_report import AttemptReport, Choices
from text2sim.agents.attempts import DURATION_RULE, Attempts
from text2sim.agents.cinematography import Cinematography, best_treatment
from text2sim.agents.conversation import BudgetSpent, Conversation, RoleFailed
from text2sim.agents.critic_view import critic_exhibit, what_holds, with_effects
from text2sim.agents.criticism import criticise, decision_to_film
from text2sim.agents.dealt_cards import DealtCards, failure_signatures
from text2sim.agents.deciding import decide
from text2sim.agents.journal import Emit
from text2sim.agents.loop_result import LoopLimits, LoopOutcome, State
from text2sim.agents.mending import Mending
from text2sim.agents.models.exchange import ModelError, StoppedError
from text2sim.agents.planning import Request, TriedPlan, make_plan, plan_text
from text2sim.agents.rehearsal import held_at_start
from text2sim.agents.replies import CasePlan, Decision, Fragments, Route
from text2sim.agents.requirements import Requirement, take_apart
from text2sim.agents.trials import MAX_TRIAL_ROUNDS, TRIALS_SHARE, affordable
from text2sim.agents.writer_team import Workshop

RECENT_RUNS = 3
"""Number of the latest attempts whose longest run says what the next will take."""
STYLE_MINUTES = 4.0
"""Minutes that are kept for the search for the best film once all expectations are true."""
JUDGING_OVERTIME = 5.0
"""Minutes after the end of the time within which the last run is still judged, if all expectations are true."""
MAX_UNASKED_SHARE = 0.25
"""Largest estimated share of the time left for a first run about which the Planner is not asked."""


class AgentLoop:
    """The loop for one case.

    Args:
        case: The case folder.
        request: The request.
        chat: The conversation with the models.
        dealt: The Debug Cards.
        emit: Callback for journal events.
        limits: Bounds of attempts and time.
    """

    def __init__(
        self, case: Path, request: Request, chat: Conversation, dealt: DealtCards, emit: Emit, limits: LoopLimits
    ) -> None:
        self.case, self.path, self.request = case, case / "case.yaml", request
        self.chat, self.dealt, self.emit, self.limits = chat, dealt, emit, limits
        self.attempts = Attempts(case)
        self.made: list[Attempt] = []
        self.agreement = Agreement(CasePlan.model_construct(name=case.name, event="", checks=Fragments()), emit)
        self.workshop = Workshop(chat, dealt, self.agreement, request, self.path, emit)
        self.workshop.left = self.left
        self.mending = Mending(self.workshop, self.agreement, self.path, emit)
        self.only_if_accepted = False
        """Whether the case existed before, so that only an accepted version may replace it."""
        self.style = False
        """Whether the best film of the final version is searched for."""
        self.prewarm = False
        """Whether the engine starts while the Writers still write."""
        self.base = ""
        """Text of the existing case that is to be changed."""
        self._agreed: dict[int, Agreement] = {}
        """The agreement at each attempt that ran, by number."""
        self._known_warnings: set[tuple[str, str]] = set()
        """Doubts that the Planner was asked about, by kind and name."""
        self.progress = lambda now: emit("progress", live=True, phase=now.phase, t=now.t, duration=now.duration)

    # --- entry points -----------------------------------------------------------------------------------------

    def generate(self) -> LoopOutcome:
        """Generate a case from the request."""
        return self.ending(self._generated)

    def _generated(self) -> LoopOutcome:
        self.emit("stage", name="plan")
        self.require(take_apart(self.chat, self.request.text, self.request.images))
        plan = make_plan(self.chat, self.request, self.dealt, self.path)
        self.agreement.expect(plan, plan.checks.expect)
        self._tell(plan)
        if plan.possible == "no":
            return LoopOutcome("impossible", plan.why, plan=plan)
        if self.prewarm:
            self.attempts.runner.start()
        return self.work(self._draft_sections(), "first version")

    def require(self, requirements: dict[str, Requirement]) -> None:
        """Record the requirements, before anything is built."""
        self.request = replace(self.request, requirements=requirements)
        self.emit("requirements", rows={name: one.what for name, one in requirements.items()})

    def ending(self, way: Callable[[], LoopOutcome]) -> LoopOutcome:
        """Run an entry point of the loop, and turn whatever ends it into an outcome.

        Raises:
            KeyboardInterrupt: If the user stopped it.
        """
        try:
            return way()
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
        """Improve a case until it is accepted or a limit is reached.

        Args:
            text: The first version.
            cause: Why it was made.
        """
        before = self.made[-1].text if self.made else None
        while True:
            attempt = Attempt(len([one for one in self.made if one.number]) + 1, text, cause)
            attempt.changes = revising.change_lines(before, text) if before is not None else []
            self.made.append(attempt)
            self.chat.attempt = attempt.number
            report = self._try_attempt(attempt)
            if attempt.accepted:
                self._styled(attempt)
                return self.outcome("accepted", "the Critic passed it and everything expected came true")
            if (best := unbettered(self.made, self.agreement.names)) is not None:
                if not self.only_if_accepted:
                    self._styled(best)
                return self.outcome("gave_up", f"the attempts after {best.number} brought nothing better")
            best = best_of(self.made, self.agreement.names)
            filmed = best.sound(self.agreement.names) and not self.only_if_accepted
            left, reserve = self.limits.minutes_left(), STYLE_MINUTES if filmed and self.style else 0.0
            why = f"{attempt.number} attempts were made" if attempt.number >= self.limits.attempts else ""
            if self.attempts.too_late(attempt, left, reserve):
                why = f"{left:.0f} minutes are left, and a run took {attempt.wall:.0f} s"
            if why:
                if filmed:
                    self._styled(best)
                return self.outcome("spent", why)
            decision = self._decide(attempt, report)
            before = attempt.text
            if decision.action == "plan_anew":
                try:
                    plan = self._planned_anew(decision.why)
                except RoleFailed as failed:  # keep the present plan
                    self.agreement.planned_anew = True
                    self.workshop.referred.append(f"Planning anew came to nothing: {failed}")
                    decision = self._decide(attempt, report)
                else:
                    if plan.possible == "no":
                        return self.outcome("gave_up", plan.why)
                    text, cause = self._draft_sections(), f"planned anew: {decision.why}"
                    continue
            if decision.action == "give_up":
                return self.outcome("gave_up", decision.why)
            text, left_out = self._revised(attempt, decision)
            cause = "; ".join([decision.why, *left_out])
            if decision.back_to is not None:
                cause = f"attempt {decision.back_to} again, changed: {cause}"

    def _styled(self, attempt: Attempt) -> None:
        """Film the final attempt in several ways, and keep the best; its folder keeps what the Critic saw."""
        if not self.style:
            return
        self.emit("stage", name="style")
        way = Cinematography(self.chat, self.request.text, self.path, self.case / attempt.run, self.emit)
        attempt.text = best_treatment(way, attempt.text, self.attempts.refilm, self.path, self.emit)

    def _planned_anew(self, why: str) -> CasePlan:
        """Have a new plan made, once; the expectations stay."""
        self.emit("stage", name="plan")
        tried = TriedPlan(why, self._history(), self.agreement.plan, self.agreement.first, self.left())
        plan = make_plan(self.chat, replace(self.request, minutes=None), self.dealt, self.path, tried)
        if plan.possible != "no":
            self.agreement.expect_anew(plan)
        self._tell(plan)
        return plan

    def _tell(self, plan: CasePlan) -> None:
        opening_facts = {"possible": plan.possible, "why": plan.why, "assumptions": plan.assumptions, "says": plan.says}
        self.emit("planned", goal=plan.event, **opening_facts)

    # --- first version ----------------------------------------------------------------------------------------

    def _draft_sections(self) -> str:
        """Have the sections written; if a Writer fails, have a simpler plan made, once."""
        try:
            sections = self.workshop.draft_sections()
        except RoleFailed as failed:
            if self.agreement.planned_anew:
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
        self.agreement.see(attempt.text)
        contract = self.agreement.record_examined(examined)
        self._agreed[attempt.number] = copy(self.agreement)
        if not self.attempts.recall(attempt):
            guess = 0.0 if any(one.pace for one in self.made) else examined.seconds
            self.emit("running", live=True, number=attempt.number, seconds=guess)
            examined.intended = self.mending.intended(examined.warnings)
            self.attempts.run(attempt, examined, self.agreement.names, self.limits.timeout(), self.progress)
        self.emit(
            "ran", number=attempt.number, state=attempt.state, expect={n: r["ok"] for n, r in attempt.expect.items()}
        )
        if not attempt.evidence:
            self.attempts.keep(attempt)
            problems = attempt.problems or [f"the run ended without evidence: {attempt.state}"]
            return AttemptReport(problems=problems, rules=rules)
        self.attempts.look_up(attempt, self.agreement.plan, examined.loaded)
        if attempt.sound(()):
            now = self.limits.minutes_left()
            self.attempts.compare(attempt, self.agreement.plan, self.limits.timeout(), self.progress, now)
        report = AttemptReport(evidence=with_effects(self.made, attempt), rules=rules)
        if attempt.state == "finished" or attempt.pictures:
            images = self.attempts.images(attempt)
            evidence = f"{report.evidence}\n\n## Left\n\n{self.left()}"
            shown = critic_exhibit(self.made, attempt, evidence, images, self.base, self.path)
            with self.chat.overtime(JUDGING_OVERTIME if attempt.sound(self.agreement.names) else 0.0):
                critique = criticise(
                    self.chat, self.request, self.agreement.plan, shown, contract, self.agreement.restated, self.path
                )  # fmt: skip
            attempt.critique = report.critique = critique.model_dump(mode="json")
            attempt.accepted = (
                critique.verdict == "pass" and not critique.unfaithful and attempt.sound(self.agreement.names)
            )
            judgement = {"verdict": critique.verdict, "score": critique.score, "summary": critique.summary}
            failures = [failure.what for failure in critique.failures]
            self.emit("judged", number=attempt.number, **judgement, failures=failures, accepted=attempt.accepted)
        self.attempts.keep(attempt)
        return report

    def _considered(self, attempt: Attempt, examined: Examination) -> Examination:
        """Have warnings fixed and doubts resolved; estimates of the duration are ignored after a first run."""
        known = {DURATION_RULE} if any(one.pace for one in self.made) else set()
        return self._settle_doubts(attempt, *self.mending.consider_warnings(attempt, examined, known))

    def _settle_doubts(self, attempt: Attempt, examined: Examination, doubts: list[str]) -> Examination:
        """Ask the Planner once, before the run, about problems of the expectations themselves."""
        assert examined.loaded is not None
        plan = self.agreement.plan
        held = held_at_start(examined.loaded, [name for name in self.agreement.names if name not in plan.keeps])
        fresh = {name: row for name, row in held.items() if ("held-at-start", name) not in self._known_warnings}
        self._known_warnings |= {("held-at-start", name) for name in fresh}
        doubts = [*doubts, *fresh.values(), *self._too_dear(attempt, examined)]
        if not doubts:
            return examined
        self.emit("doubted", number=attempt.number, doubts=doubts[:20])
        rules = frozenset(problem.rule for problem in examined.warnings)
        decision = self._decide(attempt, AttemptReport(doubts=doubts, rules=rules), before_run=True)
        if decision.action == "give_up":
            return examined  # run it anyway, since the doubts may be wrong
        agreed, (alone, _) = copy(self.agreement), self.agreement.changed(attempt.text, decision)
        text, _ = self._revised(attempt, decision)
        for version in (text, alone):  # contract and case change together
            if (adopted := self.mending.adopt(attempt, version, examined)) is not examined:
                return adopted
        self.agreement.restore(agreed)
        self.workshop.referred.append(f"Not done before the run, because it left the case wrong: {decision.why}")
        return examined

    def _too_dear(self, attempt: Attempt, examined: Examination) -> list[str]:
        """Report once, before the first run, that it may take too much of the time left."""
        now = self.limits.minutes_left()
        if now is None or "dear" in {rule for rule, _ in self._known_warnings} or any(one.pace for one in self.made):
            return []
        left, needed = self.attempts.minutes_left(attempt, now), examined.seconds / 60
        if left is None or needed <= MAX_UNASKED_SHARE * left:
            return []
        self._known_warnings.add(("dear", ""))
        estimate = (
            f"a run is estimated at {needed:.0f} minutes (within a factor of three) of the {left:.0f} that are left"
        )
        return [f"{estimate}, and several may be needed: shorten it, coarsen the cells, or take a cheaper solver"]

    # --- decisions --------------------------------------------------------------------------------------------

    def _decide(self, attempt: Attempt, report: AttemptReport, *, before_run: bool = False) -> Decision:
        failures = [failure["what"] for failure in (report.critique or {}).get("failures", ())]
        text = " ".join([*report.problems, *failures, (report.critique or {}).get("summary", ""), attempt.state])
        plan = self.agreement.plan
        shows = {*report.rules, attempt.state, *failure_signatures(plan.checks, attempt.expect, attempt.evidence)}
        offer = self.dealt.offer(text, plan.mode, shows, plan_text(plan))
        report.referred, self.workshop.referred = self.workshop.referred, []
        report.left, minutes = self._time_left()
        tryable = not before_run and not report.problems
        choices = Choices(
            anew=not (before_run or self.agreement.planned_anew or self.only_if_accepted),
            trials=affordable(max(one.wall for one in self.made), minutes) if tryable else 0,
            earlier={} if before_run else self._earlier(attempt),
        )
        if attempt.sound(self.agreement.names) and not report.referred:
            decision = decision_to_film(report.critique)
            if decision is not None:
                return self._emit_decision(attempt, decision)
        decision = self._ask_planner(attempt, report, offer, choices)
        for rounds_left in reversed(range(MAX_TRIAL_ROUNDS)):
            if decision.action != "try":
                break
            outcomes = self._run_trials(attempt, decision, choices, minutes)
            report.trials = f"{report.trials}\n{outcomes}".strip()
            report.left, minutes = self._time_left()
            choices.trials = affordable(max(one.wall for one in self.made), minutes) if rounds_left else 0
            decision = self._ask_planner(attempt, report, offer, choices)
        return decision

    def _ask_planner(self, attempt: Attempt, report: AttemptReport, offer: str, choices: Choices) -> Decision:
        decision = decide(
            self.chat, self.request, self.agreement, attempt.text, self._history(), report, offer, self.dealt,
            self.path, choices,
        )  # fmt: skip
        return self._emit_decision(attempt, decision)

    def _emit_decision(self, attempt: Attempt, decision: Decision) -> Decision:
        self.emit("decided", number=attempt.number, action=decision.action, why=decision.why, take=decision.take,
                  routes={route.section: route.instruction for route in decision.routes})  # fmt: skip
        return decision

    def _earlier(self, attempt: Attempt) -> dict[int, tuple[str, Agreement]]:
        """Return the text and agreement of the earlier attempts that can be changed instead of the latest."""
        return {
            one.number: (one.text, copy(self._agreed[one.number]))
            for one in self.made
            if one is not attempt
            and one.number in self._agreed
            and self._agreed[one.number].same_checks(self.agreement)
        }

    def _run_trials(self, attempt: Attempt, decision: Decision, choices: Choices, minutes: float | None) -> str:
        """Run the trials of a decision, and describe their outcomes."""
        text = attempt.text if decision.back_to is None else choices.earlier[decision.back_to][0]
        patches = [attempt.critique["patches"][k - 1] for k in decision.take] if attempt.critique else []
        text, _ = revising.with_patches(text, patches, self.path, None)
        seconds = self.limits.timeout() if minutes is None else TRIALS_SHARE * 60 * minutes
        outcomes = self.attempts.trials(attempt, text, decision.trials, seconds, self.progress)
        self.emit("trials", number=attempt.number, rows=outcomes.splitlines())
        return outcomes

    def left(self) -> str:
        """Return a sentence with the attempts and time left; a resumed loop gets the same one again."""
        return self._time_left()[0]

    def _time_left(self) -> tuple[str, float | None]:
        """Return that sentence, and the minutes left in it; None without a limit."""
        attempt = self.made[-1] if self.made else Attempt(0, "", "before the first")
        minutes = self.attempts.minutes_left(attempt, self.limits.minutes_left())
        words = [f"{self.limits.attempts - attempt.number} of {self.limits.attempts} attempts are left"]
        if minutes is not None:
            words.append(f"{minutes:.0f} minutes are left for everything")
        # The run of an attempt that was a trial before takes no time.
        longest = max(self.made[-RECENT_RUNS:], key=lambda one: one.wall, default=attempt)
        if longest.wall:
            took = f"took {longest.wall:.0f} s of wall time, of which {longest.pace:.3g} s per simulated second"
            words.append(f"the run of attempt {longest.number} {took}, the rest for start, judging and film")
        return "; ".join(words) + ".", minutes

    def _history(self) -> str:
        return "\n".join(one.history_row() for one in self.made)

    def _revised(self, attempt: Attempt, decision: Decision) -> tuple[str, list[str]]:
        """Carry out a decision; return the new text, and the reasons for refused patches."""
        text, routes, base = attempt.text, list(decision.routes), attempt
        if decision.back_to is not None:
            text, agreed = self._earlier(attempt)[decision.back_to]
            base = next(one for one in self.made if one.number == decision.back_to)
            self.agreement.go_back_to(agreed)
        text = self.agreement.apply(text, decision)
        patches = dict(enumerate((attempt.critique or {}).get("patches", ()), 1))
        taken = [k for k in patches if k in decision.take]
        text, reasons = revising.with_patches(
            text, [patches[k] for k in taken], self.path, self.agreement.contract
        )  # fmt: skip
        fates = {k: f"refused: {reason}" if reason else "taken" for k, reason in zip(taken, reasons, strict=True)}
        attempt.fates += [fates.get(k, f"not taken: {decision.why}") for k in patches]
        left_out = [*filter(None, reasons)]
        self.attempts.keep(attempt)
        if decision.plan is not None:
            briefs = decision.plan.briefs.items()
            routes += [Route(section=section, instruction=brief) for section, brief in briefs]
            text, instructions = self.workshop.add_assets(text, decision.plan.assets)
            routes += instructions
        return self.workshop.follow_routes(text, routes, what_holds(base)), left_out

    # --- outcome ----------------------------------------------------------------------------------------------

    def outcome(self, state: State, why: str) -> LoopOutcome:
        """Publish the best attempt, and return the outcome."""
        best = best_of(self.made, self.agreement.names) if self.made else None
        unresolved: list[str] = []
        if best is not None:
            if best.accepted or not self.only_if_accepted:
                self.attempts.publish(best)
            missed = best.missed(self.agreement.names)
            unresolved = [f"{name}: {self.agreement.plan.says.get(name, '')}" for name in missed]
            unresolved += best.shortcomings(self.request.requirements)
        self.emit("ended", state=state, why=why, best=best.number if best else None)
        return LoopOutcome(state, why, best, unresolved, self.agreement.plan)
