"""Trials: runs of a case with other values of its parameters, before the Planner decides what to do next."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple

from text2sim.agents import revising
from text2sim.agents.assembly import examine, format_problem
from text2sim.recording.run_files import read_json
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.whole_files import write_json

MAX_TRIALS = 6
"""Largest number of trials at a time."""
MAX_TRIAL_ROUNDS = 2
"""Largest number of times that the Planner may have trials run before it decides: the second narrows the first."""
TRIALS_SHARE = 0.3
"""Largest share of the time left that all trials of a round may take."""
Settings = Mapping[str, Any]
"""Values of parameters, by name."""
MAX_TRACKS = 2
"""Largest number of bodies whose tracks are listed for each trial."""


class Outcome(NamedTuple):
    """Outcome of a trial."""

    state: str
    """Final state of the run."""
    evidence: Mapping[str, Any] | None = None
    tracks: Sequence[str] = ()
    """Positions and velocities of bodies."""


def affordable(wall: float, minutes: float | None) -> int:
    """Return how many trials fit the time left.

    Args:
        wall: Wall time of one run [s]; 0 if none was timed.
        minutes: Minutes left; None without a limit.
    """
    if not wall:
        return 0
    return MAX_TRIALS if minutes is None else min(MAX_TRIALS, int(TRIALS_SHARE * 60 * minutes / wall))


def settings_faults(text: str, trials: Sequence[Settings], path: Path) -> list[str]:
    """Describe what makes a trial impossible: unknown parameters, and values that leave the case wrong.

    Args:
        text: Text of the case.
        trials: Parameters of each trial.
        path: Path of the case file.
    """
    wrong, known = [], revising.mapping(revising.data_of(text), "params")
    for number, settings in enumerate(trials):
        where = f"/trials/{number}"
        wrong += [f"{where}/{name}: there is no such parameter" for name in settings if name not in known]
        if not settings:
            wrong.append(f"{where}: give the parameters that differ")
    if wrong:
        return wrong
    for number, settings in enumerate(trials):
        if errors := examine(revising.with_params(text, settings), path).errors:
            wrong.append(f"/trials/{number}: {format_problem(errors[0])}")
    return wrong


def trials_text(
    text: str,
    trials: Sequence[Settings],
    path: Path,
    store: Path,
    seconds: float,
    simulate: Callable[[LoadedCase, float], Outcome],
) -> str:
    """Run a case with each setting of parameters, and describe the outcomes, one line for each.

    Args:
        text: Text of the case.
        trials: Parameters of each trial.
        path: Path of the case file.
        store: File of outcomes by digest of the case, so that a resumed loop does not simulate them again.
        seconds: Wall time that all of them may take [s].
        simulate: Runs a loaded case, within a wall time [s].
    """
    stored = read_json(store)
    outcomes: dict[str, str] = stored if isinstance(stored, dict) else {}
    rows, begin = [], monotonic()
    for settings in trials:
        varied = revising.with_params(text, settings)
        key = hashlib.sha256(varied.encode()).hexdigest()
        if key not in outcomes:
            left = seconds - (monotonic() - begin)
            outcomes[key] = _outcome(varied, path, left, simulate) if left > 0 else "not run: no time was left"
            write_json(store, outcomes)
        values = ", ".join(f"{name}: {value}" for name, value in settings.items())
        rows.append(f"- {{{values}}}: {outcomes[key]}")
    return "\n".join(rows)


def _outcome(text: str, path: Path, seconds: float, simulate: Callable[[LoadedCase, float], Outcome]) -> str:
    loaded = load_text(text, path)  # `settings_faults` has examined it
    try:
        state, evidence, tracks = simulate(loaded, seconds)
    except RunError as error:
        return f"failed: {error}"
    if evidence is None:
        return state
    missed = [f"MISSED `{name}` ({row.get('why')})" for name, row in evidence["expect"].items() if not row.get("ok")]
    rows = [state, *(missed or ["all expectations true"])]
    expected = {expect.measure for expect in loaded.case.actions.expect.values()}
    for name, row in evidence["measures"].items():
        if name in expected and row.get("problem") is None and row.get("last") is not None:
            rows.append(f"`{name}` {row['min']:.3g} to {row['max']:.3g}, at the end {row['last']:.3g} {row['unit']}")
    rows += [
        f"`{name}` at {row['first']:.3g} s" for name, row in evidence["events"].items() if row.get("first") is not None
    ]
    return "; ".join([*rows, *evidence["suspicions"][:2], *tracks])
