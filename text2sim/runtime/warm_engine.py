"""The warm engine: starting, idle or at work; replaced when it dies or uses too much memory."""

import queue
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import Any

from text2sim import templates
from text2sim.runtime.child import ChildExit, Limits, default_memory
from text2sim.runtime.dialogue import Child
from text2sim.runtime.outcome import outcome_of, read_end

MODULE = "text2sim.runtime.engine_process"
START_LIMIT = 180.0
"""Processor time [s] for the engine's imports."""
BUILD_LIMIT = 900.0
"""Processor time [s] for building a scene: a new combination of options takes minutes to compile kernels."""
EXTRA_WALL_TIME = 10.0
"""Most wall time over these limits: on a shared machine, a process may wait longer than it works."""
STOP_LIMIT = 5.0
"""Time [s] that a simulation has to stop once it is asked to, and a build outside of live mode."""
MAX_DEATHS = 3
"""Deaths in a row before it was ready, after which it is not started again."""
MEMORY_POLL = 0.5


@dataclass
class Job:
    """A program that is being simulated."""

    order: int
    limit: float
    """Time [s] that the simulation may take."""
    phase: str = "build"
    since: float = field(default_factory=monotonic)
    worked: float = 0.0
    """Processor time [s] that the process had used by then."""
    begun: bool = False
    """Whether the process has reported that it began."""
    cancelled: float | None = None
    overdue: bool = False
    """Whether it was cancelled because it took too long."""


class Engine:
    """Keeps one process warm, and a second one only while it takes over from the first.

    Args:
        folder: Where its log goes.
        inbox: Where its news goes.
        memory: Resident memory [bytes] above which another process takes over.
        module: What the process runs.
        live: Whether somebody watches its results meanwhile, so that it writes them in small chunks.
    """

    def __init__(
        self, folder: Path, inbox: "queue.Queue[Any]", memory: int, module: str = MODULE, *, live: bool = True
    ) -> None:
        self._inbox, self._memory, self._module, self._live = inbox, memory, module, live
        self._log = folder / "engine.log"
        self._log_begin = 0
        self._child: Child | None = None
        self._ready = False
        self._successor: Child | None = None
        self._successor_ready = False
        self._leaving: list[Child] = []
        self._started = 0.0
        self._memory_at = 0.0
        self._deaths = 0
        self._killed = False
        self._lost = 0
        self._precision: str | None = None
        self.job: Job | None = None
        self.limit = default_memory()
        """Resident memory [bytes] at which it is killed."""
        self.peak = 0
        """Largest resident memory [bytes] seen."""
        self.size = 0
        """Resident memory [bytes] that it last reported."""
        self.words = ""
        """Why it died last."""
        self.renewals = 0
        """How often another process took over to free memory."""

    @property
    def hopeless(self) -> bool:
        """Whether it keeps dying before it is ready."""
        return self._deaths >= MAX_DEATHS

    @property
    def idle(self) -> bool:
        """Whether it can carry out an order at once."""
        return self._ready and self.job is None

    @property
    def ready(self) -> bool:
        """Whether it has started."""
        return self._ready

    def start(self) -> None:
        """Start it."""
        self._child, self._ready, self._started = self._spawn(), False, monotonic()
        self._precision = None
        self._log_begin = self._log.stat().st_size if self._log.is_file() else 0

    def fits(self, precision: str) -> bool:
        """Return whether it can compute with so many bits; if not, start another process that can.

        Genesis chooses its precision once in a process.
        """
        if self._precision in (None, precision):
            self._precision = precision
            return True
        assert self._child is not None
        self._child.end()
        self._leaving.append(self._child)
        self.start()
        return False

    def simulate(self, order: int, program: Path, out: Path, limit: float) -> None:
        """Let it simulate a program.

        Args:
            order: Number of the order.
            program: The program's folder.
            out: Folder of the run.
            limit: Time [s] that the simulation may take.
        """
        assert self._child is not None
        self._log_begin = self._log.stat().st_size if self._log.is_file() else 0
        self.job = Job(order, limit, worked=self._child.processor_time())
        self._child.send(order=order, program=str(program), out=str(out))

    @property
    def problem(self) -> str:
        """Output since its last order."""
        return read_end(self._log, self._log_begin)

    def cancel(self) -> None:
        """Ask it to stop its job."""
        if self._child is not None and self.job is not None and self.job.cancelled is None:
            self.job.cancelled = monotonic()
            self._child.send(cancel=self.job.order)

    def receive(self, child: Child, data: dict[str, Any]) -> dict[str, Any] | None:
        """Receive news of a process; return the result of the job if it has ended."""
        if child is not self._child:
            self._take_aside(child, data)
            return None
        if "memory" in data:
            self.size = data["memory"]
            self.peak = max(self.peak, self.size)
        if data.get("ready"):
            self._ready, self._deaths = True, 0
        elif "phase" in data and self.job is not None and data["order"] == self.job.order:
            self.job.begun, self.job.phase, self.job.since = True, data["phase"], monotonic()
            self.job.worked = child.processor_time()
            self._lost = 0
        elif "state" in data and self.job is not None and data["order"] == self.job.order:
            result = self._finish(data)
            self._hand_over()
            return result
        elif "died" in data:
            return self._bury(data["died"])
        elif "memory" in data and self.size > self._memory and self._successor is None:
            self._successor = self._spawn()
        return None

    def guard(self) -> dict[str, Any] | None:
        """Kill the process if it exceeds a limit; return the result of the job if it ended thereby."""
        now = monotonic()
        if self._child is None:
            return None
        if not self._ready and self._exceeds(START_LIMIT, self._started, 0.0):
            self._child.kill()
        if now >= self._memory_at:
            self._memory_at = now + MEMORY_POLL
            used = self._child.memory()
            self.peak = max(self.peak, used)
            if used > self.limit:
                return self._kill("out_of_memory", f"it used {used / 1e9:.2g} GB of memory")
        job = self.job
        if job is None:
            return None
        if job.cancelled is not None:
            # Whoever edits a case will run it again, and needs the kernels that are being compiled.
            limit = BUILD_LIMIT if self._live and job.phase == "build" else STOP_LIMIT
            if now - job.cancelled > limit:
                return self._kill("timeout" if job.overdue else "interrupted", "it did not stop when it was asked to")
        elif job.phase == "simulate" and now - job.since > job.limit:
            job.overdue = True
            self.cancel()
        elif job.phase == "build" and self._exceeds(BUILD_LIMIT, job.since, job.worked):
            return self._kill("timeout", f"building the scene took longer than {BUILD_LIMIT:g} s")
        return None

    def _exceeds(self, limit: float, since: float, worked: float) -> bool:
        """Return whether the process exceeded a limit [s] of processor time, or far exceeded it in wall time."""
        assert self._child is not None
        wall = monotonic() - since
        return wall > EXTRA_WALL_TIME * limit or (wall > limit and self._child.processor_time() - worked > limit)

    @property
    def ended(self) -> bool:
        """Whether all its processes have ended."""
        return all(child.has_ended for child in self._children)

    def end(self) -> None:
        """Let all its processes end by themselves."""
        self.cancel()
        for child in self._children:
            child.end()

    def kill(self) -> None:
        """End all its processes."""
        for child in self._children:
            child.kill()

    @property
    def _children(self) -> list[Child]:
        return [child for child in (self._child, self._successor, *self._leaving) if child is not None]

    def _spawn(self) -> Child:
        folder = Path(templates.__file__).parent
        return Child("engine", self._module, [str(folder), *["live"] * self._live], self._log, self._inbox)

    def _take_aside(self, child: Child, data: dict[str, Any]) -> None:
        """Receive news of a process that is not the current one."""
        if "died" in data:
            self._leaving = [other for other in self._leaving if other is not child]
            if child is self._successor:
                self._successor = None
        elif data.get("ready") and child is self._successor:
            self._successor_ready = True
            self._hand_over()

    def _hand_over(self) -> None:
        """Let the successor take over if it is ready and nothing is being done."""
        if self._successor is None or not self._successor_ready or self.job is not None or self._child is None:
            return
        self._child.end()
        self._leaving.append(self._child)
        self._child, self._successor, self._successor_ready = self._successor, None, False
        self._ready, self._precision = True, None
        self.renewals += 1

    def _finish(self, data: dict[str, Any]) -> dict[str, Any]:
        job, self.job = self.job, None
        assert job is not None
        if data["state"] == "interrupted" and job.overdue:
            data = {**data, "state": "timeout", "message": f"it took longer than {job.limit:g} s, and was stopped"}
        return data

    def _kill(self, state: str, message: str) -> dict[str, Any] | None:
        assert self._child is not None
        self._child.kill()
        # The inbox will report its death; until then it gets no orders.
        self._ready, self._killed = False, True
        job, self.job = self.job, None
        return None if job is None else {"order": job.order, "state": state, "message": message, "killed": True}

    def _bury(self, code: int) -> dict[str, Any] | None:
        """Replace a process that has died; return the result of its job."""
        text = read_end(self._log, self._log_begin)
        exit = ChildExit("ended", code, monotonic() - self._started, self.peak, default_memory(), 0)
        outcome = outcome_of(exit, Limits(), {}, text, 0.0)
        self._deaths += 0 if self._ready or self._killed else 1
        self._killed = False
        self.words = outcome.message
        if self._successor is not None:
            self._child, self._ready, self._started = self._successor, self._successor_ready, monotonic()
            self._successor, self._successor_ready, self._precision = None, False, None
        elif self.hopeless:
            self._child, self._ready = None, False
        else:
            self.start()
        job, self.job = self.job, None
        if job is None:
            return None
        message = {"message": outcome.message, "traceback": text, "killed": True}
        return {"order": job.order, "state": outcome.state, **message}
