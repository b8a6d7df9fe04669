"""The commands `text2sim cards`: lessons from failures, with runs that demonstrate them."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer

from text2sim.cli.learned_cards import distill_cards, show_ledger
from text2sim.cli.options import AsJson
from text2sim.cli.output import say, say_json, say_problems
from text2sim.runtime.progress import duration_text
from text2sim.service import exits
from text2sim.service.phrases import display_path

if TYPE_CHECKING:
    from text2sim.card_library.library import CardLibrary
    from text2sim.card_library.retrieval import Match
    from text2sim.card_library.verify import Verdict

cards = typer.Typer(
    help="Debug Cards: lessons from failures that were reproduced and repaired.",
    no_args_is_help=True,
)
MAX_JOBS = 16


@cards.command("list")
def list_cards(as_json: AsJson = False) -> None:
    """List the cards, one line for each: id, lesson, role, signature of the failure."""
    library = _library()
    if as_json:
        say_json(
            {"cards": [_card_as_data(entry) for entry in library.entries.values()], "problems": _problems(library)}
        )
    else:
        say(library.index())
        _say_problems(library)
    raise typer.Exit(exits.INPUT if library.problems else exits.OK)


@cards.command("show")
def show_card(
    name: Annotated[str, typer.Argument(metavar="ID", help="The card.")],
    as_json: AsJson = False,
) -> None:
    """Print a card and the paths of its two cases."""
    from text2sim.card_library.model import count_tokens

    entry = _library().find(name)
    if as_json:
        say_json(_card_as_data(entry))
        return
    card = entry.card
    applies = card.applies
    say(f"{card.brief()}\n")
    say(f"for: {', '.join(applies.roles)}; modes: {', '.join(applies.modes)}; tags: {', '.join(applies.tags)}")
    say(f"shows as: {'; '.join(applies.signatures)}")
    say(f"failing:  {display_path(entry.failing)}  ({card.evidence.failing.outcome})")
    say(f"repaired: {display_path(entry.repaired)}  ({card.evidence.repaired.outcome})")
    versions = ", ".join(f"{name} {version}" for name, version in card.evidence.measured_on.items())
    say(f"about {count_tokens(card.brief())} tokens; measured on {versions}")


@cards.command("find")
def find(
    text: Annotated[str, typer.Argument(help="The task or the failure, in words.")],
    role: Annotated[str, typer.Option("--role", help="Only cards for this role.")] = "",
    modes: Annotated[list[str] | None, typer.Option("--mode", help="A physical mode of the scene.")] = None,
    signatures: Annotated[
        list[str] | None,
        typer.Option("--signature", help="A finding of the lint or the run: the id of a rule, `diverged`, a phrase."),
    ] = None,
    limit: Annotated[int, typer.Option("--limit", min=1, max=100, help="Largest number of cards.")] = 6,
    as_json: AsJson = False,
) -> None:
    """Find the cards that fit a task or a failure."""
    from text2sim.card_library.model import Mode, Role
    from text2sim.card_library.retrieval import find_cards

    _check_choices([role] if role else [], get_args(Role), "--role")
    _check_choices(modes or [], get_args(Mode), "--mode")
    library = _library()
    options: dict[str, Any] = {"role": role or None, "modes": modes or (), "signatures": signatures or ()}
    found = find_cards(library, text=text, limit=limit, **options)
    if as_json:
        say_json({"matches": [_match_as_data(match) for match in found]})
        return
    for match in found:
        say(f"{match.score:5.2f}  {match.entry.card.index_line()}")
    if not found:
        say("no card fits", to=sys.stderr)


@cards.command("verify")
def verify(
    names: Annotated[list[str] | None, typer.Argument(metavar="[ID]...", help="The cards; all if left out.")] = None,
    runs: Annotated[Path, typer.Option("--runs", help="Folder of run folders.")] = Path("runs/cards"),
    jobs: Annotated[int, typer.Option("--jobs", min=1, max=MAX_JOBS, help="Number of cards at a time.")] = 1,
    timeout: Annotated[float, typer.Option("--timeout", min=1.0, help="Wall time in seconds for each case.")] = 300.0,
    lint_only: Annotated[
        bool, typer.Option("--lint-only", help="Run nothing; compare only the lint's findings.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Simulate again even if nothing changed.")] = False,
    as_json: AsJson = False,
) -> None:
    """Run the failing and the repaired case of cards, and compare the outcomes with those stated in the cards."""
    from text2sim.card_library.verify import verify_cards

    library = _library()
    entries = [library.find(name) for name in dict.fromkeys(names)] if names else list(library.entries.values())
    width = max((len(entry.id) for entry in entries), default=0)
    rows: list[Verdict] = []
    options: dict[str, Any] = {"runs": runs, "jobs": jobs, "timeout": timeout}
    for verdict in verify_cards(entries, simulate=not lint_only, force=force, **options):
        rows.append(verdict)
        if not as_json:
            _say_verdict(verdict, width)
    complete = len(rows) == len(entries)
    # An unreadable card has no id that could select it: it counts if all cards are verified.
    problems = [] if names else _problems(library)
    agreed = sum(verdict.ok for verdict in rows)
    if as_json:
        document = {"ok": complete and agreed == len(rows) and not problems, "problems": problems}
        say_json(document | {"cards": [verdict.as_dict() for verdict in rows]})
    else:
        say(f"{agreed} of {len(entries)} cards hold" + ("" if complete else "; stopped before the end"))
        if not names:
            _say_problems(library)
    code = exits.OK if agreed == len(rows) else exits.PHYSICS
    raise typer.Exit(exits.INTERRUPTED if not complete else exits.INPUT if problems else code)


def _library() -> "CardLibrary":
    from text2sim.card_library.library import load_library

    return load_library()


def _check_choices(given: list[str], allowed: tuple[str, ...], option: str) -> None:
    for word in given:
        if word not in allowed:
            raise typer.BadParameter(f"`{word}` is not one of {', '.join(allowed)}", param_hint=f"'{option}'")


def _card_as_data(entry: Any) -> dict[str, Any]:
    from text2sim.card_library.model import count_tokens

    document = entry.card.model_dump(mode="json")
    tokens = count_tokens(entry.card.brief())
    return document | {"folder": str(entry.folder), "tokens": tokens}


def _match_as_data(match: "Match") -> dict[str, Any]:
    card = match.entry.card
    return {
        "id": card.id,
        "title": card.title,
        "score": match.score,
        "signatures": list(match.signatures),
        "modes": list(match.modes),
        "words": match.words,
        "roles": list(card.applies.roles),
    }


def _problems(library: "CardLibrary") -> list[dict[str, Any]]:
    return [problem.as_dict() for problem in library.problems]


def _say_problems(library: "CardLibrary") -> None:
    say_problems(library.problems, {})


def _say_verdict(verdict: "Verdict", width: int) -> None:
    word = "ok" if verdict.ok else "FAIL"
    outcomes = f"{verdict.failing} -> {verdict.repaired}"
    say(f"{word:<4}  {verdict.id:<{width}}  {outcomes}  ({duration_text(verdict.wall)})")
    if verdict.message:
        say(f"      {verdict.message}")


cards.command("distill")(distill_cards)
cards.command("ledger")(show_ledger)
