"""Live runs: simulations of versions of a watched case, each in its own folder."""

from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from text2sim import __version__
from text2sim.compiler.provenance import provenance
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.whole_files import write_atomically, write_json

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan
    from text2sim.spec_schema.loaded import LoadedCase

ENDED_WELL = ("finished", "diverged")
"""States that are reproducible for the same text."""


@dataclass(frozen=True)
class Version:
    """A saved text that can be simulated."""

    saved: float
    """Time of the save [s], by `monotonic`."""
    loaded: "LoadedCase"
    plan: "Plan"
    program: dict[str, bytes]
    """Files of the program by path."""

    @cached_property
    def judge_digest(self) -> str:
        """Digest of all that the evidence depends on, besides states."""
        case = self.loaded.case.model_dump_json(by_alias=True, exclude={"render": True})
        return sha256(case.encode()).hexdigest()


@dataclass
class LiveRun:
    """A simulation of a version."""

    number: int
    folder: Path
    version: Version
    """The simulated version; replaced by later versions with the same physics."""
    state: str = "building"
    """building, simulating, or the final state."""
    unwanted: bool = False
    """Whether it was cancelled for another text."""
    message: str = ""
    traceback: str = ""
    begun: float = field(default_factory=monotonic)
    seconds: dict[str, float] = field(default_factory=dict)
    """Durations of steps for the version [s]; those of `scene` and `all` are since the save."""

    @property
    def running(self) -> bool:
        """Whether the engine is working on it."""
        return self.state in ("building", "simulating")

    def adopt(self, version: Version) -> None:
        """Replace the version by a later one with the same physics."""
        self.version = version
        self.seconds = {}

    def blame(self) -> Problem | None:
        """Return why it ended early as a problem, if the line of the case to blame is known."""
        found = provenance(self.folder / "program", self.traceback)
        source = self.version.loaded.source
        if found is None or found[0] > len(source.lines):
            return None
        text = source.lines[found[0] - 1]
        column = len(text) - len(text.lstrip()) + 1
        return Problem("", f"engine: {self.message}", found[0], column, source.file, rule="engine")

    def write_inputs(self, version: Version) -> None:
        """Write the program and the case, each file atomically."""
        for name, content in version.program.items():
            path = self.folder / "program" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(path, content)
        write_atomically(self.folder / "case.yaml", version.loaded.source.text)

    def write_record(self) -> None:
        """Write a record that distinguishes the folder from a run folder of `text2sim run`."""
        record: dict[str, Any] = {
            "made_by": "text2sim watch",
            "note": "a preview; `text2sim run` makes runs",
            "text2sim": __version__,
            "case": self.version.loaded.case.name,
            "take": self.number,
            "state": self.state,
            "message": self.message,
            "sim_digest": self.version.plan.sim_digest,
            "seconds": {name: round(value, 3) for name, value in self.seconds.items()},
        }
        write_json(self.folder / "watch.json", record)
