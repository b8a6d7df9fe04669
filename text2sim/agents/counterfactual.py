"""Counterfactual runs: without a claimed cause, its effect must not occur."""

import copy
import json
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from text2sim.agents import revising
from text2sim.agents.assembly import examine, format_problem
from text2sim.agents.contract import numbered_copies
from text2sim.agents.facts import Fact
from text2sim.agents.replies import CasePlan
from text2sim.recording.run_files import read_json
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.canonical import format_text

Data = dict[str, Any]
MAX_CAUSES = 2
"""Largest number of causes that are tested; each costs a simulation."""
TITLE = "## Without the cause"
PARTS = ("controls", "measures", "events", "expect")
CAUSE_VERDICTS: dict[bool | None, str] = {
    True: "COMES TRUE AS WELL: no cause",
    False: "does not come true, as it must be",
}
"""Verdict on a cause, by whether the effect's expectation came true in a finished run without it."""
Found = Mapping[str, Mapping[str, Any]]
_NUMBER = re.compile(r"_(\d+|\$\{.*\})$")


def case_without(case: Data, names: Collection[str], times: Mapping[str, float | None] | None = None) -> Data:
    """Return a case without its film, and without the named bodies, statics and controls and all references to them.

    A drive to a position or velocity is not left out, because a motor without a drive gives no force; it never begins,
    so that the joint is held where it starts. An expectation that counts from (`on`) an event that is left out counts
    from the time of that event instead.

    Args:
        case: The case.
        names: Bodies, statics and controls.
        times: First time of each event [s] in the run of the whole case, None if it did not happen; 0 if not given.
    """
    left = {key: row for key, row in copy.deepcopy(case).items() if key not in ("render", "variants", "sweeps")}
    scene, actions = left.get("scene") or {}, left.get("actions") or {}
    several = {name for part in PARTS for name, row in (actions.get(part) or {}).items() if "repeat" in row}
    controls = actions.get("controls") or {}
    held = {name: mode for name in names if (mode := _holding_mode(controls.get(name)))}
    for name, mode in held.items():
        never = {"kind": "constant", "value": 0, "start": scene["duration"]}
        controls[name] = {key: value for key, value in controls[name].items() if key != "on"} | {mode: never}
    names = [name for name in names if name not in held]
    for rows in (left.get("bodies") or {}, scene.get("statics") or {}, controls):
        for name in names:
            rows.pop(name, None)
    gone = {*names, *(f"{name}_*" for name in several.intersection(names))}
    pairs = (scene.get("contact") or {}).get("pairs") or {}
    for name in [name for name, row in pairs.items() if _refers(row, gone)]:
        del pairs[name]
    for row in controls.values():
        body = row.get("body")  # an airflow has a list, and blows on those that are left
        if isinstance(body, list) and (others := [one for one in body if not _refers(one, gone)]):
            row["body"] = others
    while lost := [
        (part, name)
        for part in PARTS
        for name, row in (actions.get(part) or {}).items()
        if _refers(row, gone) or _waits_in_vain(row, actions)
    ]:
        for part, name in lost:
            row = actions[part][name]
            if part == "expect" and (kept := _by_the_clock(row, times)) and not _refers(kept, gone):
                actions[part][name] = kept
                continue
            del actions[part][name]
            gone |= {name, f"{name}_*"} if name in several else {name}
    return left


def _holding_mode(control: Data | None) -> str | None:
    """Return `position` or `velocity` for a drive that holds its joint before it begins; None for what does not."""
    if control is None or control.get("kind") != "drive":
        return None
    return next((mode for mode in ("position", "velocity") if mode in control), None)


def _by_the_clock(row: Data, times: Mapping[str, float | None] | None) -> Data:
    """Return an expectation `on` an event with times of the run instead; empty if there is no such time."""
    event = row.get("on")
    time = 0.0 if times is None else times.get(str(event))
    if not isinstance(event, str) or "${" in event or time is None:
        return {}
    kept = {key: value for key, value in row.items() if key != "on"}
    for key in {"within", "at", "during"}.intersection(kept):
        span = kept[key]
        kept[key] = [_later(one, time) for one in span] if isinstance(span, list) else _later(span, time)
    return kept


def _later(value: Any, time: float) -> Any:
    if isinstance(value, str):
        return f"${{({inner[1]}) + {time}}}" if (inner := re.fullmatch(r"\$\{(.*)\}", value)) else value
    return value + time if isinstance(value, (int, float)) else value


def _waits_in_vain(row: Mapping[str, Any], actions: Mapping[str, Any]) -> bool:
    """Whether an entry is the event of a release for which no control is left."""
    releases = [one for one in (actions.get("controls") or {}).values() if one.get("kind") == "release"]
    return row.get("kind") == "released" and all(one.get("attach") != row.get("attach") for one in releases)


def _refers(row: Any, names: Collection[str]) -> bool:
    """Whether an entry refers to one of these names; `hold_*` stands for all that a `repeat` makes of `hold`."""
    if isinstance(row, str):
        return body_of(row) in names or _NUMBER.sub("_*", row) in names
    if isinstance(row, Mapping):
        return any(_refers(value, names) for key, value in row.items() if key != "kind")
    return isinstance(row, list) and any(_refers(value, names) for value in row)


def cause_faults(case: Data, plan: CasePlan) -> list[str]:
    """Describe the claims whose effects all depend on the cause itself, so that a run without it shows nothing.

    Args:
        case: The case, or one of stand-ins; `release` controls that it does not have yet are assumed.
        plan: The plan that makes the claims.
    """
    actions = case.get("actions") or {}
    awaited = [row["attach"] for row in (actions.get("events") or {}).values() if row.get("kind") == "released"]
    releases = {f"release of {name}": {"kind": "release", "attach": name} for name in awaited}
    case = case | {"actions": actions | {"controls": releases | (actions.get("controls") or {})}}
    wrong = []
    for requirement, names in plan.causes.items():
        measured = [name for name in plan.meets.get(requirement, ()) if name not in plan.keeps]
        if _effects(plan, requirement, case_without(case, names)):
            continue
        lost, cause = (", ".join(f"`{name}`" for name in some) for some in (measured, names))
        why = f"{lost}: about {cause}, or an event of it" if lost else "nothing under `meets` can fail"
        wrong.append(
            f"/causes/{requirement}: a run without {cause} shows nothing ({why}); add to `meets` what another body "
            "does, name as the cause what acts on it, or leave the claim out"
        )
    return wrong


def _effects(plan: CasePlan, requirement: str, left: Data) -> list[str]:
    """Return the names of the effect's expectations that a case without its cause still has."""
    expected = (left.get("actions") or {}).get("expect") or {}
    # An expectation in `keeps` holds from the start, so it is not an effect.
    return [name for name in plan.meets.get(requirement, ()) if name in expected and name not in plan.keeps]


def compare_causes(
    plan: CasePlan,
    text: str,
    path: Path,
    simulate: Callable[[Any], tuple[str, Found]],
    run: Path | None = None,
) -> list[Fact]:
    """Run a case once without each cause that the plan names, and compare; equal causes share a run.

    Args:
        plan: The plan. By requirement, the most important first, `causes` lists bodies and controls, and `meets` the
            expectations of the effect.
        text: The case, in which all expectations hold.
        path: Path of the case file.
        simulate: Runs a loaded case; returns its final status and the results of its expectations, by name.
        run: Folder of the run of the case, which tells when its events happened.

    Returns:
        A fact for each effect; none if the plan names no cause.
    """
    facts, times, whole = [], _first_times(run) if run is not None else None, revising.data_of(text)
    controls = (whole.get("actions") or {}).get("controls") or {}
    held = {name: f"`{name}` (its joint held)" for name, row in controls.items() if _holding_mode(row)}
    runs: dict[frozenset[str], tuple[str, Found] | RunError] = {}
    for requirement, names in plan.causes.items():
        description, causes = f"without {', '.join(held.get(name, f'`{name}`') for name in names)}", frozenset(names)
        if causes not in runs and len(runs) >= MAX_CAUSES:
            facts.append(Fact(requirement, None, f"not run {description}: {MAX_CAUSES} causes are tested at most"))
            continue
        case = case_without(whole, causes, times)
        examined = examine(format_text(json.dumps(case, ensure_ascii=False)), path)
        effects = _effects(plan, requirement, case)
        if not effects:
            facts.append(Fact(requirement, None, f"{description} nothing that is measured of it is left"))
        elif examined.errors:
            facts.append(
                Fact(requirement, None, f"{description} the case cannot be run: {format_problem(examined.errors[0])}")
            )
        else:
            if causes not in runs:
                try:
                    runs[causes] = simulate(examined.loaded)
                except RunError as error:
                    runs[causes] = error
            if isinstance(made := runs[causes], RunError):
                facts.append(Fact(requirement, None, f"{description} the run failed: {made}"))
            else:
                facts += _compared(requirement, names, description, effects, *made)
    return facts


def _compared(
    requirement: str, causes: Sequence[str], description: str, effects: Sequence[str], state: str, found: Found
) -> Iterator[Fact]:
    """Yield a fact for each expectation of an effect, from the run without its causes."""
    for name in (one for written in effects for one in numbered_copies(written, found)):
        row = found.get(name, {})
        came = row.get("ok") if state == "finished" else None
        why = row.get("why") if came in CAUSE_VERDICTS else f"the run ended as: {state}"
        told = f"{description} `{name}` {CAUSE_VERDICTS.get(came, 'could not be told')} ({why})"
        ok = None if came is None else not came
        yield Fact(requirement, ok, told, without=tuple(causes) if state == "finished" else ())


def _first_times(run: Path) -> dict[str, float | None]:
    """Return the first time of each event of a run [s], by name; None for those that did not happen."""
    evidence = read_json(run / "evidence.json") or {}
    return {name: row["first"] for name, row in (evidence.get("events") or {}).items()}


def were_tried(facts: Iterable[Mapping[str, Any]], plan: CasePlan) -> bool:
    """Return whether the case was run without each cause that a plan names, so that these runs need only be judged.

    Args:
        facts: Facts of an attempt as data, see `facts_as_data`.
        plan: The plan.
    """
    finished = {frozenset(row.get("without", ())) for row in facts}
    return all(frozenset(names) in finished for names in plan.causes.values())


def untried_causes(plan: CasePlan, seconds: float) -> Fact:
    """Return the fact that is told of all causes if a further run, of `seconds`, would take too long."""
    note = f"the case was not run without its causes, since a run takes {seconds / 60:.0f} min: judge by the pictures"
    return Fact(next(iter(plan.causes)), None, note)


def causes_text(facts: Iterable[Fact]) -> str:
    """Return the section of the evidence text that states these facts."""
    rows = [f"- `{fact.requirement}`: {fact.told}" for fact in facts]
    return "\n".join([TITLE, "", *rows]) if rows else ""
