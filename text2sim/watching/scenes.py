"""Background packing of recordings into scenes of the page, also during simulations."""

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
"""Number of the live run, digest of the film, and digest of the judgement; the latter is empty until it is judged."""
MIN_PAUSE = 0.3
"""Smallest time [s] between scenes during a simulation."""
MIN_PAUSE_FACTOR = 3.0
"""Smallest pause after a scene during a simulation, in multiples of the time that packing took."""


@dataclass(frozen=True)
class Packed:
    """A scene, or why there is none."""

    key: Key
    whole: bool
    """Whether the simulation had ended."""
    scene: bytes
    """JSON in the page's format; empty if there is none."""
    message: str
    seconds: float
    """Time that packing took."""


class Scenes:
    """Packs one scene at a time; puts it into the inbox."""

    def __init__(self, inbox: "queue.Queue[object]") -> None:
        self._inbox = inbox
        self._busy = False
        self._due = 0.0
        self.whole: Packed | None = None
        """The last scene of a finished simulation."""

    def pack(self, key: Key, folder: Path, case: "Case", *, whole: bool) -> None:
        """Pack the recording of a take, unless packing is in progress, was done, or it is too early.

        Args:
            key: Key of the scene.
            folder: Folder of the take.
            case: The case.
            whole: Whether its simulation has ended.
        """
        if self._busy or (self.whole is not None and self.whole.key == key) or (not whole and monotonic() < self._due):
            return
        self._busy = True
        threading.Thread(target=self._pack_scene, args=(key, folder, case, whole), name="scene", daemon=True).start()

    def receive(self, packed: Packed) -> None:
        """Receive a scene from the inbox."""
        self._busy = False
        if packed.whole:
            self.whole, self._due = packed, 0.0
        else:
            self._due = monotonic() + max(MIN_PAUSE, MIN_PAUSE_FACTOR * packed.seconds)

    def _pack_scene(self, key: Key, folder: Path, case: "Case", whole: bool) -> None:
        from text2sim.replay.page import pack_scene
        from text2sim.runtime.internal_errors import internal_error_message

        begun, scene, message = monotonic(), b"", ""
        try:
            contents, blob = pack_scene(folder, case)
            scene = f'{{"contents":{contents},"blob":{json.dumps(blob)}}}'.encode()
        except RunError as error:
            message = str(error)
        except Exception as error:
            message = internal_error_message(error)
        self._inbox.put(Packed(key, whole, scene, message, monotonic() - begun))
