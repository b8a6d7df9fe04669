"""Comparison of two versions of a case: changes, their effects, and the results of their runs."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from text2sim.recording.record import COMPLETE, RunRecord
from text2sim.revision.side import Side
from text2sim.spec_schema.arithmetic.values import is_number
from text2sim.spec_schema.changes.diff import Change, Effect, difference, effects, operations
from text2sim.spec_schema.changes.operation import Operation
from text2sim.spec_schema.errors import Text2SimError
from text2sim.spec_schema.loaded import LoadedCase

STATISTICS = {"last": "end", "min": "min", "max": "max"}
EQUAL_WITHIN = 1e-6
"""Relative difference below which two measured values count as equal."""


@dataclass(frozen=True)
class MeasureChange:
    """A measure that differs between the runs."""

    name: str
    unit: str
    values: dict[str, tuple[float | None, float | None]]
    """Statistics that differ, as (earlier, later)."""


@dataclass(frozen=True)
class ExpectationChange:
    """An expectation with different verdicts in the runs; None where it was not judged."""

    name: str
    was: bool | None
    now: bool | None
    why: str


@dataclass
class CaseComparison:
    """Differences between two versions."""

    changes: list[Change]
    effects: list[Effect]
    operations: list[Operation]
    """The patch that turns the first version into the second."""
    runs: tuple[Path, Path] | None = None
    """The run folders, if both were run."""
    measured: list[MeasureChange] = field(default_factory=list)
    judged: list[ExpectationChange] = field(default_factory=list)
    same_simulation: bool = False
    """Whether both are one run, because they simulate the same."""

    @property
    def same(self) -> bool:
        """Whether both versions have the same meaning."""
        return not self.changes and not self.effects


def compare(a: Side, b: Side, runs: Path | None = None) -> CaseComparison:
    """Compare two versions of a case.

    Args:
        a: The first version.
        b: The second version.
        runs: A folder of run folders, which is searched for runs of both.
    """
    old, new, patch = a.data, b.data, None
    if (a.run or b.run) and a.loaded is not None and b.loaded is not None:
        # The case in a run folder may have its prefabs expanded.
        old, new = a.loaded.raw, b.loaded.raw
    elif not any(side.loaded is not None and side.loaded.overlay for side in (a, b)):
        patch = operations(a.written, b.written)
    found: list[Effect] = []
    if a.loaded is not None and b.loaded is not None:
        values = (a.loaded.data, b.loaded.data)
        changes = difference(old, new, values)
        found = list(effects(old, new, values, _dependencies(b.loaded)))
    else:
        changes = difference(old, new)
    comparison = CaseComparison(changes, found, patch if patch is not None else operations(old, new))
    if runs is not None or (a.run and b.run):
        _add_runs(comparison, a, b, runs)
    return comparison


def _dependencies(loaded: LoadedCase) -> dict[Any, frozenset[str]]:
    """Parameters on which each expression depends, directly or through other parameters."""
    sites = {path: site.names for path, site in loaded.resolver.sites.items()}
    needs: dict[str, frozenset[str]] = {}
    for path, names in sites.items():
        if path[0] == "params" and len(path) > 1:
            needs[str(path[1])] = needs.get(str(path[1]), frozenset()) | names

    def closure(names: frozenset[str]) -> frozenset[str]:
        known: set[str] = set()
        open_names = set(names)
        while open_names:
            name = open_names.pop()
            if name not in known:
                known.add(name)
                open_names |= needs.get(name, frozenset())
        return frozenset(known)

    return {path: closure(names) for path, names in sites.items()}


# --- runs -----------------------------------------------------------------------------------------------------


def _add_runs(comparison: CaseComparison, a: Side, b: Side, runs: Path | None) -> None:
    folders = _find_run(a, runs), _find_run(b, runs)
    if folders[0] is None or folders[1] is None:
        return
    comparison.runs = (folders[0], folders[1])
    if folders[0] == folders[1]:
        comparison.same_simulation = True
        return
    was, now = (_evidence(folder) for folder in comparison.runs)
    for name in [name for name in was["measures"] if name in now["measures"]]:
        row, other = was["measures"][name], now["measures"][name]
        values = {key: (_as_number(row.get(key)), _as_number(other.get(key))) for key in STATISTICS}
        values = {key: pair for key, pair in values.items() if _differ(*pair)}
        if values:
            comparison.measured.append(MeasureChange(name, str(other.get("unit") or ""), values))
    for name in dict.fromkeys([*was["expect"], *now["expect"]]):
        before, after = was["expect"].get(name, {}), now["expect"].get(name, {})
        if before.get("ok") != after.get("ok"):
            why = str((after or before).get("why", ""))
            comparison.judged.append(ExpectationChange(name, before.get("ok"), after.get("ok"), why))


def _find_run(side: Side, runs: Path | None) -> Path | None:
    """The folder of a complete run of this version, if there is one."""
    if side.run is not None:
        return side.run
    if side.loaded is None or runs is None or not any(runs.glob(f"{side.loaded.case.name}-*")):
        return None
    from text2sim.compiler.build import plan_case

    try:
        digest = plan_case(side.loaded).sim_digest
    except (Text2SimError, OSError):
        return None
    for folder in sorted(runs.glob(f"{side.loaded.case.name}-*{digest[:10]}")):
        record = RunRecord.read(folder)
        if record is not None and record.state in COMPLETE and record.key.get("sim_digest") == digest:
            return folder
    return None


def _evidence(folder: Path) -> dict[str, dict[str, Any]]:
    """Evidence of a run, empty if it is missing or damaged."""
    from text2sim.recording.run_files import read_evidence

    return read_evidence(folder) or {"measures": {}, "expect": {}}


def _as_number(value: Any) -> float | None:
    return float(value) if is_number(value) else None


def _differ(a: float | None, b: float | None) -> bool:
    if a is None or b is None:
        return a is not b
    return abs(a - b) > EQUAL_WITHIN * max(abs(a), abs(b))
