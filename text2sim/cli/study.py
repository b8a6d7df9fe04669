"""The commands `text2sim study`: blind comparisons of methods' films by people."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from text2sim.cli.options import AsJson
from text2sim.cli.output import say, say_json
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import MachineError, RunError
from text2sim.spec_schema.text.source import read_source

study = typer.Typer(
    help="Blind comparisons of methods' films by people.",
    no_args_is_help=True,
)
Folder = Annotated[Path, typer.Argument(metavar="STUDY", help="Folder of the study.")]


@study.command("build")
def build_study(
    folder: Folder,
    methods: Annotated[list[Path], typer.Argument(metavar="METHOD...", help="Method folders that are compared.")],
    anchor: Annotated[Path, typer.Option("--anchor", help="The method folder with which each is compared.")],
    suite: Annotated[Path, typer.Option("--suite", help="The suite that has the prompts.")],
    seed: Annotated[int, typer.Option("--seed", help="Decides assignments, their order and sides.")] = 0,
    consent: Annotated[
        Path | None, typer.Option("--consent", help="The text that people agree to; ours if left out.")
    ] = None,
) -> None:
    """Make assignments of comparisons, and copies of the films under anonymous names."""
    from text2sim.evaluation.method_folder import read_method
    from text2sim.evaluation.suite import read_suite
    from text2sim.study.build import build

    prompts = {name: one.prompt for name, one in read_suite(suite)[0].prompts.items()}
    words = {} if consent is None else {"consent": read_source(consent).text}
    made = build(folder, prompts, read_method(anchor), [read_method(one) for one in methods], seed=seed, **words)
    for row in made.left_out:
        say(f"left out: {row}")
    count = len(made.assignments)
    say(f"{sum(map(len, made.assignments))} comparisons in {count} assignments, one per person")
    say(f"next: text2sim study serve {display_path(folder)}")


@study.command("serve")
def serve_study(
    folder: Folder,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="0 takes a free one.")] = 8765,
    host: Annotated[str, typer.Option("--host", help="Address of this machine to listen on.")] = "127.0.0.1",
) -> None:
    """Serve the comparisons in a browser, and record the answers.

    Ctrl-C ends it; a restart has the same address, and people continue where they were.
    """
    try:
        from text2sim.study.server import serve
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("starlette", "uvicorn", "anyio"):
            raise
        raise MachineError("the web server is not installed here: pip install 'text2sim[study]'") from None

    def tell(address: str) -> None:
        say(f"study: {address}")
        say("everybody with this address can take part; Ctrl-C ends it")
        sys.stdout.flush()

    try:
        serve(folder, host, port, tell)
    except OSError as error:
        raise RunError(f"cannot listen on {host}:{port}: {error.strerror}") from error
    raise typer.Exit(exits.INTERRUPTED)


@study.command("analyse")
def analyse_study(folder: Folder, as_json: AsJson = False) -> None:
    """Report the score of each method relative to the anchor, which has 50, with 95 % intervals over tasks."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from text2sim.study.analyse import OVERALL, analyse
    from text2sim.study.answers import Answers
    from text2sim.study.build import read_study

    plan = read_study(folder)
    answers = Answers(folder, plan)
    found = analyse(plan, answers.all())
    answers.close()
    if as_json:
        say_json(found)
        return
    columns = [*plan.questions, OVERALL]
    table = Table("method", *columns, "tasks", box=box.SIMPLE, pad_edge=False)
    for method, row in found["scores"].items():
        table.add_row(method, *(_cell(row[name]) for name in columns), str(row[OVERALL].get("tasks", "")))
    agreement = [_number(found["agreement"][name], 2) for name in plan.questions]
    table.add_row("agreement (alpha)", *agreement, "", "")
    Console().print(table)
    counted = f"{found['comparisons']} of {found['planned']} comparisons, by {found['people']} people"
    say(f"{counted}; “cannot judge”: {found['cannot_judge']} of {found['answers']} answers")
    say(f"mean preference for A, whoever it was (0 if sides do not matter): {_number(found['preference_for_a'], 2)}")
    for line in found["left_out"]:
        say(f"not compared: {line}")


def _cell(row: dict[str, Any]) -> str:
    interval = f" [{row['low']:.1f}, {row['high']:.1f}]" if "low" in row else ""
    return _number(row["score"], 1) + interval


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"
