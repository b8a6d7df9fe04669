"""Agreement between request and case: the plan, its binding expectations, and those that were restated."""

import re
from collections.abc import Iterable
from typing import Any

from text2sim.agents import revising
from text2sim.agents.assembly import FROZEN_PARTS, Examination
from text2sim.agents.contract import Contract
from text2sim.agents.journal import Emit
from text2sim.agents.replies import CasePlan, Claim, Decision, Fragments, PlanPatch
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.loaded import LoadedCase

UNMOVED = ("static", "driven")
_PARAMETER = re.compile(r"\$\{\s*(\w+)\s*\}")


class Agreement:
    """The plan and the expectations that every version of the case must keep.

    Args:
        plan: The plan; an empty one until the Planner has answered.
        emit: Callback for journal events, such as a restated expectation.
    """

    def __init__(self, plan: CasePlan, emit: Emit) -> None:
        self.plan, self._emit = plan, emit
        self.names: tuple[str, ...] = ()
        """Names of the expectations that come from the request."""
        self.first = Fragments()
        """Measures, events and expectations before anything was built."""
        self.restated: list[str] = []
        """Descriptions of restated expectations, old and new, for the Critic."""
        self.contract: Contract | None = None
        """Values of the expectations in the last valid case; None until there is one."""
        self.replanned = False
        """Whether a second plan was made; only one is allowed."""
        self._replaced: Contract | None = None
        self._why = ""

    def adopt_plan(self, plan: CasePlan, names: Iterable[str]) -> None:
        """Adopt a plan and make the named expectations binding."""
        self.plan, self.names, self.first = plan, tuple(names), plan.checks

    @property
    def pointers(self) -> tuple[str, ...]:
        """JSON Pointers to the parts of a case that only the Planner may change."""
        if self.contract is not None:
            return self.contract.pointers
        return tuple(f"/actions/{part}/{name}" for part in FROZEN_PARTS for name in getattr(self.plan.checks, part))

    def breaches(self, examined: Examination) -> list[Problem]:
        """Return a problem for each deviation of a case from the contract."""
        assert examined.loaded is not None
        contract = self.contract or self._contract_of(examined.loaded)
        rows = contract.breaches(examined.loaded)
        stated = revising.mapping(revising.data_of(examined.text), "actions")
        for part in FROZEN_PARTS:
            for name, row in getattr(self.plan.checks, part).items():
                if (part != "expect" or name in self.names) and not same((stated.get(part) or {}).get(name), row):
                    place = f"/actions/{part}/{name}"
                    rows.append((place, f"{place} comes from the request and must stay as it is"))
        return [Problem(place, message, rule="from-the-request") for place, message in dict.fromkeys(rows)]

    def record_examined(self, examined: Examination) -> Contract:
        """Record the contract of a valid case; differences from the previous contract are shown to the Critic."""
        assert examined.loaded is not None
        fresh, old = self._contract_of(examined.loaded), self.contract or self._replaced
        for part, rows in (old.values if old is not None else {}).items():
            for name, was in rows.items():
                now = fresh.values[part].get(name)
                # A measure that no expectation uses any longer does not count as restated.
                if not same(now, was) and (now is not None or part == "expect"):
                    self.report_restated(f"{part} `{name}` was {was}, is {now} ({self._why})")
        self.contract = fresh
        return fresh

    def report_restated(self, row: str) -> None:
        """Record and report a restated expectation."""
        if row not in self.restated:
            self.restated = [*self.restated, row]  # copies of the agreement share the list
            self._emit("restated", what=row)

    def adopt_values(self, text: str) -> None:
        """Copy the case's parameter values into the plan, so that later prompts show current values."""
        data = revising.data_of(text)
        duration = revising.mapping(data, "scene").get("duration")
        update: dict[str, Any] = {"params": revising.mapping(data, "params")}
        if isinstance(duration, int | float):
            update["duration"] = float(duration)
        self.plan = self.plan.model_copy(update=update)

    def changed(self, text: str, decision: Decision) -> tuple[str, CasePlan]:
        """Return the case and the plan after the changes that the Planner may make by itself.

        Raises:
            PatchError: If the patch cannot be applied.
        """
        plan, amendment = self.plan, decision.plan or PlanPatch()
        if amendment.rename:
            text = revising.with_renamed(text, amendment.rename)
            plan = CasePlan.model_validate(revising.words_renamed(plan.model_dump(mode="json"), amendment.rename))
        text = revising.with_operations(revising.with_params(text, decision.params), decision.patch)
        if amendment.duration is not None:
            add = {"op": "add", "path": _duration_path(text), "value": amendment.duration}
            text, plan = revising.with_operations(text, [add]), plan.model_copy(update={"duration": amendment.duration})
        text = revising.with_waivers(text, decision.waive)
        for checks in [amendment.checks, *([decision.restate.checks] if decision.restate is not None else [])]:
            text, plan = revising.with_checks(text, checks), _with_checks(plan, checks)
        plan = plan.model_copy(update={"params": revising.mapping(revising.data_of(text), "params")})
        return text, _with_amendment(plan, amendment)

    def apply(self, text: str, decision: Decision) -> str:
        """Apply the changes that the Planner may make by itself, and return the case."""
        before = self.plan
        text, self.plan = self.changed(text, decision)
        amendment = decision.plan or PlanPatch()
        for name in [name for name, rows in amendment.facts.items() if before.facts.get(name, rows) != rows]:
            was, now = _claims_text(before.facts[name]), _claims_text(amendment.facts[name])
            self.report_restated(f"fact `{name}` was {was}, is {now}")
        for part in ("meets", "causes"):
            for name, rows in getattr(amendment, part).items():
                if (was := getattr(before, part).get(name, [])) != rows:
                    self.report_restated(f"{part} of `{name}` was {was}, is {rows}")
        if amendment.rename:
            self.first = Fragments.model_validate(revising.words_renamed(self.first.model_dump(), amendment.rename))
        fresh = [name for name in amendment.checks.expect if name not in self.names]
        if fresh:
            self.names = (*self.names, *fresh)
            self.first = self.first.model_copy(update={"expect": self.first.expect | amendment.checks.expect})
            self._emit("expected", names=fresh, says={name: amendment.says.get(name, "") for name in fresh})
        if decision.restate is not None or decision.params or decision.patch or fresh:
            causes = ((decision.params, "a parameter changed"), (decision.patch, "a value was patched"))
            why = ", ".join(text for given, text in (*causes, (fresh, "an expectation was added")) if given)
            self._renew(decision.restate.why if decision.restate is not None else why)
        return text

    def restore(self, earlier: "Agreement") -> None:
        """Restore the state of an earlier copy."""
        vars(self).update(vars(earlier))

    def same_checks(self, other: "Agreement") -> bool:
        """Whether two agreements have the same measures, events and expectations."""
        return self.names == other.names and self.plan.checks == other.plan.checks

    def go_back_to(self, earlier: "Agreement") -> None:
        """Restore the parameters, bodies and contract of an earlier copy with the same checks; keep what is newer."""
        # How requirements are tested (`facts`, `meets`, `causes`) and what the checks mean (`says`, `keeps`) belongs to
        # the request and may have been amended since; it does not depend on the version of the case.
        kept = {
            name: getattr(self.plan, name)
            for name in ("possible", "why", "cannot", "facts", "says", "keeps", "meets", "causes")
        }
        newer = {
            "plan": earlier.plan.model_copy(update=kept),
            "restated": self.restated,  # the Critic has to know of every restatement
            "replanned": self.replanned,  # the one further plan stays used up
        }
        vars(self).update(vars(earlier) | newer)

    def replace_plan(self, plan: CasePlan) -> None:
        """Replace the plan; binding expectations stay, and new ones are added.

        Args:
            plan: Contains all binding expectations, perhaps restated (see `planning._check_plan`).
        """
        self.first = self.first.model_copy(update={"expect": plan.checks.expect | self.first.expect})
        self.plan, self.names, self.replanned = plan, tuple(plan.checks.expect), True
        self._renew("it was planned anew")

    def _renew(self, why: str) -> None:
        """Have the contract recorded again from the next valid case, with the reason for the Critic."""
        # There was no valid case in between: both causes explain the differences of the next one.
        if self.contract is None and self._replaced is not None and why not in self._why:
            why = f"{self._why}; {why}"
        self._replaced, self.contract, self._why = self.contract or self._replaced, None, why

    def _contract_of(self, loaded: LoadedCase) -> Contract:
        planned = [name for name, body in self.plan.bodies.items() if body.kind not in UNMOVED]
        return Contract.of(loaded, self.names, planned)


def _with_checks(plan: CasePlan, checks: Fragments) -> CasePlan:
    """Return the plan with further or restated measures, events and expectations."""
    merged = {part: getattr(plan.checks, part) | getattr(checks, part) for part in FROZEN_PARTS}
    return plan.model_copy(update={"checks": Fragments(**merged)})


def _with_amendment(plan: CasePlan, amendment: PlanPatch) -> CasePlan:
    """Return the plan with the fields of an amendment that concern neither the case nor the checks."""
    bodies = {name: body for name, body in plan.bodies.items() if name not in amendment.drop_bodies}
    update: dict[str, Any] = {
        "bodies": bodies | amendment.bodies,
        "says": plan.says | amendment.says,
        "keeps": [*plan.keeps, *(name for name in amendment.keeps if name not in plan.keeps)],
        "facts": plan.facts | amendment.facts,
        "meets": plan.meets | amendment.meets,
        "causes": {name: rows for name, rows in (plan.causes | amendment.causes).items() if rows},
        "assets": [*plan.assets, *amendment.assets],
    }
    for name in ("event", "shared", "assumptions"):
        value = getattr(amendment, name)
        if isinstance(value, dict):
            lines = dict(enumerate(getattr(plan, name), 1)) | value
            value = [lines[number] for number in sorted(lines) if lines[number] is not None]
        if value not in ("", None):
            update[name] = value
    return plan.model_copy(update=update)


def _claims_text(claims: Iterable[Claim]) -> str:
    return str([claim.model_dump(exclude_defaults=True) for claim in claims])


def _duration_path(text: str) -> str:
    """Pointer to the duration of a case, or to the parameter if the duration is just `${parameter}`."""
    data = revising.data_of(text)
    parameter = _PARAMETER.fullmatch(str(revising.mapping(data, "scene").get("duration")))
    named = parameter is not None and parameter[1] in revising.mapping(data, "params")
    return f"/params/{parameter[1]}" if parameter is not None and named else "/scene/duration"
