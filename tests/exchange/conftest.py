"""A recorded run for all tests, and its recording."""

from pathlib import Path

import numpy as np
import pytest

from exchange.recorded import write_run


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with everything in it."""
    return write_run(tmp_path_factory.mktemp("recorded") / "run")


@pytest.fixture(scope="session")
def recorded(run: Path) -> dict[str, np.ndarray]:
    """Its states."""
    with np.load(run / "states" / "chunk_00000.npz") as chunk:
        return {name: chunk[name] for name in chunk.files}
