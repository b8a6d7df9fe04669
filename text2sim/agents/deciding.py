"""Decisions about an attempt: made by the Planner, tested on a copy, after trials if it wants them, and carried out."""

from collections.abc import Callable
from typing import Any

from text2sim.agents import revising
from text2sim.agents.attempt import Attempt
from text2sim.agents.attempt_report import AttemptReport, Choices
from text2sim.agents.attempts import Attempts
from text2sim.agents.conversation import RoleFailed, Wrong, typed_parser
from text2sim.agents.critic_view import what_holds
from text2sim.agents.criticism import decision_to_film
from text2sim.agents.decision_faults import decision_faults
from text2sim.agents.history import History
from text2sim.agents.loop_result import LoopLimits
from text2sim.agents.offered_cards import failure_signatures
from text2sim.agents.planning import PLANNER, plan_text
from text2sim.agents.rehearsal import RESERVED_NAMES
from text2sim.agents.replies import Decision, Route
from text2sim.agents.roles import render, system_prompt
from text2sim.agents.trials import MAX_TRIAL_ROUNDS, TRIALS_SHARE, affordable
from text2sim.agents.writer_team import Workshop


class Deciding:
    """Has the Planner decide about attempts that were not accepted, and carries out its decisions.

    Args:
        workshop: The Writers, with the request, the agreement and the cards.
        history: The attempts so far.
        attempts: Their folder, where trials are run.
        limits: Bounds of attempts and time.
        progress: Callback for the progress of a simulation.
    """

    def __init__(
        self,
        workshop: Workshop,
        history: History,
        attempts: Attempts,
        limits: LoopLimits,
        progress: Callable[[Any], None],
    ) -> None:
        self.workshop, self.history, self.attempts = workshop, history, attempts
        self.limits, self.progress = limits, progress

    def decide(self, attempt: Attempt, report: AttemptReport, *, before_run: bool = False) -> Decision:
        """Return the decision about an attempt.

        Args:
            attempt: The latest attempt.
            report: What the Planner is told of it; completed here.
            before_run: Whether it has not been run yet, so that there is nothing but doubts to decide about.

        Raises:
            RoleFailed: If no part of an answer is usable.
            BudgetSpent: If the budget is used up.
            ModelError: If the model cannot be reached.
        """
        workshop, plan = self.workshop, self.workshop.agreement.plan
        critique = report.critique or {}
        failures = [failure["what"] for failure in critique.get("failures", ())]
        text = " ".join([*report.problems, *failures, critique.get("summary", ""), attempt.state])
        shows = {*report.rules, attempt.state, *failure_signatures(plan.checks, attempt.expect, attempt.evidence)}
        offer = workshop.offered.offer(text, plan.mode, shows, plan_text(plan))
        report.referred, workshop.referred = workshop.referred, []
        report.left, minutes = self.history.time_left()
        tryable = not before_run and not report.problems
        choices = Choices(
            anew=not (before_run or workshop.agreement.replanned or self.history.base),
            trials=self._affordable_trials(minutes) if tryable else 0,
            earlier={} if before_run else self.history.earlier(attempt, workshop.agreement),
        )
        if attempt.sound(workshop.agreement.names) and not report.referred:
            decision = decision_to_film(report.critique, attempt.text, self.workshop.path)
            if decision is not None:
                return self._emitted(attempt, decision)
        decision = self._ask_planner(attempt, report, offer, choices)
        for rounds_left in reversed(range(MAX_TRIAL_ROUNDS)):
            if decision.action != "try":
                break
            outcomes = self._run_trials(attempt, decision, choices, minutes)
            report.trials = f"{report.trials}\n{outcomes}".strip()
            report.left, minutes = self.history.time_left()
            choices.trials = self._affordable_trials(minutes) if rounds_left else 0
            decision = self._ask_planner(attempt, report, offer, choices)
        return decision

    def carry_out(self, attempt: Attempt, decision: Decision) -> tuple[str, list[str]]:
        """Carry out a decision; return the text of the next version, and the reasons for refused patches.

        Args:
            attempt: The attempt that was decided about; it gets the fates of the Critic's patches.
            decision: The decision.
        """
        agreement = self.workshop.agreement
        text, routes, base = attempt.text, list(decision.routes), attempt
        if decision.back_to is not None:
            text, agreed = self.history.earlier(attempt, agreement)[decision.back_to]
            base = next(one for one in self.history.made if one.number == decision.back_to)
            agreement.go_back_to(agreed)
        text = agreement.apply(text, decision)
        patches = dict(enumerate((attempt.critique or {}).get("patches", ()), 1))
        taken = [k for k in patches if k in decision.take]
        text, reasons = revising.with_patches(
            text, [patches[k] for k in taken], self.workshop.path, agreement.contract
        )  # fmt: skip
        text = revising.with_params(text, decision.params)  # the Planner's value counts, also if a patch sets it
        fates = {k: f"refused: {reason}" if reason else "taken" for k, reason in zip(taken, reasons, strict=True)}
        attempt.fates += [fates.get(k, f"not taken: {decision.why}") for k in patches]
        self.attempts.keep(attempt)
        if decision.plan is not None:
            briefs = decision.plan.briefs.items()
            routes += [Route(section=section, instruction=brief) for section, brief in briefs]
            text, instructions = self.workshop.add_assets(text, decision.plan.assets)
            routes += instructions
        return self.workshop.follow_routes(text, routes, what_holds(base)), [*filter(None, reasons)]

    def _ask_planner(self, attempt: Attempt, report: AttemptReport, offer: str, choices: Choices) -> Decision:
        """Ask the Planner; of an answer that stays faulty the sound part is returned.

        Args:
            attempt: The latest attempt.
            report: Report on it.
            offer: One line for each card that may fit.
            choices: What the Planner may choose from.
        """
        workshop, last = self.workshop, list[Decision]()
        agreement, request = workshop.agreement, workshop.request

        def faults(decision: Decision) -> list[str]:
            return decision_faults(
                decision,
                agreement,
                attempt.text,
                report,
                workshop.offered,
                workshop.path,
                choices,
                request.requirements,
            )

        def check(decision: Decision) -> None:
            last.append(decision)
            if wrong := faults(decision):
                raise Wrong(wrong)

        question = render(
            "decide_ask",
            request=request.text,
            plan=plan_text(agreement.plan),
            history=self.history.rows(),
            report=str(report),
            left=f"{report.left} {choices.text(agreement.plan.params)}",
            cards=offer,
        )
        system = system_prompt(PLANNER, "decide", taken=", ".join(RESERVED_NAMES))
        try:
            decision = workshop.chat.ask("planner", system, question, typed_parser(Decision, check))
        except RoleFailed as failed:
            if not last or (sound := _sound_part(last[-1], faults)) is None:
                raise
            decision = sound.model_copy(
                update={"why": f"{sound.why} (without what could not be done: {failed.reasons[0]})"}
            )
        return self._emitted(attempt, decision)

    def _emitted(self, attempt: Attempt, decision: Decision) -> Decision:
        self.workshop.emit(
            "decided", number=attempt.number, action=decision.action, why=decision.why, take=decision.take,
            routes={route.section: route.instruction for route in decision.routes},
        )  # fmt: skip
        return decision

    def _affordable_trials(self, minutes: float | None) -> int:
        return affordable(max(one.wall for one in self.history.made), minutes)

    def _run_trials(self, attempt: Attempt, decision: Decision, choices: Choices, minutes: float | None) -> str:
        """Run the trials of a decision, and describe their outcomes."""
        text = attempt.text if decision.back_to is None else choices.earlier[decision.back_to][0]
        patches = [attempt.critique["patches"][k - 1] for k in decision.take] if attempt.critique else []
        text, _ = revising.with_patches(text, patches, self.workshop.path, None)
        seconds = self.limits.timeout() if minutes is None else TRIALS_SHARE * 60 * minutes
        outcomes = self.attempts.trials(attempt, text, decision.trials, seconds, self.progress)
        self.workshop.emit("trials", number=attempt.number, rows=outcomes.splitlines())
        return outcomes


def _sound_part(decision: Decision, faults: Callable[[Decision], list[str]]) -> Decision | None:
    """The valid part of a decision; None if there is none."""
    if decision.action == "try":
        rest = {"action": "try", "why": decision.why, "take": decision.take, "back_to": decision.back_to}
        sound = [one for one in decision.trials if not faults(Decision(**rest, trials=[one]))]
        if sound and not faults(trying := Decision(**rest, trials=sound)):
            return trying
    routes = [route.model_copy(update={"cards": []}) for route in decision.routes]
    kept: Decision | None = None
    for key in ("routes", "take", "params", "patch", "waive", "restate", "plan"):
        value = routes if key == "routes" else getattr(decision, key)
        base = kept or Decision(action="repair", why=decision.why, back_to=decision.back_to)
        if value and not faults(more := Decision.model_validate(base.model_dump(exclude_unset=True) | {key: value})):
            kept = more
    return kept
