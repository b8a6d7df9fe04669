"""Sessions over a case in a folder of its own."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from watched import CASE, Watched


@pytest.fixture
def watch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Watched]]:
    """Return a function that begins to watch a case; it takes the text and the options of the session."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    begun: list[Watched] = []

    def begin(text: str = CASE, **options: object) -> Watched:
        begun.append(Watched(tmp_path, text, **options))
        return begun[-1].start()

    yield begin
    for watched in begun:
        if not watched.stops:
            watched.stop()
