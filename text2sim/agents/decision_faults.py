"""Faults of a decision of the Planner: what is impossible, has no effect, or weakens the request."""

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.agents import revising
from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import FROZEN_PARTS, PLANNER_PARTS, examine, format_problem, owner_of
from text2sim.agents.attempt_report import AttemptReport, Choices
from text2sim.agents.contract import weakened_bounds
from text2sim.agents.counterfactual import cause_faults
from text2sim.agents.facts import claim_faults
from text2sim.agents.planning import asset_faults, binding_faults, card_faults
from text2sim.agents.rehearsal import RESERVED_NAMES, plan_faults
from text2sim.agents.replies import SECTIONS, CasePlan, Decision, PlanPatch
from text2sim.agents.trials import settings_faults
from text2sim.spec_schema.changes.patch import PatchError, same
from text2sim.spec_schema.errors import SpecError

if TYPE_CHECKING:
    from text2sim.agents.offered_cards import OfferedCards

_CLAUSE_START = re.compile(r"(?:^|[.;]\s+|\d[.)]\s+)`?([a-z]\w*)")
"""First word of a sentence, of a clause after a semicolon, or of a numbered item."""


def decision_faults(
    decision: Decision,
    agreement: Agreement,
    case: str,
    report: AttemptReport,
    cards: "OfferedCards",
    path: Path,
    choices: Choices,
    requirements: Collection[str] = (),
) -> list[str]:
    """Describe the parts of a decision that are impossible, have no effect, or weaken the request.

    Args:
        decision: The decision.
        agreement: The plan and its contract.
        case: Text of the attempt.
        report: Report on the attempt.
        cards: The Debug Cards.
        path: Path of the case file.
        choices: What the Planner may choose from.
        requirements: Names of the requirements, for facts that the decision adds to the plan.
    """
    if decision.back_to is not None:
        if decision.back_to not in choices.earlier:
            return [f"/back_to: it can be {', '.join(map(str, choices.earlier)) or 'left out only'}"]
        case, agreement = choices.earlier[decision.back_to]
    offered = (report.critique or {}).get("patches", ())
    wrong = [
        f"/take: there is no patch {k}; there are {len(offered)}" for k in decision.take if not 1 <= k <= len(offered)
    ]
    if decision.action == "try":
        return wrong or _trial_faults(decision, case, offered, path, choices.trials)
    work = [key for key in decision.model_fields_set - {"action", "why", "trials", "back_to"} if getattr(decision, key)]
    present = agreement.plan.params
    unchanged = [name for name, value in decision.params.items() if name in present and same(present[name], value)]
    if len(unchanged) == len(decision.params):
        work = [key for key in work if key != "params"]
    if decision.action == "give_up":
        return []
    if decision.action == "plan_anew":
        wrong += [f"/{key}: with `plan_anew` nothing else is done; leave it out" for key in sorted(work)]
        if not choices.anew:
            wrong.append("/action: it was planned anew already, or the case is somebody's own: repair")
        return wrong
    if decision.trials:
        wrong.append("/trials: they need `action: try`")
    wrong += _waiver_faults(decision, report)
    for number, route in enumerate(decision.routes):
        wrong += [f"/routes/{number}{row}" for row in card_faults({route.section: route.cards}, cards)]
    wrong += _misrouted(decision, agreement.plan)
    wrong += [
        f"/params/{n}: expressions know this name; choose another" for n in decision.params if n in RESERVED_NAMES
    ]
    wrong += foreign_operations(decision.patch) + _check_faults(decision, agreement)
    if decision.plan is not None:
        bodies = {*agreement.plan.bodies, *decision.plan.bodies}
        wrong += [f"/plan{row}" for row in claim_faults(decision.plan.facts, requirements, bodies)]
        expected = {*agreement.plan.checks.expect, *decision.plan.checks.expect}
        wrong += [f"/plan{row}" for row in binding_faults(decision.plan, requirements, expected)]
        wrong += _cause_faults(decision, agreement, case) if not wrong else []
    if not (work and (set(work) - {"plan"} or _changes_anything(decision))):
        wrong += [f"/params/{name}: it is {present[name]!r} already" for name in unchanged]
        wrong.append(
            "take a patch, route work, or change a parameter or what is checked: otherwise the next attempt is this one"
        )
    return wrong or _problems_introduced(decision, agreement, case, path, [offered[k - 1] for k in decision.take])


def _misrouted(decision: Decision, plan: CasePlan) -> list[str]:
    """Routes with a clause that begins with the name of what the other of `scene` and `bodies` writes."""
    changed = decision.plan or PlanPatch()
    places = [(f"/routes/{number}", route.section, route.instruction) for number, route in enumerate(decision.routes)]
    places += [(f"/plan/briefs/{section}", section, brief) for section, brief in changed.briefs.items()]
    owners = {
        name: "scene" if body.kind == "static" else "bodies" for name, body in (plan.bodies | changed.bodies).items()
    }
    return [
        f"{place}: `{name}` is written by the `{owners[name]}` Writer: route there what concerns it"
        for place, section, words in places
        if section in ("scene", "bodies")
        for name in dict.fromkeys(_CLAUSE_START.findall(words))
        if owners.get(name, section) != section
    ]


def _cause_faults(decision: Decision, agreement: Agreement, case: str) -> list[str]:
    """Describe faults of the claims about causes that a decision makes or changes."""
    assert decision.plan is not None
    try:
        text, plan = agreement.changed(case, decision)
    except (PatchError, SpecError):
        return []  # reported as an error of the decision itself
    changed = {*decision.plan.causes, *decision.plan.meets}
    claims = plan.model_copy(update={"causes": {name: rows for name, rows in plan.causes.items() if name in changed}})
    return [f"/plan{row}" for row in cause_faults(revising.data_of(text), claims)]


def _waiver_faults(decision: Decision, report: AttemptReport) -> list[str]:
    # A waiver may be for what this very decision will cause; the check refuses names that are not rules.
    changes = bool(decision.take or decision.routes or decision.params or decision.back_to)
    strange = [rule for rule in decision.waive if rule.partition("@")[0] not in report.rules and not changes]
    unexplained = [rule for rule, why in decision.waive.items() if len(why) < 10]
    return [
        *(f"/waive/{rule}: the lint did not find this here" for rule in strange),
        *(f"/waive/{rule}: say why, in ten characters or more" for rule in unexplained),
    ]


def _trial_faults(decision: Decision, case: str, patches: Sequence[Any], path: Path, allowed: int) -> list[str]:
    """Describe faults of a decision to run trials first."""
    if not allowed:
        return ["/action: no trials now, there were some already or time is short: repair"]
    rest = sorted(decision.model_fields_set - {"action", "why", "trials", "take", "back_to"})
    used = [key for key in rest if getattr(decision, key)]
    wrong = [f"/{key}: leave it out; with `try` only `trials`, `take` and `back_to` count" for key in used]
    if not 1 <= len(decision.trials) <= allowed:
        wrong.append(f"/trials: give 1 to {allowed} of them (got {len(decision.trials)})")
    text, refused = revising.with_patches(case, [patches[k - 1] for k in decision.take], path, None)
    return wrong or [*filter(None, refused)] or settings_faults(text, decision.trials, path)


def _changes_anything(decision: Decision) -> bool:
    """Whether a change of the plan also changes the case or creates work for a Writer."""
    plan = decision.plan
    names = ("duration", "rename", "briefs", "assets", "keeps", "facts", "meets", "causes")
    return plan is not None and bool(plan.checks.expect or any(getattr(plan, name) for name in names))


def foreign_operations(operations: Sequence[Mapping[str, Any]]) -> list[str]:
    """Describe the operations that touch a Writer's section."""
    return [
        f"/patch/{k}: `{place}` is a Writer's: route it; your patch is for "
        f"{', '.join(f'/{part}' for part in PLANNER_PARTS)}"
        for k, row in enumerate(operations)
        for place in dict.fromkeys(str(row.get(member, row.get("path"))) for member in ("path", "from"))
        if place.split("/")[1:2] in ([], [""], *([section] for section in SECTIONS))
    ]


def _check_faults(decision: Decision, agreement: Agreement) -> list[str]:
    """Describe faults of restated or new expectations, and of other changes of the plan."""
    wrong, plan = [], agreement.plan
    if decision.restate is not None:
        checks = decision.restate.checks
        wrong += weakened_bounds(agreement.first.expect, checks.expect)
        parts = [(getattr(plan.checks, part), getattr(checks, part)) for part in FROZEN_PARTS]
        if all(same(now.get(name), row) for now, said in parts for name, row in said.items()):
            wrong.append("/restate/checks: they say what stands there already")
    if decision.plan is None:
        return wrong
    new, says = decision.plan.checks, decision.plan.says
    for part in FROZEN_PARTS:
        wrong += [
            f"/plan/checks/{part}/{name}: there is one of this name; say it anew by `restate`"
            for name, row in getattr(new, part).items()
            if name in getattr(plan.checks, part) and not same(getattr(plan.checks, part)[name], row)
        ]
    wrong += [f"/plan/says/{name}: say which sentence it stands for" for name in new.expect if name not in says]
    known = {*plan.checks.expect, *new.expect}
    for part, names in (("keeps", decision.plan.keeps), ("says", says)):
        wrong += [f"/plan/{part}/{name}: there is no expectation `{name}`" for name in names if name not in known]
    wrong += [
        f"/plan/drop_bodies: `{name}` is not in the plan"
        for name in decision.plan.drop_bodies
        if name not in plan.bodies
    ]
    faults = asset_faults(decision.plan.assets, plan.bodies | decision.plan.bodies)
    wrong += [f"/plan/assets: {fault}" for fault in faults]
    for old, name in decision.plan.rename.items():
        if old not in plan.params:
            wrong.append(f"/plan/rename/{old}: there is no such parameter")
        elif name in plan.params or name in RESERVED_NAMES:
            wrong.append(f"/plan/rename/{old}: `{name}` is taken")
    return wrong


def _problems_introduced(
    decision: Decision, agreement: Agreement, case: str, path: Path, taken: Sequence[Mapping[str, Any]]
) -> list[str]:
    """Describe the problems that a decision would introduce and that no Writer could fix.

    The patches that the decision takes are applied first: a new expectation may need a duration that one of them sets.
    """
    try:
        text, plan = agreement.changed(case, decision)
    except (PatchError, SpecError) as error:
        return [f"/patch: {str(error).splitlines()[0]}"]
    if text == case and plan.checks == agreement.plan.checks and plan.facts == agreement.plan.facts:
        return []
    text, _ = revising.with_patches(text, taken, path, None)
    duration = revising.mapping(revising.data_of(text), "scene").get("duration")
    if isinstance(duration, int | float):
        plan = plan.model_copy(update={"duration": float(duration)})
    return [*_new_plan_faults(agreement.plan, plan, path), *_new_problems(case, text, agreement, path)]


def _new_plan_faults(old: CasePlan, new: CasePlan, path: Path) -> list[str]:
    if old.checks == new.checks and old.bodies == new.bodies and old.facts == new.facts:
        return []
    before = set(plan_faults(old, path))
    return [row for row in plan_faults(new, path) if row not in before]


def _new_problems(case: str, text: str, agreement: Agreement, path: Path) -> list[str]:
    before = {(problem.path, problem.rule) for problem in examine(case, path).errors}
    return [
        format_problem(problem)
        for problem in examine(text, path).errors
        if (problem.path, problem.rule) not in before and owner_of(problem, agreement.pointers) == "plan"
    ]
