"""A program in a process of its own, with limits on time, memory and log."""

import os
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from pathlib import Path
from threading import Thread
from time import monotonic
from typing import IO, Literal

import psutil

from text2sim.assets.confined import SECRET_WORDS
from text2sim.runtime import kernel_cache
from text2sim.runtime.stop import Stop

POLL_INTERVAL = 0.1
"""Time [s] between checks of the child."""
MEMORY_POLL = 0.5
"""Time [s] between checks of its memory, which cost more."""

# Variables that a program needs to find its engine, caches and devices. It gets no others: an environment holds keys
# and addresses that a generated program must not see.
_KEPT_VARIABLES = frozenset(
    "PATH HOME USER LOGNAME SHELL LANG LANGUAGE TZ TMPDIR TEMP TMP DISPLAY WAYLAND_DISPLAY XAUTHORITY "
    "LD_LIBRARY_PATH PYTHONPATH PYTHONHOME PYOPENGL_PLATFORM VIRTUAL_ENV MPLCONFIGDIR "
    "SYSTEMROOT SYSTEMDRIVE WINDIR COMSPEC PATHEXT APPDATA LOCALAPPDATA PROGRAMDATA USERPROFILE".split()
)
_KEPT_PREFIXES = (
    "LC_ XDG_ QD_ GS_ CUDA_ NVIDIA_ NV_ HIP_ ROCR_ ROCM_ HSA_ DYLD_ EGL_ __EGL_ __GLX_ LIBGL_ MESA_ GALLIUM_ "
    "LP_ VK_ OMP_ MKL_ OPENBLAS_ NUMBA_ TORCH_ PYTORCH_ CONDA_"
).split()
# With this prefix, Linux kills a program when the thread that started it dies, for whatever reason. (What `prctl` sets
# survives `exec`; 1 is PR_SET_PDEATHSIG. Running Python between fork and exec is not safe with threads.)
_MORTAL = """\
import ctypes, os, sys
ctypes.CDLL(None).prctl(1, 9)
if os.getppid() == int(sys.argv[1]):
    os.execv(sys.argv[2], sys.argv[2:])
"""
THREADS = 1
"""Threads of numeric libraries. Sums depend on it: with another number, fem bodies are 0.1 mm off after 0.3 s."""


@dataclass(frozen=True)
class Limits:
    """What a program may use."""

    timeout: float = 3600.0
    """Wall time [s]."""
    patience: float = inf
    """Expected wall time [s] from which a simulation is stopped as soon as its speed is known."""
    memory: int | None = None
    """Resident memory [bytes] of the program and all its children; `free_memory` if None."""
    grace: float = 20.0
    """Time [s] that a program has to save its results, once it is asked to stop."""
    log: int = 20_000_000
    """Size [bytes] of the log; a longer one loses its middle."""


@dataclass(frozen=True)
class ChildExit:
    """How a program ended."""

    cause: Literal["ended", "timeout", "memory", "stopped"]
    """`ended` by itself, or why we ended it."""
    code: int
    """Exit code; negative is the signal that killed it."""
    wall: float
    """How long it ran [s]."""
    peak_memory: int
    """Largest resident memory [bytes] seen."""
    memory_limit: int
    """Memory that it was allowed [bytes]."""
    log_left_out: int
    """Bytes that did not fit into the log."""


def child_environment(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the part of an environment that a program gets: without keys, tokens and secrets."""
    kept = {
        name: value
        for name, value in environment.items()
        if (name.upper() in _KEPT_VARIABLES or name.upper().startswith(tuple(_KEPT_PREFIXES)))
        and not any(word in name.upper() for word in SECRET_WORDS)
    }
    return kept | {
        **dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), str(THREADS)),
        "PYTHONHASHSEED": "0",
        "PYTHONUNBUFFERED": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
        "PYTHONIOENCODING": "utf-8",
        # A crash in native code then leaves the Python line in the log.
        "PYTHONFAULTHANDLER": "1",
    }


def dying_with_parent(command: Sequence[str]) -> tuple[str, ...]:
    """Return a command, which begins with the path of a program, so that it dies with us, if the system can do that."""
    if sys.platform != "linux":
        return tuple(command)
    return sys.executable, "-I", "-S", "-c", _MORTAL, str(os.getpid()), *command


def default_memory() -> int:
    """Return 85 % of the memory [bytes] of this machine, or of its container."""
    total = psutil.virtual_memory().total
    for path in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        with suppress(OSError, ValueError):  # no such file, or the word `max`
            total = min(total, int(Path(path).read_text()))
    return int(0.85 * total)


def free_memory() -> int:
    """Return 85 % of the memory [bytes] that nothing uses now, and at most `default_memory`.

    A program beside others must not take all that there is: the machine would read its files anew at every step.
    """
    return min(default_memory(), int(0.85 * psutil.virtual_memory().available))


def run_child(
    command: Sequence[str],
    *,
    folder: Path,
    log: Path,
    limits: Limits,
    stop: Stop,
    on_poll: Callable[[], bool | None],
    inherit: Sequence[int] = (),
) -> ChildExit:
    """Run a command until it ends, or exceeds a limit.

    It gets a session of its own, so that Ctrl-C in a terminal reaches only us and we decide what it means. If we are
    killed, it dies too, since nobody would enforce its limits.

    Args:
        command: What to run; the first word is a path.
        folder: Its working directory.
        log: Where its output goes, appended.
        limits: What it may use.
        stop: Requests to stop: the first asks it to stop, the second kills it.
        on_poll: Called about ten times a second; if it returns true, the command is stopped as for a timeout.
        inherit: File descriptors that it keeps open (the lock of its run).
    """
    memory_limit = limits.memory or free_memory()
    kernel_cache.unlock()
    with log.open("ab", buffering=0) as sink:
        process = subprocess.Popen(
            dying_with_parent(command),
            cwd=folder,
            env=child_environment(os.environ),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            pass_fds=tuple(inherit) if os.name == "posix" else (),
        )
        assert process.stdout is not None
        pump = _Pump(process.stdout, sink, limits.log)
        watch = _Watch(process, limits, memory_limit)
        try:
            while not watch.ended(stop):
                if on_poll():
                    watch.give_up()
        finally:
            # Also if the listener fails, and for grandchildren that outlive the program.
            watch.kill()
            process.wait()
            left_out = pump.finish()
        on_poll()
    return ChildExit(watch.cause, process.returncode, watch.wall, watch.peak, memory_limit, left_out)


class _Watch:
    """Keeps a process within its limits."""

    def __init__(self, process: subprocess.Popen[bytes], limits: Limits, memory_limit: int) -> None:
        self.cause: Literal["ended", "timeout", "memory", "stopped"] = "ended"
        self.peak = 0
        self._process = process
        self._limits = limits
        self._memory_limit = memory_limit
        self._begun = monotonic()
        self._kill_at = float("inf")
        self._memory_at = self._begun

    @property
    def wall(self) -> float:
        """Time [s] since it began."""
        return monotonic() - self._begun

    def ended(self, stop: Stop) -> bool:
        """Wait a moment; return whether the process is gone."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=POLL_INTERVAL)
            return True
        now = monotonic()
        if now >= self._memory_at:
            self._memory_at = now + MEMORY_POLL
            used = _tree_memory(self._process.pid)
            self.peak = max(self.peak, used)
            if used > self._memory_limit:
                self.cause = "memory"
                self.kill()  # no grace: saving results needs memory too
        if self.cause == "ended":
            if stop.count:
                self._ask("stopped", signal.SIGINT, now)
            elif now - self._begun > self._limits.timeout:
                self._ask("timeout", signal.SIGTERM, now)
        if stop.count > 1 or now > self._kill_at:
            self.kill()
        return False

    def give_up(self) -> None:
        """End it as if its time were over."""
        if self.cause == "ended":
            self._ask("timeout", signal.SIGTERM, monotonic())

    def _ask(self, cause: Literal["timeout", "stopped"], number: signal.Signals, now: float) -> None:
        self.cause = cause
        self._kill_at = now + self._limits.grace
        with suppress(OSError, ValueError):
            self._process.send_signal(number)

    def kill(self) -> None:
        """End the process and everything that it started."""
        kill_group(self._process)


def kill_group(process: subprocess.Popen[bytes]) -> None:
    """End a process that has a session of its own, and everything that it started."""
    if os.name == "posix":
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    else:
        with suppress(psutil.Error):
            for child in psutil.Process(process.pid).children(recursive=True):
                child.kill()
        process.kill()


def _tree_memory(pid: int) -> int:
    total = 0
    with suppress(psutil.Error):
        parent = psutil.Process(pid)
        for process in (parent, *parent.children(recursive=True)):
            with suppress(psutil.Error):
                total += process.memory_info().rss
    return total


class _Pump:
    """Moves output into the log: its beginning, and its end, which tells the reason of a failure."""

    def __init__(self, source: IO[bytes], sink: IO[bytes], limit: int) -> None:
        self._source = source
        self._sink = sink
        self._head = limit - limit // 10
        self._tail_limit = limit // 10
        self._tail: deque[bytes] = deque()
        self._tail_size = 0
        self._left_out = 0
        self._failed = False
        self._thread = Thread(target=self._run, name="log", daemon=True)
        self._thread.start()

    def finish(self) -> int:
        """Write the end of the log; return how many bytes are left out."""
        self._thread.join(timeout=5.0)
        if self._left_out:
            self._write(b"\n[... %d bytes left out ...]\n" % self._left_out)
        for block in tuple(self._tail):
            self._write(block)
        return self._left_out

    def _run(self) -> None:
        # Reads until the source ends: a full pipe would block the program.
        while block := os.read(self._source.fileno(), 1 << 16):
            if self._head > 0:
                self._write(block[: self._head])
                block, self._head = block[self._head :], self._head - len(block)
            if block:
                self._tail.append(block)
                self._tail_size += len(block)
            while self._tail_size > self._tail_limit:
                dropped = len(self._tail.popleft())
                self._tail_size -= dropped
                self._left_out += dropped
        self._source.close()

    def _write(self, block: bytes) -> None:
        if self._failed:
            return
        try:
            self._sink.write(block)
        except OSError:  # the disk is full: the run itself may still end well
            self._failed = True
