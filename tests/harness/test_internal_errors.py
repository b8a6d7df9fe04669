"""What is kept of an error of ours: readable, whatever the home folder is."""

from pathlib import Path

import pytest

from text2sim.runtime.internal_errors import internal_error_message, keep_details


def test_paths_of_a_home_that_is_the_root_stay(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    error = ValueError(f"{tmp_path}/a/b")
    monkeypatch.setenv("HOME", "/")
    assert f"{tmp_path}/a/b" in Path(keep_details(error)).read_text()
    monkeypatch.setenv("HOME", str(tmp_path))
    assert "~/a/b" in Path(keep_details(error)).read_text()


def test_without_a_home_an_error_is_told_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere() -> Path:
        raise RuntimeError("could not determine home directory")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", nowhere)
    assert internal_error_message(ValueError("odd")).endswith("ValueError: odd")
