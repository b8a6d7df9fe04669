"""The command `text2sim check`."""

import os
import sys
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.options import AsJson, Sets, Variants, overlay_of
from text2sim.cli.output import say, say_json
from text2sim.runtime.progress import duration_text
from text2sim.service import exits
from text2sim.spec_schema.errors import nearest

if TYPE_CHECKING:
    from text2sim.lint.rules import Rule
    from text2sim.service.examined import Examined

LONG_RUN = 60.0
"""Expected wall time [s] of a run above which it is printed."""


def check(
    cases: Annotated[
        list[Path] | None, typer.Argument(help="Case folders, case.yaml files, or folders of cases.")
    ] = None,
    variants: Variants = None,
    sets: Sets = None,
    all_variants: Annotated[bool, typer.Option("--variants", help="Check every variant of a case, too.")] = False,
    settings: Annotated[bool, typer.Option("--settings", help="Print the derived settings and their reasons.")] = False,
    rules: Annotated[bool, typer.Option("--rules", help="List the rules of the lint.")] = False,
    explain: Annotated[
        str, typer.Option("--explain", metavar="RULE", help="Explain a rule: meaning, reason, remedy, example.")
    ] = "",
    as_json: AsJson = False,
) -> None:
    """Find the problems of cases without running them."""
    from text2sim.service.examined import Examined, examine, find_cases
    from text2sim.spec_schema.reuse.overlay import CaseOverlay

    if rules or explain:
        raise typer.Exit(say_rule(explain, as_json) if explain else say_rules(as_json))
    # For small arrays, threads take longer to start than they save.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if not cases:
        raise typer.BadParameter("give a case, or --rules, or --explain RULE", param_hint="'CASES...'")
    rows: list[Examined] = []
    overlay = overlay_of(variants, sets)
    for path in find_cases(cases):
        base = examine(path, overlay=overlay)
        names = list(base.loaded.written.data.get("variants") or ()) if all_variants and base.loaded else []
        for number, more in enumerate([(), *((name,) for name in names)]):
            row = examine(path, overlay=overlay + CaseOverlay(more)) if number else base
            rows.append(row)
            if not as_json:
                _say(row, base if number else None, settings=settings)
    if as_json:
        say_json({"ok": all(row.ok for row in rows), "cases": [row.as_dict() for row in rows]})
    raise typer.Exit(max((row.exit for row in rows), default=exits.OK))


def _say(row: "Examined", base: "Examined | None", *, settings: bool) -> None:
    """Print the problems of a case, except those that its base case has, too."""
    from text2sim.cli.cases import say_examined

    known = set(base.problems) if base is not None else set()
    row.problems, everything = [problem for problem in row.problems if problem not in known], row.problems
    if row.overlay and row.problems and row.plan is None:
        say(f"{row.title}:", to=sys.stderr)
    say_examined(row)
    row.problems = everything
    if row.plan is not None:
        say(f"{row.title}: ok{_counts(row)}")
        if row.held:
            say(f"    already true at the start, and would be if nothing moved: {', '.join(row.held)}")
        if row.seconds >= LONG_RUN:
            say(f"    about {duration_text(row.seconds)} to simulate on two idle cores, within a factor of three")
        for note in row.plan.notes if settings else ():
            say(f"    {note}")


def _counts(row: "Examined") -> str:
    counts = (len(row.problems), "warning", "warnings"), (len(row.waived), "waived", "waived")
    return "".join(f", {n} {one if n == 1 else many}" for n, one, many in counts if n)


def say_rules(as_json: bool) -> int:
    """Print one line for each rule, and return the exit code."""
    from text2sim.lint.rules import RULES

    if as_json:
        say_json({"rules": [_plain(rule) for rule in RULES]})
        return exits.OK
    wide = max(len(rule.id) for rule in RULES)
    for rule in RULES:
        say(f"{rule.id:{wide}}  {rule.severity:7}  {rule.title}")
    return exits.OK


def say_rule(name: str, as_json: bool) -> int:
    """Print the full description of a rule, and return the exit code."""
    from text2sim.lint.rules import RULES, find_rule
    from text2sim.service.descriptions import describe_rule

    rule = find_rule(name)
    if rule is None:
        hint = nearest(name, [rule.id for rule in RULES])
        end = f"; did you mean `{hint}`?" if hint else ""
        aside = "other tags are those of errors, whose messages say it all"
        if "/" in name or "." in name:
            aside = "--settings says which settings were derived"
        say(f"the lint has no rule `{name}`{end} (--rules lists them; {aside})", to=sys.stderr)
        return exits.INPUT
    if as_json:
        say_json(_plain(rule))
        return exits.OK
    say(describe_rule(rule))
    return exits.OK


def _plain(rule: "Rule") -> dict[str, Any]:
    return {field.name: getattr(rule, field.name) for field in fields(rule) if field.name != "run"}
