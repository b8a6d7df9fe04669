"""The Critic: it sees the request, the case and the evidence, changes nothing, and answers with patches."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from text2sim.agents.asking import Desk, RoleFailed, Wrong, typed
from text2sim.agents.casework import said
from text2sim.agents.contract import Contract
from text2sim.agents.models.exchange import Image
from text2sim.agents.planning import Request
from text2sim.agents.replies import Critique, Patch, Plan
from text2sim.agents.roles import ROLES, render, system_prompt
from text2sim.revision.revise import Refused, revise
from text2sim.spec_schema.changes.patch import PatchError
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.source import Source

CRITIC = ROLES["critic"]


@dataclass(frozen=True)
class Exhibit:
    """What the Critic is shown."""

    attempt: int
    case: str
    """Text of the case."""
    evidence: str
    cites: frozenset[str]
    """What a judgement can rest on."""
    images: tuple[Image, ...]
    missed: tuple[str, ...]
    """Expectations of the request that did not come true."""


def criticise(
    desk: Desk, request: Request, plan: Plan, exhibit: Exhibit, contract: Contract, restated: Sequence[str], path: Path
) -> Critique:
    """Have a run judged.

    A patch that could not be applied, changes what is not its section's, makes the case wrong, or asks for something
    else than the request does, goes back to the Critic; one that stays wrong is left out.

    Args:
        desk: Where the Critic is asked.
        request: What was wanted.
        plan: The plan.
        exhibit: What is shown.
        contract: The expectations that come from the request.
        restated: Expectations that the Planner has restated, old and new.
        path: Where the case stands.
    """
    evidence = exhibit.evidence
    if restated:
        evidence += "\n\n## Restated expectations: do they ask for less?\n\n" + "\n".join(
            f"- {row}" for row in restated
        )
    if not exhibit.images:
        evidence += "\n\nThere are no pictures of this run."
    elif not desk.vision("critic"):
        evidence += "\n\n(There are pictures, but you cannot see pictures: judge by the numbers.)"
    question = render(
        "judge",
        request=request.text,
        event=plan.event,
        assumptions="; ".join(plan.assumptions),
        case=exhibit.case.strip(),
        attempt=exhibit.attempt,
        evidence=evidence,
    )
    last: list[Critique] = []

    def check(critique: Critique) -> None:
        last.append(critique)
        wrong = _contradictions(critique, exhibit)
        for number, patch in enumerate(critique.patches, 1):
            wrong += [f"patch {number}: {reason}" for reason in patch_faults(patch, exhibit.case, contract, path)]
        if wrong:
            raise Wrong(wrong)

    images = (*exhibit.images, *request.images)
    try:
        return desk.ask("critic", system_prompt(CRITIC), question, typed(Critique, check), images)
    except RoleFailed:
        if not last:
            raise
        return _without_faults(last[-1], exhibit, contract, path)


def patch_faults(patch: Patch, case: str, contract: Contract, path: Path) -> list[str]:
    """Say why a patch cannot be applied to a case; nothing if it can."""
    try:
        revision = revise(Source(case, str(path)), path, patch.operations, patch.section)
    except PatchError as error:
        return [str(error)]
    except Refused as refused:
        return [said(problem) for problem in _worst(refused.problems)]
    except SpecError as error:
        return [said(problem) for problem in _worst(error.problems)]
    return contract.breaches(load_text(revision.text, path))


def _worst(problems: Sequence[Problem]) -> list[Problem]:
    return [problem for problem in problems if problem.severity == "error"][:4]


def _contradictions(critique: Critique, exhibit: Exhibit) -> list[str]:
    wrong = []
    for number, failure in enumerate(critique.failures):
        known = [cite for cite in failure.cites if cite.split("[")[0].strip() in exhibit.cites]
        if not known:
            wrong.append(
                f"/failures/{number}/cites: {', '.join(failure.cites)} is not in the evidence; cite expect:NAME, "
                f"measure:NAME, event:NAME, frame:N, body:NAME, diagnostic:NAME or run"
            )
    if critique.verdict == "repair" and not critique.failures:
        wrong.append("/failures: what is to be repaired?")
    if critique.verdict == "pass" and exhibit.missed:
        wrong.append(
            f"/verdict: it cannot pass while {', '.join(exhibit.missed)} did not come true; if the expectation says "
            "the wrong thing, answer `repair` with a failure of section `plan`"
        )
    return wrong


def _without_faults(critique: Critique, exhibit: Exhibit, contract: Contract, path: Path) -> Critique:
    """A judgement that stayed wrong in parts, without those."""
    patches = [patch for patch in critique.patches if not patch_faults(patch, exhibit.case, contract, path)]
    verdict = "repair" if critique.verdict == "pass" and exhibit.missed else critique.verdict
    return critique.model_copy(update={"patches": patches, "verdict": verdict})
