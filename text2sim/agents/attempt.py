"""Attempt: one version of a case, with the result of its run and its judgement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from text2sim.agents.contract import numbered_copies
from text2sim.agents.requirements import Requirement

MAX_STALLED_ATTEMPTS = 2
"""Number of finished attempts without improvement that end the loop, once all expectations are true."""
MAX_UNFINISHED_ATTEMPTS = 3
"""The same for attempts in a row that did not finish: they show what cannot be run, not that nothing is better."""
MAX_STALLED_REFILMS = 5
"""The same for attempts that only film a run again, which is cheap."""


@dataclass
class Attempt:
    """One version of the case, and the result of its run."""

    number: int
    text: str
    cause: str
    """Why it was made."""
    coarse_text: str = ""
    """The text before its steps became finer; empty if they did not."""
    changes: list[str] = field(default_factory=list)
    """Differences from the previous version."""
    problems: list[str] = field(default_factory=list)
    """Reasons why it could not be run."""
    state: str = "unsound"
    """`unsound` if it could not be run, else the final state of the run."""
    run: str = ""
    """The run folder, relative to the case folder."""
    evidence: str = ""
    """Summary of the run for the Critic and the Planner."""
    expect: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Results of the expectations, by name."""
    cites: list[str] = field(default_factory=list)
    """Items of the evidence that a judgement may cite."""
    pictures: list[str] = field(default_factory=list)
    """Files in its folder."""
    wall: float = 0.0
    """Wall time of the run [s]; 0 without a run."""
    took: float = 0.0
    """Wall time until the next prompt [s]: of the run, its pictures, and runs without a cause; 0 without a run."""
    pace: float = 0.0
    """Wall time per simulated second [s]; 0 without a run."""
    critique: dict[str, Any] | None = None
    fates: list[str] = field(default_factory=list)
    """Outcome of each of the Critic's patches."""
    accepted: bool = False
    facts: list[dict[str, Any]] = field(default_factory=list)
    """Computed facts about requirements."""

    def missed(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return those of the named expectations that failed."""
        known = {one: name for name in names for one in numbered_copies(name, self.expect)}
        return tuple(dict.fromkeys(known[one] for one in known if self.expect.get(one, {}).get("ok") is not True))

    def sound(self, names: Sequence[str]) -> bool:
        """Return whether the run finished with the named expectations and its own true."""
        return self.state == "finished" and not self.missed([*names, *self.expect])

    def history_row(self) -> str:
        """Return one line for the history of attempts."""
        missed = [name for name, row in self.expect.items() if row.get("ok") is not True]
        row = f"{self.number}. {self.cause}: "
        row += self.state if not self.problems else "refused: " + "; ".join(self.problems[:2])
        if self.expect:
            row += f"; {len(self.expect) - len(missed)} of {len(self.expect)} expectations true"
        for name in missed[:4]:
            row += f"; `{name}` {self.expect[name].get('why', '')}"
        if self.critique is not None:
            row += f"; Critic: {self.critique['verdict']}, {self.critique['score']:g} of 100"
            row += "".join(f"; {failure['what']}" for failure in self.critique["failures"][:3])
        return row

    def shortcomings(self, requirements: Mapping[str, Requirement]) -> list[str]:
        """Return its problems, and, unless it was accepted, unmet requirements and the Critic's failures."""
        if self.accepted:
            return list(self.problems)
        marks, failures = (self.critique or {}).get("requirements", {}), (self.critique or {}).get("failures", ())
        rows = [
            f"{'half met' if marks[name]['mark'] else 'not met'}: {one.what}"
            for name, one in requirements.items()
            if name in marks and marks[name]["mark"] < 1
        ]
        return list(dict.fromkeys([*self.problems, *rows, *(failure["what"] for failure in failures)]))

    def rank(self, names: Sequence[str]) -> tuple[Any, ...]:
        """Return a sort key for the quality of an attempt; larger is better."""
        critique = self.critique or {}
        passed, missed = critique.get("verdict") == "pass", len(self.missed(names))
        false = len({fact["requirement"] for fact in self.facts if fact["ok"] is False})
        return self.accepted, self.state == "finished", passed, -missed, critique.get("score", 0), -false, -self.number


def best_of(made: Sequence[Attempt], names: Sequence[str]) -> Attempt:
    """Return the best of at least one attempt; `names` are the expectations that come from the request."""
    return max(made, key=lambda one: one.rank(names))


def stalled_best(made: Sequence[Attempt], names: Sequence[str]) -> tuple[Attempt, str] | None:
    """Return the best attempt, and why the loop ends with it, if enough later ones were no better; else None.

    Args:
        made: The attempts, at least one.
        names: The expectations that come from the request; the best attempt has to meet them.
    """
    best = best_of(made, names)
    if not best.sound(names):
        return None
    until = made.index(best) + 1
    before, later = made[:until], made[until:]
    finished = [one for one in later if one.state == "finished"]
    fresh = {one.run or one.number for one in finished} - {one.run for one in before}
    last = made[-MAX_UNFINISHED_ATTEMPTS:]
    if len(fresh) >= MAX_STALLED_ATTEMPTS or len(later) >= MAX_STALLED_REFILMS:
        return best, f"{_listed(later)} brought nothing better than attempt {best.number}"
    if len(later) >= MAX_UNFINISHED_ATTEMPTS and not any(one.state == "finished" for one in last):
        return best, f"{_listed(last)}, one after the other, did not finish; attempt {best.number} is the best"
    return None


def _listed(made: Sequence[Attempt]) -> str:
    """Name attempts, each with how its run ended."""
    return f"attempt{'s' * (len(made) > 1)} {', '.join(f'{one.number} ({one.state})' for one in made)}"


def changed_expectations(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[str]:
    """Describe the expectations whose result changed."""
    rows = []
    for name, row in after.items():
        was = before.get(name, {}).get("ok")
        if name in before and was != row.get("ok"):
            rows.append(f"`{name}` {'came true' if row.get('ok') else 'no longer holds'}")
    return rows
