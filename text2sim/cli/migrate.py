"""The command `text2sim migrate`."""

from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.options import AsJson
from text2sim.cli.output import say
from text2sim.service.phrases import display_path
from text2sim.spec_schema.text.source import Source


def migrate(
    cases: Annotated[list[Path], typer.Argument(help="Case folders, case.yaml files, or folders of cases.")],
    check: Annotated[bool, typer.Option("--check", help="Write nothing; exit 1 if a file would change.")] = False,
    as_json: AsJson = False,
) -> None:
    """Convert cases of older versions of the language to the latest one. Comments are kept."""
    from text2sim.cli.cases import rewrite_cases
    from text2sim.spec_schema.changes.edit import edit_source
    from text2sim.spec_schema.reuse.migration import LATEST, steps_for
    from text2sim.spec_schema.text.document import parse_document

    def change(source: Source) -> str:
        steps = steps_for(parse_document(source).data)
        return edit_source(source, steps) if steps else source.text

    def report(source: Source, text: str) -> None:
        old = parse_document(source).data["text2sim"]
        file = display_path(Path(source.file))
        say(f"{file}: version {old} {'would become' if check else 'is now'} version {LATEST}")

    rewrite_cases(cases, change, report, keep=check, as_json=as_json)
