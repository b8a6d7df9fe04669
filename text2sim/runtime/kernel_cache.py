"""Cache of compiled kernels, which the engine keeps for all programs of a user."""

import os
from contextlib import suppress
from pathlib import Path
from time import time

from text2sim.spec_schema.whole_files import user_cache

STALE_LOCK_AGE = 120.0
"""Age [s] at which a lock counts as abandoned: the engine holds it for seconds, while it reads or writes the index."""


def cache_folder() -> Path:
    """Return where the engine keeps compiled kernels."""
    if chosen := os.environ.get("QD_OFFLINE_CACHE_FILE_PATH"):
        return Path(chosen).absolute()
    return user_cache() / "quadrants" / "qdcache"


def is_warm() -> bool:
    """Return whether the engine has compiled anything on this machine before."""
    with suppress(OSError):
        return any(cache_folder().iterdir())
    return False


def unlock() -> None:
    """Remove the lock of an engine that was killed while it held it.

    Nobody else does, and as long as it is there, every run compiles all of its kernels again, for minutes.
    """
    for lock in cache_folder().glob("**/qdcache.lock"):
        with suppress(OSError):  # another process was faster
            if time() - lock.stat().st_mtime > STALE_LOCK_AGE:
                lock.unlink()
