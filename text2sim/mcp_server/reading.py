"""Tools that read a case: its problems and its contents."""

from typing import TYPE_CHECKING, Any

from text2sim.mcp_server.answers import (
    MAX_PICTURE,
    ToolAnswer,
    clipped,
    compressed,
    digest,
    paged,
    problem_rows,
    refusal,
    text_page,
)
from text2sim.mcp_server.workspace import Workspace
from text2sim.service.examined import Examined, examine
from text2sim.spec_schema.errors import Text2SimError, did_you_mean
from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.text.source import read_source

if TYPE_CHECKING:
    from text2sim.compiler.build import Resolution
    from text2sim.compiler.explicit import Explicit

PARTS = ("summary", "text", "resolved")
"""Parts that `show` can print besides single bodies."""


def check(workspace: Workspace, case: str, overlay: CaseOverlay, *, settings: bool, offset: int) -> ToolAnswer:
    """Find all problems of a case.

    Args:
        workspace: The workspace.
        case: The case.
        overlay: Its overlay.
        settings: Whether derived solver settings are listed, too.
        offset: Number of the first problem to list.
    """
    return ToolAnswer(verdict(examine(workspace.case_file(case), overlay=overlay), offset, settings=settings))


def verdict(row: Examined, offset: int = 0, *, settings: bool = False) -> dict[str, Any]:
    """Return the result of examining a case.

    Args:
        row: The case.
        offset: Number of the first problem to list.
        settings: Whether derived solver settings are listed, too.
    """
    errors = sum(problem.severity == "error" for problem in row.problems)
    page = paged(problem_rows(row.problems, row.sources), offset)
    document: dict[str, Any] = {"case": row.name, "file": str(row.path), "ok": row.ok}
    if row.loaded is not None:
        document["digest"] = digest(row.loaded.source.text)
    if row.failure:
        document["error"] = clipped(row.failure)
    document |= {"errors": errors, "warnings": len(row.problems) - errors, "problems": page["rows"]}
    if "next_offset" in page:
        document["next_offset"] = page["next_offset"]
    if row.waived:
        document["waived"] = clipped([waived.as_dict() for waived in row.waived], 8)
    if settings and row.plan is not None:
        document["settings"] = clipped(list(row.plan.notes), 40)
    return document


def show(workspace: Workspace, case: str, overlay: CaseOverlay, *, part: str, picture: bool, offset: int) -> ToolAnswer:
    """Describe a case, and draw its start.

    Args:
        workspace: The workspace.
        case: The case.
        overlay: Its overlay.
        part: `summary`, `text`, `resolved`, or the name of a body.
        picture: Whether to add a picture of the start.
        offset: Number of the first character of the page.
    """
    file = workspace.case_file(case)
    if part == "text":
        source = read_source(file)
        piece, page = text_page(source.text, offset)
        return ToolAnswer({"file": str(file), "digest": digest(source.text), **page}, piece)
    from text2sim.compiler.build import resolve_case
    from text2sim.compiler.explicit import explicit

    row = examine(file, to="loaded", overlay=overlay)
    if row.loaded is None:
        return ToolAnswer(verdict(row), failed=True)
    try:
        resolution = resolve_case(row.loaded)
    except Text2SimError as error:
        row.blame(error)
        return ToolAnswer(verdict(row), failed=True)
    found = explicit(resolution)
    document: dict[str, Any] = {"case": row.name, "file": str(file), "digest": digest(row.loaded.source.text)}
    answer = ToolAnswer(document)
    if part == "summary":
        document |= _summary(resolution, found)
    else:
        if part != "resolved":
            known = [*found.data["scene"].get("statics", {}), *found.data["bodies"]]
            if part not in known:
                hint = did_you_mean(part, [*known, *PARTS])
                return refusal(f"`part` is one of {', '.join(PARTS)}, or a body or static of the case{hint}")
            found = found.only(part)
        answer.text, page = text_page(found.text(), offset)
        document |= page
    if picture:
        answer.picture, answer.media = _picture(resolution, overlay)
    return answer


def _summary(resolution: "Resolution", found: "Explicit") -> dict[str, Any]:
    """Names and kinds of the contents of a case."""
    case, plan, data = resolution.loaded.case, resolution.plan, found.data
    actions = data.get("actions", {})
    bodies = {}
    for name, body in data["bodies"].items():
        copies = len(resolution.placed.get(name, ()))
        bodies[name] = " ".join(filter(None, (body["kind"], _shape(body), f"×{copies}" if copies > 1 else "")))
    return {
        "prompt": clipped(case.prompt),
        "duration": case.scene.duration,
        "dt": plan.dt,
        "substeps": plan.settings.substeps,
        "statics": clipped({name: _shape(body) for name, body in data["scene"].get("statics", {}).items()}),
        "bodies": clipped(bodies),
        **{
            section: clipped({name: row.get("kind", "") for name, row in actions.get(section, {}).items()})
            for section in ("controls", "measures", "events")
        },
        "expect": clipped(list(actions.get("expect", {}))),
        "cameras": clipped(list(data["render"].get("cameras", {}))),
        "variants": clipped(list(resolution.loaded.written.data.get("variants") or {})),
        "sweeps": clipped(list(resolution.loaded.written.data.get("sweeps") or {})),
        "more": "part: text (as written), resolved (with all defaults), or the name of a body",
    }


def _shape(body: dict[str, Any]) -> str:
    shape = body.get("shape")
    return str(shape.get("kind", "")) if isinstance(shape, dict) else ""


def _picture(resolution: "Resolution", overlay: CaseOverlay) -> tuple[bytes, str]:
    """The picture of a case's start, and its type."""
    from text2sim.drawing.layout import layout

    page = layout(resolution, ", ".join(overlay.words))
    return (page, "image/png") if len(page) <= MAX_PICTURE else compressed(page)
