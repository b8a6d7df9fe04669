"""Question that an attempt puts to the Planner: what became of it, and what the Planner may choose from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from text2sim.agents.agreement import Agreement
from text2sim.agents.run_summary import to_decide_by
from text2sim.agents.yaml_text import yaml_text
from text2sim.spec_schema.text.writing import flow_text


@dataclass
class AttemptReport:
    """Report on an attempt for the Planner."""

    problems: Sequence[str] = ()
    """Errors of the check, if it could not be run."""
    doubts: Sequence[str] = ()
    """Findings about the expectations themselves, before the run."""
    referred: Sequence[str] = ()
    """Faults that Writers refer to the Planner."""
    evidence: str = ""
    critique: Mapping[str, Any] | None = None
    rules: frozenset[str] = frozenset()
    """Ids of the lint rules with findings."""
    left: str = ""
    """Sentence with the attempts and time left, and the duration of the last run."""
    trials: str = ""
    """Outcomes of trials, one line each."""

    def __str__(self) -> str:
        parts = []
        if self.problems:
            parts.append(
                "It could not be run. What is wrong, and was not mended by its owners:\n\n" + _bullets(self.problems)
            )
        if self.doubts:
            parts.append(
                "It has not been run yet: the check has doubts about it. Fix what is true of them (`restate`, `plan`, "
                "`params`, `routes`); if something is intended, say so (`waive` the rule, or `plan: {keeps: […]}`):\n\n"
                + _bullets(self.doubts)
            )
        if self.referred:
            parts.append("Writers refer to you:\n\n" + _bullets(self.referred))
        if self.evidence:
            parts.append("# Evidence\n\n" + to_decide_by(self.evidence))
        if self.trials:
            parts.append(f"# Trials\n\n{self.trials}")
        if self.critique is not None:
            patches = self.critique.get("patches", [])
            parts.append("# The Critic\n\n" + yaml_text(_condensed(self.critique)))
            for number, patch in enumerate(patches, 1):
                parts.append(f"Patch {number}:\n\n" + yaml_text(patch))
        return "\n\n".join(parts)


@dataclass
class Choices:
    """What the Planner may choose from when it decides."""

    anew: bool = False
    """Whether it may make a new plan."""
    trials: int = 0
    """Number of trials that it may ask for."""
    earlier: Mapping[int, tuple[str, Agreement]] = field(default_factory=dict)
    """Text and agreement of the attempts that it may go back to, by number."""

    def text(self, params: Mapping[str, Any]) -> str:
        """Return the choices in a sentence or two.

        Args:
            params: Parameters of the present plan; of an earlier attempt, those with other values are named.
        """
        rows = [f"At most {self.trials} trials can be run." if self.trials else "No trials can be run now."]
        if self.earlier:
            differing = {
                number: {name: value for name, value in agreed.plan.params.items() if params.get(name) != value}
                for number, (_, agreed) in self.earlier.items()
            }
            versions = (f"{number}{f' {flow_text(own)}' if own else ''}" for number, own in differing.items())
            rows.append(f"`back_to` can be {', '.join(versions)}.")
        return " ".join(rows)


def _condensed(critique: Mapping[str, Any]) -> dict[str, Any]:
    """Return a judgement without its patches and empty entries, with only the names of requirements that are met."""
    marks = critique.get("requirements") or {}
    met = [name for name, row in marks.items() if row["mark"] == 1]
    unmet = {name: row for name, row in marks.items() if row["mark"] < 1}
    rows = {**critique, "requirements": unmet, "met": met, "patches": None}
    return {key: row for key, row in rows.items() if row not in ([], {}, "", None)}


def _bullets(lines: Sequence[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)
