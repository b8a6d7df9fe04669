"""Journal of a loop: an append-only file, and those who watch it."""

import json
from collections.abc import Callable
from pathlib import Path
from threading import Lock
from typing import Any, Protocol

from text2sim.spec_schema.whole_files import naming, write_atomically

Listener = Callable[[str, dict[str, Any]], None]


class Emit(Protocol):
    """Tells of something that happened."""

    def __call__(self, event: str, /, *, live: bool = False, **what: Any) -> None:
        """Tell of it; what is only `live` is shown and not kept, because it would not be the same a second time."""


class Journal:
    """One line of JSON for each thing that happened.

    A loop that is started again does the same things again, out of what it kept. Those are in the file already and are
    not written twice.

    Args:
        file: Where it is kept.
        listener: Told of everything.
    """

    def __init__(self, file: Path, listener: Listener = lambda event, what: None) -> None:
        self._file, self._listener = file, listener
        self._known = _lines(file)
        self._lock = Lock()
        file.parent.mkdir(parents=True, exist_ok=True)

    def __call__(self, event: str, /, *, live: bool = False, **what: Any) -> None:
        """Tell of something."""
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
    rows = text.splitlines(keepends=True)
    if rows and not rows[-1].endswith("\n"):
        # A kill in the middle of a line: it is cut off, and written again when its turn comes.
        write_atomically(file, "".join(rows[:-1]))
        rows = rows[:-1]
    return [row.rstrip("\n") for row in rows]
