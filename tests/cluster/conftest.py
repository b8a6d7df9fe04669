"""Workers that can also call functions of these tests."""

import os
from pathlib import Path

import pytest

from text2sim.cluster import pool


@pytest.fixture
def open_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the pool's workers call what `open_worker.py` has."""
    monkeypatch.setattr(pool, "MODULE", "open_worker")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ["PYTHONPATH"]]))
