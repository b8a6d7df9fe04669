"""The plan, and what it promises: which expectations stand, what a case does to them, and what was said anew."""

from collections.abc import Iterable
from typing import Any

from text2sim.agents import revising
from text2sim.agents.casework import FROZEN_PARTS, Examination
from text2sim.agents.contract import Contract
from text2sim.agents.journal import Emit
from text2sim.agents.replies import Decision, Fragments, Plan
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.load import LoadedCase

UNMOVED = ("static", "driven")


class Agreement:
    """What the loop owes the request.

    Args:
        plan: The plan; without expectations, until there is one.
        emit: Told when an expectation is said anew.
    """

    def __init__(self, plan: Plan, emit: Emit) -> None:
        self.plan, self._emit = plan, emit
        self.names: tuple[str, ...] = ()
        """Expectations that come from the request."""
        self.first = Fragments()
        """What was expected before anything was built."""
        self.restated: list[str] = []
        """What was said anew, old and new, for the Critic."""
        self.contract: Contract | None = None
        """Values of the expectations in the last sound case; None until there is one."""
        self._replaced: Contract | None = None
        self._why = ""

    def expect(self, plan: Plan, names: Iterable[str]) -> None:
        """Take up a plan; from now on these of its expectations stand."""
        self.plan, self.names, self.first = plan, tuple(names), plan.checks

    @property
    def pointers(self) -> tuple[str, ...]:
        """Where in a case stands what only the Planner may change."""
        if self.contract is not None:
            return self.contract.pointers
        return tuple(f"/actions/{part}/{name}" for part in FROZEN_PARTS for name in getattr(self.plan.checks, part))

    def breaches(self, examined: Examination) -> list[Problem]:
        """Say where a case asks for something else than the request does."""
        assert examined.loaded is not None
        contract = self.contract or self._contract_of(examined.loaded)
        rows = contract.breaches(examined.loaded)
        stated = revising.data_of(examined.text).get("actions") or {}
        for part in FROZEN_PARTS:
            for name, row in getattr(self.plan.checks, part).items():
                if (part != "expect" or name in self.names) and not same((stated.get(part) or {}).get(name), row):
                    rows.append(f"/actions/{part}/{name} comes from the request and must stay as it is")
        return [Problem(row.split(":")[0].split(" ")[0], row, rule="from-the-request") for row in dict.fromkeys(rows)]

    def take_down(self, examined: Examination) -> Contract:
        """Keep what the expectations of a sound case ask for; what is other than before is put before the Critic."""
        assert examined.loaded is not None
        fresh, old = self._contract_of(examined.loaded), self.contract or self._replaced
        for part, rows in (old.values if old is not None else {}).items():
            for name, was in rows.items():
                now = fresh.values[part].get(name)
                if not same(now, was):
                    self.say_restated(f"{part} `{name}` was {was}, is {now} ({self._why})")
        self.contract = fresh
        return fresh

    def say_restated(self, row: str) -> None:
        """Keep, and tell, that an expectation is another one now."""
        if row not in self.restated:
            self.restated.append(row)
            self._emit("restated", what=row)

    def apply(self, text: str, decision: Decision) -> str:
        """Do what the Planner may do by itself: parameters, waivers, expectations said anew. Returns the case."""
        text = revising.with_waivers(revising.with_params(text, decision.params), decision.waive)
        self.plan = self.plan.model_copy(update={"params": self.plan.params | decision.params})
        if decision.restate is not None:
            old, new = self.plan.checks, decision.restate.checks
            both: dict[str, Any] = {part: getattr(old, part) | getattr(new, part) for part in FROZEN_PARTS}
            self.plan = self.plan.model_copy(update={"checks": old.model_copy(update=both)})
            text = revising.with_checks(text, new)
        if decision.restate is not None or decision.params:
            # What they ask for is taken down anew when the case is sound, and the Critic sees what was other.
            self._replaced, self.contract = self.contract or self._replaced, None
            self._why = decision.restate.why if decision.restate is not None else "a parameter has changed"
        return text

    def _contract_of(self, loaded: LoadedCase) -> Contract:
        planned = [name for name, body in self.plan.bodies.items() if body.kind not in UNMOVED]
        return Contract.of(loaded, self.names, planned)
