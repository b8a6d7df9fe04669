"""Session that watches a case: checks it when it is saved, and updates states, evidence and scene."""

import queue
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from text2sim.runtime import warm_engine
from text2sim.runtime.dialogue import News
from text2sim.runtime.internal_errors import internal_error_message
from text2sim.runtime.progress import ProgressTail
from text2sim.runtime.warm_engine import Engine
from text2sim.spec_schema.whole_files import write_json
from text2sim.watching import page_text
from text2sim.watching.case_files import CaseFiles
from text2sim.watching.judging import Judge, JudgedTake
from text2sim.watching.live_run import ENDED_WELL, LiveRun, Version
from text2sim.watching.page_state import PageState
from text2sim.watching.protocols import Checked, Listener
from text2sim.watching.scenes import Packed, Scenes

POLL_INTERVAL = 0.05
"""Time [s] between polls of the files."""
SHUTDOWN_TIME = 10.0
"""Time [s] that processes have to end, in which the engine stores its compiled kernels."""


@dataclass(frozen=True)
class Options:
    """Options of the user."""

    timeout: float = 60.0
    """Time limit of a simulation [s]."""
    memory: int = 3_000_000_000
    """Resident memory [bytes] above which the engine is restarted."""
    engine: str = warm_engine.MODULE
    """Module of the engine's process."""


class WatchSession:
    """Session that watches a case.

    Args:
        case_file: The case's file.
        folder: Folder of takes, which exists and is ours.
        examine: Reads the case.
        state: State of the page.
        listener: Receives events.
        options: Options of the user.
    """

    def __init__(
        self,
        case_file: Path,
        folder: Path,
        examine: Callable[[], Checked],
        state: PageState,
        listener: Listener,
        options: Options,
    ) -> None:
        self._folder, self._examine, self._state, self._listener = folder, examine, state, listener
        self._options = options
        self._files = CaseFiles(case_file)
        self._inbox: queue.Queue[Any] = queue.Queue()
        self.engine = Engine(folder, self._inbox, options.memory, options.engine)
        self.judge = Judge(self._inbox)
        self.scenes = Scenes(self._inbox)
        self._version: Version | None = None
        self._saved = monotonic()
        self._takes = 0
        self._live_run: LiveRun | None = None
        self._progress: ProgressTail | None = None
        self._shows = 0
        self._reported: tuple[int, str, str] | None = None
        """The last completed key: live run, film, judgement."""
        self._valid = False
        """Whether the current text can be run."""
        self._shown = False
        """Whether the page shows the result of the current text."""

    def run(self, stops: Callable[[], int]) -> None:
        """Watch until `stops` returns a number of requests to stop."""
        for old in self._folder.glob("take-*"):
            shutil.rmtree(old, ignore_errors=True)
        self.engine.start()
        try:
            self._check()
            while not stops():
                if saved := self._files.saved():
                    self._saved = monotonic() - self._files.age
                    self._check(again=saved == "touched")
                self._listen()
                self._guard()
                self._reconcile()
        finally:
            self._state.show(words="ended", tone="bad", progress=None)
            self.engine.cancel()
            until = monotonic() + SHUTDOWN_TIME
            self.engine.end()
            while monotonic() < until and stops() < 2 and not self.engine.ended:
                sleep(POLL_INTERVAL)
            self.engine.kill()

    # --- the text ------------------------------------------------------------------------------------------------

    def _check(self, *, again: bool = False) -> None:
        """Read the case; `again` if the same text was saved again."""
        try:
            checked = self._examine()
            version = self._compile(checked)
        except Exception as error:  # a bug of ours must not end the session: the next save may avoid it
            self._valid = False
            self._listener.trouble(internal_error_message(error), None)
            self._state.show(words="internal error", tone="bad", mark="!", problems=[], progress=None)
            return
        self._valid, self._shown = version is not None, False
        self._state.show(case=checked.name, problems=page_text.problem_rows(checked))
        if version is None:
            self._state.show(**page_text.refusal(checked), stale=True)
        self._listener.checked(checked, monotonic() - self._saved)
        if version is None:
            return
        live_run = self._live_run
        if again and live_run is not None and not live_run.running and live_run.state not in ENDED_WELL:
            self._live_run = None  # a failure may not be reproducible: another save tries again
        self._version = version
        self._reconcile()

    def _compile(self, checked: Checked) -> Version | None:
        if not checked.ok or checked.loaded is None or checked.plan is None:
            return None
        from text2sim.compiler.emit import emit

        return Version(self._saved, checked.loaded, checked.plan, emit(checked.plan))

    # --- updates -------------------------------------------------------------------------------------------------

    def _reconcile(self) -> None:
        version, live_run = self._version, self._live_run
        if version is None:
            return
        if live_run is None or live_run.version.plan.sim_digest != version.plan.sim_digest:
            self._simulate(version)
            return
        if live_run.version is not version:
            live_run.adopt(version)
            live_run.write_inputs(version)
        if live_run.state == "building":
            return
        judged = self.judge.judged
        if not live_run.running and (judged is None or judged.key != (live_run.number, version.judge_digest)):
            live_run.write_inputs(version)
            self.judge.judge((live_run.number, version.judge_digest), live_run.folder, version.loaded)
            if self._valid:
                self._state.show(words="judging", tone="busy", progress=None)
            return
        judgement = "" if live_run.running else version.judge_digest
        key = (live_run.number, version.plan.render_digest, judgement)
        self.scenes.pack(key, live_run.folder, version.loaded.case, whole=not live_run.running)
        self._conclude(live_run, version, key)

    def _simulate(self, version: Version) -> None:
        if self._live_run is not None and self._live_run.running:
            self.engine.cancel()
            self._live_run.unwanted = True
            return
        if self.engine.hopeless or not self.engine.idle:
            return
        if not self.engine.fits(version.plan.settings.precision):
            self._listener.status("the engine is restarted, for another numeric precision")
            return
        self._takes += 1
        self._live_run = live_run = LiveRun(self._takes, self._folder / f"take-{self._takes}", version)
        live_run.seconds["check"] = monotonic() - version.saved
        live_run.write_inputs(version)
        self._progress = ProgressTail(live_run.folder / "progress.jsonl")
        self.engine.simulate(live_run.number, live_run.folder / "program", live_run.folder, self._options.timeout)
        self._state.show(words="building the scene", tone="busy", mark="…", stale=True, progress=None, timing="")

    def _conclude(self, live_run: LiveRun, version: Version, key: tuple[int, str, str]) -> None:
        """Report, once, that everything is up to date."""
        judged, packed = self.judge.judged, self.scenes.whole
        if live_run.running or judged is None or (self._reported == key and (self._shown or not self._valid)):
            return
        if packed is None or packed.key != key:
            return
        self._shown = True
        live_run.seconds["all"] = monotonic() - version.saved
        self._state.show(stale=not self._valid)
        if self._valid:
            closing = page_text.closing(live_run, judged.evidence, packed.message)
            self._state.show(**closing, timing=page_text.timing(live_run))
        if self._reported == key:
            self._listener.status("nothing to do: physics, film and expectations have not changed")
            return
        self._reported = key
        live_run.write_record()
        for old in self._folder.glob("take-*"):
            if old != live_run.folder:
                shutil.rmtree(old, ignore_errors=True)
        self._listener.done(live_run, judged.evidence, packed.message)

    # --- news ----------------------------------------------------------------------------------------------------

    def _listen(self) -> None:
        """Wait briefly for messages, and handle all that have arrived."""
        try:
            news = self._inbox.get(timeout=POLL_INTERVAL)
            while True:
                self._handle(news)
                news = self._inbox.get_nowait()
        except queue.Empty:
            pass

    def _handle(self, news: Any) -> None:
        if isinstance(news, JudgedTake):
            self.judge.receive(news)
            if self._live_run is not None and news.key[0] == self._live_run.number:
                self._live_run.seconds["judge"] = news.seconds
            if news.message and self._live_run is not None and self._live_run.state in ENDED_WELL:
                self._listener.trouble(news.message, None)
        elif isinstance(news, Packed):
            self.scenes.receive(news)
            self._show_scene(news)
        elif isinstance(news, News):
            before = self.engine.ready
            self._after_simulation(self.engine.receive(news.child, news.data))
            if self.engine.ready and not before:
                self._listener.status("the engine has started")
            if "died" in news.data and self.engine.hopeless:
                self._listener.trouble(f"the engine does not start: {self.engine.words}; see engine.log", None)
                self._state.show(words="the engine does not start", tone="bad", mark="!", progress=None)
            if (
                (live_run := self._live_run) is not None
                and news.data.get("phase") == "simulate"
                and live_run.state == "building"
            ):
                live_run.state = "simulating"
                live_run.seconds["build"] = monotonic() - live_run.begun

    def _show_scene(self, packed: Packed) -> None:
        live_run = self._live_run
        if live_run is None or packed.key[0] != live_run.number or not packed.scene:
            return
        if packed.whole and self._version is not None:
            live_run.seconds["scene"] = monotonic() - self._version.saved
        self._shows += 1
        self._state.show_scene(
            f"{live_run.number}-{self._shows}", str(live_run.number), packed.scene, whole=packed.whole
        )
        self._state.show(stale=not self._valid)

    def _guard(self) -> None:
        self._after_simulation(self.engine.guard())
        live_run = self._live_run
        if live_run is None or not live_run.running or self._progress is None:
            if live_run is None and self._version is not None and not self.engine.ready and not self.engine.hopeless:
                self._state.show(words="starting the engine", tone="busy", mark="…")
            return
        for record in self._progress.read():
            if record.get("phase") == "simulate" and self._valid and record.get("duration"):
                done = record["t"] / record["duration"]
                self._state.show(words="simulating", tone="busy", progress=round(done, 3))

    def _after_simulation(self, result: dict[str, Any] | None) -> None:
        """Handle the end of a simulation."""
        live_run = self._live_run
        if result is None or live_run is None or result["order"] != live_run.number:
            return
        if result["state"] == "lost":
            self._live_run = None
            return
        live_run.seconds["simulate"] = monotonic() - live_run.begun - live_run.seconds.get("build", 0.0)
        live_run.state, live_run.message = result["state"], result.get("message", "")
        live_run.traceback = result.get("traceback", "")
        if result.get("killed"):
            # The judge reads the final state from this file.
            status = {"state": live_run.state, "message": live_run.message}
            write_json(live_run.folder / "status.json", status)
        if live_run.unwanted:
            self._live_run = None
            return
        if live_run.state not in ENDED_WELL:
            self._listener.trouble(f"{live_run.state.replace('_', ' ')}: {live_run.message}", live_run.blame())
        if result.get("killed") and not self.engine.hopeless:
            self._listener.status("the engine is restarted")
