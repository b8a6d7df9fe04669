"""Packs recordings for the page in the background, also while they are still being made."""

import json
import queue
import threading
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from text2sim.spec_schema.errors import RunError

if TYPE_CHECKING:
    from text2sim.spec_schema.models.case import Case

Key = tuple[int, str, str]
"""Number of the take, digest of how it is filmed, and digest of how it was judged; empty before that."""
PAUSE = 0.3
"""Time [s] between two scenes of a recording that is being made, at least."""
SHARE = 3.0
"""How many times as long as a scene took to pack nothing is packed after it, while the simulation goes on."""


@dataclass(frozen=True)
class Packed:
    """A scene, or why there is none."""

    key: Key
    whole: bool
    """Whether the recording had ended."""
    scene: bytes
    """As the page reads it, in JSON; empty if there is none."""
    message: str
    seconds: float
    """How long it took."""


class Scenes:
    """Packs one scene at a time; puts it into the inbox."""

    def __init__(self, inbox: "queue.Queue[object]") -> None:
        self._inbox = inbox
        self._busy = False
        self._due = 0.0
        self.whole: Packed | None = None
        """The scene that was packed last of a recording that had ended."""

    def pack(self, key: Key, folder: Path, case: "Case", *, whole: bool) -> None:
        """Pack what lies in a folder, unless something is being packed, or this was, or it is too early for more.

        Args:
            key: What of.
            folder: Of the take.
            case: As it is judged.
            whole: Whether its recording has ended.
        """
        if self._busy or (self.whole is not None and self.whole.key == key) or (not whole and monotonic() < self._due):
            return
        self._busy = True
        threading.Thread(target=self._work, args=(key, folder, case, whole), name="scene", daemon=True).start()

    def receive(self, packed: Packed) -> None:
        """Receive what was packed."""
        self._busy = False
        if packed.whole:
            self.whole, self._due = packed, 0.0
        else:
            self._due = monotonic() + max(PAUSE, SHARE * packed.seconds)

    def _work(self, key: Key, folder: Path, case: "Case", whole: bool) -> None:
        from text2sim.replay.page import pack_scene
        from text2sim.runtime.trouble import told

        begun, scene, message = monotonic(), b"", ""
        try:
            contents, blob = pack_scene(folder, case)
            scene = f'{{"contents":{contents},"blob":{json.dumps(blob)}}}'.encode()
        except RunError as error:
            message = str(error)
        except Exception as error:
            message = told(error)
        self._inbox.put(Packed(key, whole, scene, message, monotonic() - begun))
