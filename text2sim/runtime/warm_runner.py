"""Runs programs one after the other in a warm engine, where `run_program` starts a process for each."""

import queue
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from text2sim.compiler.provenance import provenance
from text2sim.runtime.child import ChildExit, Limits, default_memory
from text2sim.runtime.outcome import EXIT_DIVERGED, Outcome
from text2sim.runtime.program import Finished, ProgressRelay, run_program
from text2sim.runtime.progress import Clock
from text2sim.runtime.stop import Stop
from text2sim.runtime.warm_engine import Engine
from text2sim.spec_schema.errors import EngineError

POLL_INTERVAL = 0.05
"""Time [s] between checks of progress and requests to stop."""
MAX_ENGINE_MEMORY = 3_000_000_000
"""Resident memory [bytes] above which a new engine replaces the old one."""
SHUTDOWN_TIME = 10.0
"""Time [s] that the engine has to save the kernels that it compiled."""
EXIT_CODES = {"finished": 0, "diverged": EXIT_DIVERGED}


class WarmRunner:
    """Runs programs; the second builds in a fraction of a second.

    Args:
        folder: Where the engine's log goes.
    """

    def __init__(self, folder: Path) -> None:
        self._inbox: queue.Queue[Any] = queue.Queue()
        self._engine = Engine(folder, self._inbox, MAX_ENGINE_MEMORY, live=False)
        self._started, self._orders = False, 0

    def start(self) -> None:
        """Start the engine, unless it has started, so that the first program finds it ready."""
        if not self._started:
            self._started = True
            self._engine.start()

    def __call__(
        self,
        folder: Path,
        *,
        flags: tuple[str, ...],
        limits: Limits,
        stop: Stop,
        clock: Clock,
        inherit: tuple[int, ...] = (),
    ) -> Finished:
        """Run a program, as `run_program` does. Films and runs on a GPU get processes of their own."""
        rest: dict[str, Any] = {"limits": limits, "stop": stop, "clock": clock, "inherit": inherit}
        if "--film-only" in flags or "--backend" in flags:
            return run_program(folder, flags=flags, **rest)
        done = self._simulate(folder.resolve(), limits, stop, clock)
        if "--no-film" in flags or done.outcome.state not in EXIT_CODES:
            return done
        film = run_program(folder, flags=("--film-only",), **rest)
        why = film.outcome.film_message or film.outcome.message
        return replace(done, outcome=replace(done.outcome, film_message=why), no_film=film.no_film)

    def close(self) -> None:
        """End the engine, if it was ever started."""
        if not self._started:
            return
        self._engine.end()
        until = monotonic() + SHUTDOWN_TIME
        while monotonic() < until and not self._engine.ended:
            sleep(POLL_INTERVAL)
        self._engine.kill()

    def _simulate(self, folder: Path, limits: Limits, stop: Stop, clock: Clock) -> Finished:
        engine, program = self._engine, folder / "program"
        relay = ProgressRelay(folder / "progress.jsonl", clock, stop, limits)
        engine.limit, engine.peak = limits.memory or default_memory(), 0
        clock.enter("start")
        begun = monotonic()
        with stop.gently():
            result = self._carry_out(program, folder, limits.timeout, stop, clock, relay)
        relay.poll()
        text = engine.problem
        with (folder / "log.txt").open("a", encoding="utf-8") as log:
            log.write(text)
        state, message = result["state"], result.get("message", "")
        if state == "timeout" and relay.hopeless_because:
            message = relay.hopeless_because
        blame = provenance(program, result.get("traceback", "")) if state == "failed" else None
        ended = ChildExit(
            "stopped" if state == "interrupted" else "ended",
            EXIT_CODES.get(state, 1), monotonic() - begun, engine.peak, engine.limit, 0,
        )  # fmt: skip
        return Finished(Outcome(state, relay.simulated, message), ended, blame, "")

    def _carry_out(
        self, program: Path, out: Path, timeout: float, stop: Stop, clock: Clock, relay: ProgressRelay
    ) -> dict[str, Any]:
        """Let the engine simulate a program, and return its result.

        Raises:
            EngineError: if it does not start.
        """
        engine = self._engine
        self.start()
        self._orders += 1
        precision = "64" if 'precision="64"' in (program / "scene.py").read_text("utf-8") else "32"
        sent, result = False, None
        while result is None:
            if engine.hopeless:
                raise EngineError(f"the engine does not start: {engine.words}")
            if not sent and stop.count:
                return {"state": "interrupted", "message": "stopped on request"}
            if not sent and engine.idle and engine.fits(precision):
                clock.enter("build")
                engine.simulate(self._orders, program, out, timeout)
                sent = True
            with suppress(queue.Empty):
                news = self._inbox.get(timeout=POLL_INTERVAL)
                result = engine.receive(news.child, news.data)
            result = result or engine.guard()
            if relay.poll() and engine.job is not None:
                engine.job.overdue = True
                engine.cancel()
            if stop.count:
                engine.cancel()
            if stop.count > 1:
                engine.kill()
        return result
