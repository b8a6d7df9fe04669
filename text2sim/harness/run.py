"""Runs a case into a folder with evidence; does only what is not yet done."""

import json
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from math import inf
from pathlib import Path
from typing import Any, Literal

from text2sim import __version__
from text2sim.compiler.plan import Plan
from text2sim.harness.folder import Wanted, Work, drop_previous, install_program, install_run, remaining_work, staging
from text2sim.harness.rescue import rescue
from text2sim.harness.result import RunResult
from text2sim.harness.sources import film_code, judge_code, simulation_code
from text2sim.recording.inventory import JUDGED, RECORDED, list_files
from text2sim.recording.record import COMPLETE, RunRecord
from text2sim.recording.run_files import read_evidence
from text2sim.runtime.child import THREADS, Limits
from text2sim.runtime.lock import RunLock
from text2sim.runtime.machine import device_kind, missing_libraries, versions
from text2sim.runtime.machine_check import check_ability
from text2sim.runtime.outcome import read_status
from text2sim.runtime.program import Finished, run_program
from text2sim.runtime.progress import Clock, OnProgress, ignore
from text2sim.runtime.stop import Stop
from text2sim.spec_schema.errors import MachineError, Problem, RunError
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.reuse.expanded import expanded_text
from text2sim.spec_schema.reuse.overlay import needs_layers
from text2sim.spec_schema.whole_files import write_atomically

__all__ = ["Compile", "Device", "run_case"]

Compile = Callable[[LoadedCase, Path], Plan]
"""Writes the program of a case into a folder and returns its plan."""
Runner = Callable[..., Finished]
"""Runs the program of a run folder, as `run_program` does."""
STRUNG = ("rope", "chain")
"""Kinds of bodies that a blow pulls taut."""
SHORTER = 4
"""Factor on the substeps: a rope held with it as 4.1 kg fell 1 m into its bucket of 3.3 kg; with 2 it did not."""
Device = Literal["cpu", "gpu"]
"""What the engine computes on. The CPU is faster for a scene of a few hundred bodies."""


def run_case(
    loaded: LoadedCase,
    *,
    runs: Path,
    on_progress: OnProgress = ignore,
    timeout: float = 3600.0,
    patience: float = inf,
    memory_gb: float | None = None,
    film: bool = True,
    force: bool = False,
    device: Device = "cpu",
    stop: Stop | None = None,
    compile_to: Compile | None = None,
    lint: Sequence[dict[str, Any]] = (),
    runner: Runner = run_program,
) -> RunResult:
    """Bring the run folder of a case up to date: simulate, film, judge and report, as far as needed.

    Args:
        loaded: The case.
        runs: The folder of run folders.
        on_progress: Receives progress.
        timeout: Wall time [s] that the program may take.
        patience: Expected wall time [s] from which it is stopped as soon as its speed is known.
        memory_gb: Memory [GB] that it may use; 85 % of what is free at the start if left out.
        film: Whether a film is wanted.
        force: Simulate again even if nothing changed.
        device: What the engine computes on.
        stop: Requests to stop; Ctrl-C and SIGTERM if left out.
        compile_to: The compiler.
        lint: Findings to keep with the run, as in `RunRecord`.
        runner: Runs the program.

    Raises:
        SpecError: if the case cannot be compiled.
        MachineError: if this machine cannot run it, or another process does at the moment.
        RunError: if its run folder is in the way.
    """
    if compile_to is None:
        from text2sim.compiler.build import compile_case

        compile_to = compile_case
    memory = None if memory_gb is None else int(memory_gb * 1e9)
    limits = Limits(timeout=timeout, patience=patience, memory=memory)
    check_ability(loaded)
    engine = _Engine.find(device)
    with nullcontext(stop) if stop else Stop() as stop, staging(runs) as stage:
        clock = Clock(on_progress, loaded.case.scene.duration)
        clock.enter("compile")
        staged = stage / "run"
        staged.mkdir()
        plan = compile_to(loaded, staged / "program")
        folder = runs / "-".join(filter(None, (loaded.case.name, loaded.overlay.label, plan.sim_digest[:10])))
        with RunLock(runs, folder.name) as lock:
            run = _Run(loaded, plan, folder, engine, limits, clock, stop, lock, film)
            run.record.lint, run.runner = list(lint), runner
            work = run.work(force=force)
            run.do(work, staged)
            return run.result(work)


@dataclass(frozen=True)
class _Engine:
    """What a simulation depends on besides its program."""

    versions: dict[str, str]
    device: Device

    @classmethod
    def find(cls, device: Device) -> "_Engine":
        found = versions()
        if "genesis-world" not in found:
            raise MachineError("Genesis is not installed here; `text2sim doctor` says what is missing")
        if lacking := [library for library in missing_libraries() if library.essential]:
            names = " and ".join(library.soname for library in lacking)
            packages = " ".join(library.package for library in lacking)
            raise MachineError(f"Genesis does not start without {names}: sudo apt-get install -y {packages}")
        if device == "gpu" and device_kind() != "cuda":
            raise MachineError("there is no CUDA device here; `text2sim doctor` says why")
        return cls(found, device)

    def key(self, sim_digest: str) -> dict[str, str]:
        return {
            "sim_digest": sim_digest,
            "templates": simulation_code(),
            "genesis": self.versions["genesis-world"],
            "device": "cuda" if self.device == "gpu" else "cpu",
            "threads": str(THREADS),
        }


class _Run:
    """One call of `run_case`, from the compiled program on."""

    def __init__(
        self,
        loaded: LoadedCase,
        plan: Plan,
        folder: Path,
        engine: _Engine,
        limits: Limits,
        clock: Clock,
        stop: Stop,
        lock: RunLock,
        film: bool,
    ) -> None:
        self.loaded, self.plan, self.folder, self.limits = loaded, plan, folder, limits
        self.clock, self.stop, self.lock, self.film, self.device = clock, stop, lock, film, engine.device
        self.film_digest = sha256((plan.render_digest + film_code()).encode()).hexdigest()
        self.judge_digest = _judge_digest(loaded, self.film_digest)
        self.record = RunRecord(
            case=loaded.case.name,
            state="running",
            key=engine.key(plan.sim_digest),
            text2sim=__version__,
            case_digest=_case_digest(loaded),
            variants=[*loaded.overlay.variants, *([".".join(point)] if (point := loaded.overlay.point) else [])],
            sets=list(loaded.overlay.sets),
            seed=plan.seed,
            versions=engine.versions,
            duration=loaded.case.scene.duration,
            notes=list(plan.notes),
        )
        self.runner: Runner = run_program
        self.film_message = ""
        self.damage = ""
        """Damage of the existing run folder, and what was done about it."""
        self.problem: Problem | None = None
        self.evidence: dict[str, Any] | None = None

    def work(self, *, force: bool) -> Work:
        """Return the work to do."""
        if force:
            return Work.SIMULATE
        rescue(self.folder, self.record.key)
        work, damage = remaining_work(
            self.folder, Wanted(self.record.key, self.film_digest, self.judge_digest, self.film)
        )
        self.damage = f"{damage}: {work.value}" if damage else ""
        return work

    def do(self, work: Work, staged: Path) -> None:
        """Do the work, with the program in `staged`."""
        if work is Work.SIMULATE:
            self._write_inputs(staged)
            self.record.started = datetime.now(UTC).isoformat(timespec="seconds")
            self.record.write(staged)
            install_run(staged, self.folder)
            self._simulate()
        else:
            self._refresh(staged, work)
            if work is Work.FILM:
                self._film_again()
        if work is Work.NOTHING:
            self.evidence = read_evidence(self.folder)
        else:
            self._judge()
        if work is Work.SIMULATE and self.record.state in COMPLETE and self.evidence is not None:
            drop_previous(self.folder, staged.parent)

    def result(self, work: Work) -> RunResult:
        """Record timings, and return the result."""
        timings, record = self.clock.finish(), self.record
        if record.state == "diverged":
            self.problem = self._blame_body()
        if work is not Work.NOTHING:
            record.timings |= {name: round(t, 3) for name, t in timings.items()}
            record.write(self.folder)
        video, report = self.folder / "video.mp4", self.folder / "report.html"
        current = record.render_digest == self.film_digest and video.is_file()
        if self.evidence is not None:
            # The file is sorted by name, but people expect the order of the case.
            expect = self.evidence["expect"]
            self.evidence["expect"] = {name: expect[name] for name in self.loaded.case.actions.expect if name in expect}
        return RunResult(
            case=record.case,
            folder=self.folder,
            work=work,
            state=record.state,
            time=record.time,
            message=record.message,
            problem=self.problem,
            evidence=self.evidence,
            film=video if current else None,
            film_message=self.film_message,
            report=report if report.is_file() else None,
            damage=self.damage,
            stopped=self.stop.count > 0,
            warnings=list(self.plan.warnings),
            notes=list(record.notes),
            timings=timings,
            wall=self.clock.wall,
        )

    def _write_inputs(self, folder: Path) -> None:
        write_atomically(folder / "case.yaml", self.loaded.source.text)
        write_atomically(folder / "expanded.yaml", expanded_text(self.loaded))
        resolved = self.loaded.case.model_dump(mode="json", by_alias=True)
        write_atomically(folder / "resolved.json", json.dumps(resolved, indent=1) + "\n")

    def _refresh(self, staged: Path, work: Work) -> None:
        """Take over the existing record; bring everything but the states up to date with the case."""
        fresh, self.record = self.record, RunRecord.read(self.folder) or self.record
        if work is Work.NOTHING and self.record.case_digest == fresh.case_digest:
            return
        install_program(staged / "program", self.folder / "program")
        self._write_inputs(self.folder)
        self.record.case_digest, self.record.text2sim = fresh.case_digest, fresh.text2sim
        self.record.variants, self.record.sets = fresh.variants, fresh.sets
        self.record.notes, self.record.lint = fresh.notes, fresh.lint
        if work is Work.FILM or self.record.render_digest != self.film_digest:
            self._drop_films()
        self.record.write(self.folder)

    def _simulate(self) -> None:
        record = self.record
        done = self._run_program(() if self.film else ("--no-film",))
        outcome = done.outcome
        record.state, record.time, record.message = outcome.state, outcome.time, outcome.message
        record.exit_code, record.wall = done.ended.code, round(done.ended.wall, 3)
        record.peak_memory = done.ended.peak_memory
        if self.film and record.state in COMPLETE:
            self._keep_film(done, outcome.film_message)
        if record.state != "finished" and done.blame is not None:
            line, code = done.blame
            record.where = {"line": line, "code": code}
            source = self.loaded.source
            text = source.lines[line - 1] if line <= len(source.lines) else ""
            column = len(text) - len(text.lstrip()) + 1
            self.problem = Problem("", f"engine: {record.message}", line, column, source.file, rule="engine")
        if record.state in COMPLETE:
            record.recorded = list_files(self.folder, RECORDED)
        if done.ended.log_left_out:
            record.notes.append(f"log.txt lacks {done.ended.log_left_out} bytes from its middle")
        record.write(self.folder)

    def _blame_body(self) -> Problem | None:
        """Return the divergence as a problem at the line of the body on which it was first seen."""
        where = read_status(self.folder / "status.json").get("where")
        name = body_of(str(where.get("body"))) if isinstance(where, dict) else ""
        if name not in self.loaded.case.bodies:
            return None
        message, kind = self.record.message, getattr(self.loaded.case.bodies[name], "kind", "")
        if kind in STRUNG:
            finer = SHORTER * self.plan.settings.substeps
            message += (
                f"; if a blow pulls it taut, use scene.substeps of {finer}, or a {kind} of fewer and heavier links"
            )
        return self.loaded.problem(("bodies", name), message, key=True, rule="diverged")

    def _drop_films(self) -> None:
        """Remove previews that show previous cameras or looks: evidence and report would be about these."""
        self.record.render_digest = ""
        for file in (*self.folder.glob("video*.mp4"), self.folder / "visibility.json"):
            file.unlink(missing_ok=True)

    def _film_again(self) -> None:
        done = self._run_program(("--film-only",))
        self._keep_film(done, done.outcome.film_message or done.outcome.message)
        self.record.write(self.folder)

    def _run_program(self, flags: tuple[str, ...]) -> Finished:
        if self.device == "gpu":
            flags = (*flags, "--backend", "gpu")
        return self.runner(
            self.folder,
            flags=flags,
            limits=self.limits,
            stop=self.stop,
            clock=self.clock,
            inherit=(self.lock.fileno,),
        )

    def _keep_film(self, done: Finished, reason: str) -> None:
        if (self.folder / "video.mp4").is_file():
            self.record.render_digest = self.film_digest
        else:
            stopped = "stopped on request" if done.ended.cause == "stopped" else ""
            self.film_message = stopped or done.no_film or reason or "the program made none"

    def _judge(self) -> None:
        if not any((self.folder / "states").glob("chunk_*.npz")):
            return  # it ended before there was anything to judge
        from text2sim.evidence.evidence import judge
        from text2sim.evidence.report import write_report

        self.record.judge_digest, self.record.judged = "", {}
        self.record.write(self.folder)
        self.clock.enter("judge")
        try:
            judge(self.folder, self.loaded.case, self.loaded)
            self.evidence = read_evidence(self.folder)  # in the order in which a later process reads it
        except RunError as error:
            self.record.notes.append(f"nothing could be judged: {error}")
            return
        self.clock.enter("report")
        self._make_replay()
        write_report(self.folder, self.loaded.case)
        self.record.judge_digest, self.record.judged = self.judge_digest, list_files(self.folder, JUDGED)

    def _make_replay(self) -> None:
        from text2sim.replay.page import NAME, is_quick, write_replay

        (self.folder / NAME).unlink(missing_ok=True)  # it shows an older recording or expectations
        if not is_quick(self.folder):
            return
        try:
            write_replay(self.folder, self.loaded.case)
        except RunError as error:
            self.record.notes.append(f"there is no 3D replay: {error}")


def _case_digest(loaded: LoadedCase) -> str:
    """Return the digest of the case as written, its prefabs, and what is laid over it."""
    text = loaded.source.text
    if needs_layers(loaded.written.data, loaded.overlay):
        text += "\0" + repr(loaded.overlay) + "\0" + expanded_text(loaded)
    return sha256(text.encode()).hexdigest()


def _judge_digest(loaded: LoadedCase, film_digest: str) -> str:
    """Return the digest of what evidence depends on besides recorded states, and of the code that makes it."""
    case = loaded.case.model_dump_json(by_alias=True, exclude={"render": True})
    # How well bodies are seen depends on the cameras.
    return sha256((case + film_digest + judge_code()).encode()).hexdigest()
