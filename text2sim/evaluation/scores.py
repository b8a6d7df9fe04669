"""Scores of a judgement: weighted sums of a judge's marks, reproducible from the stored replies."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints

from text2sim.agents.replies import Answer
from text2sim.evaluation.suite import CATEGORIES, Prohibition, Prompt

PHYSICAL_WEIGHTS = {"scene": 0.20, "body": 0.275, "action": 0.275, "render": 0.25}
"""Weights of S, B, A and R in the physical score."""
REQUIREMENTS_WEIGHT, AESTHETIC_WEIGHT = 0.7, 0.3
"""Weights in R of the render requirements and of the aesthetics."""
MAX_PENALTY = 40.0
"""Points that are subtracted if all prohibitions are violated."""
MAX_UNUSABLE, MAX_KEYFRAMED, MAX_SEVERE = 20.0, 40.0, 60.0
"""Upper bounds of a physical score: without a usable execution or film; with mainly keyframes or effects instead of
simulation; with a severely violated prohibition."""
VISUAL_WEIGHTS = {"content": 0.30, "depiction": 0.30, "polish": 0.25, "impact": 0.15}
"""Weights of C, D, P and I in the visual score."""

Evidence = Annotated[str, StringConstraints(max_length=2000)]
Hundred = Annotated[float, Field(ge=0, le=100)]


class Marked(Answer):
    """Mark of a requirement: 1, 1/2 or 0."""

    mark: Annotated[float, Field(ge=0, le=1)]
    evidence: Evidence = ""


class Violation(Answer):
    """Whether a prohibition is violated."""

    violated: Literal["no", "yes", "severely"]
    evidence: Evidence = ""


class PhysicalReply(Answer):
    """Reply of a judge who sees prompt, program, records and frames."""

    requirements: dict[str, Marked]
    """Marks by `category.name`."""
    prohibitions: dict[str, Violation] = {}
    aesthetics: Hundred
    execution: Literal["usable", "unusable"]
    motion: Literal["simulated", "mainly_keyframed"]
    why: Evidence = ""
    """Reason for `unusable` or `mainly_keyframed`."""


class VisualReply(Answer):
    """Reply of a judge who sees prompt and film alone."""

    content: Hundred
    """C: everything in the prompt is present, and happens in the right order and completely."""
    depiction: Hundred
    """D: it is clearly visible and understandable."""
    polish: Hundred
    """P: light, materials and surroundings fit together."""
    impact: Hundred
    """I: the film is worth showing to others."""
    why: Evidence = ""


@dataclass(frozen=True)
class PhysicalScore:
    """A physical score with its parts, each 0 to 100."""

    parts: Mapping[str, float]
    """S, B, A and R, by category."""
    faithfulness: float
    """F in R: weighted mean of the marks of render requirements."""
    aesthetics: float
    """Q in R."""
    penalty: float
    """Points that are subtracted for violated prohibitions."""
    caps: tuple[float, ...]
    """Upper bounds that apply."""
    total: float


def physical_score(
    prompt: Prompt, reply: PhysicalReply, *, usable: bool = True, keyframed: bool = False
) -> PhysicalScore:
    r"""Return the physical score of a judgement.

    S, B, A = 100 \sum_i w_i m_i / \sum_i w_i over the requirements of a category, with importance w and mark m of 1,
    1/2 or 0; a requirement without a mark counts 0. R = 0.7 F + 0.3 Q, where F is the same mean over the render
    requirements and Q the judge's aesthetics. The total is 0.20 S + 0.275 B + 0.275 A + 0.25 R
    - 40 \sum_violated v_j / \sum v_j, with weights v of the prohibitions, clamped to 0 to 100, and at most the lowest
    cap that applies: 20, 40 or 60.

    Args:
        prompt: The prompt, with requirements.
        reply: The judge's reply.
        usable: Whether the film can be decoded; False caps the score.
        keyframed: Whether most of the recorded motion is keyframed; True caps the score.
    """
    assert prompt.requirements is not None
    parts: dict[str, float] = {}
    for kind in CATEGORIES:
        rows = [
            (requirement.importance, f"{kind}.{name}")
            for name, requirement in getattr(prompt.requirements, kind).items()
        ]
        met = sum(
            weight * (reply.requirements[name].mark if name in reply.requirements else 0) for weight, name in rows
        )
        parts[kind] = 100 * met / sum(weight for weight, _ in rows)
    faithfulness = parts["render"]
    parts["render"] = REQUIREMENTS_WEIGHT * faithfulness + AESTHETIC_WEIGHT * reply.aesthetics
    penalty = MAX_PENALTY * _violated(prompt.prohibitions, reply.prohibitions)
    caps = tuple(
        cap
        for cap, applies in (
            (MAX_UNUSABLE, not usable or reply.execution == "unusable"),
            (MAX_KEYFRAMED, keyframed or reply.motion == "mainly_keyframed"),
            (MAX_SEVERE, any(row.violated == "severely" for row in reply.prohibitions.values())),
        )
        if applies
    )
    total = sum(weight * parts[kind] for kind, weight in PHYSICAL_WEIGHTS.items()) - penalty
    total = min(max(0.0, min(100.0, total)), *caps, 100.0)
    return PhysicalScore(parts, faithfulness, reply.aesthetics, penalty, caps, total)


def _violated(prohibitions: Mapping[str, Prohibition], violations: Mapping[str, Violation]) -> float:
    """Weighted fraction of the prohibitions that are violated; 0 if there are none."""
    whole = sum(prohibition.weight for prohibition in prohibitions.values())
    bad = sum(
        prohibition.weight
        for name, prohibition in prohibitions.items()
        if name in violations and violations[name].violated != "no"
    )
    return bad / whole if whole else 0.0


def visual_score(reply: VisualReply) -> float:
    """Return the visual score 0.30 C + 0.30 D + 0.25 P + 0.15 I."""
    return sum(weight * getattr(reply, part) for part, weight in VISUAL_WEIGHTS.items())


def physical_faults(prompt: Prompt, reply: PhysicalReply, frames: int) -> list[str]:
    """Describe the faults of a physical judgement: wrong names, wrong marks, missing evidence.

    Args:
        prompt: The prompt, with requirements.
        reply: The judge's reply.
        frames: Number of frames that the judge was shown.
    """
    assert prompt.requirements is not None
    rows = _names("requirements", prompt.requirements.rows(), reply.requirements)
    rows += _names("prohibitions", prompt.prohibitions, reply.prohibitions)
    for name, mark in reply.requirements.items():
        where = f"/requirements/{name}"
        if mark.mark not in (0, 0.5, 1):
            rows.append(f"{where}/mark: is 1, 0.5 or 0, not {mark.mark:g}")
        elif mark.mark < 1 and len(mark.evidence) < 8:
            rows.append(f"{where}/evidence: a mark of {mark.mark:g} has to cite what shows it")
        rows += _unseen(where, mark.evidence, frames)
    for name, row in reply.prohibitions.items():
        if row.violated != "no" and len(row.evidence) < 8:
            rows.append(f"/prohibitions/{name}/evidence: a violation has to cite what shows it")
        rows += _unseen(f"/prohibitions/{name}", row.evidence, frames)
    if (reply.execution, reply.motion) != ("usable", "simulated") and len(reply.why) < 8:
        rows.append("/why: say what shows that it is unusable, or mainly keyframed")
    return rows


def _names(part: str, wanted: Mapping[str, Any], given: Mapping[str, Any]) -> list[str]:
    missing, extra = [n for n in wanted if n not in given], [n for n in given if n not in wanted]
    rows = [f"/{part}/{name}: is missing" for name in missing]
    return rows + [f"/{part}/{name}: there is none of this name" for name in extra]


def _unseen(where: str, evidence: str, frames: int) -> list[str]:
    """Faults: cited frames that were not shown."""
    cited = {int(number) for number in re.findall(r"\bframes? (\d{1,4})\b", evidence)}
    return [
        f"{where}/evidence: there is no frame {n}; {frames} were shown" for n in sorted(cited) if not 1 <= n <= frames
    ]
