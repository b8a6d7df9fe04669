"""The commands `text2sim cards distill` and `cards ledger`: learned cards, their sources and their effects."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from text2sim.agents.journal import Journal
from text2sim.cli.evaluate import MethodOptions
from text2sim.cli.options import AsJson, with_options
from text2sim.cli.output import say, say_json
from text2sim.runtime.stop import Stop
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError, SpecError, Text2SimError

if TYPE_CHECKING:
    from text2sim.evaluation.methods import Allowance

HELD_OUT = "demonstrations"
"""The suite whose sources must not be learned from."""


@with_options(MethodOptions)
def distill_cards(
    case: Annotated[
        Path | None, typer.Argument(metavar="[CASE]", help="A case folder in which agents have worked.")
    ] = None,
    suite: Annotated[Path | None, typer.Option("--suite", help="Learn from the prompts of a suite instead.")] = None,
    judge: Annotated[str, typer.Option("--judge", help="The model that judges; `--model` if left out.")] = "",
    reviewer: Annotated[
        str,
        typer.Option(
            "--reviewer", help="The model that reviews failures and writes cards of a suite; the judge's if left out."
        ),
    ] = "",
    out: Annotated[Path, typer.Option("--out", help="Folder of cards to which they are added.")] = Path("cards"),
    work: Annotated[
        Path, typer.Option("--work", help="Folder for answers, judgements and runs of a suite; its work is continued.")
    ] = Path("runs/learning"),
    apart: Annotated[
        list[Path] | None,
        typer.Option("--apart-from", metavar="SUITE", help="Another suite that must not share a source."),
    ] = None,
    only: Annotated[list[str] | None, typer.Option("--only", metavar="ID", help="Only this prompt.")] = None,
    repeats: Annotated[int, typer.Option("--repeats", min=1, max=20, help="Judgements of each kind.")] = 3,
    as_json: AsJson = False,
    *,
    options: MethodOptions,
) -> None:
    """Learn cards from a finished loop, for `verify` to run, or from a suite, where they are run and tested.

    With --suite all prompts are answered and judged; for each the reviewer writes a card about a failure. Both
    its cases are run, the prompt is answered again with it, and it is kept only if the score improves. The ledger
    beside the cards records the source of each. An interrupted command resumes when called again.
    """
    if (case is None) == (suite is None):
        raise RunError("give a source to learn from: a CASE, or --suite SUITE")
    model = options.model
    if not model:
        raise RunError("name a model: --model MODEL (or the variable TEXT2SIM_MODEL)")
    if case is not None:
        _from_case(case, judge or model[-1], out, as_json)
        return
    assert suite is not None
    from text2sim.evaluation.ledger import read_ledger

    judge = judge or model[-1]
    _from_suite(suite, apart or [], only or [], model, judge, reviewer or judge, out, work, repeats, options.allowance)
    if as_json:
        say_json(read_ledger(out).model_dump(mode="json", exclude={"prompts"}))
    else:
        show_ledger(out)


def _from_case(case: Path, model: str, out: Path, as_json: bool) -> None:
    from text2sim.agents.conversation import Conversation
    from text2sim.agents.distilling import distill
    from text2sim.agents.models.calls import Account, Budget, CallLog
    from text2sim.agents.session import endpoint_of

    folder = case / "generation"
    journal = Journal(folder / "distilled.jsonl")
    chat = Conversation({"": endpoint_of(model, case)}, CallLog(folder / "calls"), Account(), Budget(), journal)
    written = distill(chat, case, out)
    if as_json:
        say_json({"ok": True, "cards": [str(out / name) for name in written]})
        return
    for name in written:
        say(str(out / name))
    say(f"next: TEXT2SIM_CARDS={out} text2sim cards verify {' '.join(written)}" if written else "nothing to learn here")


def _from_suite(
    suite: Path, apart: list[Path], only: list[str], model: list[str], judge: str, reviewer: str, out: Path, work: Path,
    repeats: int, allowance: "Allowance",
) -> None:  # fmt: skip
    from text2sim.evaluation.learning import Learning
    from text2sim.evaluation.suite import check_complete, read_suite, select_prompts, shared_sources

    read, document = read_suite(suite)
    check_complete(read, document)
    held_out = [read_suite(other)[0] for other in (Path(HELD_OUT), *apart)]
    if problems := [row for other in held_out for row in shared_sources(read, other, document)]:
        raise SpecError(problems)
    with Stop() as stop, stop.gently():
        learning = Learning(
            read, select_prompts(read, only), out, work, model, judge, allowance, lambda line: say(line, to=sys.stderr),
            repeats, reviewer, stop=lambda: stop.count > 0,
        )  # fmt: skip
        try:
            learning.run()
        except Text2SimError:
            if not stop.count:
                raise
            say("stopped; the same command continues", to=sys.stderr)
            raise KeyboardInterrupt from None


def show_ledger(
    cards: Annotated[Path, typer.Argument(metavar="CARDS", help="Folder of learned cards.")] = Path("cards"),
    runs: Annotated[
        list[Path] | None, typer.Option("--runs", help="A folder with loops of `generate`, to count uses of cards.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show for each learned card its sources, its effect on scores, and whether it was ever retrieved."""
    from text2sim.card_library.library import BUILT_IN, load_library
    from text2sim.evaluation.ledger import count_offered_cards, read_ledger

    for folder in (cards, *(runs or ())):
        if not folder.is_dir():
            raise RunError(f"{display_path(folder)}: there is no such folder")
    ledger = read_ledger(cards)
    loops, offered = count_offered_cards(runs or [])
    if as_json:
        found = {name: one.model_dump(mode="json") | {"dealt": offered[name]} for name, one in ledger.cards.items()}
        say_json({"loops": loops, "cards": found})
        return
    for name, one in ledger.cards.items():
        notes = [one.state]
        if any(row.dealt for row in one.tried):
            notes.append(f"{one.gain:+.1f} points where it was tested{': WORSE' if one.gain < 0 else ''}")
        elif one.tried:
            notes.append("NEVER RETRIEVED where it was tested")
        if loops and one.state == "kept":
            used = f"used in {offered[name]} of {loops} loops"
            notes.append(used if offered[name] else f"NEVER RETRIEVED in {loops} loops")
        say(f"{name}: {'; '.join(notes)}")
        for debt in one.owes:
            source = ledger.prompts[debt.prompt].source
            say(f"    owes {source.title} ({source.authors}, {source.year}; {debt.prompt}): {debt.failure}")
    if not ledger.cards:
        say("no cards were learned here")
    if loops:
        idle = [name for name in load_library([BUILT_IN]).entries if not offered[name]]
        say(f"built-in cards NEVER RETRIEVED in {loops} loops: {', '.join(idle) or 'none'}")
