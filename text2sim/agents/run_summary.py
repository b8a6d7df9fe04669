"""Summary of a run as text: the evidence that the Critic judges and the Planner reads."""

import json
from collections.abc import Iterable, Mapping, Sequence
from math import isnan
from pathlib import Path
from typing import Any

from text2sim.agents.roles import quoted
from text2sim.recording.run_files import read_measures

Data = dict[str, Any]

QUOTED_TIMES = 7
"""Number of times at which each measure is quoted."""
MAX_ROWS = 30
"""Largest number of rows of a table."""
SHOWN_OF_REPEATED = 3
"""Most entries of one `repeat` that are all told; of more the first and the last."""
MAX_MINOR_ROWS = 6
"""Largest number of rows about joint limits, paths and work."""
IGNORED_OVERLAP = 5e-4
"""Largest overlap of rigid bodies that is not reported [m]."""
IGNORED_OVERSHOOT = {"m": 1e-3, "rad": 0.01}
"""Largest deviations from joint limits and driven paths that are not reported, by unit."""
IGNORED_WORK = 1e-6
"""Largest work that is not reported [J]."""
SERIES, SERIES_TIMES = "; over time ", "- over time: at "
"""What stands before values over time, and before their times, which all measures share."""
ABOUT_MOTION = ("Measures", "Diagnostics", "Positions", "Without the cause")
"""First words of the parts of the evidence that another film of the same run does not change."""
ROUNDING = 1e-12
"""Size below which a number is shown as 0."""
LOG_TAIL = 1_500
"""Characters from the end of the log of a run that did not finish."""


def evidence_text(
    folder: Path,
    evidence: Mapping[str, Any] | None,
    record: Mapping[str, Any],
    given: Iterable[str],
    pictured: str = "",
) -> str:
    """Summarise a run.

    Args:
        folder: The run folder.
        evidence: Content of `evidence.json`; None if nothing was recorded.
        record: Content of `run.json`.
        given: Names of the expectations that come from the request.
        pictured: Note about the accompanying frames.
    """
    parts = [_outcome(record)]
    if evidence is not None:
        parts += [
            _table("## Expectations", _expectations(evidence["expect"], set(given))),
            _table("## Measures", _measures(folder, evidence["measures"])),
            _table("## Events", _events(evidence["events"])),
            _table("## Diagnostics", _diagnostics(evidence)),
            _table("## What the cameras saw", [*([f"- {pictured}"] if pictured else []), *_visibility_rows(evidence)]),
        ]
    else:
        parts.append("Nothing was recorded.")
    if record.get("state") != "finished":
        parts.append("## End of the log\n\n<log>\n" + quoted(_log_tail(folder)) + "\n</log>")
    return "\n\n".join(part for part in parts if part)


def to_look_at(evidence: str) -> str:
    """Return evidence without the numbers about the motion, for a film of a run that was judged before."""
    return "\n\n## ".join(part for part in evidence.split("\n\n## ") if not part.startswith(ABOUT_MOTION))


def to_decide_by(evidence: str) -> str:
    """Return evidence without the parts for the Critic alone: values over time, and the cameras' views."""
    parts = [part for part in evidence.split("\n\n## ") if not part.startswith("What the cameras saw")]
    return "\n\n## ".join(map(_without_series, parts))


def _without_series(part: str) -> str:
    return "\n".join(row.partition(SERIES)[0] for row in part.split("\n") if not row.startswith(SERIES_TIMES))


def judgement_text(number: int, cause: str, critique: Mapping[str, Any] | None, fates: Sequence[str]) -> str:
    """Describe the Critic's judgement of an attempt, and the fate of each of its patches.

    Args:
        number: Number of the attempt.
        cause: Why the attempt was made.
        critique: The Critic's answer; None if it could not judge.
        fates: Outcome of each of its patches, in their order.
    """
    if critique is None:
        return f"Attempt {number} ({cause}) could not be judged."
    rows = [f"Attempt {number} ({cause}): {critique['verdict']}, {critique['score']:g} of 100. {critique['summary']}"]
    rows += [
        f"- `{name}` {row['mark']:g}: {row['why']}"
        for name, row in critique.get("requirements", {}).items()
        if row["mark"] < 1
    ]
    rows += [f"- {failure['what']}" for failure in critique["failures"]]
    for k, patch in enumerate(critique["patches"]):
        fate = fates[k] if k < len(fates) else "open"
        rows.append(f"- your patch on {patch['section']} ({patch['why']}): {fate}")
    rows += [f"- a patch of yours could not be applied: {row}" for row in critique.get("refused", ())]
    return "\n".join(rows)


def attempts_table(attempts: Sequence[tuple[int, Mapping[str, Any]]]) -> str:
    """Return a table of the results of expectations by attempt, and the names of those that were always true."""
    if len(attempts) < 2:
        return ""
    names = dict.fromkeys(name for _, expect in attempts for name in expect)
    always = [name for name in names if all(expect.get(name, {}).get("ok") for _, expect in attempts)]
    rows = []
    for name in (name for name in names if name not in always):
        found = [expect.get(name, {}) for _, expect in attempts]
        cells = [f"{'true' if row.get('ok') else 'MISSED'}: {row.get('why', '')}" if row else "-" for row in found]
        rows.append(f"| `{name}` | " + " | ".join(cells) + " |")
    if rows:
        rows.insert(0, "| expectation | " + " | ".join(f"attempt {number}" for number, _ in attempts) + " |")
    if always:
        rows.append(f"True in each attempt: {', '.join(f'`{name}`' for name in always)}")
    return "\n".join(rows)


def citable_items(evidence: Mapping[str, Any] | None, frames: int, bodies: Iterable[str]) -> frozenset[str]:
    """Return the citable items of a run's evidence.

    Args:
        evidence: Evidence of the run; None if there is none.
        frames: Number of pictures that were shown.
        bodies: Names of bodies.
    """
    cites = {"run"} | {f"frame:{k}" for k in range(1, frames + 1)} | {f"body:{name}" for name in bodies}
    if evidence is not None:
        for part, word in (("expect", "expect"), ("measures", "measure"), ("events", "event")):
            cites |= {f"{word}:{name}" for name in evidence[part]}
        cites |= {f"diagnostic:{name}" for name in DIAGNOSTICS}
    return frozenset(cites)


DIAGNOSTICS = ("energy", "penetration", "speeds", "joint_limits", "deformables", "suspicions", "contacts", "visibility",
               "legibility", "non_finite", "driven", "off_path", "motors_at_limit", "bonds",
               "causes")  # fmt: skip


def _outcome(record: Mapping[str, Any]) -> str:
    reached = f"{record.get('time', 0):.3g} of {record.get('duration', 0):g} s simulated"
    message = f": {record['message']}" if record.get("message") else ""
    if seconds := (record.get("timings") or {}).get("simulate"):
        reached += (
            f", {_short_number(seconds / record['time'])} s of wall time per simulated second"
            if record.get("time")
            else ""
        )
    return f"Run: {record.get('state')}, {reached}{message}"


def _repeated(names: Iterable[str]) -> list[list[str]]:
    """Group names of one `repeat` that follow each other, such as `bend_0`, `bend_1` and so on."""
    groups: list[list[str]] = []
    for name in names:
        base, _, number = name.rpartition("_")
        follows = groups and number.isdecimal() and groups[-1][0] == f"{base}_0" and int(number) == len(groups[-1])
        groups[-1].append(name) if follows else groups.append([name])
    return groups


def _expectations(expect: Mapping[str, Data], given: set[str]) -> list[str]:
    rows = []
    for names in _repeated(expect):
        found = [expect[name] for name in names]
        if _is_long(names) and len({row.get("ok") for row in found}) == 1:
            told = {key: f"{found[0].get(key)}; …; {found[-1].get(key)}" for key in ("wanted", "why")}
            rows.append(_expectation(f"`{names[0]}` to `{names[-1]}`", found[0] | told, names[0] in given))
        else:
            rows += [_expectation(f"`{name}`", row, name in given) for name, row in zip(names, found, strict=True)]
    return rows


def _expectation(names: str, row: Data, given: bool) -> str:
    mark = {True: "true", False: "MISSED", None: "open"}[row.get("ok")]
    return f"- {mark} {names}{' (request)' if given else ''}: wanted {row.get('wanted')}; found: {row.get('why')}"


def _measures(folder: Path, measures: Mapping[str, Data]) -> list[str]:
    times, series = read_measures(folder)
    rows, picked = [], list[int]()
    if series and len(times) > QUOTED_TIMES:
        picked = [round(k * (len(times) - 1) / (QUOTED_TIMES - 1)) for k in range(QUOTED_TIMES)]
        rows.append(f"{SERIES_TIMES}{', '.join(_short_number(times[k]) for k in picked)} s")
    shown = {name for names in _repeated(measures) for name in (names[:: len(names) - 1] if _is_long(names) else names)}
    shown |= {name for name, row in measures.items() if row.get("problem") or row.get("min") is None}
    for name, row in measures.items():
        if name not in shown:
            continue
        if row.get("problem"):
            rows.append(f"- `{name}`: {row['problem']}")
            continue
        low, high = (f"{_short_number(row[end])} at {_short_number(row[f'{end}_at'])} s" for end in ("min", "max"))
        text = f"- `{name}` [{row.get('unit') or '-'}]: min {low}, max {high}"
        if picked and (values := series.get(name)) is not None:
            text += SERIES + ", ".join(_short_number(values[k]) for k in picked)
        rows.append(text)
    for first, *between, last in filter(_is_long, _repeated(measures)):
        inner = [measures[name] for name in between if name not in shown]
        ends = (f"{_short_number(least)} to {_short_number(most)}" for least, most in _spans(inner, ("min", "max")))
        rows += [f"- between `{first}` and `{last}` {len(inner)} more: min {', max '.join(ends)}"] if inner else []
    return rows


def _is_long(names: Sequence[str]) -> bool:
    return len(names) > SHOWN_OF_REPEATED


def _spans(rows: Sequence[Data], keys: Sequence[str]) -> list[tuple[float, float]]:
    """Return the smallest and the largest value of each key."""
    return [(min(row[key] for row in rows), max(row[key] for row in rows)) for key in keys]


def _events(events: Mapping[str, Data]) -> list[str]:
    rows = []
    for name, row in events.items():
        count = row.get("count") or 0
        when = f"once, at {_short_number(row['first'])} s" if count else "never"
        if count > 1:
            first, last = _short_number(row["first"]), _short_number(row["last"])
            when = f"{count} times, first at {first} s, last at {last} s"
        rows.append(f"- `{name}`: {when}" + (f" ({row['problem']})" if row.get("problem") else ""))
    return rows


def _diagnostics(evidence: Mapping[str, Any]) -> list[str]:
    rows = []
    energy = evidence.get("energy")
    if energy:
        rows.append(
            f"- energy: {_short_number(energy['start'])} J first, at most {_short_number(energy['max'])} J at "
            f"{_short_number(energy['max_at'])} s, {_short_number(energy['end'])} J at the end"
            + "".join(f"; {row}" for row in _work_rows(energy))
            + "".join(f"; not counted: {row}" for row in energy.get("not_counted") or ())
        )
    deepest = evidence.get("penetration") or {}
    if (deepest.get("value") or 0.0) > IGNORED_OVERLAP:
        between = " and ".join(f"`{name}`" for name in deepest["between"])
        rows.append(
            f"- penetration: at most {_short_number(deepest['value'])} m, {between}, at "
            f"{_short_number(deepest['time'])} s"
        )
    over = [row for row in evidence.get("joint_limits") or () if row["by"] > IGNORED_OVERSHOOT[row["unit"]]]
    off = [row for row in evidence.get("off_path") or () if row["value"] > IGNORED_OVERSHOOT[row["unit"]]]
    for name, found in (
        ("non_finite", evidence.get("non_finite")),
        ("joint_limits", over[:MAX_MINOR_ROWS]),
        ("driven", evidence.get("driven")),
        ("off_path", off[:MAX_MINOR_ROWS]),
        ("bonds", evidence.get("bonds")),
    ):
        if found:
            rows.append(f"- {name}: {_small(found)}")
    rows += [f"- motors_at_limit: {_at_limit(row)}" for row in (evidence.get("motors_at_limit") or [])[:MAX_MINOR_ROWS]]
    for body, row in list((evidence.get("speeds") or {}).items())[:MAX_ROWS]:
        linear = (row or {}).get("linear") or {}
        if linear.get("max"):
            rows.append(
                f"- speeds: `{body}` at most {_short_number(linear.get('max'))} m/s at "
                f"{_short_number(linear.get('at'))} s"
            )
    for body, row in list((evidence.get("deformables") or {}).items())[:MAX_ROWS]:
        told = [
            f"{name} {_worst_value(one)}"
            for name, one in row.items()
            if isinstance(one, dict) and one.get("value") and name != "against_bounds"
        ]
        if (row.get("against_bounds") or {}).get("value"):
            told.append(
                f"it meets the invisible wall of its solver's space (most at {row['against_bounds']['at']:.3g} s)"
            )
        rows.append(f"- deformables: `{body}`, worst values: {', '.join(told) or 'none'}")
    rows += [f"- suspicions: {text}" for text in (evidence.get("suspicions") or [])[:MAX_ROWS]]
    return rows


def _at_limit(row: Mapping[str, Any]) -> str:
    off = "" if row["off"] is None else f", {_short_number(row['off'])} {row['unit']} from its target at the end"
    against = " and ".join(f"`{name}`" for name in row.get("against") or ())
    return (
        f"`{row['joint']}` at its max_force of {_short_number(row['max_force'])} {row['force_unit']} for "
        f"{row['share']:.0%} of `{row['control']}`, {_short_number(row['start'])} to {_short_number(row['end'])} s{off}"
        + (f", pressed against {against}" if against else "")
    )


def _work_rows(energy: Mapping[str, Any]) -> list[str]:
    """Work of motors and controls, and the motors' work up to the maximum of the energy."""
    works = energy.get("works") or {}
    entries = [("motor", name, work) for name, work in (works.get("motors") or {}).items()]
    entries += [("control", name, work) for name, work in (works.get("controls") or {}).items()]
    entries = sorted((row for row in entries if abs(row[2]) > IGNORED_WORK), key=lambda row: -abs(row[2]))
    if not entries:
        return []
    rows = ", ".join(f"{what} `{name}` {_short_number(work)} J" for what, name, work in entries[:MAX_MINOR_ROWS])
    until = f"; motors until then {_short_number(energy['work_until_max'])} J" if works.get("motors") else ""
    return [f"work in all: {rows}{until}"]


def _worst_value(row: Mapping[str, Any]) -> str:
    """A worst value with its unit, place and time."""
    where = f" in `{row['in']}`" if row.get("in") else ""
    return (
        f"{_short_number(row['value'])} {row.get('unit') or ''}".rstrip()
        + f"{where} at {_short_number(row.get('at'))} s"
    )


def _visibility_rows(evidence: Mapping[str, Any]) -> list[str]:
    rows = []
    for camera, row in (evidence.get("visibility") or {}).items():
        for body, seen in row["bodies"].items():
            share = f"{100 * seen['largest']:.2g} % of the picture (at {_short_number(seen['at'])} s)"
            often = f"seen in {seen['pictures']} of {row['pictures']} samples"
            rows.append(f"- `{camera}`: `{body}` fills at most {share}, {often}")
        if row["never_seen"]:
            rows.append(f"- `{camera}` never sees {', '.join(f'`{name}`' for name in row['never_seen'])}")
    legibility = evidence.get("legibility") or {}
    rows += [f"- {remark}" for remark in (legibility.get("remarks") or [])[:MAX_ROWS]]
    return rows


def _table(title: str, rows: Sequence[str]) -> str:
    if not rows:
        return ""
    more = [f"- … and {len(rows) - MAX_ROWS} more"] if len(rows) > MAX_ROWS else []
    return "\n".join([title, "", *rows[:MAX_ROWS], *more])


def _log_tail(folder: Path) -> str:
    try:
        text = (folder / "log.txt").read_text("utf-8", "replace")
    except OSError:
        return ""
    # Paths are cut to their last two parts, to reveal nothing of this machine.
    rows = [
        " ".join(".../" + "/".join(w.split("/")[-2:]) if w.startswith("/") else w for w in row.split(" "))
        for row in text[-LOG_TAIL:].splitlines()
    ]
    return "\n".join(rows)


def _small(value: Any) -> str:
    """Return data on one line, with four digits."""
    return json.dumps(_rounded(value), ensure_ascii=False, separators=(", ", ": "))[:400].replace('"', "")


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, dict):
        return {key: _rounded(row) for key, row in value.items() if row not in (None, [], {})}
    if isinstance(value, list):
        return [_rounded(row) for row in value[:6]]
    return value


def _short_number(value: Any) -> str:
    if not isinstance(value, int | float) or isnan(value):
        return "-"
    return f"{value:.4g}" if abs(value) > ROUNDING else "0"
