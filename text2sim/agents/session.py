"""Session: a loop on disk, with request, models and progress, so that it can be resumed after any interruption.

CASE/case.yaml                     the best version
CASE/generation/request.json       request, models and budget
CASE/generation/calls/             every finished call of a model
CASE/generation/attempts/NN/       every version: case, evidence, judgement
CASE/generation/journal.jsonl      all events, in order
CASE/generation/run.json           outcome and cost
CASE/runs/                         the simulations
"""

import json
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from itertools import count
from pathlib import Path
from typing import Any, Literal

from text2sim.agents.conversation import Conversation
from text2sim.agents.existing_case import amend
from text2sim.agents.inputs import add_inputs, copy_input, describe_assets, probe_joints
from text2sim.agents.journal import Journal, Listener
from text2sim.agents.loop import AgentLoop
from text2sim.agents.loop_result import LoopLimits, LoopOutcome
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.models.endpoint import Endpoint
from text2sim.agents.models.endpoint import endpoint_of as _endpoint_of
from text2sim.agents.models.exchange import Image
from text2sim.agents.offered_cards import OfferedCards
from text2sim.agents.planning import Request
from text2sim.agents.roles import ROLES
from text2sim.agents.yaml_text import yaml_text
from text2sim.recording.run_files import read_json
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.text.source import plain_text
from text2sim.spec_schema.whole_files import write_atomically, write_json

Kind = Literal["generate", "repair", "edit"]
MAX_REQUEST_LENGTH = 100_000
"""Longest request [characters]; every Writer reads it."""
LARGEST_IMAGE = 4_000_000
"""Largest picture of a request [bytes]."""
IMAGES = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg"}


@dataclass
class SessionWish:
    """Request, models and budget of a session."""

    kind: Kind
    text: str
    models: dict[str, str]
    """Model by role; "" for all other roles."""
    attempts: int = 30
    tokens: int | None = None
    cost: float | None = None
    minutes: float | None = None
    sim_timeout: float = 3600.0
    cards: bool = True
    images: list[str] = field(default_factory=list)
    """Names of files in `generation/inputs`."""
    inputs: list[str] = field(default_factory=list)
    """Names of assets in the case's manifest."""
    base: str = ""
    """Text of the existing case that is to be changed."""
    style: bool = False
    """Whether the best film of the final case is searched for."""
    planned_minutes: float | None = None
    """`minutes` when the session began. The Planner is told these, so that a session that is resumed with more time
    sends the same prompts and repeats no finished call."""


class Session:
    """The loop of one case folder."""

    def __init__(self, case: Path, wish: SessionWish) -> None:
        self.case, self.wish, self.folder = case, wish, case / "generation"
        self.account = Account()

    @classmethod
    def begin(
        cls, case: Path, wish: SessionWish, images: list[Path], assets: list[Path], licence: str = ""
    ) -> "Session":
        """Begin a session; its input files are repaired, checked and registered as assets of the case.

        An edit or repair may follow a loop that has ended, whose records are kept as `generation.1` and so on.

        Args:
            case: The folder.
            wish: Request, models and budget.
            images: Pictures that belong to the request.
            assets: Meshes and mechanisms.
            licence: Licence of these files.

        Raises:
            RunError: If another loop has used this folder, or an input cannot be used.
        """
        over = _begun(case) and wish.kind != "generate" and _is_over(case)
        if _begun(case) and not over:
            raise RunError(
                f"{case}: agents have worked here already; continue with `--resume`, or choose another folder"
            )
        wish.text = plain_text(wish.text)
        if not wish.text.strip():
            raise RunError("the request is empty")
        wish.planned_minutes = wish.minutes
        if len(wish.text) > MAX_REQUEST_LENGTH:
            raise RunError(f"the request has {len(wish.text):,} characters, and may have {MAX_REQUEST_LENGTH:,}")
        for file in images:
            if file.suffix.lower() not in IMAGES or not file.is_file():
                raise RunError(f"{file}: a picture is a .png or .jpg file")
            if file.stat().st_size > LARGEST_IMAGE:
                raise RunError(f"{file}: larger than {LARGEST_IMAGE / 1e6:g} MB")
        for file in assets:
            if not file.is_file():
                raise RunError(f"{file}: there is no such file")
        case.mkdir(parents=True, exist_ok=True)
        if over:
            (case / "generation").rename(
                next(free for k in count(1) if not (free := case / f"generation.{k}").exists())
            )
        wish.images = [copy_input(file, case / "generation" / "inputs").name for file in images]
        wish.inputs = add_inputs(case, [*assets, *images], licence)
        (case / "generation").mkdir(exist_ok=True)
        text = json.dumps(asdict(wish), indent=1, ensure_ascii=False) + "\n"  # not strict: a limit may be infinite
        write_atomically(case / "generation" / "request.json", text)
        return cls(case, wish)

    @classmethod
    def resume(cls, case: Path) -> "Session":
        """Resume an interrupted session.

        Raises:
            RunError: If there is nothing to resume.
        """
        file = case / "generation" / "request.json"
        try:
            written = json.loads(file.read_text("utf-8"))
            return cls(case, SessionWish(**{"planned_minutes": written.get("minutes"), **written}))
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise RunError(f"{file}: there is nothing to resume ({error})") from None

    def run(
        self, listener: Listener, stop: Callable[[], bool] = lambda: False, *, prewarm: bool = False
    ) -> LoopOutcome:
        """Run the loop to its end.

        Args:
            listener: Called with every event.
            stop: Polled; returns whether to give up.
            prewarm: Whether to start the engine while the Writers still write the first version.

        Raises:
            MachineError: If this machine cannot run simulations.
            KeyboardInterrupt: If the user stopped it.
        """
        wish = self.wish
        budget = Budget(wish.tokens, wish.cost, wish.minutes, minutes_before=self._minutes_before())

        def report(event: str, what: dict[str, Any]) -> None:
            if event in ("planned", "ran", "judged", "decided"):
                self._write(loop, offered, None, budget)  # a kill must not refund the minutes used
            listener(event, what)

        journal = Journal(self.folder / "journal.jsonl", report)
        endpoints = {role: endpoint_of(spec, self.case) for role, spec in wish.models.items()}
        chat = Conversation(endpoints, CallLog(self.folder / "calls"), self.account, budget, journal, stop)
        offered = OfferedCards(_library() if wish.cards else None, journal)
        files = [self.folder / "inputs" / name for name in wish.images]
        images = tuple(Image(file.name, IMAGES[file.suffix.lower()], file.read_bytes()) for file in files)
        probe_joints(self.case, wish.inputs, journal)
        request = Request(wish.text, images, describe_assets(self.case, wish.inputs), minutes=wish.planned_minutes)
        loop = AgentLoop(
            self.case, request, chat, offered, journal, LoopLimits(wish.attempts, wish.sim_timeout, budget.minutes_left)
        )
        loop.style, loop.prewarm = wish.style, prewarm
        outcome: LoopOutcome | None = None
        ending = "Stopped before the end; `--resume` continues."
        try:
            if wish.kind == "generate":
                outcome = loop.generate()
            else:
                outcome = amend(loop, wish.base, run_first=wish.kind == "repair")
            ending = outcome.sentence()
            return outcome
        except Exception as error:
            ending = f"Ended by an error: {error}"
            raise
        finally:
            self._write(loop, offered, outcome, budget)
            chat.close(ending)

    def _write(self, loop: AgentLoop, offered: OfferedCards, outcome: LoopOutcome | None, budget: Budget) -> None:
        best = outcome.best if outcome else None
        record = {
            "state": outcome.state if outcome else "interrupted",
            "why": outcome.why if outcome else "",
            "best": best.number if best else None,
            "unresolved": outcome.unresolved if outcome else [],
            "restated": loop.agreement.restated,
            "attempts": [
                {
                    "number": one.number,
                    "cause": one.cause,
                    "state": one.state,
                    "problems": one.problems,
                    "expect": {name: row["ok"] for name, row in one.expect.items()},
                    "verdict": (one.critique or {}).get("verdict"),
                    "score": (one.critique or {}).get("score"),
                    "run": one.run,
                }
                for one in loop.history.made
            ],
            "cards": {role: sorted(cards) for role, cards in offered.offered.items()},
            "models": self.wish.models,
            "minutes": round(budget.minutes_used, 3),
            "account": self.account.as_dict(),
        }
        write_json(self.folder / "run.json", record)
        if loop.agreement.plan.event:
            write_atomically(self.folder / "plan.yaml", yaml_text(loop.agreement.plan.model_dump(mode="json")) + "\n")

    def _minutes_before(self) -> float:
        try:
            return float(json.loads((self.folder / "run.json").read_text("utf-8"))["minutes"])
        except (OSError, ValueError, KeyError, TypeError):
            return 0.0


def endpoint_of(spec: str, case: Path) -> Endpoint:
    """Return an endpoint; `{case}` in the name of a mailbox stands for the case folder."""
    return _endpoint_of(spec.replace("{case}", str(case)))


def check_models(models: dict[str, str]) -> None:
    """Check the names of roles.

    Raises:
        RunError: If a role is unknown; the message lists the roles.
    """
    if unknown := sorted(set(models) - set(ROLES) - {""}):
        raise RunError(f"there is no role {', '.join(unknown)}; there are {', '.join(ROLES)}")


def folder_name(request: str) -> str:
    """Return the name of the folder for a request: its first words."""
    words = re.findall(r"[a-z0-9]+", request.lower())
    kept = [word for word in words if word not in ("a", "an", "the", "of", "and", "is", "are")][:5]
    return "_".join(kept)[:48] or "request"


def free_folder(parent: Path, request: str) -> Path:
    """Return an unused folder for a new request, named after its first words, and numbered if necessary."""
    first = parent / folder_name(request)
    names = (first if k == 1 else first.with_name(f"{first.name}_{k}") for k in count(1))
    return next(folder for folder in names if not (folder / "case.yaml").exists() and not _begun(folder))


def _begun(folder: Path) -> bool:
    return (folder / "generation" / "request.json").exists()


def _is_over(folder: Path) -> bool:
    record = read_json(folder / "generation" / "run.json") or {}
    return record.get("state", "interrupted") != "interrupted"


def _library() -> Any:
    from text2sim.card_library.library import load_library

    return load_library()
