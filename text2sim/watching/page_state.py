"""What the page shows, and the films that it plays."""

import json
import threading
from typing import Any


class PageState:
    """A record that the session changes and that pages follow."""

    def __init__(self, **content: Any) -> None:
        self._content: dict[str, Any] = {**content, "films": []}
        self._films: dict[str, bytes] = {}
        self._cameras: list[str] = []
        self._version = 0
        self._changed = threading.Condition()
        self._closed = False

    def show(self, **changes: Any) -> None:
        """Change what is shown."""
        with self._changed:
            if any(self._content.get(key, ...) != value for key, value in changes.items()):
                self._content |= changes
                self._notify()

    def show_film(self, camera: str, name: str, film: bytes) -> None:
        """Show a film under a name that none had before; pages may still be reading the one that it replaces."""
        with self._changed:
            rows: list[dict[str, str]] = self._content["films"]
            kept = {row["name"] for row in rows} | {name}
            self._films = {key: value for key, value in (self._films | {name: film}).items() if key in kept}
            rows = [*(row for row in rows if row["camera"] != camera), {"camera": camera, "name": name}]
            self._show_films(rows)

    def keep_cameras(self, cameras: list[str]) -> None:
        """Say which cameras there are, in order; films of others go."""
        with self._changed:
            self._cameras = cameras
            self._show_films(self._content["films"])

    def film(self, name: str) -> bytes | None:
        """Return a film, if it is still there."""
        with self._changed:
            return self._films.get(name)

    def read(self) -> tuple[int, str]:
        """Return the version of what is shown, and it as JSON."""
        with self._changed:
            return self._version, json.dumps(self._content, allow_nan=False)

    def follow(self, version: int, timeout: float) -> tuple[int, str] | None:
        """Wait for another version than `version`; None if there is none within `timeout` [s]."""
        with self._changed:
            self._changed.wait_for(lambda: self._version != version or self._closed, timeout)
            return None if self._version == version else self.read()

    def close(self) -> None:
        """Let all pages go."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    @property
    def closed(self) -> bool:
        """Whether nothing more will be shown."""
        return self._closed

    def _show_films(self, rows: list[dict[str, str]]) -> None:
        rows = [row for row in rows if row["camera"] in self._cameras]
        rows.sort(key=lambda row: self._cameras.index(row["camera"]))
        if rows != self._content["films"]:
            self._content["films"] = rows
            self._notify()

    def _notify(self) -> None:
        self._version += 1
        self._changed.notify_all()
