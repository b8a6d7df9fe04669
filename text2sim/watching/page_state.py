"""State of the page, and the scenes that it loads."""

import json
import threading
from typing import Any


class PageState:
    """A record that the session changes and that pages follow."""

    def __init__(self, **content: Any) -> None:
        self._content: dict[str, Any] = {**content, "scene": None}
        self._scenes: dict[str, bytes] = {}
        self._version = 0
        self._changed = threading.Condition()
        self._closed = False

    def show(self, **changes: Any) -> None:
        """Change members of the state."""
        with self._changed:
            if any(self._content.get(key, ...) != value for key, value in changes.items()):
                self._content |= changes
                self._notify()

    def show_scene(self, name: str, live_run: str, scene: bytes, *, whole: bool) -> None:
        """Show a new scene; the previous one is kept for pages that are still loading it.

        Args:
            name: Name of the scene, which must be new.
            live_run: The simulation.
            scene: The scene in the page's format.
            whole: Whether its simulation has ended.
        """
        with self._changed:
            before = (self._content["scene"] or {}).get("name")
            self._scenes = {key: value for key, value in self._scenes.items() if key == before} | {name: scene}
            self._content["scene"] = {"name": name, "take": live_run, "whole": whole}
            self._notify()

    def scene(self, name: str) -> bytes | None:
        """Return a scene, if it is still kept."""
        with self._changed:
            return self._scenes.get(name)

    def read(self) -> tuple[int, str]:
        """Return the version of the state, and the state as JSON."""
        with self._changed:
            return self._version, json.dumps(self._content, allow_nan=False)

    def follow(self, version: int, timeout: float) -> tuple[int, str] | None:
        """Wait for another version than `version`, at most `timeout` [s]; None if there is none."""
        with self._changed:
            self._changed.wait_for(lambda: self._version != version or self._closed, timeout)
            return None if self._version == version else self.read()

    def close(self) -> None:
        """End all waiting pages."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    @property
    def closed(self) -> bool:
        """Whether the state will not change any more."""
        return self._closed

    def _notify(self) -> None:
        self._version += 1
        self._changed.notify_all()
