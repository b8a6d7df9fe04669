"""Reading in a child process: results, refusals, limits."""

import os
from pathlib import Path
from typing import Any

import pytest

from text2sim.assets import confined as module
from text2sim.assets.confined import call_confined
from text2sim.spec_schema.errors import AssetError


def read(path: Path, wish: str) -> tuple[int, int]:
    """What a reader may do."""
    if wish == "refuse":
        raise AssetError("is not to be read")
    if wish == "hoard":
        return len(bytearray(40 * 1024**3)), 0
    if wish == "die":
        os.abort()
    if wish == "spin":
        while True:
            pass
    return path.stat().st_size, os.getpid()


@pytest.fixture(autouse=True)
def found_by_a_child(monkeypatch: Any) -> None:
    monkeypatch.setattr(read, "__module__", "tests.assets.test_confined")


def test_a_small_file_is_read_here_and_a_large_one_elsewhere(tmp_path: Path) -> None:
    path = tmp_path / "mesh.obj"
    path.write_bytes(b"x" * 100)
    assert call_confined(read, path, "") == (100, os.getpid())
    path.write_bytes(b"x" * (module.MAX_LOCAL_SIZE + 1))
    size, process = call_confined(read, path, "")
    assert size == module.MAX_LOCAL_SIZE + 1
    assert process != os.getpid()


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ("refuse", "is not to be read"),
        ("hoard", "needs more than 4 GB"),
        ("die", "crashes the library that works on it (signal 6"),
    ],
)
def test_a_reader_that_fails_is_a_refusal(tmp_path: Path, wish: str, words: str) -> None:
    (tmp_path / "mesh.obj").write_bytes(b"")
    with pytest.raises(AssetError) as refused:
        call_confined(read, tmp_path / "mesh.obj", wish, large=True)
    assert words in str(refused.value)


def test_a_reader_that_takes_for_ever_is_stopped(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.setattr(module, "WALL_TIME_FACTOR", 0.04)
    (tmp_path / "mesh.obj").write_bytes(b"")
    with pytest.raises(AssetError, match="takes more than"):
        call_confined(read, tmp_path / "mesh.obj", "spin", large=True)
