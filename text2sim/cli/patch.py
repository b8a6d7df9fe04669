"""The command `text2sim patch`."""

import difflib
import sys
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.options import AsJson
from text2sim.cli.output import say, say_json, say_problems
from text2sim.revision.files import rewrite
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.text.source import decode_source, read_source

if TYPE_CHECKING:
    from text2sim.revision.patch_file import PatchFile
    from text2sim.revision.revise import Revision


class Section(StrEnum):
    """Sections that an author of patches may own."""

    scene = "scene"
    bodies = "bodies"
    actions = "actions"
    render = "render"


def patch(
    case: Annotated[Path, typer.Argument(help="A case folder or case.yaml file.")],
    operations: Annotated[str, typer.Argument(metavar="PATCH.JSON", help="RFC 6902 operations; - reads from stdin.")],
    owner: Annotated[
        Section | None, typer.Option("--owner", help="The only section that the patch may change.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Write nothing; print what would change.")] = False,
    as_json: AsJson = False,
) -> None:
    """Apply a patch to a case, completely or not at all; comments and order are kept.

    The result must be a valid case without new lint errors.
    """
    from text2sim.revision.patch_file import read_patch
    from text2sim.revision.revise import RefusedPatch, revise
    from text2sim.service.examined import case_file
    from text2sim.spec_schema.changes.patch import PatchError

    file = case_file(case)
    source = read_source(file)
    given = decode_source(sys.stdin.buffer.read(), "-") if operations == "-" else read_source(Path(operations))
    wanted = read_patch(given)
    try:
        revision = revise(source, file, wanted.operations, owner.value if owner is not None else None)
        if not dry_run and revision.text != source.text:
            rewrite(file, source, revision.text)
    except PatchError as error:
        problem = wanted.problem(error)
        if as_json:
            say_json({"ok": False, "file": str(file), "operation": error.index, "problems": [problem.as_dict()]})
        else:
            say_problems([problem], {given.file: given.text})
        raise typer.Exit(exits.INPUT) from None
    except RefusedPatch as refused:
        _say_refused(refused, file, wanted, as_json)
        raise typer.Exit(exits.INPUT) from None
    if as_json:
        say_json(_document(revision, file, dry_run))
    else:
        _say(revision, file, len(wanted.operations), dry_run)


def _say(revision: "Revision", file: Path, count: int, dry_run: bool) -> None:
    from text2sim.spec_schema.changes.diff_words import change_line

    say_problems([*revision.remaining, *revision.warnings], {str(file): revision.text})
    for change in revision.changes:
        say(change_line(change))
    if dry_run:
        before, after = revision.source.text.splitlines(keepends=True), revision.text.splitlines(keepends=True)
        for line in difflib.unified_diff(before, after, display_path(file), f"{display_path(file)} (patched)"):
            say(line.rstrip("\r\n"))
    if revision.text == revision.source.text:
        say(f"{display_path(file)}: the patch changes nothing")
    else:
        say(
            f"{display_path(file)}: {count} operation{'s' if count != 1 else ''} "
            f"{'would be ' if dry_run else ''}applied"
        )


def _say_refused(refused: Any, file: Path, wanted: "PatchFile", as_json: bool) -> None:
    if as_json:
        rows = zip(refused.problems, refused.blame, strict=True)
        problems = [problem.as_dict() | {"operation": index} for problem, index in rows]
        say_json({"ok": False, "file": str(file), "problems": problems})
        return
    say_problems(refused.problems, {str(file): refused.text})
    for index in sorted({index for index in refused.blame if index is not None}):
        operation = wanted.operations[index]
        say(f"    caused by operation {index + 1} ({operation['op']} {operation['path']})", to=sys.stderr)
    say(f"{display_path(file)} would be invalid with this patch, and is not changed", to=sys.stderr)


def _document(revision: "Revision", file: Path, dry_run: bool) -> dict[str, Any]:
    from text2sim.spec_schema.changes.diff_words import change_line

    return {
        "ok": True,
        "file": str(file),
        "written": not dry_run and revision.text != revision.source.text,
        "changes": [change_line(change) for change in revision.changes],
        "undo": revision.undo,
        "warnings": [problem.as_dict() for problem in revision.warnings],
        "remaining": [problem.as_dict() for problem in revision.remaining],
    }
