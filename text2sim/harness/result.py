"""Result of a run."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from text2sim.harness.folder import Work
from text2sim.recording.run_files import read_evidence
from text2sim.spec_schema.errors import Problem


@dataclass(frozen=True)
class RunResult:
    """What `run_case` did, and the outcome."""

    case: str
    """Name of the case."""
    folder: Path
    """The run folder."""
    work: Work
    """How much had to be done."""
    state: str
    """One of `record.STATES`."""
    time: float
    """Simulated time reached [s]."""
    message: str
    """Why the simulation ended early; empty if it did not."""
    problem: Problem | None
    """The same as a problem at the line of the case to blame, if that is known."""
    evidence: dict[str, Any] | None
    """As in `evidence.json`; None if nothing was recorded."""
    film: Path | None
    film_message: str
    """Why there is no film although one was wanted."""
    report: Path | None
    stopped: bool
    """Whether someone asked to stop."""
    damage: str = ""
    """What was missing or damaged in the existing run folder, and what was done about it."""
    warnings: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    timings: dict[str, float] = field(default_factory=dict)
    """Wall time of each phase [s] of this call."""
    wall: float = 0.0
    """Wall time [s] of this call."""

    @property
    def expectations(self) -> dict[str, dict[str, Any]]:
        """By name, as in `evidence.json`: `ok`, `wanted`, `why`, `value`, `unit`."""
        return (self.evidence or {}).get("expect", {})

    @property
    def suspicions(self) -> list[str]:
        """What looks wrong in the recording, whatever the expectations say: a sentence each."""
        return (self.evidence or {}).get("suspicions", [])

    @property
    def passed(self) -> bool:
        """Whether the simulation ran to its end and met all expectations."""
        return self.state == "finished" and (self.evidence or {}).get("verdict") == "passed"

    @classmethod
    def from_dict(cls, data: dict[str, Any], folder: Path) -> "RunResult":
        """Return the result that `as_dict` gave in another process, for the run that is now in `folder`.

        In addition, `stopped` in `data` says whether someone asked to stop.
        """
        own: dict[str, Any] = {
            name: data[name] for name in ("case", "state", "time", "message", "film_message", "stopped", "damage")
        }
        own |= {name: folder / Path(data[name]).name if data[name] else None for name in ("film", "report")}
        return cls(
            **own,
            folder=folder,
            work=Work(data["work"]),
            problem=Problem(**data["problem"]) if data["problem"] else None,
            evidence=evidence | {"expect": data["expect"]} if (evidence := read_evidence(folder)) else None,
            warnings=[Problem(**problem) for problem in data["warnings"]],
            notes=data["notes"],
            timings=data["timings"],
            wall=data["wall"],
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain data, for machines."""
        return {
            "case": self.case,
            "folder": str(self.folder),
            "work": self.work.value,
            "state": self.state,
            "time": self.time,
            "passed": self.passed,
            "message": self.message,
            "problem": self.problem.as_dict() if self.problem else None,
            "expect": self.expectations,
            "suspicions": self.suspicions,
            "film": str(self.film) if self.film else None,
            "film_message": self.film_message,
            "report": str(self.report) if self.report else None,
            "log": str(self.folder / "log.txt"),
            "damage": self.damage,
            "warnings": [p.as_dict() for p in self.warnings],
            "notes": self.notes,
            "timings": {name: round(t, 3) for name, t in self.timings.items()},
            "wall": round(self.wall, 3),
        }
