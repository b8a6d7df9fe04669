"""From a case to a run folder with evidence, doing only what is not yet done."""

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim import __version__
from text2sim.harness.child import Limits
from text2sim.harness.folder import Wanted, Work, install_program, install_run, remaining_work, staging
from text2sim.harness.lock import RunLock
from text2sim.harness.outcome import EXIT_INTERRUPTED
from text2sim.harness.program import Finished, run_program
from text2sim.harness.progress import Clock, OnProgress, ignore
from text2sim.harness.record import COMPLETE, RunRecord, write_atomically
from text2sim.harness.stop import Stop
from text2sim.spec_schema.errors import MachineError, Problem

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan
    from text2sim.spec_schema.load import LoadedCase

Compile = Callable[["LoadedCase", Path], "Plan"]
"""Writes the program of a case into a folder and returns its plan."""


@dataclass(frozen=True)
class RunResult:
    """What `run_case` did and what came of it."""

    case: str
    """Name of the case."""
    folder: Path
    """The run folder."""
    work: Work
    """How much had to be done."""
    state: str
    """One of `record.STATES`."""
    message: str
    """Why the simulation ended early; empty if it did not."""
    problem: Problem | None
    """The same, at the line of the case to blame, if that is known."""
    evidence: dict[str, Any] | None
    """As in `evidence.json`; None if nothing was recorded."""
    film: Path | None
    film_message: str
    """Why there is no film although there should be one."""
    report: Path | None
    stopped: bool
    """Whether someone asked to stop."""
    warnings: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    timings: dict[str, float] = field(default_factory=dict)
    """Wall time of each phase [s] of this call."""
    wall: float = 0.0
    """Wall time [s] of this call."""

    @property
    def expectations(self) -> dict[str, dict[str, Any]]:
        """The expectations of the case by name, each with `passed`."""
        return (self.evidence or {}).get("expect", {})

    @property
    def passed(self) -> bool:
        """Whether the simulation came to its end and everything expected came true."""
        return self.state == "finished" and all(row.get("passed") for row in self.expectations.values())

    def as_dict(self) -> dict[str, Any]:
        """The result as plain data, for machines."""
        return {
            "case": self.case,
            "folder": str(self.folder),
            "work": self.work.value,
            "state": self.state,
            "passed": self.passed,
            "message": self.message,
            "problem": self.problem.as_dict() if self.problem else None,
            "expect": self.expectations,
            "film": str(self.film) if self.film else None,
            "film_message": self.film_message,
            "report": str(self.report) if self.report else None,
            "log": str(self.folder / "log.txt"),
            "warnings": [p.as_dict() for p in self.warnings],
            "notes": self.notes,
            "timings": {name: round(t, 3) for name, t in self.timings.items()},
            "wall": round(self.wall, 3),
        }


def run_case(
    loaded: "LoadedCase",
    *,
    runs: Path,
    on_progress: OnProgress = ignore,
    timeout: float = 3600.0,
    memory_gb: float | None = None,
    film: bool = True,
    force: bool = False,
    stop: Stop | None = None,
    compile_to: Compile | None = None,
) -> RunResult:
    """Bring the run folder of a case up to date: simulate, film, judge and report what is not yet.

    Args:
        loaded: The case.
        runs: The folder of run folders.
        on_progress: Told how far it has come.
        timeout: Wall time [s] that the program may take.
        memory_gb: Memory [GB] that it may use; 85 % of the machine's if left out.
        film: Whether a film is wanted.
        force: Simulate again even if nothing changed.
        stop: Requests to stop; Ctrl-C and SIGTERM if left out.
        compile_to: The compiler.

    Raises:
        SpecError: if the case cannot be compiled.
        MachineError: if this machine cannot run it.
        RunError: if its run folder is in use, or in the way.
    """
    if stop is None:
        with Stop() as stop:
            return run_case(
                loaded, runs=runs, on_progress=on_progress, timeout=timeout, memory_gb=memory_gb, film=film,
                force=force, stop=stop, compile_to=compile_to,
            )  # fmt: skip
    if compile_to is None:
        from text2sim.compiler.build import compile_case

        compile_to = compile_case
    limits = Limits(timeout=timeout, memory=None if memory_gb is None else int(memory_gb * 1e9))
    clock = Clock(on_progress, loaded.case.scene.duration)
    genesis = _genesis_version()
    clock.enter("compile")
    with staging(runs) as stage:
        (stage / "run").mkdir()
        plan = compile_to(loaded, stage / "run" / "program")
        name = f"{loaded.case.name}-{plan.sim_digest[:10]}"
        with RunLock(runs, name) as lock:
            return _Run(loaded, plan, runs / name, genesis, clock, stop).bring_up_to_date(
                stage / "run", film=film, force=force, limits=limits, lock=lock
            )


class _Run:
    """One call of `run_case`, from the compiled program on."""

    def __init__(
        self, loaded: "LoadedCase", plan: "Plan", folder: Path, genesis: str, clock: Clock, stop: Stop
    ) -> None:
        from text2sim.harness.machine import device_kind, versions

        self.loaded, self.plan, self.folder, self.clock, self.stop = loaded, plan, folder, clock, stop
        case_text = loaded.source.text
        self.judge_digest = _judge_digest(loaded)
        self.fresh = RunRecord(
            case=loaded.case.name,
            state="running",
            key={"sim_digest": plan.sim_digest, "genesis": genesis, "device": device_kind()},
            text2sim=__version__,
            case_digest=sha256(case_text.encode()).hexdigest(),
            seed=plan.seed,
            versions=versions(),
            duration=loaded.case.scene.duration,
            notes=list(plan.notes),
        )
        self.film_message = ""
        self.problem: Problem | None = None
        self.evidence: dict[str, Any] | None = None

    def bring_up_to_date(self, staged: Path, *, film: bool, force: bool, limits: Limits, lock: RunLock) -> RunResult:
        """Do what is not yet done, with the program that lies in `staged`."""
        wanted = Wanted(self.fresh.key, self.plan.render_digest, self.judge_digest, film)
        work = Work.SIMULATE if force else remaining_work(self.folder, wanted)
        if work is Work.SIMULATE:
            self._write_inputs(staged)
            self.fresh.started = datetime.now(UTC).isoformat(timespec="seconds")
            self.fresh.write(staged)
            install_run(staged, self.folder)
            record = self.fresh
            self._simulate(record, limits, lock, film=film)
        else:
            record = RunRecord.read(self.folder) or self.fresh
            self._refresh(record, staged)
            if work is Work.FILM:
                self._film(record, limits, lock)
        if work is Work.NOTHING:
            self.evidence = json.loads((self.folder / "evidence.json").read_text("utf-8"))
        else:
            self._judge(record)
        return self._result(record, work)

    def _write_inputs(self, folder: Path) -> None:
        (folder / "case.yaml").write_bytes(self.loaded.source.text.encode())
        resolved = self.loaded.case.model_dump(mode="json", by_alias=True)
        write_atomically(folder / "resolved.json", json.dumps(resolved, indent=1) + "\n")

    def _refresh(self, record: RunRecord, staged: Path) -> None:
        """Bring what does not touch the recorded states to the case as it is now."""
        if record.case_digest == self.fresh.case_digest and record.text2sim == __version__:
            return
        install_program(staged / "program", self.folder / "program")
        self._write_inputs(self.folder)
        record.case_digest, record.text2sim = self.fresh.case_digest, __version__
        record.notes = self.fresh.notes
        record.write(self.folder)

    # --- steps ------------------------------------------------------------------------------------------------

    def _simulate(self, record: RunRecord, limits: Limits, lock: RunLock, *, film: bool) -> None:
        flags = () if film else ("--no-film",)
        done = run_program(
            self.folder, flags=flags, limits=limits, stop=self.stop, clock=self.clock, inherit=(lock.fileno,)
        )
        outcome = done.outcome
        record.state, record.time, record.message = outcome.state, outcome.time, outcome.message
        record.exit_code, record.wall = done.ended.code, round(done.ended.wall, 3)
        record.peak_memory = done.ended.peak_memory
        if film:
            self._keep_film(record, done)
        if record.state not in COMPLETE or record.state == "diverged":
            self._blame(record, done)
        if done.ended.log_left_out:
            record.notes.append(f"log.txt lacks {done.ended.log_left_out} bytes from its middle")
        record.write(self.folder)

    def _film(self, record: RunRecord, limits: Limits, lock: RunLock) -> None:
        record.render_digest = ""
        record.write(self.folder)
        done = run_program(
            self.folder, flags=("--film-only",), limits=limits, stop=self.stop, clock=self.clock, inherit=(lock.fileno,)
        )
        self._keep_film(record, done)
        record.write(self.folder)

    def _keep_film(self, record: RunRecord, done: Finished) -> None:
        made = (self.folder / "video.mp4").is_file() and not done.outcome.film_message
        if made and done.outcome.state in COMPLETE:
            record.render_digest = self.plan.render_digest
        elif done.outcome.state in COMPLETE:
            self.film_message = done.outcome.film_message or "the program made none"

    def _blame(self, record: RunRecord, done: Finished) -> None:
        line, code = done.blame or (1, "")
        record.where = {"line": line, "code": code} if done.blame else None
        if done.blame:
            message = f"engine: {record.message}"
            self.problem = Problem("", message, line, 1, str(self.loaded.path), rule="engine")

    def _judge(self, record: RunRecord) -> None:
        if not any((self.folder / "states").glob("chunk_*.npz")):
            return  # it ended before there was anything to judge
        from text2sim.harness.evidence import judge
        from text2sim.harness.report import write_report

        record.judge_digest = ""
        record.write(self.folder)
        self.clock.enter("judge")
        self.evidence = judge(self.folder, self.loaded.case)
        self.clock.enter("report")
        write_report(self.folder, self.loaded.case)
        record.judge_digest = self.judge_digest

    def _result(self, record: RunRecord, work: Work) -> RunResult:
        timings = self.clock.finish()
        if work is not Work.NOTHING:
            record.timings |= {name: round(t, 3) for name, t in timings.items()}
            record.write(self.folder)
        video, report = self.folder / "video.mp4", self.folder / "report.html"
        current = record.render_digest == self.plan.render_digest and video.is_file()
        return RunResult(
            case=record.case,
            folder=self.folder,
            work=work,
            state=record.state,
            message=record.message,
            problem=self.problem,
            evidence=self.evidence,
            film=video if current else None,
            film_message=self.film_message,
            report=report if report.is_file() else None,
            stopped=self.stop.count > 0 or record.exit_code == EXIT_INTERRUPTED,
            warnings=list(self.plan.warnings),
            notes=list(record.notes),
            timings=timings,
            wall=self.clock.wall,
        )


def _genesis_version() -> str:
    try:
        return version("genesis-world")
    except PackageNotFoundError:
        raise MachineError("Genesis is not installed here; `text2sim doctor` says what is missing") from None


def _judge_digest(loaded: "LoadedCase") -> str:
    """Digest of all that evidence depends on besides the recorded states, and of the code that makes it."""
    digest = sha256(loaded.case.model_dump_json(by_alias=True, exclude={"render": True}).encode())
    folder = Path(__file__).parent
    for path in sorted(folder.rglob("*.py")):
        digest.update(os.fspath(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


__all__ = ["Compile", "RunResult", "run_case"]
