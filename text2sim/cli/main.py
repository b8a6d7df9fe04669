"""Command line. Every command has its own module and imports what it needs when it runs."""

import gc
import os
import sys
from typing import Annotated

import typer

from text2sim import __version__
from text2sim.cli.asset import asset
from text2sim.cli.benchmark import benchmark
from text2sim.cli.cards import cards
from text2sim.cli.check import check
from text2sim.cli.compare import compare_runs
from text2sim.cli.compile import compile_cases
from text2sim.cli.dataset import dataset
from text2sim.cli.diff import diff
from text2sim.cli.doctor import doctor
from text2sim.cli.evaluate import evaluate
from text2sim.cli.export import export
from text2sim.cli.fmt import fmt
from text2sim.cli.generate import edit, generate, repair
from text2sim.cli.git import git
from text2sim.cli.mcp import mcp
from text2sim.cli.migrate import migrate
from text2sim.cli.new import new
from text2sim.cli.patch import patch
from text2sim.cli.prefabs import prefabs
from text2sim.cli.render import render
from text2sim.cli.replay import replay
from text2sim.cli.run import run_cases
from text2sim.cli.schema import schema
from text2sim.cli.show import show
from text2sim.cli.study import study
from text2sim.cli.suite import run_suite
from text2sim.cli.watch import watch
from text2sim.service import exits

app = typer.Typer(
    name="text2sim",
    help="A case in YAML becomes a Genesis program, a run, and evidence.",
    epilog="Exit codes: 0 fine; 1 the physics did not do what was expected; 2 the input is wrong; "
    "3 this machine cannot, or not now; 70 a bug of ours.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("new")(new)
app.command("check")(check)
app.command("show")(show)
app.command("run")(run_cases)
app.command("render")(render)
app.command("replay")(replay)
app.command("export")(export)
app.command("generate")(generate)
app.command("repair")(repair)
app.command("edit")(edit)
app.command("watch")(watch)
app.command("test")(run_suite)
app.command("compare")(compare_runs)
app.command("compile")(compile_cases)
app.command("fmt")(fmt)
app.command("diff")(diff)
app.command("patch")(patch)
app.command("migrate")(migrate)
app.add_typer(git, name="git")
app.command("prefabs")(prefabs)
app.add_typer(asset, name="asset")
app.add_typer(cards, name="cards")
app.add_typer(benchmark, name="benchmark")
app.add_typer(evaluate, name="evaluate")
app.add_typer(dataset, name="dataset")
app.add_typer(study, name="study")
app.command("schema")(schema)
app.command("doctor")(doctor)
app.command("mcp")(mcp)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"text2sim {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and exit.", callback=_show_version, is_eager=True),
    ] = False,
) -> None:
    pass


def run() -> None:
    """Run the command line and exit with one of `exits`."""
    # Nearly all objects of a short command live to its end: collecting garbage takes a tenth of its time.
    gc.set_threshold(100_000, 20, 50)
    # Nor do we want whatever other packages plug into pydantic, which searches all that is installed for it.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # The parent process may have closed both.
    sys.stdout, sys.stderr = (stream or open(os.devnull, "w") for stream in (sys.stdout, sys.stderr))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        # A terminal that cannot show a character must not stop a run.
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    try:
        app(prog_name="text2sim")
    except KeyboardInterrupt:
        sys.exit(exits.INTERRUPTED)
    except SystemExit:
        # On a closed pipe the library exits with 1, which would be a verdict.
        if type(sys.stdout).__name__ == "PacifyFlushWrapper":
            sys.exit(exits.OK)
        raise
    except BrokenPipeError:
        # The reader has closed the pipe; Python must not complain about that at exit.
        sys.stdout = open("/dev/null" if sys.platform != "win32" else "NUL", "w")  # noqa: SIM115
        sys.exit(exits.OK)
    except Exception as error:
        from text2sim.cli.failure import fail, fail_unheard

        try:
            code = fail(error, as_json="--json" in sys.argv)
        except OSError as unheard:
            code = fail_unheard(unheard)
        sys.exit(code)
