"""The painter as the session sees it: a process that is started again if it dies, up to a point."""

import queue
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.runtime.dialogue import Child
from text2sim.watching.judging import Key
from text2sim.watching.live_run import LiveRun, Version

MODULE = "text2sim.watching.painter"
DEATHS = 3
"""Deaths in a row after which there will be no films."""


@dataclass(frozen=True)
class Shown:
    """A film that is ready."""

    key: Key
    camera: str
    path: Path
    whole: bool
    """Whether it goes to the end of the recording, or its simulation goes on."""


class Painting:
    """Films takes, one at a time; the next order ends the one before it.

    Args:
        folder: Where its log goes.
        width: Of the films [pixels].
        inbox: Where its news go.
        module: What the process runs.
    """

    def __init__(self, folder: Path, width: int, inbox: "queue.Queue[Any]", module: str = MODULE) -> None:
        self._folder, self._width, self._inbox, self._module = folder, width, inbox, module
        self._child: Child | None = None
        self._order = 0
        self._deaths = 0
        self.key: Key | None = None
        """What is being filmed, or was."""
        self.busy = False
        self.trouble = ""
        """Why there is no film."""

    def start(self) -> None:
        """Start the process, so that it is there when it is needed."""
        if self._child is None and self._deaths < DEATHS:
            self._child = Child("painter", self._module, [], self._folder / "painter.log", self._inbox)

    def film(self, take: LiveRun, version: Version) -> None:
        """Film a take, as far as it is recorded and as it goes on, the way that a version wants it filmed."""
        self.key = (take.number, version.plan.render_digest)
        self.start()
        if self._child is None:
            return  # and `trouble` says why
        self._order += 1
        self.busy, self.trouble = True, ""
        self._child.send(
            order=self._order,
            script=version.program["render.py"].decode(),
            out=str(take.folder),
            width=self._width,
            ahead=version.ahead,
            colors=version.colors,
        )

    def cancel(self) -> None:
        """Stop filming: what was wanted no longer is."""
        if self._child is not None and self.busy:
            self._child.send(cancel=self._order)
        self.busy, self.key = False, None

    def take(self, child: Child, data: dict[str, Any]) -> Shown | None:
        """Take in news; return a film that is ready."""
        if child is not self._child:
            return None
        if "died" in data:
            self._child = None
            self._deaths += 1
            if self.busy:
                self.trouble = self.trouble or "the painter crashed; painter.log says more"
                self.busy, self.key = False, self.key if self._deaths >= DEATHS else None
        elif data.get("ready") is False:
            self._deaths, self.trouble = DEATHS, data["message"]
        elif data.get("order") == self._order and self.busy:
            if "film" in data and self.key is not None:
                return Shown(self.key, data["camera"], Path(data["film"]), data.get("whole", True))
            if "frames" in data:
                self.busy, self._deaths = False, 0
                self.trouble = "" if data["frames"] else "nothing was recorded"
            if "message" in data:
                self.busy, self.trouble = False, data["message"]
        return None

    @property
    def ended(self) -> bool:
        """Whether the process is not there any more."""
        return self._child is None or self._child.gone

    def end(self) -> None:
        """Let the process end by itself."""
        if self._child is not None:
            self._child.end()

    def kill(self) -> None:
        """End the process."""
        if self._child is not None:
            self._child.kill()
