"""A process that takes orders and sends news, both as lines of JSON."""

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psutil

import text2sim
from text2sim.runtime import kernel_cache
from text2sim.runtime.child import child_environment, dying_with_parent

MAX_LINE_LENGTH = 100_000
"""Longest line of news that is read [characters]."""
MAX_LOG_SIZE = 2_000_000
"""Size [bytes] at which a new log is begun."""


@dataclass(frozen=True)
class News:
    """A message of a process; the last one is `died` with its exit code."""

    child: "Child"
    data: dict[str, Any]


class Child:
    """A process of ours in a session of its own, so that Ctrl-C in a terminal reaches only us.

    It ends when its input ends, so it cannot outlive us; on Linux it dies with the thread that started it.

    Args:
        name: Name of the thread that listens to it.
        module: What it runs.
        arguments: Its arguments.
        log: Where its errors go, appended.
        inbox: Where its news goes.
        whole_environment: Whether it gets the whole environment, keys included: only for code of ours.
    """

    def __init__(
        self,
        name: str,
        module: str,
        arguments: Sequence[str],
        log: Path,
        inbox: "queue.Queue[Any]",
        *,
        whole_environment: bool = False,
    ) -> None:
        self.name = name
        kernel_cache.unlock()
        environment = dict(os.environ) if whole_environment else child_environment(os.environ)
        # The package may be in a folder that only our own interpreter knows.
        home = str(Path(text2sim.__file__).resolve().parent.parent)
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [home, environment.get("PYTHONPATH", "")]))
        if log.is_file() and log.stat().st_size > MAX_LOG_SIZE:
            log.unlink()
        with log.open("ab") as sink:
            self._process = subprocess.Popen(
                dying_with_parent([sys.executable, "-P", "-m", module, *arguments]),
                cwd=log.parent,
                env=environment,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=sink,
                text=True,
                encoding="utf-8",
                errors="replace",
                start_new_session=True,
            )
        self._inbox = inbox
        threading.Thread(target=self._listen, name=name, daemon=True).start()

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    def send(self, **order: Any) -> None:
        """Send an order; a dead process loses it."""
        assert self._process.stdin is not None
        with suppress(OSError, ValueError):
            self._process.stdin.write(json.dumps(order) + "\n")
            self._process.stdin.flush()

    def memory(self) -> int:
        """Return the resident memory [bytes]; 0 if it is gone."""
        try:
            return psutil.Process(self._process.pid).memory_info().rss
        except psutil.Error:
            return 0

    def processor_time(self) -> float:
        """Return the processor time [s] that it has used; 0 if it is gone."""
        try:
            used = psutil.Process(self._process.pid).cpu_times()
        except psutil.Error:
            return 0.0
        return float(used.user + used.system)

    def end(self) -> None:
        """Let it end by itself, so that it saves the kernels that it compiled."""
        assert self._process.stdin is not None
        with suppress(OSError, ValueError):
            self._process.stdin.close()

    @property
    def has_ended(self) -> bool:
        """Whether it has ended."""
        return self._process.poll() is not None

    def kill(self) -> None:
        """End it, now."""
        self._process.kill()
        self._process.wait()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in iter(lambda: self._process.stdout.readline(MAX_LINE_LENGTH), ""):  # type: ignore[union-attr]
            with suppress(ValueError):
                data = json.loads(line)
                if isinstance(data, dict):
                    self._inbox.put(News(self, data))
        self._inbox.put(News(self, {"died": self._process.wait()}))
