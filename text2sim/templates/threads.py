"""Threads for kernels that treat many particles one by one; all others run on one.

Genesis 1.4.5 runs every kernel on one thread: most are too short for more, and where several add to the same number,
the result depends on who comes first.
"""

import os
from contextlib import contextmanager

from quadrants.lang import impl

MOST = 8  # threads; more wait longer for each other than they save
ENOUGH = 16000  # particles for more than one thread; with fewer, to wake them takes as long as they save


@contextmanager
def spare_threads():
    """Let the engine that is started within have threads which its own kernels do not use."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    os.environ.setdefault("QD_NUM_THREADS", str(min(cores, MOST)))
    yield
    impl.current_cfg().cpu_max_num_threads = 1


class Threads:
    """Context in which kernels use the spare threads; they must not add to the same numbers.

    Args:
        particles: Number of particles.
    """

    def __init__(self, particles):
        self.number = int(os.environ.get("QD_NUM_THREADS", "1")) if particles >= ENOUGH else 1

    def __enter__(self):
        impl.current_cfg().cpu_max_num_threads = self.number

    def __exit__(self, *_):
        impl.current_cfg().cpu_max_num_threads = 1
