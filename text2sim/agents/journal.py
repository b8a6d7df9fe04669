"""Journal of a loop: an append-only file and a listener."""

import json
from collections.abc import Callable
from pathlib import Path
from threading import Lock
from typing import Any, Protocol

from text2sim.spec_schema.whole_files import naming, write_atomically

Listener = Callable[[str, dict[str, Any]], None]


class Emit(Protocol):
    """Callback that reports an event."""

    def __call__(self, event: str, /, *, live: bool = False, **what: Any) -> None:
        """Report an event; a `live` one is shown but not stored, because it would differ when the loop is replayed."""


class Journal:
    """A log with one line of JSON for each event, which is also passed to a listener.

    A resumed loop repeats its events from its stored replies. Those are in the file already and are not written twice.
    """

    def __init__(self, file: Path, listener: Listener = lambda event, what: None) -> None:
        self._file, self._listener = file, listener
        self._known = _lines(file)
        self._lock = Lock()
        file.parent.mkdir(parents=True, exist_ok=True)

    def __call__(self, event: str, /, *, live: bool = False, **what: Any) -> None:
        """Report an event; see `Emit`."""
        with self._lock:
            if not live:
                self._keep(json.dumps({"event": event, **what}, ensure_ascii=False, allow_nan=False))
            self._listener(event, what)

    def _keep(self, line: str) -> None:
        if line in self._known:
            self._known.remove(line)
            return
        with naming(self._file), self._file.open("a", encoding="utf-8") as file:
            file.write(line + "\n")


def _lines(file: Path) -> list[str]:
    try:
        text = file.read_text("utf-8", "replace")
    except OSError:
        return []
    *rows, rest = text.split("\n")  # `splitlines` also splits at line separators within a text
    if rest:
        # The process was killed while writing a line. Drop it: its event will be repeated.
        write_atomically(file, text.removesuffix(rest))
    return rows
