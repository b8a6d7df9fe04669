"""Command line. Every command has its own module, and imports what it needs when it runs."""

import gc
import os
import sys
from collections.abc import Iterable
from importlib import import_module
from typing import Annotated

import typer

from text2sim import __version__
from text2sim.service import exits

COMMANDS = {
    "new": "new:new",
    "check": "check:check",
    "show": "show:show",
    "run": "run:run_cases",
    "render": "render:render",
    "replay": "replay:replay",
    "export": "export:export",
    "generate": "generate:generate",
    "repair": "generate:repair",
    "edit": "generate:edit",
    "watch": "watch:watch",
    "test": "suite:run_suite",
    "compare": "compare:compare_runs",
    "compile": "compile:compile_cases",
    "fmt": "fmt:fmt",
    "diff": "diff:diff",
    "patch": "patch:patch",
    "migrate": "migrate:migrate",
    "git": "git:git",
    "prefabs": "prefabs:prefabs",
    "asset": "asset:asset",
    "cards": "cards:cards",
    "benchmark": "benchmark:benchmark",
    "evaluate": "evaluate:evaluate",
    "dataset": "dataset:dataset",
    "study": "study:study",
    "schema": "schema:schema",
    "doctor": "doctor:doctor",
    "mcp": "mcp:mcp",
}
"""Modules of the commands, and what each has for it, in the order of the help."""


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"text2sim {__version__}")
        raise typer.Exit


def _root(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and exit.", callback=_show_version, is_eager=True),
    ] = False,
) -> None:
    pass


def make_app(names: Iterable[str] = COMMANDS) -> typer.Typer:
    """Return the command line with some of its commands; to import them all takes a tenth of a `check`."""
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
    app.callback()(_root)
    for name in names:
        module, _, attribute = COMMANDS[name].partition(":")
        found = getattr(import_module(f"text2sim.cli.{module}"), attribute)
        if isinstance(found, typer.Typer):
            app.add_typer(found, name=name)
        else:
            app.command(name)(found)
    return app


def __getattr__(name: str) -> typer.Typer:
    if name == "app":
        return make_app()
    raise AttributeError(name)


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
        asked = [word for word in sys.argv[1:2] if word in COMMANDS]
        make_app(asked or COMMANDS)(prog_name="text2sim")
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
