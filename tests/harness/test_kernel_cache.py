"""The cache of compiled kernels, as runs find it."""

import os
import sys
from pathlib import Path
from time import time

import pytest

from text2sim.runtime import kernel_cache
from text2sim.runtime.child import Limits, run_child
from text2sim.runtime.stop import Stop


@pytest.mark.parametrize(("age", "left"), [(kernel_cache.STALE_LOCK_AGE + 5, False), (5.0, True)])
def test_a_lock_that_was_left_behind_is_removed_before_a_program_starts(
    age: float, left: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With it the engine would compile all kernels anew, run by run."""
    monkeypatch.setenv("QD_OFFLINE_CACHE_FILE_PATH", str(tmp_path / "kernels"))
    lock = tmp_path / "kernels" / "kernel_compilation_manager" / "qdcache.lock"
    lock.parent.mkdir(parents=True)
    lock.touch()
    os.utime(lock, (time() - age, time() - age))
    run_child(
        (sys.executable, "-c", "pass"), folder=tmp_path, log=tmp_path / "log.txt", limits=Limits(timeout=60.0),
        stop=Stop(), on_poll=lambda: False,
    )  # fmt: skip
    assert lock.exists() is left
    assert kernel_cache.is_warm()


def test_no_cache_is_no_trouble(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QD_OFFLINE_CACHE_FILE_PATH", str(tmp_path / "nowhere"))
    kernel_cache.unlock()
    assert not kernel_cache.is_warm()
