"""Runs to compare, with their labels."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from text2sim.recording.inventory import first_fault
from text2sim.recording.record import RunRecord
from text2sim.recording.run_files import read_evidence, read_json
from text2sim.spec_schema.errors import RunError

MAX_RUNS = 24
"""More columns do not fit on the page."""

DESCRIPTIVE_PARTS = ("text2sim", "prompt")
"""Parts of a case that do not affect the simulation."""


@dataclass(frozen=True)
class Run:
    """One run, with its record, evidence and case."""

    folder: Path
    label: str
    """Its short name, unique among the runs."""
    record: RunRecord
    evidence: dict[str, Any]
    resolved: dict[str, Any]
    """The case as it ran, including all defaults."""

    @property
    def verdict(self) -> str:
        """`passed`, `failed` or `incomplete`."""
        return str(self.evidence.get("verdict") or "incomplete")

    @cached_property
    def leaves(self) -> dict[tuple[Any, ...], Any]:
        """Every value of the case by path; a list of numbers or strings counts as one value."""
        found: dict[tuple[Any, ...], Any] = {}
        stack: list[tuple[tuple[Any, ...], Any]] = [((), self.resolved)]
        while stack:
            path, value = stack.pop()
            if isinstance(value, dict) and value:
                stack += [((*path, key), item) for key, item in reversed(value.items())]
            elif isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
                stack += [((*path, index), item) for index, item in reversed(list(enumerate(value)))]
            elif value not in (None, {}, []):
                found[path] = value
        return found


def read_runs(folders: Sequence[Path]) -> list[Run]:
    """Read run folders; a sweep folder stands for all its runs.

    Raises:
        RunError: If there are fewer than two runs or too many, or a folder has no run or no evidence.
    """
    rows: list[tuple[Path, str | None]] = []
    for folder in folders:
        sweep = read_json(folder / "sweep.json")
        rows += _members(folder, sweep) if isinstance(sweep, dict) else [(folder, None)]
    if len(rows) < 2:
        raise RunError("two runs or more are needed for a comparison")
    if len(rows) > MAX_RUNS:
        raise RunError(f"at most {MAX_RUNS} runs can be compared at once (got {len(rows)})")
    runs = [_read(folder, label) for folder, label in rows]
    return _labelled(runs)


def _members(folder: Path, sweep: dict[str, Any]) -> list[tuple[Path, str | None]]:
    members, rows = [], sweep.get("runs")
    for row in rows if isinstance(rows, list) else ():
        name = row.get("folder") if isinstance(row, dict) else None
        if isinstance(name, str) and name == Path(name).name:
            members.append((folder.parent / name, str(row.get("label", name))))
    return members


def _read(folder: Path, label: str | None) -> Run:
    record = RunRecord.read_whole(folder)
    if record is None:
        raise RunError(f"{folder}: not the folder of a run (no run.json)")
    if damage := first_fault(folder, record.judged):
        raise RunError(f"{folder}: {damage}; run the case again")
    evidence, resolved = read_evidence(folder), read_json(folder / "resolved.json")
    if evidence is None or not isinstance(resolved, dict):
        why = f": {record.message}" if record.message else ""
        raise RunError(f"{folder}: the run {record.state} before there was anything to compare{why}")
    return Run(folder, label or folder.name, record, evidence, resolved)


def _labelled(runs: list[Run]) -> list[Run]:
    """Shorten labels: drop the digest if names stay unique, else use the values that differ if they are few."""
    names = [run.label for run in runs]
    short = [name.rpartition("-")[0] or name for name in names]
    for better in (short, _values(runs)):
        if len(set(better)) == len(names):
            names = better
            break
    seen: set[str] = set()
    for number, name in enumerate(names):
        names[number] = f"{name} ({number + 1})" if name in seen else name  # the same folder was given twice
        seen.add(name)
    return [replace(run, label=name) for run, name in zip(runs, names, strict=True)]


def _values(runs: list[Run]) -> list[str]:
    """Labels made of at most two differing values, such as `density 500`; parameters take precedence over the rest."""
    paths = differing_paths(runs)
    paths = [path for path in paths if path[0] == "params"] or paths
    if len(paths) > 2 or any(isinstance(run.leaves.get(path), list) for run in runs for path in paths):
        return []
    return [", ".join(f"{path[-1]} {_text(run.leaves.get(path))}" for path in paths) for run in runs]


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def differing_paths(runs: Sequence[Run]) -> list[tuple[Any, ...]]:
    """Return the paths of the values that differ between the cases, parameters first."""
    paths: dict[tuple[Any, ...], None] = {}
    for run in runs:
        paths |= dict.fromkeys(run.leaves)
    found = [
        path
        for path in paths
        if path[0] not in DESCRIPTIVE_PARTS and not are_equal([run.leaves.get(path) for run in runs])
    ]
    return sorted(found, key=lambda path: path[0] != "params")


def are_equal(values: Sequence[Any]) -> bool:
    """Whether all values have the same JSON text."""
    return len({json.dumps(value, sort_keys=True) for value in values}) == 1
