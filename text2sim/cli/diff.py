"""The command `text2sim diff`."""

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.output import say, say_json
from text2sim.cli.verdict import MARKS
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.plain import plain

if TYPE_CHECKING:
    from text2sim.revision.compare import CaseComparison
    from text2sim.revision.side import Side

MAX_SHOWN_EFFECTS = 20
"""Largest number of derived values that are printed."""
_STYLES = {"+": "green", "-": "red", ">": "cyan", "~": "yellow", "=": "dim"}
_HELP = "A case, its folder, one of its revisions (`case.yaml@HEAD~1`), a variant (`case.yaml+soft`), or a run folder."
_Options = Annotated[list[str] | None, typer.Option(metavar="NAME", help="Apply this variant to it; several in order.")]


def diff(
    a: Annotated[str, typer.Argument(help=_HELP)],
    b: Annotated[str, typer.Argument(help="Another.")],
    variant_a: _Options = None,
    variant_b: _Options = None,
    runs: Annotated[Path, typer.Option("--runs", help="Folder of runs: results of both are compared, too.")] = Path(
        "runs"
    ),
    stat: Annotated[bool, typer.Option("--stat", help="Only count the differences.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the RFC 6902 patch that turns A into B.")] = False,
) -> None:
    """Show how two versions of a case differ in meaning; order, comments and format do not count.

    Exit codes: 0 same meaning, 1 different, 2 one cannot be read.
    """
    from text2sim.revision.compare import compare
    from text2sim.revision.side import open_side
    from text2sim.spec_schema.reuse.overlay import CaseOverlay

    with ExitStack() as stack:
        one = stack.enter_context(open_side(a, CaseOverlay(tuple(variant_a or ()))))
        other = stack.enter_context(open_side(b, CaseOverlay(tuple(variant_b or ()))))
        found = compare(one, other, runs if not (stat or as_json) and runs.is_dir() else None)
    if as_json:
        say_json(found.operations)
    else:
        for side in (one, other):
            _say_invalid(side)
        for line in stat_lines(found) if stat else report_lines(found):
            say_line(line)
    raise typer.Exit(exits.OK if found.same else exits.PHYSICS)


def report_lines(found: "CaseComparison") -> list[str]:
    """Return the lines that describe the differences by section, and their consequences."""
    from text2sim.spec_schema.changes.diff_words import change_line, effect_line, sections

    lines = []
    for name, changes in sections(found.changes).items():
        lines += [f"{name or 'case'}:", *(f"  {change_line(change)}" for change in changes)]
    if found.effects:
        lines += ["derived values:", *(f"  {effect_line(effect)}" for effect in found.effects[:MAX_SHOWN_EFFECTS])]
        if len(found.effects) > MAX_SHOWN_EFFECTS:
            lines.append(f"  … and {len(found.effects) - MAX_SHOWN_EFFECTS} more values")
    return [*lines, *_run_lines(found)]


def stat_lines(found: "CaseComparison") -> list[str]:
    """Return the lines that count the differences."""
    from text2sim.spec_schema.changes.diff_words import sections

    lines = []
    for name, changes in sections(found.changes).items():
        kinds = [change.kind if change.kind != "kind" else "changed" for change in changes]
        counts = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
        lines.append(f"{name or 'case'}: {counts}")
    if found.effects:
        lines.append(f"{len(found.effects)} derived value{'s' if len(found.effects) != 1 else ''}")
    return lines


def _run_lines(found: "CaseComparison") -> list[str]:
    from text2sim.revision.compare import STATISTICS

    if found.runs is None:
        return []
    if found.same_simulation:
        return [] if found.same else [f"both give the same simulation: {display_path(found.runs[0])}"]
    lines = [f"results ({display_path(found.runs[0])} → {display_path(found.runs[1])}):"]
    for row in found.measured:
        unit = f" {row.unit}" if row.unit else ""
        pairs = [f"{STATISTICS[key]} {_number(x)} → {_number(y)}{unit}" for key, (x, y) in row.values.items()]
        lines.append(f"  {row.name}  {', '.join(pairs)}")
    for row in found.judged:
        lines.append(f"  {row.name}  {MARKS[row.was]} → {MARKS[row.now]}: {row.why}")
    return lines if len(lines) > 1 else [*lines, "  all measures and expectations agree"]


def _number(value: float | None) -> str:
    return "?" if value is None else f"{value:.4g}"


def _say_invalid(side: "Side") -> None:
    if side.problems:
        say(f"{side.label} is not valid, so that derived values cannot be compared:", to=sys.stderr)
        say(f"  {side.problems[0]}", to=sys.stderr)


def say_line(line: str) -> None:
    """Print a line of a difference, in colour on a terminal."""
    if not sys.stdout.isatty():
        say(line)
        return
    from rich.console import Console
    from rich.text import Text

    bare = line.lstrip(" ")
    style: Any = _STYLES.get(bare[:1], "") if line.startswith(" ") else "bold"
    Console(highlight=False, soft_wrap=True).print(Text(plain(line), style=style))
