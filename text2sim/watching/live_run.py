"""A take: one simulation of one version of the case, in a folder of its own."""

import json
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from text2sim import __version__
from text2sim.compiler.provenance import provenance
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.whole_files import write_atomically

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan
    from text2sim.spec_schema.loaded import LoadedCase

ENDED_WELL = ("finished", "diverged")
"""States that the same text would reach again."""


@dataclass(frozen=True)
class Version:
    """A saved text that can be simulated."""

    saved: float
    """When the save was noticed [s], by `monotonic`."""
    loaded: "LoadedCase"
    plan: "Plan"
    program: dict[str, bytes]
    """Its files by path."""

    @cached_property
    def judge_digest(self) -> str:
        """Digest of all that the evidence depends on, besides states."""
        case = self.loaded.case.model_dump_json(by_alias=True, exclude={"render": True})
        return sha256(case.encode()).hexdigest()


@dataclass
class LiveRun:
    """One simulation."""

    number: int
    folder: Path
    version: Version
    """What is simulated; a later version with the same physics takes its place."""
    state: str = "building"
    """building, simulating, or how it ended."""
    unwanted: bool = False
    """Whether it was ended for another text."""
    message: str = ""
    traceback: str = ""
    begun: float = field(default_factory=monotonic)
    seconds: dict[str, float] = field(default_factory=dict)
    """What was done for the version, and how long that took [s]; of the scene, and of all, since the save."""

    @property
    def running(self) -> bool:
        """Whether the engine is at it."""
        return self.state in ("building", "simulating")

    def adopt(self, version: Version) -> None:
        """Stand for a later version, whose physics are the same."""
        self.version = version
        self.seconds = {}

    def blame(self) -> Problem | None:
        """Return why it ended early, at the line of the case where that is known."""
        found = provenance(self.folder / "program", self.traceback)
        source = self.version.loaded.source
        if found is None or found[0] > len(source.lines):
            return None
        text = source.lines[found[0] - 1]
        column = len(text) - len(text.lstrip()) + 1
        return Problem("", f"engine: {self.message}", found[0], column, source.file, rule="engine")

    def write_inputs(self, version: Version) -> None:
        """Write the program and the case, each file in one motion."""
        for name, content in version.program.items():
            path = self.folder / "program" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(path, content)
        write_atomically(self.folder / "case.yaml", version.loaded.source.text)

    def write_record(self) -> None:
        """Say what lies here: no run that could be taken for one of `text2sim run`."""
        record: dict[str, Any] = {
            "made_by": "text2sim watch",
            "note": "a preview; `text2sim run` makes the run that others can rely on",
            "text2sim": __version__,
            "case": self.version.loaded.case.name,
            "take": self.number,
            "state": self.state,
            "message": self.message,
            "sim_digest": self.version.plan.sim_digest,
            "seconds": {name: round(value, 3) for name, value in self.seconds.items()},
        }
        write_json(self.folder / "watch.json", record)


def write_json(path: Path, value: Any) -> None:
    """Write a value as JSON, in one motion."""
    write_atomically(path, json.dumps(value, indent=1, allow_nan=False) + "\n")
