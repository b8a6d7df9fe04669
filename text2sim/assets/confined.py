"""Files of strangers, read in a process of its own within limits of memory and time: a hostile one can end only that.

    python -m text2sim.assets.confined MODULE FUNCTION

The arguments come in and the result goes out as pickles, between two processes of ours.
"""

import pickle
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from text2sim.spec_schema.errors import AssetError

R = TypeVar("R")
SMALL = 64 * 1024
"""Bytes of a file that is read here: to begin a process takes longer than to read it, whatever is in it."""
SECONDS, MEMORY = 40, 4 * 1024**3
"""Processor time [s] and memory [bytes] that reading may take: a sound file of 64 MiB takes 5 s and 0.5 GB."""
PATIENCE = 3 * SECONDS
"""Wall time [s] of the same, on a machine that does other things as well."""


def confined(function: Callable[..., R], path: Path, *args: Any, large: bool = False) -> R:
    """Return what a function of a module says of a file, called in a process of its own unless the file is small.

    Args:
        function: Takes the path, and what follows it here.
        path: The file.
        args: What else it takes.
        large: Whether there is much in the file, however few its bytes are.

    Raises:
        AssetError: if the function does, or if it takes more than it may, or brings the process down.
    """
    if not large and path.stat().st_size <= SMALL:
        return function(path, *args)
    from text2sim.assets.meshes import environment

    command = [sys.executable, "-P", "-m", __name__, function.__module__, function.__name__]
    try:
        done = subprocess.run(
            command, input=pickle.dumps((path, *args)), env=environment(), capture_output=True, timeout=PATIENCE,
            check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise AssetError(f"takes more than {PATIENCE} s to read: make it simpler") from None
    if done.returncode == -24:  # SIGXCPU, which not every system names
        raise AssetError(f"takes more than {SECONDS} s to read: make it simpler")
    if done.returncode:
        how = f"signal {-done.returncode}" if done.returncode < 0 else f"exit {done.returncode}"
        said = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
        raise AssetError(f"brings its reader down ({', '.join([how, *said])[:200]})")
    result, refusal = pickle.loads(done.stdout)
    if refusal is not None:
        raise AssetError(refusal)
    return result


def _main(module: str, name: str) -> None:
    limit()
    args = pickle.load(sys.stdin.buffer)
    result: Any = None
    refusal = None
    try:
        result = getattr(import_module(module), name)(*args)
    except AssetError as error:
        refusal = str(error)
    except MemoryError:
        refusal = f"cannot be read: it needs more than {MEMORY // 1024**3} GB of memory"
    sys.stdout.buffer.write(pickle.dumps((result, refusal)))


def limit() -> None:
    """Bound memory and time of this process, where the system can."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    except (ImportError, OSError, ValueError):
        pass


if __name__ == "__main__":
    _main(*sys.argv[1:])
