"""Output of commands about cases, and the loop of commands that rewrite them."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import typer

from text2sim.cli.output import say, say_json, say_problems
from text2sim.revision.files import rewrite
from text2sim.service import exits
from text2sim.service.examined import Examined, case_file, find_cases
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import Text2SimError
from text2sim.spec_schema.text.source import Source, read_source


def say_examined(case: Examined) -> None:
    """Print the problems of a case."""
    if case.failure:
        say(f"{display_path(case.path)}: {case.failure}", to=sys.stderr)
    say_problems(case.problems, case.sources)


def rewrite_cases(
    cases: list[Path],
    change: Callable[[Source], str],
    report: Callable[[Source, str], None],
    *,
    keep: bool,
    as_json: bool,
) -> NoReturn:
    """Rewrite the files of cases, report the changes, and exit.

    Args:
        cases: Cases, or folders of cases.
        change: Returns the new text of a file, or the same text.
        report: Prints the changes of a file, given its new text; not called with `as_json`.
        keep: Write nothing; the exit code tells whether a file would change.
        as_json: Print one JSON document.

    Raises:
        typer.Exit: Always.
    """
    code, documents = exits.OK, list[dict[str, Any]]()
    for path in find_cases(cases):
        file = case_file(path)
        try:
            source = read_source(file)
            text = change(source)
            changed = text != source.text
            if changed and not keep:
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
        if changed:
            code = max(code, exits.PHYSICS if keep else exits.OK)
            if not as_json:
                report(source, text)
    if as_json:
        say_json({"ok": code == exits.OK, "files": documents})
    raise typer.Exit(code)
