"""The Planner: it alone reads the card library, defines success, and decides what is done next."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.agents import language
from text2sim.agents.asking import Desk, Wrong, typed
from text2sim.agents.casework import FROZEN_PARTS
from text2sim.agents.contract import weakened
from text2sim.agents.models.exchange import Image
from text2sim.agents.rehearsal import TAKEN, plan_faults
from text2sim.agents.replies import SECTIONS, Decision, Fragments, Opening, Plan
from text2sim.agents.requirements import Requirements, rows
from text2sim.agents.roles import ROLES, render, system_prompt
from text2sim.agents.shelf import Shelf
from text2sim.agents.yaml_text import yaml_text

if TYPE_CHECKING:
    from text2sim.agents.deck import Deck

PLANNER = ROLES["planner"]


@dataclass(frozen=True)
class Request:
    """What somebody wants."""

    text: str
    images: tuple[Image, ...] = ()
    inputs: tuple[str, ...] = ()
    """Files that came with it, in words."""
    requirements: Requirements = field(default_factory=dict)
    """What it asks for, one thing at a time; empty if nobody has taken it apart."""


@dataclass
class Report:
    """What the Planner is told of an attempt."""

    problems: Sequence[str] = ()
    """What the checker said, if it could not be run."""
    evidence: str = ""
    critique: Mapping[str, Any] | None = None
    rules: frozenset[str] = frozenset()
    """Ids of the lint's rules that found something."""


def make_plan(desk: Desk, request: Request, deck: "Deck", path: Path) -> Plan:
    """Have a request planned; the Planner may read some pages first.

    Args:
        desk: Where it is asked.
        request: What is wanted.
        deck: The cards.
        path: Where the case will stand.
    """
    asked = rows(request.requirements)
    question = render("plan_ask", request=request.text, inputs=request.inputs, requirements=asked)
    system = system_prompt(
        PLANNER,
        vocabulary=language.vocabulary(),
        rules=language.rules(brief=True),
        pages=language.to_plan_with(),
        cards=deck.index(),
        taken=", ".join(TAKEN),
    )
    read = typed(Plan, lambda plan: _check_plan(plan, deck, path, request.requirements))
    return desk.ask("planner", system, question, read, request.images, more=Shelf(deck.pages))


def _check_plan(plan: Plan, deck: "Deck", path: Path, requirements: Requirements) -> None:
    if plan.possible == "no":
        if not plan.why:
            raise Wrong(["/why: say why it cannot be done"])
        return
    wrong = []
    if not plan.bodies:
        wrong.append("/bodies: name every body and static")
    if not plan.checks.expect:
        wrong.append("/checks/expect: at least one expectation has to follow from the request")
    for part, names in (("says", plan.says), ("keeps", plan.keeps)):
        wrong += [
            f"/{part}/{name}: there is no expectation `{name}` in checks"
            for name in names
            if name not in plan.checks.expect
        ]
    wrong += [f"/says/{name}: say which sentence it stands for" for name in plan.checks.expect if name not in plan.says]
    wrong += [
        f"/assets: `{asset.body}` is not a body of the plan" for asset in plan.assets if asset.body not in plan.bodies
    ]
    wrong += [
        f"/{part}/{name}: there is no requirement `{name}`; there are {', '.join(requirements)}"
        for part in ("meets", "causes")
        for name in getattr(plan, part)
        if name not in requirements
    ]
    wrong += [
        f"/meets/{name}: there is no expectation `{row}` in checks"
        for name, bound in plan.meets.items()
        for row in bound
        if row not in plan.checks.expect
    ]
    wrong += card_faults(plan.cards, deck)
    wrong += plan_faults(plan, path)
    if wrong:
        raise Wrong(wrong)


def card_faults(cards: Mapping[str, Sequence[str]], deck: "Deck") -> list[str]:
    """Say which cards nobody would get: of a role or an id that there is not."""
    wrong = [f"/cards/{role}: there is no Writer `{role}`" for role in cards if role not in SECTIONS]
    for role, ids in cards.items():
        wrong += [f"/cards/{role}: there is no card `{card}`" for card in ids if deck.dealing and not deck.has(card)]
    return wrong


def open_case(
    desk: Desk, request: Request, case: str, evidence: str, loaded_expect: Sequence[str], *, keep: bool
) -> Opening:
    """Have the Planner take up a wish about a case that is there already; `keep` if all its expectations must stay."""

    def check(opening: Opening) -> None:
        wrong = []
        if opening.possible != "no" and not (opening.routes or opening.params):
            wrong.append("/routes: say which Writer does what")
        wrong += [f"/drop: there is no expectation `{name}`" for name in opening.drop if name not in loaded_expect]
        wrong += [f"/drop/{name}: what the case expects stays; mend the case" for name in opening.drop if keep]
        wrong += [
            f"/checks/expect/{name}: there is one of this name"
            for name in opening.checks.expect
            if name in loaded_expect
        ]
        wrong += [
            f"/says/{name}: say which sentence it stands for"
            for name in opening.checks.expect
            if name not in opening.says
        ]
        if wrong:
            raise Wrong(wrong)

    system = system_prompt(PLANNER, "open", rules=language.rules(brief=True), pages=language.to_plan_with())
    question = render("open_ask", request=request.text, case=case, evidence=evidence)
    return desk.ask("planner", system, question, typed(Opening, check), request.images)


def decide(
    desk: Desk, request: Request, plan: Plan, first: Fragments, history: str, report: Report, cards: str
) -> Decision:
    """Have the Planner decide about an attempt that was not accepted.

    Args:
        desk: Where it is asked.
        request: What is wanted.
        plan: The plan.
        first: Measures, events and expectations as they were put before anything was built.
        history: A line for each attempt.
        report: The last one.
        cards: One line for each card that may fit.
    """
    offered = len((report.critique or {}).get("patches", ()))

    def check(decision: Decision) -> None:
        wrong = [f"/take: there is no patch {k}; there are {offered}" for k in decision.take if not 1 <= k <= offered]
        wrong += [
            f"/waive/{rule}: the lint did not find this here" for rule in decision.waive if rule not in report.rules
        ]
        wrong += [
            f"/waive/{rule}: say why, in ten characters or more"
            for rule, why in decision.waive.items()
            if len(why) < 10
        ]
        if decision.restate is not None:
            wrong += weakened(first.expect, decision.restate.checks.expect)
        busy = decision.take or decision.routes or decision.params or decision.waive or decision.restate
        if decision.action == "repair" and not busy:
            wrong.append("take a patch, route work, or change a parameter: otherwise the next attempt is this one")
        if wrong:
            raise Wrong(wrong)

    question = render(
        "decide_ask", request=request.text, plan=plan_text(plan), history=history, report=_reported(report), cards=cards
    )  # fmt: skip
    return desk.ask("planner", system_prompt(PLANNER, "decide"), question, typed(Decision, check))


def plan_text(plan: Plan) -> str:
    """Return a plan as YAML, without what only the Planner needs."""
    data = plan.model_dump(mode="json", exclude={"cards", "briefs", "possible", "why", "assets"}, exclude_defaults=True)
    for part in FROZEN_PARTS:
        if "checks" in data and not data["checks"].get(part):
            data["checks"].pop(part, None)
    return yaml_text(data)


def _reported(report: Report) -> str:
    parts = []
    if report.problems:
        parts.append(
            "It could not be run. What is wrong, and was not mended by its owners:\n\n" + _rows(report.problems)
        )
    if report.evidence:
        parts.append("# Evidence\n\n" + report.evidence)
    if report.critique is not None:
        critique = dict(report.critique)
        patches = critique.pop("patches", [])
        parts.append("# The Critic\n\n" + yaml_text(critique))
        for number, patch in enumerate(patches, 1):
            parts.append(f"Patch {number}:\n\n" + yaml_text(patch))
    return "\n\n".join(parts)


def _rows(lines: Sequence[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)
