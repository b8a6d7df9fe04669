"""Simulations that came to their end, although the process that watched them did not."""

from pathlib import Path

from text2sim.recording.inventory import RECORDED, list_files
from text2sim.recording.record import COMPLETE, RunRecord
from text2sim.recording.states import RunStates
from text2sim.runtime.outcome import clean, read_status
from text2sim.spec_schema.errors import RunError


def rescue(folder: Path, key: dict[str, str]) -> None:
    """Write down that a run is complete, if its program said so and all that it recorded is there.

    Args:
        folder: The run folder, which nobody else writes to.
        key: What the run should be a run of, as in `RunRecord`.
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
        record.message = " ".join(clean(str(status.get("message") or "")).split())
    record.recorded = list_files(folder, RECORDED)
    record.notes.append("its text2sim was killed after the simulation had come to its end")
    record.write(folder)
