"""Scores of recorded judgements, from the judges' replies."""

from collections.abc import Mapping
from typing import Any

from text2sim.agents.models.parsing import read_reply
from text2sim.evaluation.scores import PhysicalReply, VisualReply, physical_faults, physical_score, visual_score


def total(row: Mapping[str, Any], prompts: Mapping[str, Any]) -> float:
    """Total of a judge's reply about one of the prompts."""
    data = read_reply(row["reply"])[0]
    if row["kind"] == "visual":
        return visual_score(VisualReply.model_validate(data))
    reply = PhysicalReply.model_validate(data)
    assert physical_faults(prompts[row["prompt"]], reply, 16) == []
    return physical_score(prompts[row["prompt"]], reply).total
