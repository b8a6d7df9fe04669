"""Tables of an evaluation, as text, CSV and Parquet: scores, differences, agreement, resources, single judgements."""

import csv
import importlib.util
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.evaluation.judging import KINDS, Judgement, Kind, read_judgements
from text2sim.evaluation.method_folder import MethodFolder, Resources, read_method
from text2sim.evaluation.scores import PHYSICAL_WEIGHTS, VISUAL_WEIGHTS
from text2sim.evaluation.statistics import (
    Estimate,
    case_scores,
    estimate,
    judges_agree,
    paired_difference,
    part_scores,
    repeats_agree,
    spread_within,
)
from text2sim.evaluation.suite import Suite
from text2sim.spec_schema.errors import RunError, SpecError
from text2sim.spec_schema.whole_files import write_atomically

Row = dict[str, Any]

PAPER_RESULTS: tuple[Row, ...] = (
    {"method": "Text2Sim", "physical": 95.32, "visual": 70.23, "tokens": 29.1e6, "minutes": 101.4, "without": 58.0},
    {"method": "Claude-Opus-5, bare", "physical": 88.60, "visual": 59.45, "tokens": 28.7e6, "minutes": 58.7},
    {"method": "GPT-5.6-Sol, bare", "physical": 86.59, "visual": 59.89, "tokens": 24.8e6, "minutes": 60.9},
    {"method": "GPT-6-Astra, bare", "physical": 89.46, "visual": 60.64},
    {"method": "Qwen-3.8, bare", "physical": 84.09, "visual": 56.31, "tokens": 23.9e6, "minutes": 95.1},
    {"method": "Code2Worlds", "physical": 67.91, "visual": 59.26, "tokens": 27.26e6, "minutes": 113.0},
)
"""Figures that the paper of Text2Sim reports for its own 42 prompts, judges and prices; they are not directly
comparable with ours."""
RESOURCES = ("tokens_in", "tokens_out", "tokens_cached", "cost", "wall_s", "without_simulation_s", "attempts")


@dataclass(frozen=True)
class Tables:
    """All tables of an evaluation."""

    suite: Suite
    record: Row
    """Record of the judging: models, repeats, methods."""
    judgements: Sequence[Judgement]
    methods: Mapping[str, MethodFolder | None]
    """Method folders by name; None if a folder no longer exists."""
    tables: Mapping[str, list[Row]]
    """Rows by name of the table, which is also the name of its file."""


def tables_of(suite: Suite, out: Path) -> Tables:
    """Compute all tables of an evaluation.

    Raises:
        RunError: If there are no judgements, or they belong to another version of the suite.
    """
    record, rows = read_judgements(out)
    if record["digest"] != suite.digest():
        raise RunError(f"{out}: judged with another version of {record['suite']}: {record['digest'][:12]}…")
    methods = {name: _method(Path(folder)) for name, folder in record["methods"].items()}
    families = {name: prompt.family for name, prompt in suite.prompts.items()}
    tables = {
        "scores": [_scores(rows, name, families) for name in methods],
        "differences": _differences(rows, list(methods)),
        "agreement": _agreement(rows, len(record["models"])),
        "resources": [_mean_resources(name, method, suite) for name, method in methods.items()],
        "resources_by_case": [row for name, method in methods.items() for row in _case_resources(name, method, suite)],
        "judgements": [_flat(row, record["models"]) for row in rows],
        "requirements": [part for row in rows for part in _requirements(row, suite)],
    }
    return Tables(suite, record, rows, methods, tables)


def _method(folder: Path) -> MethodFolder | None:
    try:
        return read_method(folder)
    except (RunError, SpecError):
        return None


def _scores(rows: Sequence[Judgement], method: str, families: Mapping[str, str]) -> Row:
    row: Row = {"method": method}
    own = [judgement for judgement in rows if judgement.turn.method == method]
    for kind in KINDS:
        scores = {prompt: value for (_, prompt), value in case_scores(own, kind).items()}
        row |= _estimate_columns(kind, estimate(list(scores.values())))
        row[f"{kind}_sd_within"] = spread_within(rows, kind, method)
        for family in dict.fromkeys(families.values()):
            row[f"{kind}_{family}"] = _mean(value for prompt, value in scores.items() if families[prompt] == family)
        states = [judgement.state for judgement in own if judgement.turn.kind == kind]
        row[f"{kind}_not_judged"] = states.count("not_judged")
    physical, visual = ([judgement for judgement in own if judgement.turn.kind == kind] for kind in KINDS)
    for part in PHYSICAL_WEIGHTS:
        parts = part_scores(physical, lambda judged, part=part: (judged.score or {}).get("parts", {}).get(part))
        row[part] = _mean(parts.values())
    for part in VISUAL_WEIGHTS:
        row[part] = _mean(part_scores(visual, lambda judged, part=part: (judged.reply or {}).get(part)).values())
    return row


def _differences(rows: Sequence[Judgement], methods: Sequence[str]) -> list[Row]:
    found = []
    for kind in KINDS:
        scores = case_scores(rows, kind)
        for one, other in combinations(methods, 2):
            if (difference := paired_difference(scores, one, other)) is not None:
                found.append({"score": kind, "method": one, "less": other, **asdict(difference)})
    return found


_SPELLED = {"mean": "", "low": "_low", "high": "_high", "count": "_cases"}


def _estimate_columns(kind: Kind, value: Estimate | None) -> Row:
    row = asdict(value) if value is not None else dict.fromkeys(_SPELLED)
    return {f"{kind}{suffix}": row[name] for name, suffix in _SPELLED.items()}


def _agreement(rows: Sequence[Judgement], models: int) -> list[Row]:
    found = []
    for kind in KINDS:
        pairs = [("repeats of one judge", repeats_agree(rows, kind))]
        numbers = combinations(range(1, models + 1), 2)
        pairs += [(f"judges {a} and {b}", judges_agree(rows, kind, a, b)) for a, b in numbers]
        found += [
            {"score": kind, "between": name, **asdict(agreement)} for name, agreement in pairs if agreement is not None
        ]
    return found


def _mean_resources(name: str, method: MethodFolder | None, suite: Suite) -> Row:
    """Means of each resource over the cases with a known value."""
    cases = [row for row in _case_resources(name, method, suite) if row["role"] == "all"]
    row: Row = {"method": name, "cases": len(cases)}
    for part in RESOURCES:
        row[part] = _mean(case[part] for case in cases if case[part] is not None)
    return row


def _case_resources(name: str, method: MethodFolder | None, suite: Suite) -> list[Row]:
    """One row for each case, and one for each role in it."""
    found = []
    for prompt, made in (method.made if method is not None else {}).items():
        if prompt not in suite.prompts:
            continue
        result = made.result
        head = {"method": name, "prompt": prompt, "status": result.status, "accepted": result.accepted}
        wall, simulation = result.wall_s, result.simulation_s
        without = max(0.0, wall - simulation) if wall is not None and simulation is not None else None
        times = {"wall_s": wall, "simulation_s": simulation, "without_simulation_s": without}
        found.append(head | {"role": "all", **_spent(result.total), **times, "attempts": result.attempts})
        found += [head | {"role": role, **_spent(spent)} for role, spent in (result.roles or {}).items()]
    return found


def _spent(spent: Resources | None) -> Row:
    names = ("calls", "tokens_in", "tokens_out", "tokens_cached", "cost")
    return {name: getattr(spent, name) if spent is not None else None for name in names}


def _flat(row: Judgement, models: Sequence[str]) -> Row:
    turn = row.turn
    flat: Row = {
        "prompt": turn.prompt, "method": turn.method, "score": turn.kind, "judge": turn.judge,
        "model": models[turn.judge - 1], "repeat": turn.repeat, "state": row.state, "total": row.total, "why": row.why,
    }  # fmt: skip
    score, reply = row.score or {}, row.reply or {}
    flat |= {part: score.get("parts", {}).get(part) for part in PHYSICAL_WEIGHTS}
    flat |= {name: score.get(name) for name in ("faithfulness", "aesthetics", "penalty")}
    flat["caps"] = " ".join(f"{cap:g}" for cap in score.get("caps", ()))
    return flat | {part: reply.get(part) for part in VISUAL_WEIGHTS}


def _requirements(row: Judgement, suite: Suite) -> list[Row]:
    turn, prompt = row.turn, suite.prompts[row.turn.prompt]
    if turn.kind != "physical" or row.reply is None or prompt.requirements is None:
        return []
    head = {"prompt": turn.prompt, "method": turn.method, "judge": turn.judge, "repeat": turn.repeat}
    marks, violations = row.reply["requirements"], row.reply.get("prohibitions") or {}
    found = []
    for name, (_, requirement) in prompt.requirements.rows().items():
        mark = marks.get(name) or {"mark": 0.0, "evidence": ""}
        words = {"requirement": name, "what": requirement.what, "weight": requirement.importance}
        found.append(head | words | {"mark": mark["mark"], "evidence": mark["evidence"]})
    for name, prohibition in prompt.prohibitions.items():
        violation = violations.get(name) or {"violated": "no", "evidence": ""}
        words = {"requirement": f"never.{name}", "what": prohibition.what, "weight": prohibition.weight}
        mark = {"no": 1.0, "yes": 0.0, "severely": 0.0}[violation["violated"]]
        found.append(head | words | {"mark": mark, "evidence": violation["evidence"]})
    return found


def _mean(values: Iterable[float]) -> float | None:
    known = list(values)
    return float(np.mean(known)) if known else None


def write_tables(tables: Tables, out: Path) -> list[Path]:
    """Write each table as CSV, and as Parquet if pyarrow is installed; return the files."""
    written = []
    folder = out / "tables"
    folder.mkdir(parents=True, exist_ok=True)
    for name, rows in tables.tables.items():
        if not rows:
            continue
        columns = list(dict.fromkeys(key for row in rows for key in row))
        text = io.StringIO()
        writer = csv.DictWriter(text, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        write_atomically(folder / f"{name}.csv", text.getvalue())
        written.append(folder / f"{name}.csv")
        if importlib.util.find_spec("pyarrow") is not None:
            import pyarrow
            import pyarrow.parquet

            table = pyarrow.Table.from_pylist([{key: row.get(key) for key in columns} for row in rows])
            pyarrow.parquet.write_table(table, folder / f"{name}.parquet")
            written.append(folder / f"{name}.parquet")
    return written


def text_of(tables: Tables) -> str:
    """Return the scores, one line for each method, and the differences between methods."""
    rows = ["method                    physical               visual                 sd within    not judged"]
    for row in tables.tables["scores"]:
        cells = [f"{row['method'][:24]:<24}"]
        cells += [_interval(row, kind) for kind in KINDS]
        sds = [row[f"{kind}_sd_within"] for kind in KINDS]
        cells.append(" / ".join("–" if sd is None else f"{sd:.1f}" for sd in sds).rjust(11))
        cells.append(str(sum(row[f"{kind}_not_judged"] for kind in KINDS)).rjust(12))
        rows.append("  ".join(cells))
    for row in tables.tables["differences"]:
        rows.append(
            f"{row['method']} minus {row['less']}, {row['score']}: {row['mean']:+.1f} [{row['low']:+.1f}, "
            f"{row['high']:+.1f}] over {row['count']} cases"
        )
    return "\n".join(rows)


def _interval(row: Row, kind: Kind) -> str:
    if row[kind] is None:
        return "–".rjust(21)
    return f"{row[kind]:5.1f} [{row[f'{kind}_low']:5.1f}, {row[f'{kind}_high']:5.1f}]".rjust(21)
