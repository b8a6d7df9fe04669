"""From a case to a run folder with evidence, doing only what is not yet done."""

import json
from collections.abc import Callable
from datetime import UTC, datetime
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim import __version__, templates
from text2sim.harness.child import Limits
from text2sim.harness.folder import Wanted, Work, install_program, install_run, remaining_work, staging
from text2sim.harness.lock import RunLock
from text2sim.harness.outcome import EXIT_INTERRUPTED
from text2sim.harness.program import Finished, run_program
from text2sim.harness.progress import Clock, OnProgress, ignore
from text2sim.harness.record import COMPLETE, RunRecord, write_atomically
from text2sim.harness.result import RunResult
from text2sim.harness.stop import Stop
from text2sim.spec_schema.errors import MachineError, Problem, RunError

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan
    from text2sim.spec_schema.load import LoadedCase

Compile = Callable[["LoadedCase", Path], "Plan"]
"""Writes the program of a case into a folder and returns its plan."""


def run_case(
    loaded: "LoadedCase",
    *,
    runs: Path,
    on_progress: OnProgress = ignore,
    timeout: float = 3600.0,
    memory_gb: float | None = None,
    film: bool = True,
    force: bool = False,
    device: Device = "cpu",
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
        device: What the engine computes on.
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
    if device == "gpu" and device_kind() != "cuda":
        raise MachineError("there is no CUDA device here; `text2sim doctor` says why")
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
            key={
                "sim_digest": plan.sim_digest,
                "templates": _folder_digest(Path(templates.__file__).parent)[:16],
                "genesis": genesis,
                "device": device_kind(),
            },
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

    def bring_up_to_date(
        self, staged: Path, *, film: bool, force: bool, limits: Limits, lock: RunLock
    ) -> RunResult:
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
            self.evidence = _read_evidence(self.folder, self.loaded)
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

    def _simulate(self, record: RunRecord, limits: Limits, lock: RunLock, *, film: bool) -> None:
        done = self._run_program(() if film else ("--no-film",), limits, lock)
        outcome = done.outcome
        record.state, record.time, record.message = outcome.state, outcome.time, outcome.message
        record.exit_code, record.wall = done.ended.code, round(done.ended.wall, 3)
        record.peak_memory = done.ended.peak_memory
        if film and record.state in COMPLETE:
            self._keep_film(record, done, outcome.film_message)
        if record.state != "finished":
            self._blame(record, done)
        if done.ended.log_left_out:
            record.notes.append(f"log.txt lacks {done.ended.log_left_out} bytes from its middle")
        record.write(self.folder)

    def _film(self, record: RunRecord, limits: Limits, lock: RunLock) -> None:
        record.render_digest = ""
        record.write(self.folder)
        (self.folder / "video.mp4").unlink(missing_ok=True)
        done = self._run_program(("--film-only",), limits, lock)
        self._keep_film(record, done, done.outcome.film_message or done.outcome.message)
        record.write(self.folder)

    def _run_program(self, flags: tuple[str, ...], limits: Limits, lock: RunLock) -> Finished:
        if self.device == "gpu":
            flags = (*flags, "--backend", "gpu")
        return run_program(
            self.folder, flags=flags, limits=limits, stop=self.stop, clock=self.clock, inherit=(lock.fileno,)
        )

    def _keep_film(self, record: RunRecord, done: Finished, reason: str) -> None:
        if (self.folder / "video.mp4").is_file():
            record.render_digest = self.plan.render_digest
        else:
            self.film_message = done.no_film or reason or "the program made none"

    def _blame(self, record: RunRecord, done: Finished) -> None:
        line, code = done.blame or (1, "")
        record.where = {"line": line, "code": code} if done.blame else None
        if done.blame:
            message = f"engine: {record.message}"
            self.problem = Problem("", message, line, 1, self.loaded.source.file, rule="engine")

    def _judge(self, record: RunRecord) -> None:
        if not any((self.folder / "states").glob("chunk_*.npz")):
            return  # it ended before there was anything to judge
        from text2sim.harness.evidence import judge
        from text2sim.harness.report import write_report

        record.judge_digest = ""
        record.write(self.folder)
        self.clock.enter("judge")
        try:
            self.evidence = judge(self.folder, self.loaded.case)
        except RunError as error:
            record.notes.append(f"nothing could be judged: {error}")
            return
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
            time=record.time,
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


def _read_evidence(folder: Path, loaded: "LoadedCase") -> dict[str, Any]:
    evidence = json.loads((folder / "evidence.json").read_text("utf-8"))
    # The file is sorted by name; people read expectations in the order in which the case lists them.
    order = {
        name: evidence["expect"][name] for name in loaded.case.actions.expect if name in evidence["expect"]
    }
    return evidence | {"expect": order}


def _judge_digest(loaded: "LoadedCase") -> str:
    """Digest of all that evidence depends on besides the recorded states, and of the code that makes it."""
    case = loaded.case.model_dump_json(by_alias=True, exclude={"render": True})
    return sha256((case + _folder_digest(Path(__file__).parent)).encode()).hexdigest()


def _folder_digest(folder: Path) -> str:
    """Digest of the sources in a folder of the package: while we develop, a version number says too little."""
    digest = sha256()
    for path in sorted(folder.rglob("*")):
        if path.suffix in (".py", ".j2"):
            digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


__all__ = ["Compile", "RunResult", "run_case"]
