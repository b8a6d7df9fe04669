"""Entry point for running tasks, in a local pool or on a Ray cluster."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from text2sim.cluster.task import Done, Task
from text2sim.runtime.stop import Stop


@dataclass(frozen=True)
class Placement:
    """Where tasks run: in a pool on this machine, or on a Ray cluster if its address is given."""

    workers: int = 1
    """Workers of the local pool."""
    ray: str = ""
    """Address of a Ray cluster, for `ray.init`."""
    store: str = ""
    """Shared store of its nodes: a folder, or a URL that fsspec supports."""
    warm: bool = True
    """Whether workers keep their engines warm."""


def capacity(where: Placement) -> int:
    """Return the number of one-core tasks that run at once.

    Raises:
        MachineError: if Ray is not installed, or no cluster answers at `where.ray`.
    """
    if not where.ray:
        return where.workers
    from text2sim.cluster.ray_pool import connect

    return connect(where.ray)


def run_tasks(tasks: Sequence[Task], where: Placement, stop: Stop) -> Iterator[Done]:
    """Run tasks, and yield the result of each as soon as it is known.

    Args:
        tasks: The tasks.
        where: Where they run.
        stop: Requests to stop.

    Raises:
        RunError: if the store cannot be used.
        MachineError: if Ray is not installed, or no cluster answers at `where.ray`.
    """
    if not tasks:
        return
    if where.ray:
        from text2sim.cluster.ray_pool import run_ray

        yield from run_ray(tasks, where.ray, where.store, stop, warm=where.warm)
    else:
        from text2sim.cluster.pool import run_local

        yield from run_local(tasks, where.workers, stop, warm=where.warm)
