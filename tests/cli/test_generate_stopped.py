"""What `generate` says when it is stopped."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from text2sim.cli.generate import _run_session


def test_a_stopped_loop_says_what_was_spent_and_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    account = SimpleNamespace(total=lambda: SimpleNamespace(tokens=12_345))
    session = SimpleNamespace(case=tmp_path / "cases" / "swing", run=run, account=account)
    with pytest.raises(KeyboardInterrupt):
        _run_session(session, False, "none", None)  # type: ignore[arg-type]
    assert "stopped after 12,345 tokens; `--resume cases/swing` continues" in capsys.readouterr().err
