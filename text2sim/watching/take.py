"""A take: one simulation of one version of the case, in a folder of its own."""

import json
import os
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from text2sim import __version__
from text2sim.harness.record import write_atomically

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan
    from text2sim.spec_schema.load import LoadedCase

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

    @property
    def judge_digest(self) -> str:
        """Digest of all that the evidence depends on, besides states."""
        case = self.loaded.case.model_dump_json(by_alias=True, exclude={"render": True})
        return sha256(case.encode()).hexdigest()

    @property
    def ahead(self) -> float:
        """How far [s] cameras look ahead."""
        return max((camera.get("smooth", 0.0) / 2 for camera in self.plan.render["cameras"]), default=0.0)

    @property
    def colors(self) -> dict[str, list[float]]:
        """Colours by copy, where the case gives them: a change of them alone is no reason to simulate again."""
        groups = (*self.plan.statics, *self.plan.bodies)
        return {e.name: list(e.surface.rgba) for g in groups for e in g.entities if e.surface is not None}


@dataclass
class Take:
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
    """What took how long [s]."""

    @property
    def running(self) -> bool:
        """Whether the engine is at it."""
        return self.state in ("building", "simulating")

    def write_inputs(self, version: Version) -> None:
        """Write the program and the case, each file in one motion."""
        for name, content in version.program.items():
            path = self.folder / "program" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            part = path.with_name(path.name + ".part")
            part.write_bytes(content)
            os.replace(part, path)
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
