"""The Planner's first answer about an existing case that is to be changed."""

from pathlib import Path

from text2sim.agents import language, revising
from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import FROZEN_PARTS, examine, format_problem
from text2sim.agents.conversation import Conversation, Wrong, typed_parser
from text2sim.agents.decision_faults import foreign_operations
from text2sim.agents.facts import claim_faults
from text2sim.agents.page_requests import PageRequests
from text2sim.agents.planning import PLANNER, Request, limit_faults
from text2sim.agents.rehearsal import RESERVED_NAMES
from text2sim.agents.replies import Decision, Opening
from text2sim.agents.roles import render, system_prompt
from text2sim.spec_schema.changes.patch import PatchError
from text2sim.spec_schema.errors import SpecError


def open_case(
    chat: Conversation,
    request: Request,
    agreement: Agreement,
    case: str,
    evidence: str,
    path: Path,
    *,
    keep: bool,
    left: str,
) -> Opening:
    """Have the Planner open work on an existing case.

    Args:
        chat: The conversation with the models.
        request: The request.
        agreement: The plan and its contract.
        case: Text of the case.
        evidence: Summary of its run.
        path: Path of the case file.
        keep: Whether all its expectations must stay.
        left: Sentence with the attempts and time left.
    """
    checks = agreement.plan.checks

    def check(opening: Opening) -> None:
        wrong = limit_faults(opening, request.requirements)
        if opening.possible != "no" and not (opening.routes or opening.params or opening.patch):
            wrong.append("/routes: say which Writer does what")
        wrong += [f"/drop: there is no expectation `{name}`" for name in opening.drop if name not in checks.expect]
        wrong += [f"/drop/{name}: what the case expects stays; mend the case" for name in opening.drop if keep]
        wrong += [
            f"/checks/expect/{name}: there is one of this name"
            for name in opening.checks.expect
            if name in checks.expect
        ]
        wrong += [
            f"/says/{name}: say which sentence it stands for"
            for name in opening.checks.expect
            if name not in opening.says
        ]
        wrong += foreign_operations(opening.patch)
        new = any(route.section == "bodies" for route in opening.routes)
        named_bodies = [body for rows in opening.facts.values() for row in rows for body in row.bodies] if new else []
        wrong += claim_faults(opening.facts, request.requirements, [*agreement.plan.bodies, *named_bodies])
        if not wrong and opening.possible != "no":
            wrong = _opening_faults(opening, agreement, case, path)
        if wrong:
            raise Wrong(wrong)

    rules, kinds = language.rules(brief=True), language.kinds_to_expect_with()
    system = system_prompt(PLANNER, "open", taken=", ".join(RESERVED_NAMES), rules=rules, kinds=kinds)
    rows = {name: one.what for name, one in request.requirements.items()}
    question = render("open_ask", request=request.text, requirements=rows, case=case, evidence=evidence, left=left)
    return chat.ask(
        "planner", system, question, typed_parser(Opening, check), request.images, read_pages=PageRequests()
    )


def as_decision(opening: Opening) -> Decision:
    """Return the decision that is equivalent to an opening."""
    return Decision(action="repair", why=opening.why or opening.event, params=opening.params, patch=opening.patch)


def _opening_faults(opening: Opening, agreement: Agreement, case: str, path: Path) -> list[str]:
    """Faults of an opening that do not depend on the Writers' work."""
    try:
        text, _ = agreement.changed(revising.with_checks(case, opening.checks, opening.drop), as_decision(opening))
    except (PatchError, SpecError) as error:
        return [f"/patch: {str(error).splitlines()[0]}"]
    pointers = [f"/actions/{part}/{name}" for part in FROZEN_PARTS for name in getattr(opening.checks, part)]
    pointers += [*agreement.pointers, *(f"/params/{name}" for name in opening.params)] + [
        "/waive",
        "/variants",
        "/sweeps",
        "/prefabs",
    ]
    before = {(problem.path, problem.rule) for problem in examine(case, path).errors}
    fresh = [one for one in examine(text, path).errors if (one.path, one.rule) not in before]
    # Bodies that a Writer is asked to add do not exist yet.
    later = {
        "unknown-body",
        "unknown-link",
        "unknown-joint",
        "no-such-copy",
        "no-copies",
        "unknown-attach",
        "unknown-spring",
    }
    if any(route.section == "bodies" for route in opening.routes):  # nor are joints as they will be
        later |= {"dead-event", "dead-measure", "cannot-hold", "target-out-of-range"}
    return [
        format_problem(p) for p in fresh if p.rule not in later and any(p.path.startswith(place) for place in pointers)
    ]
