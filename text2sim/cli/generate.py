"""The commands `text2sim generate`, `repair` and `edit`: agents that write and repair cases."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.last_film import Film, FilmMinutes, Quality, last_film
from text2sim.cli.loop_view import progress_view, say_outcome
from text2sim.cli.options import with_options
from text2sim.cli.output import say, say_json
from text2sim.runtime.stop import Stop
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.text.source import read_source

STDIN = "-"
MAX_REQUEST_SIZE = 1_000_000
"""Largest size of a request [bytes]."""

File = Annotated[Path | None, typer.Option("--file", metavar="FILE", help="Read the text from this file (UTF-8).")]


if TYPE_CHECKING:
    from text2sim.agents.loop_result import LoopOutcome
    from text2sim.agents.session import Kind, Session

MODEL = "TEXT2SIM_MODEL"

Model = Annotated[
    list[str] | None,
    typer.Option(
        "--model",
        metavar="[ROLE=]MODEL",
        envvar=MODEL,
        help="The model: provider/model, openai/model@URL, mailbox:DIR, replay:DIR; with ROLE= for that role only.",
    ),
]
Tokens = Annotated[int | None, typer.Option("--tokens", min=1, help="Limit of tokens, in and out.")]
Cost = Annotated[float | None, typer.Option("--cost", min=0.0, help="Limit of costs in US dollars.")]
Minutes = Annotated[float | None, typer.Option("--minutes", min=0.1, help="Limit of wall time in minutes.")]


@dataclass(frozen=True)
class AgentOptions:
    """Options of commands with loops of agents."""

    model: Model = None
    attempts: Annotated[
        int, typer.Option("--attempts", min=1, max=1000, help="Largest number of versions of the case.")
    ] = 30
    tokens: Tokens = None
    cost: Cost = None
    minutes: Minutes = None
    sim_timeout: Annotated[
        float, typer.Option("--sim-timeout", min=1.0, help="Limit of a simulation's wall time in seconds.")
    ] = 3600.0


@dataclass(frozen=True)
class LoopOptions(AgentOptions):
    """Options of `generate`, `repair` and `edit`."""

    images: Annotated[
        list[Path] | None, typer.Option("--image", help="A picture or sketch that belongs to the request.")
    ] = None
    no_cards: Annotated[bool, typer.Option("--no-cards", help="Do not use Debug Cards.")] = False
    style: Annotated[
        bool,
        typer.Option("--style/--no-style", help="Film the final case in several ways, and keep the best film."),
    ] = False
    film: Film = "draft"
    film_minutes: FilmMinutes = None
    resume: Annotated[bool, typer.Option("--resume", help="Continue the work in this folder.")] = False
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document at the end.")] = False


@with_options(LoopOptions, style=True)
def generate(
    request: Annotated[str, typer.Argument(help="What the case should show, in words; `-` reads from stdin.")] = "",
    file: File = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="The case's folder; cases/<first words> if left out.")
    ] = None,
    meshes: Annotated[list[Path] | None, typer.Option("--mesh", help="A mesh for the case.")] = None,
    urdfs: Annotated[list[Path] | None, typer.Option("--urdf", help="A URDF or MJCF model for the case.")] = None,
    licence: Annotated[str, typer.Option("--licence", help="Terms of use of these files.")] = "",
    *,
    options: LoopOptions,
) -> None:
    """Generate a case from a request in words: plan, write, run and judge it until it shows what was requested.

    The best version is always kept, with its evidence and unresolved points. Exit code 1: it was not accepted.
    """
    from text2sim.agents.session import free_folder

    text = "" if options.resume else words_of(request, file)
    if options.resume and out is None and request:
        out = Path(request)
    case, assets = out or free_folder(Path("cases"), text), [*(meshes or []), *(urdfs or [])]
    session = _session("generate", case, text, options, assets=assets, licence=licence)
    _run_session(session, options.as_json, options.film, options.film_minutes)


@with_options(LoopOptions)
def repair(
    case: Annotated[Path, typer.Argument(help="The case's folder.")],
    wrong: Annotated[str, typer.Argument(metavar="WHAT_IS_WRONG", help="What is wrong, in words; `-`: stdin.")] = "",
    file: File = None,
    *,
    options: LoopOptions,
) -> None:
    """Repair a case with agents: it is run first, and all its expectations are kept."""
    _amend("repair", case, wrong, file, options)


@with_options(LoopOptions)
def edit(
    case: Annotated[Path, typer.Argument(help="The case's folder.")],
    wish: Annotated[str, typer.Argument(help="What should be different, in words; `-`: stdin.")] = "",
    file: File = None,
    *,
    options: LoopOptions,
) -> None:
    """Change a case with agents."""
    _amend("edit", case, wish, file, options)


def _amend(kind: "Kind", case: Path, words: str, file: Path | None, options: LoopOptions) -> None:
    from text2sim.service.examined import case_file

    text = "" if options.resume else words_of(words, file)
    path = case_file(case)
    base = "" if options.resume else read_source(path).text
    session = _session(kind, path.parent, text, options, base=base)
    _run_session(session, options.as_json, options.film, options.film_minutes)


def _session(
    kind: "Kind",
    case: Path,
    text: str,
    options: LoopOptions,
    *,
    base: str = "",
    assets: Sequence[Path] = (),
    licence: str = "",
) -> "Session":
    from text2sim.agents.session import Session, SessionWish

    models = _models(options.model)
    if options.resume:
        session = Session.resume(case)
        # New options take precedence, because a key may have expired or a budget may have been too small.
        session.wish.models |= models
        session.wish.attempts = max(session.wish.attempts, options.attempts)
        for name in ("tokens", "cost", "minutes"):
            if getattr(options, name) is not None:
                setattr(session.wish, name, getattr(options, name))
        return session
    from text2sim.agents.session import endpoint_of

    for name in _needed_models(models).values():
        endpoint_of(name, case)  # a typo in a name should leave no files behind
    wish = SessionWish(
        kind, text, models, options.attempts, options.tokens, options.cost, options.minutes, options.sim_timeout,
        cards=not options.no_cards, base=base, style=options.style,
    )  # fmt: skip
    return Session.begin(case, wish, options.images or [], [*assets], licence)


def _models(given: list[str] | None) -> dict[str, str]:
    from text2sim.agents.session import check_models

    found: dict[str, str] = {}
    for word in given or []:
        role, equals, name = word.partition("=")
        found |= {role: name} if equals and role.isidentifier() else {"": word}
    check_models(found)
    return found


def _needed_models(models: dict[str, str]) -> dict[str, str]:
    if "" not in models:
        raise RunError(
            f"name a model: --model provider/model (or the variable {MODEL}), or --model mailbox:DIR to answer "
            "yourself; see docs/models.md"
        )
    return models


def _run_session(session: "Session", as_json: bool, film: Quality, film_minutes: float | None) -> None:
    with Stop() as stop, progress_view(session.case.name, quiet=as_json) as listener:
        try:
            with stop.gently():
                outcome = session.run(listener, lambda: stop.count > 0, prewarm=True)
        except KeyboardInterrupt:
            spent = f"{session.account.total().tokens:,} tokens"
            say(f"stopped after {spent}; `--resume {display_path(session.case)}` continues", to=sys.stderr)
            raise
    if not as_json:
        say_outcome(session, outcome)
    path, note = None, "there is no run"
    if outcome.best is not None and outcome.best.run:
        path, note = last_film(session.case / outcome.best.run, film, film_minutes, quiet=as_json)
    if as_json:
        say_json(outcome_document(session, outcome) | {"film": None if path is None else str(path), "film_told": note})
    elif film != "none":
        say(f"no film: {note}" if path is None else f"film: {path}{f' ({note})' if note else ''}")
    raise typer.Exit(exits.OK if outcome.accepted else exits.PHYSICS)


def outcome_document(session: "Session", outcome: "LoopOutcome") -> dict[str, Any]:
    """Return the document that `--json` prints."""
    best = outcome.best
    return {
        "ok": outcome.accepted,
        "state": outcome.state,
        "why": outcome.why,
        "case": str(session.case / "case.yaml") if best is not None else None,
        "attempt": best.number if best else None,
        "run": str(session.case / best.run) if best is not None and best.run else None,
        "expect": best.expect if best else {},
        "critique": best.critique if best else None,
        "unresolved": outcome.unresolved,
        "assumptions": outcome.plan.assumptions if outcome.plan else [],
        "account": session.account.as_dict(),
    }


def words_of(words: str, file: Path | None) -> str:
    """Return the text of a request. The argument is never a file name: only `--file` and `-` read.

    Args:
        words: The argument; `-` for standard input.
        file: A text file instead.

    Raises:
        RunError: if both are given, or the input is not text or too long.
    """
    if file is not None and words:
        raise RunError(f"give either words or --file {file}, not both")
    if words == STDIN:
        return _text(sys.stdin.buffer.read(MAX_REQUEST_SIZE + 1), "standard input")
    if file is None:
        if _is_file(words):
            say(f"taken as words: {words} (--file {words} reads the file)", to=sys.stderr)
        return words
    if not file.is_file():
        raise RunError(f"{file}: there is no such file")
    with file.open("rb") as stream:
        return _text(stream.read(MAX_REQUEST_SIZE + 1), str(file))


def _is_file(words: str) -> bool:
    try:
        return Path(words).is_file()
    except (OSError, ValueError):  # not a valid path, or too long for one
        return False


def _text(content: bytes, name: str) -> str:
    if len(content) > MAX_REQUEST_SIZE:
        raise RunError(f"{name}: a request has at most {MAX_REQUEST_SIZE / 1e6:g} MB")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RunError(f"{name}: byte {error.start} is not UTF-8; save it as UTF-8 text") from None
