"""Limits of a loop, and its result."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from text2sim.agents.attempt import Attempt
from text2sim.agents.replies import CasePlan
from text2sim.agents.requirements import Requirements

State = Literal["accepted", "accepted_in_part", "impossible", "gave_up", "spent", "failed"]


def impossible_parts(plan: CasePlan, requirements: Requirements) -> list[str]:
    """Return what of a request the plan declares impossible, each with the reason; empty if all of it is possible."""
    if plan.possible != "partly":
        return []
    rows = [f"{requirements[name].what} ({why})" for name, why in plan.cannot.items() if name in requirements]
    return [f"not possible: {row}" for row in rows or [plan.why]]


@dataclass(frozen=True)
class LoopLimits:
    """Limits of a loop, besides tokens and cost."""

    attempts: int = 30
    sim_timeout: float = 3600.0
    """Largest wall time of one simulation [s]."""
    minutes_left: Callable[[], float | None] = lambda: None
    """Returns the minutes left for the whole loop; None without a limit."""

    def timeout(self) -> float:
        """Return the largest wall time of the next simulation [s]."""
        left = self.minutes_left()
        return self.sim_timeout if left is None else max(1.0, min(self.sim_timeout, 60 * left))


@dataclass
class LoopOutcome:
    """Result of a loop."""

    state: State
    why: str
    best: Attempt | None = None
    unresolved: list[str] = field(default_factory=list)
    plan: CasePlan | None = None

    @property
    def accepted(self) -> bool:
        """Whether the case does all of the request that is possible."""
        return self.state in ("accepted", "accepted_in_part")

    def sentence(self) -> str:
        """Return in a line how the loop ended, which version is kept, and what that lacks."""
        heads = {"accepted": "Accepted", "accepted_in_part": "Accepted in part", "impossible": "Not possible"}
        head = heads.get(self.state, "Ended by an error" if self.state == "failed" else "Not accepted")
        kept = "no version was made" if self.best is None else f"version {self.best.number} is kept as the best"
        if self.unresolved:
            kept += f"; unresolved: {'; '.join(self.unresolved)}"
        parts = [self.why] if self.state == "impossible" else [self.why, kept]
        return f"{head}: {'; '.join(part.rstrip('. ') for part in parts)}."
