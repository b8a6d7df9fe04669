"""Rescue of simulations that ran to their end, although the process that watched them was killed."""

from pathlib import Path

from text2sim.recording.inventory import RECORDED, list_files
from text2sim.recording.record import COMPLETE, RunRecord
from text2sim.recording.states import RunStates
from text2sim.runtime.outcome import printable, read_status
from text2sim.spec_schema.errors import RunError


def rescue(folder: Path, key: dict[str, str]) -> None:
    """Record that a run is complete if its program said so and nothing of the recording is missing.

    Args:
        folder: The run folder, which nobody else writes to.
        key: What the recorded states should depend on, as in `RunRecord`.
    """
    record, status = RunRecord.read(folder), read_status(folder / "status.json")
    if record is None or record.state != "running" or record.key != key or status.get("state") not in COMPLETE:
        return
    try:
        states = RunStates.load(folder)
        if not states.frames or states.lacks(status["state"]):
            return
        record.state, record.time = status["state"], states.end
    except RunError:
        return
    if record.state == "diverged":
        record.message = " ".join(printable(str(status.get("message") or "")).split())
    record.recorded = list_files(folder, RECORDED)
    record.notes.append("text2sim was killed after the simulation was complete")
    record.write(folder)
