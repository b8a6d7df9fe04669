"""One process per run folder: a lock that the system releases when its holders are dead."""

import os
from pathlib import Path

import psutil

from text2sim.spec_schema.errors import MachineError

if os.name == "posix":
    import fcntl
else:
    import msvcrt


class RunLock:
    """Holds a run folder for this process, and for the program that inherits `fileno`.

    The system locks an open file, until the last process that has it open ends: no lock of dead processes stays
    behind, and a program that outlives us still keeps others off its folder. The file itself stays: to delete a file
    that others may be about to lock would let two in.

    Args:
        runs: Folder of run folders; the lock is in `.locks` of it.
        name: Name of the run folder.
        done: What its holder does to it: `run`, `built`.
    """

    def __init__(self, runs: Path, name: str, done: str = "run") -> None:
        self._path = runs / ".locks" / name
        self._name, self._done = name, done
        self._descriptor: int | None = None

    @property
    def fileno(self) -> int:
        """The descriptor that a child process keeps open."""
        assert self._descriptor is not None
        return self._descriptor

    def __enter__(self) -> "RunLock":
        self._path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o644)
        if not _try_lock(descriptor):
            holder = os.read(descriptor, 100).decode("ascii", "replace").strip()
            os.close(descriptor)
            raise MachineError(f"{self._name} is being {self._done} by {_holder_text(holder)}; wait for it, or end it")
        os.truncate(descriptor, 0)
        os.write(descriptor, f"{os.getpid()}\n".encode())
        self._descriptor = descriptor
        return self

    def __exit__(self, *_: object) -> None:
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None


def _holder_text(holder: str) -> str:
    if not holder.isdecimal() or len(holder) > 9:  # no number of a process
        return "another text2sim"
    if psutil.pid_exists(int(holder)):
        return f"another text2sim (process {holder})"
    return f"a program that outlived its text2sim (process {holder}, which is gone)"


def _try_lock(descriptor: int) -> bool:
    try:
        if os.name == "posix":
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            # Beyond the end, so that others can still read whose lock it is.
            os.lseek(descriptor, 1 << 20, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
            os.lseek(descriptor, 0, os.SEEK_SET)
    except OSError:
        return False
    return True
