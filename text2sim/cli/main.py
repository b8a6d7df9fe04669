"""Command line; each command has its own module, which imports what it needs when it runs."""

import gc
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from text2sim import __version__
from text2sim.service import exits
from text2sim.spec_schema.plain import plain

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
"""Module and function of each command, in the order of the help."""


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


_UsageError: Any = typer.BadParameter.__mro__[1]
"""What typer raises for arguments that do not fit; no version exports it by this name."""


class _Commands(TyperGroup):
    """Commands whose usage errors quote what was written without its control characters."""

    def make_context(self, *args: Any, **options: Any) -> Any:
        with _quoted_plainly():
            return super().make_context(*args, **options)

    def invoke(self, ctx: Any) -> Any:
        with _quoted_plainly():
            return super().invoke(ctx)


@contextmanager
def _quoted_plainly() -> Iterator[None]:
    try:
        yield
    except _UsageError as error:
        error.message = plain(error.message)
        raise


def make_app(names: Iterable[str] = COMMANDS) -> typer.Typer:
    """Return the command line with some of its commands; importing all takes a tenth of the time of `check`."""
    app = typer.Typer(
        name="text2sim",
        cls=_Commands,
        help="A case in YAML becomes a Genesis program, a run, and evidence.",
        epilog="Exit codes: 0 ok; 1 expectations were not met; 2 the input is invalid; "
        "3 this machine cannot do it, or not now; 70 a bug of ours.",
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
    # Nearly all objects of a short command live to its end: garbage collection takes a tenth of its time.
    gc.set_threshold(100_000, 20, 50)
    # pydantic would search all installed packages for plugins, which we do not want.
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
        # On a closed pipe the library exits with 1, which would mean unmet expectations.
        if type(sys.stdout).__name__ == "PacifyFlushWrapper":
            sys.exit(exits.OK)
        raise
    except BrokenPipeError:
        # The reader has closed the pipe, which Python would report at exit.
        sys.stdout = open("/dev/null" if sys.platform != "win32" else "NUL", "w")  # noqa: SIM115
        sys.exit(exits.OK)
    except Exception as error:
        from text2sim.cli.failure import fail, fail_unheard

        try:
            code = fail(error, as_json="--json" in sys.argv)
        except OSError as unheard:
            code = fail_unheard(unheard)
        sys.exit(code)
