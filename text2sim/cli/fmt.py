"""The command `text2sim fmt`."""

import difflib
from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.options import AsJson
from text2sim.cli.output import say
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.text.source import Source

KEYS = {"text2sim", "name", "scene", "bodies", "actions", "render", "prefab"}
"""A file with none of these keys is not ours to rewrite."""


def fmt(
    cases: Annotated[list[Path], typer.Argument(help="Case folders, case.yaml files, or folders of cases.")],
    check: Annotated[bool, typer.Option("--check", help="Write nothing; exit 1 if a file would change.")] = False,
    diff: Annotated[bool, typer.Option("--diff", help="Write nothing; print what would change.")] = False,
    as_json: AsJson = False,
) -> None:
    """Format cases canonically: order, indentation, quotes. Comments are kept."""
    from text2sim.cli.cases import rewrite_cases
    from text2sim.spec_schema.text.canonical import format_source
    from text2sim.spec_schema.text.document import parse_document

    def change(source: Source) -> str:
        document = parse_document(source)
        if not isinstance(document.data, dict) or not document.data.keys() & KEYS:
            raise SpecError(
                [document.problem((), "is neither a case nor a prefab, so it is left as it is", rule="type")]
            )
        return format_source(source)

    def report(source: Source, text: str) -> None:
        file = display_path(Path(source.file))
        if not diff:
            say(f"{'would change' if check else 'changed'}: {file}")
            return
        before, after = source.text.splitlines(keepends=True), text.splitlines(keepends=True)
        for line in difflib.unified_diff(before, after, file, f"{file} (canonical)"):
            say(line.rstrip("\n"))

    rewrite_cases(cases, change, report, keep=check or diff, as_json=as_json)
