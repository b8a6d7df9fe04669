"""`run.json`: what was run, where, and how it ended."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, TypeAdapter

from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.whole_files import write_atomically

FILE = "run.json"

STATES = ("running", "finished", "diverged", "interrupted", "timeout", "out_of_memory", "crashed", "failed")
"""`crashed`: ended by a signal; `failed`: the engine or the program stopped with a message."""

COMPLETE = ("finished", "diverged")
"""States that the same case would reach again, so that another simulation gains nothing."""


@dataclass
class RunRecord:
    """The contents of `run.json`, the only file of a run folder that depends on clocks and machines."""

    __pydantic_config__ = ConfigDict(allow_inf_nan=False)

    case: str
    """Name of the case."""
    state: str
    """One of `STATES`."""
    key: dict[str, str]
    """What the recorded states depend on: digests of the case and of our templates, engine, device."""
    text2sim: str = ""
    """Version of text2sim."""
    case_digest: str = ""
    """SHA-256 of `case.yaml` as written."""
    render_digest: str = ""
    """Digest of the film in the folder; empty if there is none."""
    judge_digest: str = ""
    """Digest behind the evidence in the folder: of expectations, and of the code that judged them."""
    variants: list[str] = field(default_factory=list)
    """Variants that were laid over the case, in their order; a point of a sweep as `SWEEP.POINT`."""
    sets: list[str] = field(default_factory=list)
    """Single values that were set, as `PATH=VALUE`."""
    seed: int = 0
    """Seed of the engine."""
    versions: dict[str, Any] = field(default_factory=dict)
    """Versions of Python and the libraries."""
    message: str = ""
    """Why it ended early."""
    where: dict[str, Any] | None = None
    """The line of the case to blame, if known."""
    time: float = 0.0
    """Simulated time reached [s]."""
    duration: float = 0.0
    """Simulated time wanted [s]."""
    started: str = ""
    """When the run started, in UTC."""
    wall: float = 0.0
    """How long the program ran [s]."""
    timings: dict[str, float] = field(default_factory=dict)
    """Wall time of each phase [s]."""
    exit_code: int | None = None
    """Exit code of the program; a negative one is a signal."""
    peak_memory: int = 0
    """Largest resident memory of the program [bytes]."""
    lint: list[dict[str, Any]] = field(default_factory=list)
    """What the lint found: `rule`, `path`, `message`, and the author's `reason` where it is waived."""
    notes: list[str] = field(default_factory=list)
    """Derived settings with their reasons, and other remarks."""
    recorded: dict[str, str] = field(default_factory=dict)
    """Files that the simulation wrote, as in `inventory`; empty if it did not run to its end."""
    judged: dict[str, str] = field(default_factory=dict)
    """Files that were made from these."""

    def write(self, folder: Path) -> None:
        """Write it, so that a reader finds the old or the new record and never half of one."""
        write_atomically(folder / FILE, json.dumps(asdict(self), indent=1, allow_nan=False) + "\n")

    @classmethod
    def read(cls, folder: Path) -> "RunRecord | None":
        """Return the record of a folder; None if there is none that can be trusted."""
        try:
            record = _RECORD.validate_python(json.loads((folder / FILE).read_text("utf-8")))  # it may be anybody's
        except (OSError, ValueError, RecursionError):
            return None
        return record if record.state in STATES else None

    @classmethod
    def read_whole(cls, folder: Path) -> "RunRecord | None":
        """Return the record of a folder; None if there is none.

        Raises:
            RunError: if there is one that cannot be trusted, so that nothing vouches for the other files.
        """
        record = cls.read(folder)
        if record is None and (folder / FILE).exists():
            raise RunError(f"{folder}: {FILE} is damaged; run the case again")
        return record


_RECORD = TypeAdapter(RunRecord)
