"""The command `text2sim fmt`."""

import difflib
from pathlib import Path
from typing import Annotated

import typer

from text2sim.service import exits


def fmt(
    cases: Annotated[list[Path], typer.Argument(help="Case folders, case.yaml files, or folders of cases.")],
    check: Annotated[bool, typer.Option("--check", help="Write nothing; exit 1 if a file would change.")] = False,
    diff: Annotated[bool, typer.Option("--diff", help="Write nothing; print what would change.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> None:
    """Format cases in the canonical form: order, indentation, quotes. Comments stay."""
    from text2sim.cli.cases import say_examined
    from text2sim.cli.output import say, say_json
    from text2sim.revision.files import rewrite
    from text2sim.service.examined import Examined, case_file, find_cases
    from text2sim.service.phrases import shown
    from text2sim.spec_schema.errors import Text2SimError
    from text2sim.spec_schema.text.canonical import format_source
    from text2sim.spec_schema.text.source import read_source

    code, documents = exits.OK, []
    for path in find_cases(cases):
        file = case_file(path)
        try:
            source = read_source(file)
            text = format_source(source)
            changed = text != source.text
            if changed and not (check or diff):
                rewrite(file, source, text)
        except (Text2SimError, OSError) as error:
            row = Examined(file)
            row.blame(error)
            code = max(code, row.exit)
            documents.append(row.as_dict())
            if not as_json:
                say_examined(row)
            continue
        documents.append({"file": str(file), "changed": changed, "problems": []})
        if not changed:
            continue
        if check or diff:
            code = max(code, exits.PHYSICS)
        if diff and not as_json:
            before, after = source.text.splitlines(keepends=True), text.splitlines(keepends=True)
            for line in difflib.unified_diff(before, after, shown(file), f"{shown(file)} (canonical)"):
                say(line.rstrip("\n"))
        elif not as_json:
            say(f"{'would change' if check else 'changed'}: {shown(file)}")
    if as_json:
        say_json({"ok": code == exits.OK, "files": documents})
    raise typer.Exit(code)
