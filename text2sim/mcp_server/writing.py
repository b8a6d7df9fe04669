"""Tools that write a case: texts are checked before they are written, and concurrent changes are not overwritten."""

import json
from pathlib import Path
from typing import Any

from text2sim.mcp_server.answers import ToolAnswer, clipped, digest, problem_rows, refusal
from text2sim.mcp_server.reading import verdict
from text2sim.mcp_server.workspace import CASE_FILE, Workspace
from text2sim.revision.files import rewrite
from text2sim.revision.patch_file import read_patch
from text2sim.revision.revise import RefusedPatch, Revision, revise
from text2sim.service.examined import Examined
from text2sim.service.new_case import make_case
from text2sim.spec_schema.changes.diff_words import change_line
from text2sim.spec_schema.changes.patch import PatchError
from text2sim.spec_schema.errors import SpecError, Text2SimError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.source import MAX_BYTES, Source, check_source, read_source
from text2sim.spec_schema.whole_files import write_atomically

MAX_PATCH = 400_000
"""Largest length of a patch [characters]."""
MAX_UNDO = 3_000
"""Largest length of the undo patch [characters]; a longer one is left out."""


def new(workspace: Workspace, case: str, template: str) -> ToolAnswer:
    """Write a case to start from.

    Args:
        workspace: The workspace.
        case: The case to write.
        template: The case to copy; a small one if empty.
    """
    folder = workspace.case_folder(case)
    workspace.refuse_runs(folder)
    source = workspace.case_file(template).parent if template else None
    with workspace.editing():
        file = make_case(folder.name, source, folder.parent)
    return ToolAnswer({"ok": True, "file": str(file), "digest": digest(read_source(file).text)})


def write(workspace: Workspace, case: str, text: str, replaces: str) -> ToolAnswer:
    """Write a whole case, if it has no errors.

    Args:
        workspace: The workspace.
        case: Its folder.
        text: The case.
        replaces: Digest of the existing text; empty if there is none.
    """
    if len(text) > MAX_BYTES:
        return refusal(f"the text has {len(text)} characters; a case has {MAX_BYTES} at most")
    folder = workspace.case_folder(case)
    workspace.refuse_runs(folder)
    file = folder / CASE_FILE
    with workspace.editing():
        old = read_source(workspace.case_file(str(folder))) if file.exists() or file.is_symlink() else None
        if old is None and replaces:
            return refusal(f"{file} does not exist: leave `replaces` out to write a new case")
        if old is not None and replaces != digest(old.text):
            why = "has changed since you read it" if replaces else "already exists"
            advice = "read it with `show`, part: text, and give its digest as `replaces`"
            return refusal(f"{file} {why}; nothing was written: {advice}", digest=digest(old.text))
        row = _checked(text, file)
        if not row.ok:
            return ToolAnswer({"written": False, **verdict(row)}, failed=True)
        if old is not None:
            rewrite(file, old, text)
        else:
            folder.mkdir(parents=True, exist_ok=True)
            write_atomically(file, text)
    return ToolAnswer({"written": True, **verdict(row)})


def _checked(text: str, file: Path) -> Examined:
    """Read, plan and lint a text as if it were in a file; the result has its problems."""
    row = Examined(file)
    try:
        check_source(Source(text, str(file)))
        row.loaded = load_text(text, file)
        row.plan_and_lint()
    except (Text2SimError, OSError) as error:
        row.blame(error)
    # The problems are about this text, not about the file on disk.
    row.sources[str(file)] = text
    return row


def patch(
    workspace: Workspace, case: str, operations: list[dict[str, Any]], owner: str, *, dry_run: bool, replaces: str
) -> ToolAnswer:
    """Apply operations to a case: all of them, or none.

    Args:
        workspace: The workspace.
        case: The case.
        operations: Operations of JSON Patch.
        owner: The only section that may change; every section if empty.
        dry_run: Do not write the file.
        replaces: Digest of the text that the caller has read; not compared if empty.
    """
    given = Source(json.dumps(operations, ensure_ascii=False), "operations")
    if len(given.text) > MAX_PATCH:
        return refusal(f"the patch has {len(given.text)} characters; {MAX_PATCH} are allowed")
    file = workspace.case_file(case)
    workspace.refuse_runs(file.parent)
    with workspace.editing():
        source = read_source(file)
        if replaces and replaces != digest(source.text):
            return refusal(f"{file} has changed since you read it; nothing was written", digest=digest(source.text))
        try:
            wanted = read_patch(given)
            revision = revise(source, file, wanted.operations, owner or None)
            if not dry_run and revision.text != source.text:
                rewrite(file, source, revision.text)
        except PatchError as error:
            return refusal(str(error), operation=error.index, file=str(file))
        except RefusedPatch as refused:
            return _refusal_answer(refused, file)
        except SpecError as error:
            return ToolAnswer({"ok": False, "problems": problem_rows(error.problems[:20])}, failed=True)
    return ToolAnswer(_document(revision, file, dry_run))


def _refusal_answer(refused: RefusedPatch, file: Path) -> ToolAnswer:
    rows = problem_rows(refused.problems, {str(file): refused.text})
    blamed = [
        row | ({"operation": index} if index is not None else {})
        for row, index in zip(rows, refused.blame, strict=True)
    ]
    error = "the case would be invalid with this patch, and is not changed"
    return refusal(error, file=str(file), problems=clipped(blamed, 20))


def _document(revision: Revision, file: Path, dry_run: bool) -> dict[str, Any]:
    document = {
        "ok": True,
        "file": str(file),
        "written": not dry_run and revision.text != revision.source.text,
        "digest": digest(revision.source.text if dry_run else revision.text),
        "changes": clipped([change_line(change) for change in revision.changes]),
        "warnings": clipped(problem_rows(revision.warnings, {str(file): revision.text}), 15),
        "errors_that_were_there_before": clipped(problem_rows(revision.remaining, {str(file): revision.text}), 15),
    }
    undo = revision.undo
    return document | ({"undo": undo} if len(json.dumps(undo)) <= MAX_UNDO else {})
