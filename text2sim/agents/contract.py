"""Contract of a request: its expectations, fixed before anything is built, which must not be weakened.

Evaluated values are compared, so that a bound cannot be relaxed through a parameter either.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from text2sim.spec_schema.arithmetic.values import is_number
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.names.selectors import body_of, strings_in

Data = dict[str, Any]
CONTRACT_PARTS = ("expect", "measures", "events")
MAX_RELAXATION = 0.5
"""Fraction by which the Planner may relax a bound, tolerance or count when it restates an expectation."""


@dataclass(frozen=True)
class Contract:
    """Expectations, with the measures, events and bodies that they depend on."""

    names: tuple[str, ...]
    """The expectations."""
    values: Mapping[str, Data]
    """Entries by part (`expect`, `measures`, `events`) and name, with expressions evaluated."""
    subjects: frozenset[str]
    """The dynamic bodies that they depend on."""

    @property
    def pointers(self) -> tuple[str, ...]:
        """JSON Pointers to the contract's entries in a case."""
        return tuple(f"/actions/{part}/{name}" for part in CONTRACT_PARTS for name in self.values[part])

    @classmethod
    def of(cls, loaded: LoadedCase, names: Iterable[str], planned: Iterable[str] = ()) -> "Contract":
        """Return the contract of a case: the named expectations and everything that they depend on.

        Args:
            loaded: The case.
            names: Names of expectations.
            planned: Names of bodies that are dynamic in the plan, whatever they are in the case.
        """
        actions = loaded.data.get("actions") or {}
        names = [copy for name in names for copy in numbered_copies(name, actions.get("expect") or {})]
        values: dict[str, Data] = {part: {} for part in CONTRACT_PARTS}
        pending = [("expect", name) for name in names]
        while pending:
            part, name = pending.pop()
            row = (actions.get(part) or {}).get(name)
            if row is None or name in values[part]:
                continue
            values[part][name] = row
            words = strings_in(row)
            pending += [
                (other, word) for other in CONTRACT_PARTS[1:] for word in words if word in (actions.get(other) or {})
            ]
        bodies = loaded.data.get("bodies") or {}
        named = {body_of(word) for part in CONTRACT_PARTS[1:] for word in strings_in(values[part])}
        dynamic = {name for name in named & set(bodies) if _kind(bodies[name]) != "driven"}
        return cls(tuple(names), values, frozenset(dynamic | (named & set(planned))))

    def breaches(self, loaded: LoadedCase) -> list[tuple[str, str]]:
        """Return (JSON Pointer, message) for each way in which another version of the case breaks the contract."""
        actions = loaded.data.get("actions") or {}
        found = []
        for name in self.names:
            if name not in self.values["expect"]:
                place = f"/actions/expect/{name}"
                found.append((place, f"{place} comes from the request and must stay"))
        for part in CONTRACT_PARTS:
            for name, row in self.values[part].items():
                now, place = (actions.get(part) or {}).get(name), f"/actions/{part}/{name}"
                if now is None:
                    found.append((place, f"{place} comes from the request and must stay"))
                elif not same(now, row):
                    found.append((place, f"{place} comes from the request and must stay as it is: {row}"))
        bodies = loaded.data.get("bodies") or {}
        for name in sorted(self.subjects):
            place, about = f"/bodies/{name}", "the request's expectations are about it"
            if name not in bodies:
                found.append((place, f"{place}: {about}: it must stay a body that moves"))
            elif _kind(bodies[name]) == "driven":
                found.append((place, f"{place}: {about}: it cannot be `driven`"))
        return found


def numbered_copies(name: str, known: Iterable[str]) -> list[str]:
    """Return those of the known names that are copies of an entry, in a case whose `repeat` entries are expanded."""
    known = list(known)
    if name in known:
        return [name]
    return [copy for copy in known if re.fullmatch(rf"{re.escape(name)}_\d+", copy)] or [name]


def weakened_bounds(old: Mapping[str, Data], new: Mapping[str, Data]) -> list[str]:
    """Describe how restated expectations are weaker than before, as far as their bounds alone show it.

    Args:
        old: The expectations before, by name.
        new: The restated ones.
    """
    found = []
    for name, row in new.items():
        before = old.get(name)
        if before is None:
            found.append(f"{name}: there is no such expectation to restate")
            continue
        bounds_before, bounds_after = _bounds(before), _bounds(row)
        if bounds_before - bounds_after:
            found.append(f"{name}: a restated expectation keeps its {', '.join(sorted(bounds_before - bounds_after))}")
        copies, copies_left = before.get("repeat"), row.get("repeat", 1)
        if isinstance(copies, int) and isinstance(copies_left, int) and copies_left < copies:
            found.append(f"{name}: it stands for {copies} expectations: keep `repeat: {copies}`")
        for side, sign in (("above", -1), ("below", 1)):
            old_bound, new_bound = before.get(side), row.get(side)
            if not (isinstance(old_bound, int | float) and isinstance(new_bound, int | float)):
                continue
            if sign * (new_bound - old_bound) > MAX_RELAXATION * abs(old_bound):
                found.append(
                    f"{name}: `{side}` may move by {MAX_RELAXATION:.0%} of {old_bound:g} at most: this asks for less"
                )
        if all(before.get(key) == row.get(key) for key in ("event", "never", "measure", "stat")):
            found += [f"{name}: {fault}: this asks for less" for fault in _wider(before, row)]
    return found


def _wider(before: Data, row: Data) -> Iterator[str]:
    """Describe what is wider in an expectation about the same event or measure: its tolerance or its count.

    A range of counts that moves without growing is no weaker. Windows may move and grow: the Planner guesses times.
    """
    percent = f"{MAX_RELAXATION:.0%}"
    old, new = before.get("tolerance"), row.get("tolerance")
    if is_number(old) and is_number(new) and new > (1 + MAX_RELAXATION) * old:
        yield f"`tolerance` may grow by {percent} of {old:g} at most"
    old, new = _range(before.get("count")), _range(row.get("count"))
    if old and new and new[1] - new[0] > old[1] - old[0]:
        low, high = (1 - MAX_RELAXATION) * old[0], (1 + MAX_RELAXATION) * old[1]
        if new[0] < low or new[1] > high:
            yield f"`count` may widen by {percent} of either end at most"


def _range(value: Any) -> tuple[float, float] | None:
    """Return both ends of a range; those of a number are equal."""
    ends = [value, value] if is_number(value) else value
    if isinstance(ends, list | tuple) and len(ends) == 2 and all(map(is_number, ends)):
        return ends[0], ends[1]
    return None


def _bounds(row: Mapping[str, Any]) -> set[str]:
    return {"within", "never", "count", "before", "above", "below", "equals"} & set(row)


def _kind(body: Any) -> str:
    return str(body.get("kind")) if isinstance(body, dict) else ""
