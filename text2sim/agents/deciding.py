"""Decisions of the Planner about an attempt, tested on a copy before they are carried out."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from text2sim.agents.agreement import Agreement
from text2sim.agents.attempt_report import AttemptReport, Choices
from text2sim.agents.conversation import Conversation, RoleFailed, Wrong, typed_parser
from text2sim.agents.decision_faults import decision_faults
from text2sim.agents.planning import PLANNER, Request, plan_text
from text2sim.agents.rehearsal import RESERVED_NAMES
from text2sim.agents.replies import Decision
from text2sim.agents.roles import render, system_prompt

if TYPE_CHECKING:
    from text2sim.agents.dealt_cards import DealtCards


def decide(
    chat: Conversation,
    request: Request,
    agreement: Agreement,
    case: str,
    history: str,
    report: AttemptReport,
    offer: str,
    dealt: "DealtCards",
    path: Path,
    choices: Choices,
) -> Decision:
    """Have the Planner decide about an attempt that was not accepted.

    Args:
        chat: The conversation with the models.
        request: The request.
        agreement: The plan and its contract.
        case: Text of the attempt.
        history: One line for each attempt.
        report: Report on the latest attempt.
        offer: One line for each card that may fit.
        dealt: The Debug Cards.
        path: Path of the case file.
        choices: What the Planner may choose from.

    Raises:
        RoleFailed: If no part of an answer is usable.
        BudgetSpent: If the budget is used up.
        ModelError: If the model cannot be reached.
    """
    last: list[Decision] = []

    def faults(decision: Decision) -> list[str]:
        return decision_faults(decision, agreement, case, report, dealt, path, choices, request.requirements)

    def check(decision: Decision) -> None:
        last.append(decision)
        if wrong := faults(decision):
            raise Wrong(wrong)

    question = render(
        "decide_ask",
        request=request.text,
        plan=plan_text(agreement.plan),
        history=history,
        report=str(report),
        left=f"{report.left} {choices.text(agreement.plan.params)}",
        cards=offer,
    )
    system = system_prompt(PLANNER, "decide", taken=", ".join(RESERVED_NAMES))
    try:
        return chat.ask("planner", system, question, typed_parser(Decision, check))
    except RoleFailed as failed:
        if not last or (sound := _sound_part(last[-1], faults)) is None:
            raise
        return sound.model_copy(update={"why": f"{sound.why} (without what could not be done: {failed.reasons[0]})"})


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
