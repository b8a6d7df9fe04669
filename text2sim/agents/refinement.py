"""Finer time steps for a run in which bodies sank into each other by more than they are thick.

How much finer they have to be follows from the depth, so that nobody needs to be asked.
"""

from collections.abc import Mapping
from typing import Any

from text2sim.agents.revising import data_of, mapping, with_sections
from text2sim.compiler.build import plan_case
from text2sim.spec_schema.loaded import LoadedCase

MAX_SUBSTEPS = 50
"""Most substeps that are set."""


def with_finer_steps(text: str, loaded: LoadedCase, evidence: Mapping[str, Any]) -> tuple[str, float]:
    """Return a case with as many substeps as its run should have had, and by how much it takes longer.

    Args:
        text: Text of the case.
        loaded: The case.
        evidence: Evidence of its run.

    Returns:
        The text, and the ratio of the substeps; the same text and 1 if no bodies were too deep inside each other.
    """
    factor = evidence.get("substeps_factor")
    if not factor:
        return text, 1.0
    now = plan_case(loaded).settings.substeps
    finer = min(now * factor, MAX_SUBSTEPS)
    if finer <= now:
        return text, 1.0
    scene = mapping(data_of(text), "scene") | {"substeps": finer}
    return with_sections(text, {"scene": scene}), finer / now
