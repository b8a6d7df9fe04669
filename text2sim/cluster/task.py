"""Tasks: what they are, what they need, and what came of them."""

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
TRIES = 3
"""How often a task is begun whose worker is lost."""
PACKAGE = "text2sim."


@dataclass(frozen=True)
class Needs:
    """What a task occupies while it runs."""

    cores: float = 1.0
    memory: int = 1_500_000_000
    """Resident memory [bytes]."""
    gpu: float = 0.0
    seconds: float | None = None
    """Wall time [s] that it will take, if that is known."""


@dataclass(frozen=True)
class Task:
    """A function of ours that is called somewhere else, with a `TaskPlace` and with arguments."""

    function: str
    """`text2sim.folder.module:function`; it returns what JSON can hold. A result with `again: true` may come out
    otherwise another time (a time limit, a request to stop), and is not kept."""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    """What JSON can hold."""
    label: str = ""
    needs: Needs = Needs()
    inputs: Mapping[str, Path] = field(default_factory=dict)
    """Files or folders that it reads, by name."""
    output: Path | None = None
    """Folder into which it writes; what lies there already stays."""

    def order(self, inputs: Mapping[str, Any], output: Any) -> dict[str, Any]:
        """Return the task as data for a worker."""
        return {"function": self.function, "arguments": dict(self.arguments), "inputs": inputs, "output": output}


@dataclass(frozen=True)
class Done:
    """What came of a task."""

    task: Task
    result: dict[str, Any] | None
    """What its function returned; None if it failed."""
    error: str = ""
    """Why it failed."""
    tries: int = 1
    seconds: float = 0.0
    """Wall time [s] of the last try."""
    worker: str = ""
    """Where it ran; empty if its result was there already."""
    machine: bool = False
    """Whether it failed for want of something that the machine lacks."""

    @property
    def stopped(self) -> bool:
        """Whether it did not run, or not to its end, because somebody asked to stop."""
        return self.error == STOPPED


@dataclass
class TaskPlace:
    """What a function that runs as a task finds where it runs."""

    inputs: dict[str, Path]
    output: Path
    stop: Stop
    """Counts requests to stop."""
    runner: "Runner"
    """Runs programs, in an engine that stays warm if the worker has one."""


def call(order: Mapping[str, Any], place: TaskPlace) -> dict[str, Any]:
    """Call the function of a task.

    Raises:
        ValueError: if it is none of ours.
    """
    module, _, name = str(order["function"]).partition(":")
    if not module.startswith(PACKAGE):
        raise ValueError(f"{module} is no module of text2sim")
    function: Callable[..., dict[str, Any]] = getattr(import_module(module), name)
    return function(place, **order["arguments"])


def key_of(order: Mapping[str, Any], code: str) -> str:
    """Return the digest of all that the result of a task depends on.

    Args:
        order: The task; its inputs are digests.
        code: Digest of our own code.
    """
    parts = [order["function"], order["arguments"], order["inputs"], code]
    return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
