"""Cards from a finished loop: what failed in it, and what mended that, both of them run."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from text2sim import __version__
from text2sim.agents.conversation import Conversation, Wrong, typed
from text2sim.agents.replies import Answer
from text2sim.agents.roles import ROLES, system_prompt
from text2sim.agents.yaml_text import yaml_text
from text2sim.card_library.library import CARD_FILE, FAILING, REPAIRED, check_card
from text2sim.card_library.model import card_schema
from text2sim.spec_schema.errors import RunError, SpecError
from text2sim.spec_schema.whole_files import write_atomically

MOST = 3
"""Cards from one loop."""


class Proposal(Answer):
    """A card, and the attempts that it comes from."""

    failing: int
    repaired: int
    card: dict[str, Any]


class Proposals(Answer):
    """What the Distiller answers."""

    cards: Annotated[list[Proposal], Field(max_length=MOST)] = []


@dataclass(frozen=True)
class Tried:
    """An attempt as a loop has left it."""

    number: int
    text: str
    record: Mapping[str, Any]

    @property
    def outcome(self) -> str | None:
        """What came of it, in the words of a card; None if nothing that a card can say."""
        if self.record["state"] == "diverged":
            return "state:diverged"
        if self.record["state"] != "finished":
            return None
        missed = [name for name, row in self.record["expect"].items() if row["ok"] is not True]
        return f"missed:{missed[0]}" if missed else "passed"


def tried(case: Path) -> list[Tried]:
    """Read what a loop has left in a case folder.

    Raises:
        RunError: If there is nothing that was both run and mended.
    """
    found = []
    for folder in sorted((case / "generation" / "attempts").glob("[0-9][0-9]*")):
        try:
            record = json.loads((folder / "attempt.json").read_text("utf-8"))
            found.append(Tried(int(folder.name), (folder / "case.yaml").read_text("utf-8"), record))
        except (OSError, ValueError, KeyError):
            continue
    outcomes = {one.outcome for one in found} - {None}
    if "passed" not in outcomes or len(outcomes) < 2:
        raise RunError(
            f"{case}: no attempt here failed in a run and was mended in another: there is nothing to learn from"
        )
    return found


def distill(desk: Conversation, case: Path, out: Path) -> list[str]:
    """Have cards proposed, check them, and write them down.

    Args:
        desk: Where the Distiller is asked.
        case: The case folder of a finished loop.
        out: The folder of cards.

    Returns:
        Ids of the cards that were written; `text2sim cards verify` runs them.
    """
    attempts = {one.number: one for one in tried(case)}
    system = system_prompt(ROLES["distiller"], form=_form())
    question = "\n\n".join(_told(one, attempts.get(one.number - 1)) for one in attempts.values())

    def check(answer: Proposals) -> None:
        wrong = [row for proposal in answer.cards for row in _faults(proposal, attempts)]
        if wrong:
            raise Wrong(wrong)

    answer: Proposals = desk.ask("distiller", system, question, typed(Proposals, check))
    written = []
    for proposal in answer.cards:
        data, bad, good = _card(proposal, attempts)
        folder = out / str(data["id"])
        if folder.exists():
            raise RunError(f"{folder} is there already")
        folder.mkdir(parents=True)
        for name, text in ((CARD_FILE, yaml_text(data) + "\n"), (FAILING, bad.text), (REPAIRED, good.text)):
            write_atomically(folder / name, text)
        written.append(str(data["id"]))
    return written


def _faults(proposal: Proposal, attempts: Mapping[int, Tried]) -> list[str]:
    where = f"card of attempts {proposal.failing} and {proposal.repaired}"
    bad, good = attempts.get(proposal.failing), attempts.get(proposal.repaired)
    if bad is None or good is None:
        return [f"{where}: there are attempts {', '.join(map(str, attempts))}"]
    if bad.outcome in (None, "passed"):
        return [f"{where}: attempt {bad.number} did not fail in a run"]
    if good.outcome != "passed":
        return [f"{where}: attempt {good.number} did not pass"]
    data, bad, good = _card(proposal, attempts)
    try:
        check_card(yaml_text(data), failing=bad.text, repaired=good.text)
    except SpecError as error:
        return [f"{where}: {problem.path}: {problem.message}" for problem in error.problems[:8]]
    return []


def _card(proposal: Proposal, attempts: Mapping[int, Tried]) -> tuple[dict[str, Any], Tried, Tried]:
    """The card with what was seen filled in by us: outcomes are facts, not opinions."""
    bad, good = attempts[proposal.failing], attempts[proposal.repaired]
    given = proposal.card.get("evidence")
    evidence = dict(given) if isinstance(given, dict) else {}
    for key, one in (("failing", bad), ("repaired", good)):
        row = evidence.get(key)
        evidence[key] = (dict(row) if isinstance(row, dict) else {}) | {"outcome": one.outcome}
    evidence["measured_on"] = {"text2sim": __version__, "genesis-world": version("genesis-world")}
    return {**proposal.card, "evidence": evidence}, bad, good


def _told(one: Tried, before: Tried | None) -> str:
    record = one.record
    parts = [f"# Attempt {one.number}: {record['cause']}", f"Outcome: {one.outcome or record['state']}"]
    if before is None:
        parts.append(f"```yaml\n{one.text.strip()}\n```")
    else:
        parts.append("Changed since the one before:\n" + "\n".join(f"- {line}" for line in record["changes"]))
    rows = [f"- `{name}`: wanted {row['wanted']}; {row['why']}" for name, row in record["expect"].items()]
    parts.append("\n".join(rows))
    critique = record.get("critique") or {}
    parts.append("\n".join(f"- Critic: {failure['what']}" for failure in critique.get("failures", ())))
    return "\n\n".join(part for part in parts if part)


def _form() -> str:
    schema = json.dumps(card_schema(), ensure_ascii=False, separators=(",", ":"))
    return f"  - {{failing: 1, repaired: 2, card: {{…}}}}      # card: as this JSON Schema says\n# {schema}"
