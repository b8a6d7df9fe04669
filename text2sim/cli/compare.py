"""The command `text2sim compare`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.output import say, say_json
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.plain import plain

if TYPE_CHECKING:
    from text2sim.comparison.compare import RunComparison

MAX_SHOWN_DIFFERENCES = 40
"""Most rows of differences in the terminal; the page has all."""
PIPED_WIDTH = 500
"""Most characters of a line where there is no terminal."""


def compare_runs(
    runs: Annotated[list[Path], typer.Argument(help="Run folders, or the folder of a sweep.")],
    html: Annotated[
        Path | None,
        typer.Option("--html", help="The page; comparison.html beside the first run if left out."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document and write no page.")] = False,
) -> None:
    """Compare runs side by side: differences of the cases, and their effects on measures, events and films."""
    from text2sim.comparison.compare import compare
    from text2sim.comparison.runs import read_runs

    comparison = compare(read_runs(runs))
    if as_json:
        say_json(comparison.as_dict())
        raise typer.Exit(exits.OK)
    from text2sim.comparison.page import write_comparison

    _say(comparison)
    path = write_comparison(comparison, html or comparison.runs[0].folder.parent / "comparison.html")
    say(f"page: {display_path(path)}")


def _say(comparison: "RunComparison") -> None:
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE, pad_edge=False)
    for head in ("", *(run.label for run in comparison.runs)):
        table.add_column(Text(plain(head)), overflow="fold")

    def section(title: str, rows: list[tuple[str, list[str]]]) -> None:
        if rows:
            table.add_row(Text(title, style="bold"))
        for name, cells in rows[:MAX_SHOWN_DIFFERENCES]:
            table.add_row(Text(plain(f"  {name}")), *(Text(plain(cell)) for cell in cells))
        if len(rows) > MAX_SHOWN_DIFFERENCES:
            table.add_row(f"  … and {len(rows) - MAX_SHOWN_DIFFERENCES} more")

    it = comparison
    section("case", [(row["path"], [_text(value) for value in row["values"]]) for row in it.spec])
    section("expectations", [(row["name"], [_verdict(cell) for cell in row["cells"]]) for row in it.expectations])
    section(
        "measures at the end", [(_measure(row), [_last_value(cell) for cell in row["cells"]]) for row in it.measures]
    )
    section("events, first time [s]", [(row["name"], [_first(cell) for cell in row["cells"]]) for row in it.events])
    section("runs", [(row["name"], [_text(value) for value in row["values"]]) for row in it.diagnostics])
    # A file or a pipe has no width: names broken in the middle of a word could not be searched.
    Console(width=None if sys.stdout.isatty() else PIPED_WIDTH).print(table)


def _text(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(_text, value)) + "]"
    return "–" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def _measure(row: dict[str, Any]) -> str:
    return f"{row['name']} [{row['unit']}]" if row["unit"] else row["name"]


def _last_value(cell: dict[str, Any] | None) -> str:
    return _text(cell.get("last") if cell else None)


def _verdict(cell: dict[str, Any] | None) -> str:
    if cell is None:
        return "–"
    return f"{'✓' if cell['ok'] else '✗' if cell['ok'] is False else '?'} {cell['why']}"


def _first(cell: dict[str, Any] | None) -> str:
    if cell is None or cell.get("problem"):
        return "–"
    return "never" if not cell["count"] else f"{cell['first']:.4g} ({cell['count']}×)"
