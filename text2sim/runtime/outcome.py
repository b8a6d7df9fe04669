"""Ends of programs, in plain words."""

import json
import re
import signal
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.runtime.child import ChildExit, Limits
from text2sim.spec_schema.plain import plain

EXIT_DIVERGED = 3
EXIT_INTERRUPTED = 130
GIGA = 1e9

_ANSI = re.compile(r"\x1b\[[0-9;?]*[ -/]*[@-~]")
_SIGNALS = {
    "SIGSEGV": "the engine crashed (SIGSEGV: it accessed memory that is not its own); "
    "most often the simulation had diverged, so look for a time step that is too long or bodies that overlap",
    "SIGABRT": "the engine gave up (SIGABRT: one of its own checks failed)",
    "SIGBUS": "the engine crashed (SIGBUS: memory or a file that it used went away; is a disk full?)",
    "SIGFPE": "the engine crashed (SIGFPE: a forbidden calculation, such as a whole number divided by zero)",
    "SIGILL": "the engine crashed (SIGILL: this processor lacks an instruction that a library was built for)",
}


@dataclass(frozen=True)
class Outcome:
    """Result of a simulation."""

    state: str
    """One of `record.STATES`."""
    time: float
    """Simulated time reached [s]."""
    message: str
    """Why it ended early; empty if it did not."""
    film_message: str = ""
    """Why the program ended early while it made the film, after the simulation was complete."""


def outcome_of(ended: ChildExit, limits: Limits, status: dict[str, Any], log: str, time: float) -> Outcome:
    """Return the result of a simulation.

    Args:
        ended: How the program ended.
        limits: What it was allowed.
        status: Its `status.json`; empty if it wrote none.
        log: What it printed.
        time: Simulated time [s] of its last sign of life.
    """
    reported = " ".join(printable(str(status.get("message") or "")).split())
    state, message = _state(ended, limits, reported, log)
    simulated = status.get("state")
    if simulated in ("finished", "diverged"):
        # The simulation is over and saved: only the film can have failed after that.
        diverged = simulated == "diverged"
        return Outcome(simulated, time, reported if diverged else "", "" if state == simulated else message)
    if state == "finished":
        return Outcome("failed", time, "the program ended without a status")
    return Outcome(state, time, message)


def _state(ended: ChildExit, limits: Limits, reported: str, log: str) -> tuple[str, str]:
    if ended.cause == "memory":
        used, limit = ended.peak_memory / GIGA, ended.memory_limit / GIGA
        return "out_of_memory", f"it used {used:.2g} GB of memory, more than its {limit:.2g} GB"
    if ended.cause == "timeout":
        return "timeout", f"it took longer than {limits.timeout:g} s"
    if ended.cause == "stopped" or ended.code == EXIT_INTERRUPTED:
        return "interrupted", "stopped on request"
    if ended.code == 0:
        return "finished", ""
    number = -ended.code if ended.code < 0 else ended.code - 128 if ended.code > 128 else 0
    if number:
        return _signalled(number, ended)
    if ended.code == EXIT_DIVERGED:
        return "diverged", reported or "the simulation diverged"
    if "MemoryError" in (error := last_error(log)):
        return "out_of_memory", "no memory was left"
    return "failed", reported or error or f"the program ended with exit code {ended.code} and said nothing"


def _signalled(number: int, ended: ChildExit) -> tuple[str, str]:
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = f"signal {number}"
    if name == "SIGKILL":
        if ended.peak_memory > ended.memory_limit / 2:
            return "out_of_memory", "the system killed it (SIGKILL), most likely because memory ran out"
        return (
            "crashed",
            f"someone killed it (SIGKILL): it used no more than {ended.peak_memory / GIGA:.2g} GB of memory",
        )
    if name in ("SIGINT", "SIGTERM"):
        return "interrupted", f"someone stopped it ({name})"
    return "crashed", _SIGNALS.get(name, f"it was killed ({name})")


def last_error(log: str) -> str:
    """Return the message of the last traceback of a log, as `ValueError: …`; empty if there is none."""
    log = printable(log)
    begin = log.rfind("Traceback (most recent call last):")
    if begin < 0:
        return ""
    rows = log[begin:].splitlines()[1:]
    for index, row in enumerate(rows):
        if row and not row[0].isspace():
            # An engine's message may have several lines; the first ones say what is wrong.
            return " ".join(" ".join(rows[index : index + 6]).split())[:600]
    return ""


def printable(text: str) -> str:
    """Return text without colours and other control characters, which could rewrite a terminal."""
    return plain(_ANSI.sub("", text).replace("\r", " "))


def read_status(path: Path) -> dict[str, Any]:
    """Return the status that a program wrote; empty if there is none."""
    try:
        status = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return status if isinstance(status, dict) else {}


def read_end(path: Path, begin: int = 0, limit: int = 200_000) -> str:
    """Return the end of a log, from byte `begin` on at the earliest.

    Args:
        path: The log.
        begin: First byte that may be read.
        limit: Most bytes that are read.
    """
    try:
        with path.open("rb") as stream:
            size = stream.seek(0, 2)
            stream.seek(max(begin, size - limit))
            return stream.read(limit).decode("utf-8", "replace")
    except OSError:
        return ""
