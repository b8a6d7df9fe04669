"""Sweeps: runs of one case, one for each point, and the table of results."""

import csv
import io
import json
import sys
from hashlib import sha256
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any

from text2sim.cli.output import say, say_json
from text2sim.cli.verdict import MARKS, exit_of, say_failure
from text2sim.service import exits
from text2sim.service.phrases import display_path, run_line
from text2sim.spec_schema.errors import RunError, SpecError
from text2sim.spec_schema.whole_files import write_atomically

if TYPE_CHECKING:
    from text2sim.harness.result import RunResult
    from text2sim.service.examined import Examined
    from text2sim.spec_schema.models.expectations import Expect
    from text2sim.spec_schema.reuse.overlay import CaseOverlay


def run_sweep(
    path: Path, overlay: "CaseOverlay", name: str, grid: list[str], options: dict[str, Any], *, as_json: bool
) -> int:
    """Run a sweep of a case, and return the exit code: the worst of its runs.

    Args:
        path: The case.
        overlay: Overlay of the case in every run.
        name: Name of the sweep; empty for a grid.
        grid: Axes of a grid, as `PATH=[a, b]`.
        options: Keyword arguments of `attempts`.
        as_json: Print one JSON document.
    """
    from text2sim.cli.cases import say_examined
    from text2sim.cli.many import attempts
    from text2sim.service.examined import examine

    base = examine(path, to="loaded", overlay=overlay)
    points = _points(base, name, grid) if base.ok else []
    rows = [(label, examine(path, overlay=overlay + over)) for label, over in points]
    bad = [row for _, row in rows if not row.ok] or ([] if base.ok else [base])
    if bad:
        if as_json:
            say_json({"ok": False, "runs": [row.as_dict() for row in bad]})
        printed: set[tuple[str, ...]] = set()
        for row in () if as_json else bad:
            words = tuple(str(problem) for problem in row.problems)
            if words and words in printed:
                continue  # an invalid path fails with each of its values
            printed.add(words)
            say(f"{row.title}:", to=sys.stderr)
            say_examined(row)
        return max(row.exit for row in bad)

    name = name or f"grid-{sha256(chr(0).join(grid).encode()).hexdigest()[:6]}"
    code, done = exits.OK, _Table(base, name, Path(options["runs"]))
    results = attempts([row for _, row in rows], quiet=as_json, **options)
    for number, ((label, _), (row, result)) in enumerate(zip(rows, results, strict=False)):
        code = max(code, row.exit if result is None else exit_of(result))
        done.add(label, row, result)
        done.write()
        if not as_json:
            words = "could not be run" if result is None else run_line(result)
            say_examined(row) if result is None else say_failure(row, result)
            say(f"[{number + 1}/{len(rows)}] {label}: {words}")
        if result is not None and result.stopped:
            break
    if as_json:
        say_json({"ok": code == exits.OK, **done.document()})
    else:
        done.say()
        say(f"sweep: {display_path(done.folder / 'sweep.json')}")
        say(f"next: text2sim compare {display_path(done.folder)}")
    return code


def _points(base: "Examined", name: str, grid: list[str]) -> "list[tuple[str, CaseOverlay]]":
    """Label and overlay of each run; empty, with the reason in `base`, if there are none."""
    from text2sim.spec_schema.reuse.sweeps import grid_runs, parse_grid, runs_of

    assert base.loaded is not None
    try:
        if name and grid:
            raise RunError("give either --sweep or --grid, not both")
        return runs_of(base.loaded.written, name) if name else grid_runs(parse_grid(grid))
    except (RunError, SpecError) as error:
        base.blame(error)
        base.sources |= {"--grid": "\n".join(grid), "--sweep": name}
        return []


class _Table:
    """Results of the runs, as stored in `sweep.json` and `sweep.csv`."""

    def __init__(self, base: "Examined", name: str, runs: Path) -> None:
        self.name, self.case, self.overlay = name, base.name, base.overlay
        parts = (self.case, self.overlay.label, "sweep", name)
        self.folder = runs / "-".join(part for part in parts if part)
        self.rows: list[dict[str, Any]] = []
        self.units: dict[str, str] = {}
        """Unit of the value of every expectation."""
        self.bounds: dict[str, str] = {}
        """What each expects, in short."""

    def add(self, label: str, row: "Examined", result: "RunResult | None") -> None:
        evidence = (result.evidence if result is not None else None) or {}
        assert row.loaded is not None
        wanted, found = row.loaded.case.actions.expect, evidence.get("expect", {})
        for name, expect in wanted.items():
            bound = _bound_text(expect)
            if self.bounds.setdefault(name, bound) != bound:
                self.bounds[name] = "bounds vary"
            self.units[name] = found.get(name, {}).get("unit") or self.units.get(name, "")
        self.rows.append(
            {
                "label": label,
                "folder": result.folder.name if result is not None else None,
                "variants": list(row.overlay.variants),
                "point": list(row.overlay.point) if row.overlay.point else None,
                "sets": list(row.overlay.sets),
                "state": result.state if result is not None else "failed",
                "passed": result is not None and result.passed,
                "came_true": sum(one.get("ok") is True for one in found.values()),
                "expected": len(wanted),
                "expect": {name: one.get("ok") for name, one in found.items()},
                "observed": {name: _observed(expect, name, evidence) for name, expect in wanted.items()},
            }
        )

    def document(self) -> dict[str, Any]:
        return {
            "case": self.case,
            "sweep": self.name,
            "variants": list(self.overlay.variants),
            "sets": list(self.overlay.sets),
            "folder": str(self.folder),
            "units": self.units,
            "runs": self.rows,
        }

    def write(self) -> None:
        """Rewrite both files, so that an interrupted sweep keeps its results."""
        self.folder.mkdir(parents=True, exist_ok=True)
        write_atomically(self.folder / "sweep.json", json.dumps(self.document(), indent=1, allow_nan=False) + "\n")
        stream = io.StringIO()
        names = list(self.units)
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(["label", "folder", "state", "came_true", "expected", *names])
        for row in self.rows:
            values = [row["observed"].get(name) for name in names]
            table.writerow([row[key] for key in ("label", "folder", "state", "came_true", "expected")] + values)
        write_atomically(self.folder / "sweep.csv", stream.getvalue())

    def say(self) -> None:
        """Print the values that were judged, below what was expected of them, in as many tables as the width needs."""
        columns = [["", "", *(row["label"] for row in self.rows)]]
        columns.append(["came true", "", *(f"{row['came_true']}/{row['expected']}" for row in self.rows)])
        for name, unit in self.units.items():
            cells = [_cell(row["observed"].get(name), row["expect"].get(name, True)) for row in self.rows]
            columns.append([f"{name} [{unit}]" if unit else name, self.bounds[name], *cells])
        labels, *rest = [[cell.rjust(max(map(len, column))) for cell in column] for column in columns]
        labels = [cell.strip().ljust(len(cell)) for cell in labels]
        room = get_terminal_size((100, 0)).columns
        while rest:
            lines, taken = labels, 0
            while taken < len(rest) and (not taken or len(lines[0]) + 2 + len(rest[taken][0]) <= room):
                lines = [f"{line}  {cell}" for line, cell in zip(lines, rest[taken], strict=True)]
                taken += 1
            rest = rest[taken:]
            for line in lines:
                say(line.rstrip())


def _observed(expect: "Expect", name: str, evidence: dict[str, Any]) -> float | None:
    """Return what was compared with the bounds of an expectation: with `on`, the time since that event [s]."""
    value = evidence.get("expect", {}).get(name, {}).get("value")
    if value is None or expect.on is None or expect.event is None or expect.count is not None or expect.never:
        return value
    return value - evidence["events"][expect.on]["first"]


def _bound_text(expect: "Expect") -> str:
    """Return what is expected, in short: `max < 3`, `0 to 0.5 after let_go`."""
    words = [expect.stat or ""]
    words += [f"{sign} {v:.4g}" for sign, v in ((">", expect.above), ("<", expect.below)) if v is not None]
    if expect.equals is not None:
        words.append(f"{expect.equals:.4g} ± {expect.tolerance:.4g}")
    if expect.never:
        words.append("never")
    if expect.count is not None:
        low, high = (expect.count, expect.count) if isinstance(expect.count, int) else expect.count
        words.append(f"{low} times" if low == high else f"{low} to {high} times")
    if expect.within is not None:
        words.append(" to ".join(one if isinstance(one, str) else f"{one:.4g}" for one in expect.within))
        words.append(f"after {expect.on}" if expect.on else "")
    words.append(f"before {expect.before}" if expect.before else "")
    return " ".join(word for word in words if word) or "happens"


def _cell(value: float | None, ok: bool | None) -> str:
    text = "" if value is None else f"{value:.4g}"
    return f"{text} {MARKS[ok]}".strip() if not ok else text or "-"
