"""Runs the program of a run folder and reports its result."""

import re
import sys
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

from text2sim.compiler.provenance import provenance
from text2sim.runtime import kernel_cache
from text2sim.runtime.child import ChildExit, Limits, run_child
from text2sim.runtime.outcome import Outcome, outcome_of, read_end, read_status
from text2sim.runtime.progress import CHILD_PHASES, Clock, ProgressTail, rough_duration
from text2sim.runtime.stop import Stop

FIRST_BUILD_NOTE = "compiling physics kernels: over a minute the first time on this machine"
NEW_KERNELS_NOTE = "still compiling physics kernels: every new combination of options does so once"
STOPPING_NOTE = "stopping, and keeping what was recorded; once more to kill it"
_NO_FILM = re.compile(r"^no film: (.*)$", re.MULTILINE)
BUILD_PATIENCE = 30.0
"""Wall time [s] of a build after which the user is told why."""
SPEED_SETTLES_AFTER = 40.0
"""Wall time [s] of simulating after which its speed is known."""
HOPELESS_FACTOR = 3.0
"""A simulation that would take this many times its limit is stopped; its speed does not vary that much."""


@dataclass(frozen=True)
class Finished:
    """Result of a program."""

    outcome: Outcome
    ended: ChildExit
    blame: tuple[int, str] | None
    """Line of the case and code of the program behind a failure, if they are known."""
    no_film: str
    """Why the program made no film, as it said itself."""


def run_program(
    folder: Path,
    *,
    flags: tuple[str, ...],
    limits: Limits,
    stop: Stop,
    clock: Clock,
    inherit: tuple[int, ...] = (),
) -> Finished:
    """Run `program/main.py` of a run folder, writing into that folder.

    Args:
        folder: The run folder.
        flags: `--film-only` or `--no-film`, or nothing.
        limits: What it may use.
        stop: Requests to stop.
        clock: Receives its phases.
        inherit: File descriptors that it keeps open.
    """
    folder = folder.resolve()
    program, log = folder / "program", folder / "log.txt"
    log_start = log.stat().st_size if log.is_file() else 0
    relay = ProgressRelay(folder / "progress.jsonl", clock, stop, limits)
    clock.enter("start")
    command = (sys.executable, "main.py", "--out", str(folder), *flags)
    with stop.gently():
        ended = run_child(
            command, folder=program, log=log, limits=limits, stop=stop, on_poll=relay.poll, inherit=inherit
        )
    text = read_end(log, log_start)
    status = read_status(folder / "status.json")
    outcome = outcome_of(ended, limits, status, text, _finite(status.get("time"), relay.simulated))
    if outcome.state == "timeout" and relay.hopeless_because:
        outcome = replace(outcome, message=relay.hopeless_because)
    failed = ended.code != 0 and ended.cause == "ended"
    no_film = _NO_FILM.search(text)
    return Finished(outcome, ended, provenance(program, text) if failed else None, no_film[1] if no_film else "")


class ProgressRelay:
    """Passes on the progress that a program reports, and explains a long silence."""

    def __init__(self, path: Path, clock: Clock, stop: Stop, limits: Limits) -> None:
        self._tail = ProgressTail(path)
        self._clock, self._stop = clock, stop
        self._longest = min(HOPELESS_FACTOR * limits.timeout, limits.patience)
        self._limit = min(limits.timeout, limits.patience)
        self._first_progress: tuple[float, float] | None = None
        self._stopping = False
        self._phase = "start"
        self._build_since: float | None = None
        self.simulated = 0.0
        """Simulated time reached [s]."""
        self.hopeless_because = ""
        """Why it cannot end in time; empty as long as it may."""

    def poll(self) -> bool:
        """Pass on news; return whether the program cannot end in time."""
        for record in self._tail.read():
            self._handle(record)
        if self._stop.count and not self._stopping:
            self._stopping = True
            self._clock.tell(self.simulated, note=STOPPING_NOTE)
        if self._build_since is not None and self._clock.wall - self._build_since > BUILD_PATIENCE:
            self._build_since = None
            if kernel_cache.is_warm():
                self._clock.tell(0.0, note=NEW_KERNELS_NOTE)
        return bool(self.hopeless_because)

    def _handle(self, record: dict[str, Any]) -> None:
        phase = record.get("phase", self._phase)
        if phase in CHILD_PHASES and phase != self._phase:
            self._phase = phase
            building = phase == "build"
            self._build_since = self._clock.wall if building else None
            self._clock.enter(phase, FIRST_BUILD_NOTE if building and not kernel_cache.is_warm() else "")
        if self._phase in ("simulate", "film"):
            time = _finite(record.get("t"), 0.0)
            duration = _finite(record.get("duration"), 0.0)
            if self._phase == "simulate":
                self.simulated = time
                self._judge_speed(time, duration)
            self._clock.tell(time, duration=duration)

    def _judge_speed(self, time: float, duration: float) -> None:
        """Judge, after a while, whether the simulation can end in time, without its first step, which loads kernels."""
        now = self._clock.wall
        if time > 0.0 and self._first_progress is None:
            self._first_progress = now, time
        if (
            self._first_progress is None
            or time <= self._first_progress[1]
            or now - self._first_progress[0] < SPEED_SETTLES_AFTER
        ):
            return
        begun, since = self._first_progress
        pace = (now - begun) / (time - since)
        expected_wall_time = now + (duration - time) * pace
        if expected_wall_time > self._longest:
            so_far = f"{time / duration:.1%} of it took {now:.0f} s, {pace:.3g} s per simulated second"
            fitting = max(0.0, time + (self._limit - now) / pace)
            self.hopeless_because = (
                f"{so_far}: all would take {rough_duration(expected_wall_time)}, and the limit is {self._limit:.0f} s, "
                f"in which {fitting:.2g} s can be simulated"
            )


def _finite(value: object, otherwise: float) -> float:
    return float(value) if isinstance(value, int | float) and isfinite(value) else otherwise
