"""The command `text2sim check`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from text2sim.cli import exits

if TYPE_CHECKING:
    from text2sim.cli.cases import Examined


def check(
    cases: Annotated[
        list[Path] | None, typer.Argument(help="Case folders, case.yaml files, or folders of cases.")
    ] = None,
    settings: Annotated[bool, typer.Option("--settings", help="Say which settings were derived, and why.")] = False,
    rules: Annotated[bool, typer.Option("--rules", help="List the rules of the lint.")] = False,
    explain: Annotated[
        str, typer.Option("--explain", metavar="RULE", help="Say what a rule means, why, and the way out.")
    ] = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> None:
    """Find everything that is wrong with cases, without running them."""
    from text2sim.cli.cases import examine, find_cases
    from text2sim.cli.output import say, say_json, shown

    if rules or explain:
        from text2sim.cli.rules import say_rule, say_rules

        raise typer.Exit(say_rule(explain, as_json) if explain else say_rules(as_json))
    if not cases:
        raise typer.BadParameter("give a case, or --rules, or --explain RULE", param_hint="'CASES...'")
    rows = []
    for path in find_cases(cases):
        row = examine(path)
        rows.append(row)
        if as_json:
            continue
        row.say()
        if row.plan is not None:
            say(f"{shown(row.path)}: ok{_counts(row)}")
            if settings:
                for note in row.plan.notes:
                    say(f"    {note}")
    if as_json:
        say_json({"ok": all(row.ok for row in rows), "cases": [row.as_dict() for row in rows]})
    raise typer.Exit(max((row.exit for row in rows), default=exits.OK))


def _counts(row: "Examined") -> str:
    counts = (len(row.problems), "warning", "warnings"), (len(row.waived), "waived", "waived")
    return "".join(f", {n} {one if n == 1 else many}" for n, one, many in counts if n)
