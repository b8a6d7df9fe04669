"""Entry of an existing case into the loop, to be repaired or changed on request."""

from text2sim.agents import revising
from text2sim.agents.assembly import examine, format_problem
from text2sim.agents.attempt import Attempt
from text2sim.agents.loop import AgentLoop
from text2sim.agents.loop_result import LoopOutcome
from text2sim.agents.opening import as_decision, open_case
from text2sim.agents.replies import CasePlan, Fragments, Opening, PlannedBody
from text2sim.agents.requirements import extract_requirements, requirements_of_change
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.errors import RunError


def amend(loop: AgentLoop, text: str, *, run_first: bool) -> LoopOutcome:
    """Change a case until it does what the request asks for.

    Args:
        loop: The loop of the case.
        text: The case.
        run_first: Whether to run it before changing anything, because its author reports a failure.

    Raises:
        RunError: If the text is not a case at all.
    """
    loop.history.base = text
    loop.agreement.plan = plan_of_case(text, loop.case.name)
    return loop.ending(lambda: _amended(loop, text, run_first))


def _amended(loop: AgentLoop, text: str, run_first: bool) -> LoopOutcome:
    loop.require(
        requirements_of_change(
            loop.request.text, lambda: extract_requirements(loop.chat, loop.request.text, loop.request.images)
        )
    )
    evidence, problems = _present_state(loop, text, run_first)
    shown = "\n\n".join(part for part in (evidence, "\n".join(problems)) if part)
    opening = open_case(
        loop.chat, loop.request, loop.agreement, text, shown, loop.path, keep=run_first, left=loop.history.left()
    )
    loop.emit(
        "planned", goal=opening.event, possible=opening.possible, why=opening.why, assumptions=[], says=opening.says
    )
    if opening.possible == "no":
        return LoopOutcome("impossible", opening.why, plan=loop.agreement.plan)
    for name in opening.drop:
        loop.agreement.report_restated(f"expect `{name}` was dropped, because the wish makes it wrong ({opening.why})")
    return loop.work(_opened(loop, text, opening), "as was wished")


def plan_of_case(text: str, fallback: str) -> CasePlan:
    """Derive a plan from an existing case.

    Raises:
        RunError: If the case does not have a form that the agents can work with.
    """
    try:
        data = revising.data_of(text)
        actions, duration = data.get("actions") or {}, (data.get("scene") or {}).get("duration")
        bodies = {
            str(name): PlannedBody(
                kind=str(row.get("kind") or row.get("use")),
                shape=_kind(row.get("shape")),
                mount=_kind(row.get("mount")),
            )
            for name, row in (data.get("bodies") or {}).items()
            if isinstance(row, dict)
        }
        for name, row in ((data.get("scene") or {}).get("statics") or {}).items():
            bodies[str(name)] = PlannedBody(
                kind="static", shape=_kind(row.get("shape") if isinstance(row, dict) else None)
            )
        checks = Fragments.model_validate({part: actions.get(part) or {} for part in ("measures", "events", "expect")})
        return CasePlan(
            name=str(data.get("name") or fallback),
            event=" ".join(str(data.get("prompt") or "").split())[:2000],
            duration=float(duration) if isinstance(duration, int | float) and duration else 4.0,  # it may be `${…}`
            params=data.get("params") or {},
            bodies=bodies,
            checks=checks,
            says={name: "as the case says" for name in checks.expect},
        )
    except (ValueError, TypeError, AttributeError) as error:
        raise RunError(f"the agents cannot work with this case: {str(error).splitlines()[0]}") from None


def _kind(row: object) -> str:
    return str(row.get("kind") or "") if isinstance(row, dict) else ""


def _present_state(loop: AgentLoop, text: str, run_first: bool) -> tuple[str, list[str]]:
    """Return the evidence of the unchanged case, or the reasons why it cannot be run."""
    examined = examine(text, loop.path)
    if examined.errors:
        return "", [format_problem(problem) for problem in examined.errors]
    if not run_first:
        loop.mending.inherit(examined.warnings)
        return "", []
    attempt = Attempt(0, text, "as it was")
    if not loop.attempts.recall(attempt):
        loop.emit("running", live=True, number=0)
        loop.attempts.run(
            attempt, examined, tuple(loop.agreement.plan.checks.expect), loop.limits.timeout(), loop.progress
        )
    return attempt.evidence, attempt.problems


def _opened(loop: AgentLoop, text: str, opening: Opening) -> str:
    """Apply the Planner's opening, and make the expectations binding."""
    checks = loop.agreement.plan.checks
    expect = {name: row for name, row in checks.expect.items() if name not in opening.drop} | opening.checks.expect
    merged = Fragments(
        measures=checks.measures | opening.checks.measures, events=checks.events | opening.checks.events, expect=expect
    )
    for part in ("measures", "events"):
        given, present = getattr(opening.checks, part), getattr(checks, part)
        for name in sorted(n for n in given.keys() & present.keys() if not same(given[n], present[n])):
            loop.agreement.report_restated(f"{part} `{name}` was {present[name]}, is {given[name]} ({opening.why})")
    says = {name: row for name, row in loop.agreement.plan.says.items() if name in expect} | opening.says
    plan = loop.agreement.plan.model_copy(
        update={
            "checks": merged,
            "says": says,
            "facts": opening.facts,
            "possible": opening.possible,
            "why": opening.why,
            "cannot": opening.cannot,
            "event": opening.event or loop.agreement.plan.event,
            # The author's own expectations may hold from the start.
            "keeps": [*(name for name in checks.expect if name in expect), *opening.keeps],
        }
    )
    loop.agreement.adopt_plan(plan, expect)
    text = revising.with_checks(text, opening.checks, opening.drop)
    return loop.workshop.follow_routes(loop.agreement.apply(text, as_decision(opening)), opening.routes)
