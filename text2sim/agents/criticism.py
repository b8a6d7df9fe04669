"""The Critic: reads the request, the case and the evidence, and answers with marks and proposed patches."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from text2sim.agents.assembly import format_problem
from text2sim.agents.contract import Contract
from text2sim.agents.conversation import Conversation, RoleFailed, typed_parser
from text2sim.agents.facts import Fact
from text2sim.agents.judgement import Amendment, Critique, Failure, Patch
from text2sim.agents.models.exchange import Image
from text2sim.agents.planning import Request
from text2sim.agents.replies import MAX_LINE_LENGTH, CasePlan, Decision, Where
from text2sim.agents.requirements import requirement_row, weighted_score
from text2sim.agents.restyling import restyle
from text2sim.agents.revising import most_that_hold, params_used, revised, with_patches_together
from text2sim.agents.roles import ROLES, render, system_prompt
from text2sim.agents.yaml_text import yaml_text
from text2sim.spec_schema.changes.patch import PatchError
from text2sim.spec_schema.errors import SpecError, Text2SimError
from text2sim.spec_schema.load import load_text

CRITIC = ROLES["critic"]
FIXED_PARAMETER = (
    "what the request's expectations use is fixed: leave the parameter, and patch the fields that use it, in their own "
    "sections, with numbers in its place"
)


@dataclass(frozen=True)
class Exhibit:
    """Evidence that is shown to the Critic."""

    attempt: int
    case: str
    """Text of the case; empty if only its looks have changed, so that no patch is wanted."""
    evidence: str
    cites: frozenset[str]
    """Items of the evidence that a judgement may cite."""
    images: tuple[Image, ...]
    missed: tuple[str, ...]
    """Expectations that did not come true."""
    facts: tuple[Fact, ...] = ()
    """Computed facts about requirements."""
    before: str = ""
    """Earlier attempts and their judgements."""
    finished: bool = True
    """Whether the run finished. If not, an expectation that it did not reach is no further failure."""


def criticise(
    chat: Conversation,
    request: Request,
    plan: CasePlan,
    exhibit: Exhibit,
    contract: Contract,
    restated: Sequence[str],
    path: Path,
) -> Critique:
    """Have a run judged.

    Faulty parts of an answer are requested again, once, without the evidence: requirements without a mark, and patches
    that cannot be applied, leave their section, invalidate the case or break the contract. Parts that are still faulty
    are dropped.

    Args:
        chat: The conversation with the models.
        request: The request.
        plan: The plan.
        exhibit: The evidence.
        contract: Expectations that come from the request.
        restated: Expectations that the Planner has restated, old and new, as text.
        path: Path of the case file.
    """
    evidence = exhibit.evidence
    if restated:
        restatements = "\n".join(f"- {row}" for row in restated)
        evidence += f"\n\n## Restated expectations: do they ask for less?\n\n{restatements}"
    if not exhibit.images:
        evidence += "\n\nThere are no pictures of this run."
    elif not chat.vision("critic"):
        evidence += "\n\n(There are pictures, but you cannot see pictures: judge by the numbers.)"
    question = render(
        "judge",
        request=request.text,
        requirements=_requirements_text(request, plan, exhibit.facts),
        event=plan.event,
        assumptions="; ".join(plan.assumptions),
        case=exhibit.case.strip(),
        fixed=params_used(exhibit.case, contract.pointers) if exhibit.case else [],
        attempt=exhibit.attempt,
        before=exhibit.before,
        evidence=evidence,
    )
    images = (*exhibit.images, *request.images)
    system = system_prompt(CRITIC)
    critique: Critique = chat.ask("critic", system, question, typed_parser(Critique), images)
    wished = request.requirements
    request = replace(request, requirements={name: one for name, one in wished.items() if name not in plan.cannot})
    if wrong := _faults(critique, request, exhibit, contract, path):
        critique = _amended(chat, system, critique, wrong, exhibit)
    critique = _settled(_by_the_facts(critique, exhibit.facts), request, exhibit, contract, path)
    if plan.cannot:  # impossible requirements count in the score alone
        marks = {name: row.mark for name, row in critique.requirements.items()}
        critique = critique.model_copy(update={"score": weighted_score(wished, marks)})
    return critique


def _requirements_text(request: Request, plan: CasePlan, facts: Sequence[Fact]) -> str:
    """List the requirements, each with the expectations that fail without it and its computed facts."""
    lines = []
    for name, requirement in request.requirements.items():
        names = plan.meets.get(name)
        bound = f" [{', '.join(f'expect:{one}' for one in names)}]" if names else ""
        lines.append(requirement_row(name, requirement) + bound)
        if name in plan.cannot:
            lines.append(f"  - cannot be built: {plan.cannot[name]}. Not needed, and no failure; mark what there is")
        lines += [f"  - fact, {fact}" for fact in facts if fact.requirement == name]
    return "\n".join(lines)


def _patch_faults(patch: Patch, case: str, contract: Contract, path: Path) -> list[str]:
    """Return the reasons why a patch cannot be applied to a case; empty if it can."""
    try:
        revision = revised(case, path, patch.operations, patch.section)  # type: ignore[arg-type]
    except PatchError as error:
        return [str(error)]
    except SpecError as error:
        return [format_problem(problem) for problem in error.problems if problem.severity == "error"][:4]
    messages = [message for _, message in contract.breaches(load_text(revision.text, path))]
    if messages and patch.section == "plan":
        messages.append(FIXED_PARAMETER)
    return messages


def _faults(critique: Critique, request: Request, exhibit: Exhibit, contract: Contract, path: Path) -> list[str]:
    wrong = []
    if unmarked := [name for name in request.requirements if name not in critique.requirements]:
        wrong.append(f"/requirements: no mark for {', '.join(unmarked)}")
    if critique.verdict == "repair" and not critique.failures and not _short_of(critique, request):
        wrong.append("/failures: what is to be repaired?")
    wrong += critique.refused if exhibit.case else ()
    for number, reasons in enumerate(_faults_by_patch(critique, exhibit, contract, path), 1):
        wrong += [f"patch {number}: {reason}" for reason in reasons]
    return wrong


def _faults_by_patch(critique: Critique, exhibit: Exhibit, contract: Contract, path: Path) -> list[list[str]]:
    """Return for each patch why it cannot be applied; empty for those that together give a valid case."""
    if not exhibit.case:  # a judgement of looks needs no patches
        return []
    rows = [patch.model_dump(mode="json") for patch in critique.patches]

    def attempt(few: Sequence[int]) -> str | None:
        return with_patches_together(exhibit.case, [rows[k] for k in few], path, contract)

    kept, case = most_that_hold(range(len(rows)), attempt) or ((), exhibit.case)
    return [[] if k in kept else _patch_faults(patch, case, contract, path) for k, patch in enumerate(critique.patches)]


def _amended(chat: Conversation, system: str, critique: Critique, wrong: Sequence[str], exhibit: Exhibit) -> Critique:
    """Ask once more for the unusable parts of a judgement."""
    case = exhibit.case if critique.patches or critique.refused else ""
    judgement = critique.model_dump(mode="json", exclude={"refused"}, exclude_defaults=True)
    question = render("judge_again", judgement=yaml_text(judgement), wrong=wrong, case=case)
    try:
        more: Amendment = chat.ask("critic", system, question, typed_parser(Amendment), rounds=1)
    except RoleFailed:
        return critique
    return critique.model_copy(
        update={
            "requirements": critique.requirements | more.requirements,
            "failures": more.failures or critique.failures,
            "patches": more.patches or critique.patches,
            "refused": more.refused if more.patches or more.refused else critique.refused,
        }
    )


def _short_of(critique: Critique, request: Request) -> list[str]:
    """Return the names of the requirements that are marked as not met."""
    known = request.requirements
    return [name for name, row in critique.requirements.items() if name in known and row.mark < known[name].needed]


def _by_the_facts(critique: Critique, facts: Sequence[Fact]) -> Critique:
    """Return a judgement in which requirements that a fact contradicts are at most half met."""
    against = {fact.requirement: fact.told for fact in facts if fact.ok is False}
    marks = {
        name: row.model_copy(update={"mark": 0.5, "why": against[name]}) if name in against and row.mark == 1 else row
        for name, row in critique.requirements.items()
    }
    return critique.model_copy(update={"requirements": marks})


def _settled(critique: Critique, request: Request, exhibit: Exhibit, contract: Contract, path: Path) -> Critique:
    """Return a judgement without its unusable parts, with its score; it passes only if all requirements are met."""
    patches, refused = [], [*critique.refused] if exhibit.case else []
    for patch, faults in zip(critique.patches, _faults_by_patch(critique, exhibit, contract, path), strict=False):
        if faults:
            refused.append(f"on {patch.section} ({patch.why}): {faults[0]}")
        else:
            patches.append(patch)
    failures = [
        failure.model_copy(update={"cites": _known_cites(failure.cites, exhibit) or ["run"]})
        for failure in critique.failures
    ]
    failure_text = " ".join(failure.what for failure in failures)
    cited = {cite for failure in failures for cite in failure.cites}
    section = critique.responsible or "plan"
    sections: set[Where] = {patch.section for patch in critique.patches}
    patched: Where = critique.responsible or (sections.pop() if len(sections) == 1 else "plan")
    for name in exhibit.missed:
        if f"expect:{name}" not in cited and (exhibit.finished or not failures):
            what = f"the expectation `{name}` did not come true"
            failures.append(Failure(what=what, cites=[f"expect:{name}"], section=section))
    for name in _short_of(critique, request):
        row = critique.requirements[name]
        if name not in failure_text and not set(row.cites) & cited:
            half = "only half met" if row.mark else "not met"
            what = f"{half}: {request.requirements[name].what}{f' ({row.why})' if row.why else ''}"
            cites = _known_cites(row.cites, exhibit) or ["run"]
            failures.append(Failure(what=what[:MAX_LINE_LENGTH], cites=cites, section=patched))
    for name in request.requirements:
        if name not in critique.requirements:
            what = f"not marked: {request.requirements[name].what}"
            failures.append(Failure(what=what[:MAX_LINE_LENGTH], cites=["run"], section=section))
    marks = {name: row.mark for name, row in critique.requirements.items()}
    whole = all(marks.get(name, 0.0) >= one.needed for name, one in request.requirements.items())
    passed = critique.verdict == "pass" and not exhibit.missed and whole
    verdict = "repair" if critique.verdict == "pass" and not passed else critique.verdict
    score = weighted_score(request.requirements, marks) if request.requirements else critique.score
    return critique.model_copy(
        update={"patches": patches, "refused": refused, "failures": failures, "verdict": verdict, "score": score}
    )


def decision_to_film(critique: Mapping[str, Any] | None, case: str, path: Path) -> Decision | None:
    """Return the decision to take all patches of a critique if they change only film and looks; otherwise None.

    The Planner is not asked, because it is cheap to film a recorded run again.

    Args:
        critique: A `Critique` of a run in which all expectations are true; None if there is none.
        case: Text of the case that was run.
        path: Path of the case file.
    """
    if critique is None:
        return None
    patches = critique["patches"]
    failed, patched = (Counter(row["section"] for row in critique[part]) for part in ("failures", "patches"))
    if not patches or critique["refused"] or critique["unfaithful"]:
        return None
    film_alone = {*failed, *patched} == {"render"}
    if not film_alone and not (
        failed - Counter({"render": failed["render"]}) <= patched and _restyles(patches, case, path)
    ):
        return None
    return Decision(action="repair", why=critique["summary"] or patches[0]["why"], take=[*range(1, len(patches) + 1)])


def _restyles(patches: Sequence[Mapping[str, Any]], case: str, path: Path) -> bool:
    """Whether patches together change nothing but film and looks."""
    try:
        restyle(case, [operation for patch in patches for operation in patch["operations"]], path)
    except Text2SimError:
        return False
    return True


def _known_cites(cites: Sequence[str], exhibit: Exhibit) -> list[str]:
    return [cite for cite in cites if cite.split("[")[0].strip() in exhibit.cites]
