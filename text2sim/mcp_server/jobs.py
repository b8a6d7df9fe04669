"""Background runs, one at a time, with progress and stop."""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from threading import Event, Lock, Thread
from time import monotonic

from text2sim.mcp_server.answers import ToolAnswer, refusal
from text2sim.runtime.internal_errors import internal_error_message
from text2sim.runtime.progress import PHASES, OnProgress, Progress
from text2sim.runtime.stop import Stop
from text2sim.spec_schema.errors import RunError

MAX_REMEMBERED_JOBS = 20
"""Number of jobs that are remembered."""
STOP_GRACE = 1.5
"""Time [s] that a run has to end when the server does; a client kills the server after two seconds."""

Work = Callable[[OnProgress, Stop], ToolAnswer]
"""Runs a case to its end and returns the answer."""


@dataclass(eq=False)
class BackgroundRun:
    """A run in the background."""

    id: str
    case: str
    what: str
    """Identity of the run: equal requests are the same job."""
    stop: Stop = field(default_factory=Stop)
    progress: Progress = field(default_factory=lambda: Progress("compile"))
    answer: ToolAnswer | None = None
    """The answer, once it is done."""
    begun: float = field(default_factory=monotonic)
    over: Event = field(default_factory=Event)

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self.over.is_set()

    @property
    def reached(self) -> float:
        """Progress as a number of phases, with a fraction if that is known."""
        phase = self.progress.phase
        return (list(PHASES).index(phase) if phase in PHASES else 0) + (self.progress.fraction or 0.0)

    @property
    def words(self) -> str:
        """Progress in words."""
        progress = self.progress
        text = PHASES.get(progress.phase, progress.phase or "compiling")
        if progress.fraction is not None:
            text += f" {progress.t:.3g} of {progress.duration:g} s"
        if progress.eta is not None:
            text += f", about {progress.eta:.0f} s left"
        return text

    def status(self) -> ToolAnswer:
        """Return the answer, or the progress until there is one."""
        if self.answer is not None and self.done:
            return self.answer
        document = {
            "state": "stopping" if self.stop.count else "running",
            "id": self.id,
            "case": self.case,
            "now": self.words,
            "seconds": round(monotonic() - self.begun, 1),
            "next": f"ask again with run_status, id {self.id}",
        }
        return ToolAnswer(document)


class Jobs:
    """The runs of a server, one at a time, because two would slow each other down."""

    def __init__(self) -> None:
        self._jobs: dict[str, BackgroundRun] = {}
        self._numbers = count(1)
        self._lock = Lock()

    def start(self, case: str, what: str, work: Work) -> BackgroundRun:
        """Start a run, or return the current one if it is the same.

        Args:
            case: Name of the case.
            what: Identity of the run: jobs with the same text are the same.
            work: Runs it, and returns the answer.

        Raises:
            RunError: if another one is running.
        """
        with self._lock:
            busy = next((job for job in self._jobs.values() if not job.done), None)
            if busy is not None:
                if busy.what == what:
                    return busy
                raise RunError(
                    f"{busy.case} is running ({busy.id}: {busy.words}), and only one can run at a time: wait for it "
                    "with run_status, or stop it with run_status, stop: true"
                )
            job = BackgroundRun(f"job-{next(self._numbers)}", case, what)
            self._jobs[job.id] = job
            for old in list(self._jobs)[:-MAX_REMEMBERED_JOBS]:
                del self._jobs[old]
        Thread(target=_run_job, args=(job, work), name=job.id, daemon=True).start()
        return job

    def find(self, id: str) -> BackgroundRun:
        """Return a job; the last one if `id` is empty.

        Raises:
            RunError: if there is none.
        """
        if not self._jobs:
            raise RunError("this server has not run anything yet; `evidence` finds earlier runs")
        if not id:
            return list(self._jobs.values())[-1]
        if id not in self._jobs:
            raise RunError(f"there is no `{id[:80]}`; the last one is {list(self._jobs)[-1]}")
        return self._jobs[id]

    def close(self) -> None:
        """Stop the current run."""
        for job in self._jobs.values():
            if not job.done:
                job.stop.request()
                job.stop.request()
                job.over.wait(STOP_GRACE)


def _run_job(job: BackgroundRun, work: Work) -> None:
    def listen(progress: Progress) -> None:
        job.progress = progress

    try:
        job.answer = work(listen, job.stop)
    except Exception as error:
        job.answer = refusal(internal_error_message(error))
    finally:
        job.over.set()
