"""A model that answers from a script, role by role, in order; and a loop of which nothing is heard."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from threading import Lock
from typing import Any

from text2sim.agents.conversation import Conversation
from text2sim.agents.journal import Journal
from text2sim.agents.loop import AgentLoop
from text2sim.agents.loop_result import LoopLimits
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.models.endpoint import Endpoint
from text2sim.agents.models.exchange import ModelError, ModelRequest, Reply
from text2sim.agents.offered_cards import OfferedCards
from text2sim.agents.planning import Request


class Scripted:
    """Answers with the lines it was given, and keeps what it was asked."""

    name, vision, cacheable = "scripted", True, False

    def __init__(self, replies: Mapping[str, Sequence[str]]) -> None:
        self.replies, self.asked, self._count, self._lock = replies, list[ModelRequest](), Counter[str](), Lock()

    def complete(self, request: ModelRequest, stop: Callable[[], bool]) -> Reply:
        with self._lock:
            self.asked.append(request)
            number = self._count[request.role]
            self._count[request.role] += 1
        rows = self.replies.get(request.role, ())
        if number >= len(rows):
            raise ModelError(f"the script ends here: {request.role} {number + 1}")
        text = rows[number]
        return Reply(text, len(request.messages[-1].text) // 4, len(text) // 4, None, 0.0, "scripted")

    def questions(self, role: str) -> list[str]:
        """The last message of each request to a role."""
        return [request.messages[-1].text for request in self.asked if request.role == role]


def fenced(text: str) -> str:
    return f"```yaml\n{text.strip()}\n```\n"


def chat(tmp_path: Path, model: Endpoint, budget: Budget | None = None) -> Conversation:
    journal = Journal(tmp_path / "journal.jsonl")
    return Conversation({"": model}, CallLog(tmp_path / "calls"), Account(), budget or Budget(), journal)


def quiet(event: str, /, *, live: bool = False, **what: Any) -> None:
    """A callback for journal events that tells nobody."""


def quiet_loop(folder: Path, **limits: Any) -> AgentLoop:
    """A loop whose models have no answers; `limits` are those of `LoopLimits`."""
    model, offered = chat(folder, Scripted({})), OfferedCards(None, quiet)
    return AgentLoop(folder, Request("A ball falls."), model, offered, quiet, LoopLimits(**limits))
