"""Calls of foreign libraries, above all with untrusted files, in a child process with limits of memory and time.

    python -m text2sim.assets.confined MODULE FUNCTION SECONDS MEMORY

Arguments and result are pickles, exchanged between two of our own processes.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from text2sim.assets.inspection_child import limit_resources
from text2sim.spec_schema.errors import AssetError

R = TypeVar("R")
MAX_LOCAL_SIZE = 64 * 1024
"""Size [bytes] up to which a file is read in this process: starting another would take longer."""
PROCESSOR_LIMIT, MEMORY_LIMIT = 40, 4 * 1024**3
"""Default limits of processor time [s] and memory [bytes]: a valid file of 64 MiB takes 5 s and 0.5 GB."""
WALL_TIME_FACTOR = 3.0
"""Limit of wall time over that of processor time, for a busy machine."""
SECRET_WORDS = ("KEY", "TOKEN", "SECRET", "PASSWORD", "PASSWD", "CREDENTIAL")
"""Variables of the environment with one of these words in their names are secrets."""


def call_confined(
    function: Callable[..., R],
    path: Path,
    *args: Any,
    large: bool = False,
    seconds: int = PROCESSOR_LIMIT,
    memory: int = MEMORY_LIMIT,
) -> R:
    """Call a function of a module with a file, as `call_in_child` does unless the file is small.

    Args:
        function: Takes the path and the other arguments.
        path: The file.
        args: The other arguments.
        large: Whether to use a child process even if the file is small.
        seconds: Limit of processor time [s].
        memory: Limit of memory [bytes].

    Raises:
        AssetError: if the function raises it, exceeds the limits, or crashes its process.
    """
    if not large and path.stat().st_size <= MAX_LOCAL_SIZE:
        return function(path, *args)
    return call_in_child(function, path, *args, seconds=seconds, memory=memory)


def call_in_child(
    function: Callable[..., R], *args: Any, seconds: int = PROCESSOR_LIMIT, memory: int = MEMORY_LIMIT
) -> R:
    """Call a function of a module in a new process.

    Args:
        function: The function.
        args: Its arguments.
        seconds: Limit of processor time [s].
        memory: Limit of memory [bytes].

    Raises:
        AssetError: if the function raises it, exceeds the limits, or crashes its process.
    """
    command = [sys.executable, "-P", "-m", __name__, function.__module__, function.__name__, str(seconds), str(memory)]
    patience = WALL_TIME_FACTOR * seconds
    try:
        done = subprocess.run(
            command, input=pickle.dumps(args), env=environment_without_keys(), capture_output=True,
            timeout=patience, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise AssetError(f"takes more than {patience:.0f} s to work on: make it simpler") from None
    if done.returncode == -24:  # SIGXCPU, which not every system names
        raise AssetError(f"takes more than {seconds} s to work on: make it simpler")
    if done.returncode:
        raise AssetError(f"crashes the library that works on it ({end_of(done)})")
    result, refusal = pickle.loads(done.stdout)
    if refusal is not None:
        raise AssetError(refusal)
    return result


def environment_without_keys() -> dict[str, str]:
    """Return the environment of a child process: without keys, and with this package on its path."""
    kept = {name: value for name, value in os.environ.items() if not any(word in name.upper() for word in SECRET_WORDS)}
    return kept | {"PYTHONPATH": str(Path(__file__).resolve().parents[2])}


def end_of(done: subprocess.CompletedProcess[bytes]) -> str:
    """Return how a process ended, in words: signal or exit code, and the last line of its errors."""
    how = f"signal {-done.returncode}" if done.returncode < 0 else f"exit {done.returncode}"
    last = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
    return ", ".join([how, *last])[:200]


def _main(module: str, name: str, seconds: int, memory: int) -> None:
    limit_resources(memory, seconds)
    # Libraries may print: only the result goes to the original standard output.
    results = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    args = pickle.load(sys.stdin.buffer)
    result: Any = None
    refusal = None
    try:
        result = getattr(import_module(module), name)(*args)
    except AssetError as error:
        refusal = str(error)
    except MemoryError:
        refusal = f"needs more than {memory // 1024**3} GB of memory: make it simpler"
    with results:
        results.write(pickle.dumps((result, refusal)))


if __name__ == "__main__":
    _main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
