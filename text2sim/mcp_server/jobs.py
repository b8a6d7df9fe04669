"""Runs in the background, one at a time: started, asked after, stopped."""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count
from threading import Event, Lock, Thread
from time import monotonic

from text2sim.mcp_server.answers import ToolAnswer, refusal
from text2sim.runtime.progress import PHASES, OnProgress, Progress
from text2sim.runtime.stop import Stop
from text2sim.runtime.trouble import told
from text2sim.spec_schema.errors import RunError

KEPT = 20
"""Jobs that can still be asked after."""
ENDING = 1.5
"""Time [s] that a run has to end when the server does; a client waits two seconds before it kills."""

Work = Callable[[OnProgress, Stop], ToolAnswer]
"""Runs a case to its end and says what came of it."""


@dataclass(eq=False)
class BackgroundRun:
    """One run in the background."""

    id: str
    case: str
    what: str
    """All that makes this run this one: the same asked for twice is the same job."""
    stop: Stop = field(default_factory=Stop)
    progress: Progress = field(default_factory=lambda: Progress("compile"))
    answer: ToolAnswer | None = None
    """What came of it, once it is done."""
    begun: float = field(default_factory=monotonic)
    over: Event = field(default_factory=Event)

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self.over.is_set()

    @property
    def reached(self) -> float:
        """How far it is: a number of phases, with a fraction where that is known."""
        phase = self.progress.phase
        return (list(PHASES).index(phase) if phase in PHASES else 0) + (self.progress.fraction or 0.0)

    @property
    def words(self) -> str:
        """Where it is, for people."""
        progress = self.progress
        text = PHASES.get(progress.phase, progress.phase or "compiling")
        if progress.fraction is not None:
            text += f" {progress.t:.3g} of {progress.duration:g} s"
        if progress.eta is not None:
            text += f", about {progress.eta:.0f} s left"
        return text

    def told(self) -> ToolAnswer:
        """Return what came of it, or how far it is."""
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
    """The runs of a server: one at a time, because two would only slow each other down."""

    def __init__(self) -> None:
        self._jobs: dict[str, BackgroundRun] = {}
        self._numbers = count(1)
        self._lock = Lock()

    def start(self, case: str, what: str, work: Work) -> BackgroundRun:
        """Begin a run, or return the one that is just this and still runs.

        Args:
            case: Name of the case.
            what: What is run: two jobs with the same text are one.
            work: Does it, and returns the answer.

        Raises:
            RunError: if another one runs.
        """
        with self._lock:
            busy = next((job for job in self._jobs.values() if not job.done), None)
            if busy is not None:
                if busy.what == what:
                    return busy
                raise RunError(
                    f"{busy.case} is running ({busy.id}: {busy.words}), and one runs at a time: wait for it with "
                    "run_status, or stop it with run_status, stop: true"
                )
            job = BackgroundRun(f"job-{next(self._numbers)}", case, what)
            self._jobs[job.id] = job
            for old in list(self._jobs)[:-KEPT]:
                del self._jobs[old]
        Thread(target=_work, args=(job, work), name=job.id, daemon=True).start()
        return job

    def find(self, id: str) -> BackgroundRun:
        """Return a job; the last one if `id` is empty.

        Raises:
            RunError: if there is none.
        """
        if not self._jobs:
            raise RunError("nothing was run since this server started; what was run before is found by `evidence`")
        if not id:
            return list(self._jobs.values())[-1]
        if id not in self._jobs:
            raise RunError(f"there is no `{id[:80]}`; the last one is {list(self._jobs)[-1]}")
        return self._jobs[id]

    def close(self) -> None:
        """End what runs: nobody is left to ask after it."""
        for job in self._jobs.values():
            if not job.done:
                job.stop.request()
                job.stop.request()
                job.over.wait(ENDING)


def _work(job: BackgroundRun, work: Work) -> None:
    def listen(progress: Progress) -> None:
        job.progress = progress

    try:
        job.answer = work(listen, job.stop)
    except Exception as error:
        job.answer = refusal(told(error))
    finally:
        job.over.set()
