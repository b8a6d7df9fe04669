"""The command `text2sim check`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from text2sim.cli import exits

if TYPE_CHECKING:
    from text2sim.spec_schema.errors import Problem


def check(
    cases: Annotated[list[Path], typer.Argument(help="Case folders, case.yaml files, or folders of cases.")],
    explain: Annotated[bool, typer.Option("--explain", help="Say which settings were derived, and why.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> None:
    """Find everything that is wrong with cases, without running them."""
    from text2sim.cli.cases import examine, find_cases
    from text2sim.cli.output import say, say_json, shown

    rows = []
    for path in find_cases(cases):
        row = examine(path)
        rows.append(row)
        if as_json:
            continue
        row.say()
        if row.plan is not None:
            say(f"{shown(row.path)}: ok{_counts(row.problems)}")
            if explain:
                for note in row.plan.notes:
                    say(f"    {note}")
    if as_json:
        say_json({"ok": all(row.ok for row in rows), "cases": [row.as_dict() for row in rows]})
    raise typer.Exit(max((row.exit for row in rows), default=exits.OK))


def _counts(problems: "list[Problem]") -> str:
    if not problems:
        return ""
    return f", {len(problems)} warning{'s' if len(problems) > 1 else ''}"
