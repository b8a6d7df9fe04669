"""The command `text2sim migrate`."""

from pathlib import Path
from typing import Annotated

import typer

from text2sim.service import exits


def migrate(
    cases: Annotated[list[Path], typer.Argument(help="Case folders, case.yaml files, or folders of cases.")],
    check: Annotated[bool, typer.Option("--check", help="Write nothing; exit 1 if a file would change.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
) -> None:
    """Convert cases of older versions of the language to the latest one. Comments stay."""
    from text2sim.cli.cases import say_examined
    from text2sim.cli.output import say, say_json
    from text2sim.revision.files import rewrite
    from text2sim.service.examined import Examined, case_file, find_cases
    from text2sim.service.phrases import shown
    from text2sim.spec_schema.changes.edit import edit_source
    from text2sim.spec_schema.errors import Text2SimError
    from text2sim.spec_schema.reuse.migration import LATEST, steps_for
    from text2sim.spec_schema.text.document import parse_document
    from text2sim.spec_schema.text.source import read_source

    code, documents = exits.OK, []
    for path in find_cases(cases):
        file = case_file(path)
        try:
            source = read_source(file)
            data = parse_document(source).data
            steps = steps_for(data)
            if steps and not check:
                rewrite(file, source, edit_source(source, steps))
        except (Text2SimError, OSError) as error:
            row = Examined(file)
            row.blame(error)
            code = max(code, row.exit)
            documents.append(row.as_dict())
            if not as_json:
                say_examined(row)
            continue
        documents.append({"file": str(file), "changed": bool(steps), "problems": []})
        if steps:
            code = max(code, exits.PHYSICS if check else exits.OK)
            if not as_json:
                old = data["text2sim"]
                say(f"{shown(file)}: version {old} {'would become' if check else 'is now'} version {LATEST}")
    if as_json:
        say_json({"ok": code == exits.OK, "files": documents})
    raise typer.Exit(code)
