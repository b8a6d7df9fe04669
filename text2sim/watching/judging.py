"""Background judging of takes."""

import queue
import threading
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from text2sim.spec_schema.errors import RunError

if TYPE_CHECKING:
    from text2sim.spec_schema.loaded import LoadedCase

Key = tuple[int, str]
"""Number of the live run, and digest of all that its evidence depends on besides states."""


@dataclass(frozen=True)
class JudgedTake:
    """Evidence of a live run."""

    key: Key
    evidence: dict[str, Any] | None
    """As in `evidence.json`, with expectations in the order of the case; None if there was nothing to judge."""
    message: str
    """Why there is no evidence; empty if there is."""
    seconds: float
    """Time that judging took."""


class Judge:
    """Judges one live run at a time; puts the result into the inbox."""

    def __init__(self, inbox: "queue.Queue[Any]") -> None:
        self._inbox = inbox
        self._busy: Key | None = None
        self.judged: JudgedTake | None = None
        """The last result."""
        threading.Thread(target=_import, name="imports", daemon=True).start()

    def judge(self, key: Key, folder: Path, loaded: "LoadedCase") -> None:
        """Judge a live run, unless that was done, or another is being judged.

        Args:
            key: Key of the judgement.
            folder: The run folder.
            loaded: The case.
        """
        if self._busy is None and (self.judged is None or self.judged.key != key):
            self._busy = key
            threading.Thread(target=self._judge_run, args=(key, folder, loaded), name="judge", daemon=True).start()

    def receive(self, judged: JudgedTake) -> None:
        """Receive a result from the inbox."""
        self._busy, self.judged = None, judged

    def _judge_run(self, key: Key, folder: Path, loaded: "LoadedCase") -> None:
        from text2sim.evidence.evidence import judge
        from text2sim.runtime.internal_errors import internal_error_message

        begun, evidence, message = monotonic(), None, ""
        try:
            evidence = judge(folder, loaded.case, loaded)
            evidence["expect"] = {name: evidence["expect"][name] for name in loaded.case.actions.expect}
        except RunError as error:
            message = str(error)
        except Exception as error:
            message = internal_error_message(error)
        self._inbox.put(JudgedTake(key, evidence, message, monotonic() - begun))


def _import() -> None:
    import text2sim.compiler.emit
    import text2sim.evidence.evidence  # noqa: F401, takes half a second, in which the engine starts
