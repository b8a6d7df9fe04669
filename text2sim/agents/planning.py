"""Planning: the Planner turns a request into a plan with expectations."""

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from text2sim.agents import language
from text2sim.agents.assembly import FROZEN_PARTS
from text2sim.agents.contract import weakened_bounds
from text2sim.agents.conversation import Conversation, Wrong, typed_parser
from text2sim.agents.facts import claim_faults
from text2sim.agents.models.exchange import Image
from text2sim.agents.offered_cards import MAX_GIVEN_CARDS
from text2sim.agents.page_requests import PageRequests
from text2sim.agents.rehearsal import MODES, plan_faults
from text2sim.agents.replies import SECTIONS, Asset, CasePlan, Fragments, Opening, PlannedBody, PlanPatch
from text2sim.agents.requirements import Requirements, requirement_rows
from text2sim.agents.roles import ROLES, render, system_prompt
from text2sim.agents.yaml_text import yaml_text

if TYPE_CHECKING:
    from text2sim.agents.offered_cards import OfferedCards

PLANNER = ROLES["planner"]
BLIND_NOTE = "You cannot see these pictures: go by the words, and say under `assumptions` what you took them to show."


@dataclass(frozen=True)
class Request:
    """A user's request."""

    text: str
    images: tuple[Image, ...] = ()
    inputs: tuple[str, ...] = ()
    """Descriptions of its files."""
    requirements: Requirements = field(default_factory=dict)
    """Its atomic requirements; empty if they could not be extracted."""
    minutes: float | None = None
    """Wall time for the whole loop [min]; None without a limit."""


@dataclass(frozen=True)
class TriedPlan:
    """Result of an earlier plan."""

    why: str
    """Reason for a new plan."""
    history: str
    plan: CasePlan
    first: Fragments
    """The original expectations, which a new plan must keep."""
    left: str = ""
    """Sentence with the attempts and time left."""


MAX_PLAN_ANSWERS = 6
"""Largest number of answers before planning fails, which ends the loop."""


def make_plan(
    chat: Conversation, request: Request, offered: "OfferedCards", path: Path, tried: TriedPlan | None = None
) -> CasePlan:
    """Ask the Planner for a plan; it may read some pages first.

    Args:
        chat: The conversation with the models.
        request: The request.
        offered: The cards.
        path: Future path of the case file.
        tried: Result of the earlier plan, if this is a new one.
    """
    question = render(
        "plan_ask",
        request=request.text,
        inputs=[*request.inputs, *([BLIND_NOTE] if request.images and not chat.vision("planner") else [])],
        requirements=requirement_rows(request.requirements),
        minutes=request.minutes,
        tried=_tried_plan_text(tried),
    )
    system = system_prompt(
        PLANNER,
        vocabulary=language.vocabulary(),
        rules=language.rules(brief=True),
        pages=language.to_plan_with(),
        cards=offered.card_ids(),
        modes=", ".join(MODES),
    )
    read = typed_parser(CasePlan, lambda plan: _check_plan(plan, offered, path, request.requirements, tried))
    more = PageRequests(offered.pages, examples=False)
    plan = chat.ask("planner", system, question, read, request.images, read_pages=more, rounds=MAX_PLAN_ANSWERS)
    # Only the causes of the most important effects are tested.
    importance = {name: requirement.importance for name, requirement in request.requirements.items()}
    causes = sorted(plan.causes.items(), key=lambda row: -importance.get(row[0], 0))
    return plan.model_copy(update={"causes": dict(causes)})


def _tried_plan_text(tried: TriedPlan | None) -> str:
    if tried is None:
        return ""
    expect = yaml_text({"says": tried.plan.says, "checks": {"expect": tried.first.expect}})
    left = f"\n\nLeft: {tried.left}" if tried.left else ""
    report = (
        f"{tried.why}\n\nAttempts so far:\n\n{tried.history}\n\nThe plan was:\n\n{plan_text(tried.plan)}\n\n{expect}"
    )
    return report + left


def _check_plan(
    plan: CasePlan, offered: "OfferedCards", path: Path, requirements: Requirements, tried: TriedPlan | None
) -> None:
    if plan.possible == "no":
        if not plan.why:
            raise Wrong(["/why: say why it cannot be done"])
        return
    wrong = limit_faults(plan, requirements)
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
    wrong += [f"/assets: {fault}" for fault in asset_faults(plan.assets, plan.bodies)]
    wrong += binding_faults(plan, requirements, plan.checks.expect)
    if tried is not None:
        wrong += [
            f"/checks/expect/{name}: it comes from the request and must stay, under its name"
            for name in tried.first.expect
            if name not in plan.checks.expect
        ]
        same_names = {name: row for name, row in plan.checks.expect.items() if name in tried.first.expect}
        wrong += weakened_bounds(tried.first.expect, same_names)
    wrong += claim_faults(plan.facts, requirements, plan.bodies)
    wrong += card_faults(plan.cards, offered)
    wrong += plan_faults(plan, path)
    if wrong:
        raise Wrong(wrong)


def limit_faults(plan: CasePlan | Opening, requirements: Iterable[str]) -> list[str]:
    """Describe what is wrong with the requirements that a plan declares impossible."""
    known = list(requirements)
    if plan.possible != "partly":
        return ["/cannot: it goes with `possible: partly`"] if plan.cannot else []
    if not (plan.cannot if known else plan.why):
        return ["/cannot: name the requirements that cannot be met, each with the reason" if known else "/why: say it"]
    return [f"/cannot/{name}: there is no requirement `{name}`" for name in plan.cannot if name not in known]


def binding_faults(plan: CasePlan | PlanPatch, requirements: Iterable[str], expected: Container[str]) -> list[str]:
    """Describe unknown requirements and expectations under `meets` and `causes`.

    Args:
        plan: The plan, or a change of it.
        requirements: Names of the requirements.
        expected: Names of the expectations.
    """
    known = list(requirements)
    wrong = [
        f"/{part}/{name}: there is no requirement `{name}`; there are {', '.join(known)}"
        for part in ("meets", "causes")
        for name in getattr(plan, part)
        if name not in known
    ]
    return wrong + [
        f"/meets/{name}: there is no expectation `{row}` in checks"
        for name, bound in plan.meets.items()
        for row in bound
        if row not in expected
    ]


def asset_faults(assets: Iterable[Asset], bodies: Mapping[str, PlannedBody]) -> list[str]:
    """Describe the assets that no planned body can take."""
    wrong = []
    for asset in assets:
        kind = bodies[asset.body].kind if asset.body in bodies else None
        if kind is None:
            wrong.append(f"`{asset.body}` is not a body of the plan")
        elif asset.kind == "mesh" and kind in language.body_kinds() and not language.shapes_of(kind):
            remedy = ": ask for a `mechanism`, or plan the part as a body of its own" if kind == "articulated" else ""
            wrong.append(f"`{asset.body}` is {kind}, which takes no mesh{remedy}")
    return wrong


def card_faults(cards: Mapping[str, Sequence[str]], offered: "OfferedCards") -> list[str]:
    """Describe the unknown roles and card ids of a plan."""
    wrong = [f"/cards/{role}: there is no Writer `{role}`" for role in cards if role not in SECTIONS]
    for role, ids in cards.items():
        if len(ids) > MAX_GIVEN_CARDS:
            wrong.append(f"/cards/{role}: {MAX_GIVEN_CARDS} cards at most go with one question")
        wrong += [
            f"/cards/{role}: there is no card `{card}`" for card in ids if offered.in_use and not offered.has(card)
        ]
    return wrong


def plan_text(plan: CasePlan) -> str:
    """Return a plan as YAML, without the parts that only the Planner needs."""
    data = plan.model_dump(mode="json", exclude={"cards", "briefs", "possible", "why", "assets"}, exclude_defaults=True)
    for part in FROZEN_PARTS:
        if "checks" in data and not data["checks"].get(part):
            data["checks"].pop(part, None)
    return yaml_text(data)
