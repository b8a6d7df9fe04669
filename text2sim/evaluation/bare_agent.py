"""Baseline: a coding agent that writes Genesis programs by hand.

This is the only place that runs code written by a model. It runs in a child process with limits of time, memory and log
size, and without API keys in its environment (`runtime/child.py`). That is not a sandbox: the code can read and write
whatever the user can. So it runs only if the user allows it (`evaluate run --allow-code`).
"""

import os
import re
import sys
from contextlib import suppress
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from text2sim.agents.conversation import BudgetSpent, Conversation
from text2sim.agents.journal import Journal
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.models.endpoint import endpoint_of
from text2sim.agents.models.exchange import Image, Message
from text2sim.agents.models.fences import fenced_blocks, without_thoughts
from text2sim.agents.models.parsing import ReplyError, read_reply
from text2sim.agents.roles import quoted
from text2sim.card_library.library import load_library
from text2sim.card_library.retrieval import find_cards
from text2sim.evaluation.film_frames import film_frames, length_of
from text2sim.evaluation.genesis_docs import digest, docstrings_of
from text2sim.evaluation.method_folder import CaseResult, resources_of
from text2sim.evaluation.prompt_templates import render_prompt
from text2sim.recording.run_files import read_json, read_text
from text2sim.runtime.child import ChildExit, Limits, run_child
from text2sim.runtime.outcome import printable
from text2sim.runtime.stop import Stop
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.whole_files import write_atomically, write_json

if TYPE_CHECKING:
    from text2sim.evaluation.methods import Allowance

PROGRAM, FILM, LOG, ENDED = "main.py", "film.mp4", "log.txt", "ended.json"
ROUNDS_PER_ATTEMPT = 3
"""Replies for each program that may be run, including requests for documentation."""
MAX_RESENT_MESSAGES = 12
"""Latest messages that are sent again, after the first two."""
LOG_SHOWN = 6_000
"""Characters at the end of a log that the agent sees."""
SPEED = re.compile(r"\[INFO\] Running at .* FPS")
"""A line of the engine's log about its speed."""
MAX_CARDS = 6
"""Number of cards that the agent gets; they are found by the words of the prompt."""


@dataclass(frozen=True)
class ProgramTrial:
    """A finished run of a program."""

    folder: Path
    code: int
    cause: str
    wall: float
    """Wall time [s]."""
    minutes_left: float | None
    """Minutes left of the budget when it ended; None without a limit."""

    @property
    def film(self) -> Path | None:
        """Path of its film; None without one."""
        path = self.folder / FILM
        return path if path.is_file() else None

    def is_filmed(self) -> bool:
        """Whether its film can be decoded. It cannot if the program was stopped while writing it."""
        with suppress(RunError):
            return self.film is not None and length_of(self.film) > 0
        return False


class BareAgent:
    """The agent at work on one prompt.

    Args:
        place: The prompt's folder, with calls in `calls/`, programs and their output in `attempts/NN/`.
        model: The model.
        allowance: Its budget, the same as that of text2sim.
        cards: Whether it gets Debug Cards.
        minutes_before: Time used before an interruption [min].
    """

    def __init__(
        self, place: Path, model: str, allowance: "Allowance", cards: bool, minutes_before: float = 0.0
    ) -> None:
        if not model:
            raise RunError("name the model of the agent with --model")
        self._place, self._allowance, self._cards = place, allowance, cards
        self._account, self._trials = Account(), list[ProgramTrial]()
        budget = Budget(allowance.tokens, allowance.cost, allowance.minutes, minutes_before=minutes_before)
        log, journal = CallLog(place / "calls"), Journal(place / "journal.jsonl")
        self._chat = Conversation({"": endpoint_of(model)}, log, self._account, budget, journal)
        self._budget = budget

    def answer(self, name: str, prompt: str) -> CaseResult:
        """Run the agent until it is done or its budget is used up; the last program with a film counts.

        Raises:
            KeyboardInterrupt: If the user stopped it; the next start resumes it.
            ModelError: If the model cannot be reached; the next start resumes it.
        """
        why, accepted = "its attempts are spent", False
        allowed = self._allowance
        limit = allowed.sim_timeout if allowed.minutes is None else min(allowed.sim_timeout, 60 * allowed.minutes)
        limits = {"limit": limit, "minutes": allowed.minutes, "attempts": allowed.attempts, "cores": os.cpu_count()}
        messages = [
            Message("system", render_prompt("agent", **limits)),
            Message("user", render_prompt("agent_ask", prompt=prompt, docs=digest(), cards=self._deal_cards(prompt))),
        ]
        try:
            with Stop() as stop:
                for _ in range(ROUNDS_PER_ATTEMPT * allowed.attempts):
                    if len(self._trials) >= allowed.attempts:
                        break
                    reply = self._chat.reply("agent", [*messages[:2], *messages[2:][-MAX_RESENT_MESSAGES:]])
                    response, images, done = self._act(reply, stop)
                    if done:
                        why, accepted = "", True
                        break
                    # Old pictures are not sent again.
                    messages = [Message(message.role, message.text) for message in messages]
                    messages += [Message("assistant", reply), Message("user", response, images)]
        except BudgetSpent as error:
            why = str(error)
        except BaseException as error:
            why = f"ended by {str(error) or type(error).__name__}"
            raise
        finally:
            self._chat.close("Done." if accepted else f"Not done: {why}.")
        return self._result(name, why, accepted)

    def _act(self, reply: str, stop: Stop) -> tuple[str, tuple[Image, ...], bool]:
        """Carry out the actions of a reply; return the response, its images, and whether the agent is done."""
        blocks = [block for block in fenced_blocks(without_thoughts(reply)) if block.mark in ("python", "py")]
        if blocks and blocks[-1].closed:
            trial = self._run(blocks[-1].text, stop)
            return self._describe_trial(trial), self._pictures(trial), False
        if blocks:
            return "The block of Python is not closed: send the program again, whole.", (), False
        try:
            data = read_reply(reply)[0]
        except ReplyError:
            data = None
        if isinstance(data, dict) and isinstance(data.get("read"), list):
            return docstrings_of([str(name)[:80] for name in data["read"][:20]]), (), False
        if isinstance(data, dict) and data.get("done") is True and self._trials:
            return "", (), True
        return "Answer with one ```python block, or with ```yaml and `read: […]` or `done: true`.", (), False

    def _run(self, program: str, stop: Stop) -> ProgramTrial:
        """Run a program, unless it was run before an interruption."""
        folder = (self._place / "attempts" / f"{len(self._trials) + 1:02}").resolve()
        ended = read_json(folder / ENDED)
        program_digest = sha256(program.encode()).hexdigest()
        if not isinstance(ended, dict) or ended.get("program") != program_digest:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / LOG).unlink(missing_ok=True)
            write_atomically(folder / PROGRAM, program + "\n")
            left = self._budget.minutes_left()
            limit = self._allowance.sim_timeout if left is None else min(self._allowance.sim_timeout, 60 * left)
            found: ChildExit = run_child(
                (sys.executable, PROGRAM, "--out", str(folder)), folder=folder, log=folder / LOG,
                limits=Limits(timeout=max(1.0, limit)), stop=stop, on_poll=lambda: False,
            )  # fmt: skip
            ended = {"program": program_digest, "code": found.code, "cause": found.cause, "wall": round(found.wall, 1),
                     "minutes_left": self._budget.minutes_left()}  # fmt: skip
            write_json(folder / ENDED, ended)
        left = ended.get("minutes_left")
        trial = ProgramTrial(folder, int(ended["code"]), str(ended["cause"]), float(ended["wall"]), left)
        self._trials.append(trial)
        return trial

    def _describe_trial(self, trial: ProgramTrial) -> str:
        log = shown_log(read_text(trial.folder / LOG).replace(str(trial.folder), "."))
        film = "film.mp4 is there" if trial.film else "there is no film.mp4"
        try:
            film += f", frames: {film_frames(trial.film).listed()}" if trial.film else ""
        except RunError as error:
            film = str(error)
        left = self._allowance.attempts - len(self._trials)
        return render_prompt(
            "agent_ran", trial=trial, film=film, log=quoted(log[-LOG_SHOWN:]), left=left_text(left, trial)
        )

    def _pictures(self, trial: ProgramTrial) -> tuple[Image, ...]:
        if trial.film is None or not self._chat.vision("agent"):
            return ()
        try:
            return film_frames(trial.film).images
        except RunError:
            return ()

    def _deal_cards(self, prompt: str) -> str:
        if not self._cards:
            return ""
        found = find_cards(load_library(), text=prompt, limit=MAX_CARDS)
        return "\n\n".join(match.entry.card.brief() for match in found)

    def _result(self, name: str, why: str, accepted: bool) -> CaseResult:
        filmed = [trial for trial in self._trials if trial.is_filmed()]
        best = filmed[-1] if filmed else self._trials[-1] if self._trials else None
        parts = {"program": PROGRAM, "log": LOG} | ({"film": FILM} if filmed else {})
        folder = best.folder.relative_to(self._place.resolve()) if best is not None else None
        spent = {role: resources_of(asdict(account)) for role, account in self._account.by_role().items()}
        files = {part: str(folder / file) for part, file in parts.items()} if folder is not None else {}
        return CaseResult.model_validate({
            "prompt": name, "status": "failed" if best is None else "finished", "accepted": accepted,
            "why": why[:4000], "roles": spent, "attempts": len(self._trials),
            "simulation_s": sum(trial.wall for trial in self._trials), **files,
        })  # fmt: skip


def shown_log(log: str) -> str:
    """Return a log without colours, and without the engine's lines about its speed, which would push out all others."""
    return "\n".join(line for line in printable(log).splitlines() if not SPEED.search(line))


def left_text(programs: int, trial: ProgramTrial) -> str:
    """Return what is left after a trial: programs and minutes, or if these end first, what they are enough for."""
    more = f"{programs} more program{'' if programs == 1 else 's'}"
    if trial.minutes_left is None:
        return more
    time = f"{trial.minutes_left:.0f} minutes for everything" if trial.minutes_left >= 1.5 else "hardly a minute"
    enough = int(60 * trial.minutes_left / max(trial.wall, 1.0))
    if enough >= programs:
        return f"{more}, and {time}"
    return f"{time}, enough for {enough or 'no'} more that take as long as this one"
