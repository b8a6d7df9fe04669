"""Tasks, their needs, and their results."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.runtime.stop import Stop

if TYPE_CHECKING:
    from text2sim.harness.run import Runner

STOPPED = "stopped on request"
MAX_TRIES = 3
"""Number of attempts at a task whose worker dies."""
PACKAGE = "text2sim."


@dataclass(frozen=True)
class Needs:
    """Resources that a task needs."""

    cores: float = 1.0
    memory: int = 1_500_000_000
    """Resident memory [bytes]."""
    gpu: float = 0.0
    seconds: float | None = None
    """Expected wall time [s], if that is known."""


@dataclass(frozen=True)
class Task:
    """A function of ours that a worker calls with a `TaskPlace` and arguments."""

    function: str
    """`text2sim.folder.module:function`, which returns JSON data. A result with `again: true` is not reproducible,
    because of a time limit or a request to stop, and is not reused."""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    """JSON data."""
    label: str = ""
    needs: Needs = Needs()
    inputs: Mapping[str, Path] = field(default_factory=dict)
    """Files or folders that it reads, by name."""
    output: Path | None = None
    """Folder that it writes to; existing files are kept."""

    def order(self, inputs: Mapping[str, Any], output: Any) -> dict[str, Any]:
        """Return the task as data for a worker."""
        return {"function": self.function, "arguments": dict(self.arguments), "inputs": inputs, "output": output}


@dataclass(frozen=True)
class Done:
    """Result of a task."""

    task: Task
    result: dict[str, Any] | None
    """Result of its function; None if it failed."""
    error: str = ""
    """Why it failed."""
    tries: int = 1
    seconds: float = 0.0
    """Wall time [s] of the last try."""
    worker: str = ""
    """Name of its worker; empty if the result was reused."""
    machine: bool = False
    """Whether it failed because the machine lacks something."""

    @property
    def stopped(self) -> bool:
        """Whether it did not run to its end because the user asked to stop."""
        return self.error == STOPPED


@dataclass
class TaskPlace:
    """Environment of a function that runs as a task."""

    inputs: dict[str, Path]
    output: Path
    stop: Stop
    """Requests to stop."""
    runner: "Runner"
    """Runs programs, in the worker's warm engine if it has one."""


def call_task(order: Mapping[str, Any], place: TaskPlace) -> dict[str, Any]:
    """Call the function of a task.

    Raises:
        ValueError: if it is not ours.
    """
    module, _, name = str(order["function"]).partition(":")
    if not module.startswith(PACKAGE):
        raise ValueError(f"{module} is not a module of text2sim")
    function: Callable[..., dict[str, Any]] = getattr(import_module(module), name)
    return function(place, **order["arguments"])


def key_of(order: Mapping[str, Any], code: str) -> str:
    """Return the digest of all that the result of a task depends on.

    Args:
        order: The task, with digests as inputs.
        code: Digest of our own code.
    """
    parts = [order["function"], order["arguments"], order["inputs"], code]
    return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
