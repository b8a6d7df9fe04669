"""Distillation of Debug Cards from a finished loop: a failure and its repair, both simulated."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from text2sim import __version__
from text2sim.agents.conversation import Conversation, Wrong, typed_parser
from text2sim.agents.replies import Answer
from text2sim.agents.roles import ROLES, system_prompt
from text2sim.agents.yaml_text import yaml_text
from text2sim.card_library.library import CARD_FILE, FAILING, REPAIRED, check_card
from text2sim.card_library.model import card_schema
from text2sim.revision.revise import revise
from text2sim.spec_schema.changes.patch import PatchError
from text2sim.spec_schema.errors import RunError, SpecError
from text2sim.spec_schema.text.source import Source
from text2sim.spec_schema.whole_files import write_atomically

MAX_CARDS = 3
"""Largest number of cards from one loop."""


class CardProposal(Answer):
    """A proposed card, with the attempts that it comes from."""

    failing: int
    repaired: int | None = None
    """None if no attempt fixed the failure; then `repair` does."""
    expect: list[dict[str, Any]] = []
    """RFC 6902, for both cases: adds an expectation that detects the failure, if the attempts lack one."""
    repair: list[dict[str, Any]] = []
    """RFC 6902, for the failing case, applied after `expect`."""
    card: dict[str, Any]


class Proposals(Answer):
    """Answer of the Distiller."""

    cards: Annotated[list[CardProposal], Field(max_length=MAX_CARDS)] = []


@dataclass(frozen=True)
class CardDraft:
    """A draft of a card, with its failing and its repaired case."""

    data: dict[str, Any]
    failing: str
    repaired: str

    def write(self, folder: Path) -> None:
        """Write the three files of the card, `card.yaml` last, because a folder without it is not a card."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self._files().items():
            write_atomically(folder / name, text)

    def fits(self, folder: Path) -> bool:
        """Whether the folder has no file of another card; files of this card may remain from a full disk."""
        files = self._files()
        there = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
        return there <= files.keys() and all((folder / name).read_bytes() == files[name].encode() for name in there)

    def _files(self) -> dict[str, str]:
        return {FAILING: self.failing, REPAIRED: self.repaired, CARD_FILE: yaml_text(self.data) + "\n"}


@dataclass(frozen=True)
class TriedAttempt:
    """A finished attempt, read from disk."""

    number: int
    text: str
    record: Mapping[str, Any]

    @property
    def outcome(self) -> str | None:
        """Its outcome in the terms of a card; None if a card has no term for it."""
        if self.record["state"] == "diverged":
            return "state:diverged"
        if self.record["state"] != "finished":
            return None
        missed = [name for name, row in self.record["expect"].items() if row["ok"] is not True]
        return f"missed:{missed[0]}" if missed else "passed"


def attempts_of(case: Path) -> dict[int, TriedAttempt]:
    """Return the attempts in a case folder, by number; those with damaged files are left out."""
    found = {}
    for folder in sorted((case / "generation" / "attempts").glob("[0-9][0-9]*")):
        try:
            record = json.loads((folder / "attempt.json").read_text("utf-8"))
            attempt = TriedAttempt(int(folder.name), (folder / "case.yaml").read_text("utf-8"), record)
            _attempt_text(attempt, attempt)  # fails if a field that is needed is missing
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            continue
        found[attempt.number] = attempt
    return found


def distill(chat: Conversation, case: Path, out: Path) -> list[str]:
    """Ask for cards, check them, and write them.

    Args:
        chat: The conversation with the models.
        case: The case folder of a finished loop.
        out: Output folder.

    Returns:
        Ids of the written cards; `text2sim cards verify` runs them.

    Raises:
        RunError: If the loop has no failed and no passed attempt, or the folder of a card exists already.
    """
    attempts = attempts_of(case)
    outcomes = {attempt.outcome for attempt in attempts.values()} - {None}
    if "passed" not in outcomes or len(outcomes) < 2:
        raise RunError(
            f"{case}: there is nothing to learn: it needs one attempt that failed in a run, and one that passed"
        )
    drafts: list[CardDraft] = []

    def check(answer: Proposals) -> None:
        wrong = []
        drafts.clear()
        for proposal in answer.cards:
            try:
                drafts.append(draft_card(proposal, attempts))
            except Wrong as error:
                wrong += error.reasons
        if len({draft.data["id"] for draft in drafts}) < len(drafts):
            wrong.append("/cards: each needs an `id` of its own")
        if wrong:
            raise Wrong(wrong)

    chat.ask(
        "distiller",
        system_prompt(ROLES["distiller"], form=proposal_template()),
        attempts_text(attempts),
        typed_parser(Proposals, check),
    )
    folders = {out / str(draft.data["id"]): draft for draft in drafts}
    for folder, draft in folders.items():
        if not draft.fits(folder):
            raise RunError(f"{folder} exists already")
    for folder, draft in folders.items():
        draft.write(folder)
    return [folder.name for folder in folders]


def draft_card(proposal: CardProposal, attempts: Mapping[int, TriedAttempt]) -> CardDraft:
    """Turn a proposal into a draft, checked as far as possible without running it.

    Outcomes of attempts are filled in from the record; those of patched cases are claims until `card_library.verify`
    runs them.

    Raises:
        Wrong: If the proposal is not a valid card.
    """
    failed, passed, where = attempts.get(proposal.failing), None, f"card of attempt {proposal.failing}"
    if proposal.repaired is not None:  # it may be 0, the case as it was
        passed = attempts.get(proposal.repaired)
        where = f"card of attempts {proposal.failing} and {proposal.repaired}"
    patched = bool(proposal.expect or proposal.repair)
    if failed is None or (passed is None and proposal.repaired is not None):
        raise Wrong([f"{where}: there are attempts {', '.join(map(str, attempts))}"])
    if passed is None and not proposal.repair:
        raise Wrong([f"{where}: it needs `repaired`, an attempt, or `repair`, a patch"])
    if not patched and passed is not None:
        if failed.outcome in (None, "passed"):
            raise Wrong([f"{where}: attempt {failed.number} did not fail in a run"])
        if passed.outcome != "passed":
            raise Wrong([f"{where}: attempt {passed.number} did not pass"])
    failing = _patched(failed.text, proposal.expect, f"{where}: /expect")
    repaired = _patched(passed.text, proposal.expect, f"{where}: /expect") if passed is not None else failing
    repaired = _patched(repaired, proposal.repair, f"{where}: /repair")
    given = proposal.card.get("evidence")
    evidence = dict(given) if isinstance(given, dict) else {}
    for key, attempt in (("failing", failed), ("repaired", passed)):
        row = evidence.get(key)
        fact = {} if patched or attempt is None else {"outcome": attempt.outcome}
        evidence[key] = (dict(row) if isinstance(row, dict) else {}) | fact
    evidence["measured_on"] = {"text2sim": __version__, "genesis-world": version("genesis-world")}
    draft = CardDraft({**proposal.card, "evidence": evidence}, failing, repaired)
    try:
        check_card(yaml_text(draft.data), failing=failing, repaired=repaired)
    except SpecError as error:
        raise Wrong([f"{where}: {problem.path}: {problem.message}" for problem in error.problems[:8]]) from None
    return draft


def _patched(text: str, operations: list[dict[str, Any]], where: str) -> str:
    if not operations:
        return text
    try:
        return revise(Source(text, "case.yaml"), Path("case.yaml"), operations).text
    except PatchError as error:
        raise Wrong([f"{where}: {error}"]) from None
    except SpecError as error:
        raise Wrong([f"{where}: {problem.path}: {problem.message}" for problem in error.problems[:4]]) from None


def attempts_text(attempts: Mapping[int, TriedAttempt]) -> str:
    """Return the history of a loop as text, attempt by attempt."""
    return "\n\n".join(_attempt_text(attempt, attempts.get(attempt.number - 1)) for attempt in attempts.values())


def _attempt_text(attempt: TriedAttempt, previous: TriedAttempt | None) -> str:
    record = attempt.record
    parts = [f"# Attempt {attempt.number}: {record['cause']}", f"Outcome: {attempt.outcome or record['state']}"]
    if previous is None or not record["changes"]:  # those of the first attempt at an existing case are not recorded
        parts.append(f"```yaml\n{attempt.text.strip()}\n```")
    else:
        parts.append("Changed since the one before:\n" + "\n".join(f"- {line}" for line in record["changes"]))
    rows = [f"- `{name}`: wanted {row['wanted']}; {row['why']}" for name, row in record["expect"].items()]
    parts.append("\n".join(rows))
    critique = record.get("critique") or {}
    parts.append("\n".join(f"- Critic: {failure['what']}" for failure in critique.get("failures", ())))
    return "\n\n".join(part for part in parts if part)


def proposal_template() -> str:
    """Return the template of a proposal."""
    schema = json.dumps(card_schema(), ensure_ascii=False, separators=(",", ":"))
    return f"  - {{failing: 1, repaired: 2, card: {{…}}}}      # card: as this JSON Schema says\n# {schema}"
