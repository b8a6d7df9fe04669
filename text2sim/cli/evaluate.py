"""The commands `text2sim evaluate`: suites, methods, judges, tables."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from text2sim.cli.generate import AgentOptions, Cost, Minutes, Tokens
from text2sim.cli.last_film import Film
from text2sim.cli.options import with_options
from text2sim.cli.output import say
from text2sim.runtime.stop import Stop
from text2sim.service import exits
from text2sim.spec_schema.errors import RunError, SpecError

if TYPE_CHECKING:
    from text2sim.evaluation.judging import Judging
    from text2sim.evaluation.methods import Allowance

evaluate = typer.Typer(
    help="Measure how good cases are: suites of prompts, methods that answer them, judges, a report.",
    no_args_is_help=True,
)
SuiteFile = Annotated[
    Path,
    typer.Argument(metavar="SUITE", help="A suite's YAML file; `demonstrations` and `learning` come with text2sim."),
]
Only = Annotated[list[str] | None, typer.Option("--only", metavar="ID", help="Only this prompt; may be repeated.")]
Resume = Annotated[bool, typer.Option("--resume", help="Continue the work in this folder.")]


@dataclass(frozen=True)
class MethodOptions(AgentOptions):
    """Options of commands that run methods."""

    film: Film = "draft"
    film_minutes: Annotated[
        float, typer.Option("--film-minutes", min=0.1, help="Minutes for one path-traced film.")
    ] = 10.0

    @property
    def allowance(self) -> "Allowance":
        """The budget for each prompt."""
        from text2sim.evaluation.methods import Allowance

        limits = self.attempts, self.tokens, self.cost, self.minutes, self.sim_timeout
        return Allowance(*limits, self.film, self.film_minutes)


@evaluate.command("check")
def check_suite(
    suite: SuiteFile,
    apart: Annotated[
        list[Path] | None,
        typer.Option("--apart-from", metavar="SUITE", help="A suite that must not share a source with it."),
    ] = None,
) -> None:
    """Check the form and digest of a suite, and that it shares no source or prompt with others."""
    from text2sim.evaluation.suite import check_complete, read_suite, shared_sources

    read, document = read_suite(suite)
    check_complete(read, document)
    if problems := [row for other in apart or [] for row in shared_sources(read, read_suite(other)[0], document)]:
        raise SpecError(problems)
    families = [prompt.family for prompt in read.prompts.values()]
    counts = ", ".join(f"{families.count(family)} {family}" for family in dict.fromkeys(families))
    say(f"{read.name}: {len(families)} prompts ({counts}), {'frozen' if read.frozen else 'not frozen'}")
    say(f"digest {read.digest()}")


@evaluate.command("draft")
def draft_suite(
    suite: SuiteFile,
    out: Annotated[Path, typer.Option("--out", help="File for the frozen suite.")],
    model: Annotated[str, typer.Option("--model", envvar="TEXT2SIM_MODEL", help="The model that drafts.")] = "",
) -> None:
    """Draft missing requirements of a suite from the prompts only, and freeze the suite with a digest."""
    from text2sim.evaluation.drafting import draft_missing, write_frozen
    from text2sim.evaluation.suite import read_suite

    read, document = read_suite(suite)
    done = draft_missing(read, document, model, out.parent / f".{out.stem}")
    write_frozen(done, out)
    say(f"{out}: {len(done.prompts)} prompts, frozen with digest {done.digest()}")


@evaluate.command("run")
@with_options(MethodOptions)
def run_methods(
    suite: SuiteFile,
    methods: Annotated[
        list[str],
        typer.Option(
            "--method",
            metavar="METHOD",
            help="text2sim or agent, followed by :with-cards or :no-cards; or NAME=COMMAND with {prompt}, "
            "{prompt_file} and {folder}.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", help="Folder for the folders of methods.")],
    only: Only = None,
    allow_code: Annotated[
        bool,
        typer.Option(
            "--allow-code",
            help="Let `agent` run Python that a model has written: with limits and without keys, but not in a sandbox.",
        ),
    ] = False,
    resume: Resume = False,
    *,
    options: MethodOptions,
) -> None:
    """Run methods on the prompts of a suite; the budget is for each prompt.

    With `--resume`, existing answers are kept. Exit code 1: a method has no result for some prompt.
    """
    from text2sim.card_library.library import VARIABLE
    from text2sim.evaluation.ledger import check_split
    from text2sim.evaluation.method_folder import METHOD, read_method
    from text2sim.evaluation.methods import parse_method, run_method
    from text2sim.evaluation.suite import read_suite, select_prompts

    read, document = read_suite(suite)
    prompts, chosen = select_prompts(read, only or []), [parse_method(word) for word in methods]
    if any(one.cards for one in chosen) and (more := os.environ.get(VARIABLE)):
        check_split(read, document, Path(more))
    if any(one.kind == "agent" for one in chosen) and not allow_code:
        raise RunError("`agent` runs Python that a model has written, without a sandbox; allow that with --allow-code")
    if begun := [one.name for one in chosen if (out / one.name / METHOD).exists()]:
        if not resume:
            raise RunError(f"{out}: already has work of {', '.join(begun)}; `--resume` continues it")
    failed, models, allowance = 0, options.model or [], options.allowance
    for one in chosen:
        folder = run_method(read, prompts, one, models, allowance, out, lambda line: say(line, to=sys.stderr))
        failed += sum(
            made.result.status == "failed" for name, made in read_method(folder).made.items() if name in prompts
        )
        say(str(folder))
    raise typer.Exit(exits.PHYSICS if failed else exits.OK)


@evaluate.command("judge")
def judge_methods(
    suite: SuiteFile,
    methods: Annotated[list[Path], typer.Argument(metavar="METHOD...", help="Method folders.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for judgements, replies and the report.")],
    judges: Annotated[
        list[str], typer.Option("--judge", metavar="MODEL", envvar="TEXT2SIM_MODEL", help="One or more judges.")
    ],
    repeats: Annotated[
        int, typer.Option("--repeats", min=1, max=20, help="Judgements of each kind by each judge.")
    ] = 3,
    only: Only = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, max=64, help="Number of results judged at a time.")] = 1,
    tokens: Tokens = None,
    cost: Cost = None,
    minutes: Minutes = None,
    resume: Resume = False,
) -> None:
    """Judge each result of methods several times, by judges who see neither names nor each other's scores.

    Exit code 1: a result could not be judged; the other results and the report are complete.
    """
    from text2sim.agents.models.calls import Budget
    from text2sim.agents.models.exchange import StoppedError
    from text2sim.evaluation.judging import JUDGING_FILE, Judging
    from text2sim.evaluation.method_folder import read_method
    from text2sim.evaluation.suite import check_complete, read_suite, select_prompts

    read, document = read_suite(suite)
    check_complete(read, document)
    if (out / JUDGING_FILE).exists() and not resume:
        raise RunError(f"{out}: already has judgements; use `--resume` to continue, or another folder")
    folders = [read_method(folder) for folder in methods]
    with Stop() as stop, stop.gently():
        judging = Judging(read, folders, judges, out, repeats, Budget(tokens, cost, minutes), lambda: stop.count > 0)
        try:
            rows = judging.run(select_prompts(read, only or []), lambda line: say(line, to=sys.stderr), jobs)
        except StoppedError:
            say("stopped; `--resume` continues", to=sys.stderr)
            raise KeyboardInterrupt from None
    _say_account(judging)
    missing = sum(row.state == "not_judged" for row in rows)
    if missing:
        say(f"{missing} of {len(rows)} judgements are missing; see `why` in their judgement.json", to=sys.stderr)
    _report(suite, out)
    raise typer.Exit(exits.PHYSICS if missing else exits.OK)


@evaluate.command("report")
def report(
    suite: SuiteFile,
    out: Annotated[Path, typer.Argument(metavar="JUDGED", help="The folder of `evaluate judge --out`.")],
) -> None:
    """Write tables and page of an evaluation: report.html, and CSV (also Parquet if pyarrow is installed)."""
    _report(suite, out)


def _report(suite: Path, out: Path) -> None:
    from text2sim.evaluation.report import write_report
    from text2sim.evaluation.suite import read_suite
    from text2sim.evaluation.tables import tables_of, text_of, write_tables

    tables = tables_of(read_suite(suite)[0], out)
    say(text_of(tables))
    write_tables(tables, out)
    say(f"report: {write_report(tables, out)}")
    say(f"tables: {out / 'tables'}")


def _say_account(judging: "Judging") -> None:
    spent = judging.account.total()
    paid = f", ${spent.cost:.4f}" if spent.cost else ""
    unpriced = f" ({spent.unpriced} calls without a known price)" if spent.unpriced else ""
    say(
        f"judges: {spent.calls} calls, {spent.cached} from the cache, {spent.tokens:,} tokens{paid}{unpriced}",
        to=sys.stderr,
    )
