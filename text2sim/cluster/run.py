"""Where tasks run: the one way in, for whoever has some."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from text2sim.cluster.task import Done, Task
from text2sim.runtime.stop import Stop


@dataclass(frozen=True)
class Where:
    """Where tasks run: in a pool on this machine, or on a Ray cluster if its address is given."""

    workers: int = 1
    """Of the local pool."""
    ray: str = ""
    """Address of a Ray cluster, as `ray.init` takes it."""
    store: str = ""
    """What its nodes share: a folder, or a URL that fsspec knows."""
    warm: bool = True
    """Whether workers keep their engines warm."""


def slots(where: Where) -> int:
    """Return how many tasks of one core run there at once.

    Raises:
        MachineError: if there is no such cluster.
    """
    if not where.ray:
        return where.workers
    from text2sim.cluster.ray_pool import connect

    return connect(where.ray)


def run_tasks(tasks: Sequence[Task], where: Where, stop: Stop) -> Iterator[Done]:
    """Carry tasks out, and yield what comes of each as soon as it is known.

    Args:
        tasks: The tasks.
        where: Where they run.
        stop: Ends those in progress; no others begin.

    Raises:
        RunError: if the store cannot be used.
        MachineError: if there is no such cluster.
    """
    if not tasks:
        return
    if where.ray:
        from text2sim.cluster.ray_pool import run_ray

        yield from run_ray(tasks, where.ray, where.store, stop, warm=where.warm)
    else:
        from text2sim.cluster.pool import run_local

        yield from run_local(tasks, where.workers, stop, warm=where.warm)
