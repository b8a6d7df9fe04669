"""Writers of sections: each returns its section, or a patch on it, without seeing the others' drafts."""

import copy
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.agents import kind_words, language
from text2sim.agents.assembly import FROZEN_PARTS, PLANNER_PARTS, names_for_owner, section_faults
from text2sim.agents.conversation import Conversation, Wrong, typed_parser
from text2sim.agents.page_requests import PageRequests
from text2sim.agents.page_selection import (
    BELT,
    BELT_WORDS,
    CONTROL_WORDS,
    CONTROLS_OF_EVENTS,
    COPIES,
    DEFORMABLE_KINDS,
    FIELD_CONTROLS,
    IN_STAGES,
    LIGHT_WORDS,
    MOTORED,
)
from text2sim.agents.replies import SECTIONS, CasePlan, Refer
from text2sim.agents.revising import mapping
from text2sim.agents.roles import ROLES, render, writer_prompt
from text2sim.agents.yaml_text import yaml_text
from text2sim.spec_schema.changes.patch import PatchError, apply_operations, same
from text2sim.spec_schema.text.canonical import format_text

_DENIED = re.compile(r"\b(?:never|without) [a-z_]+")
"""What a brief rules out."""
AS_WORDS = frozenset({"ball", "beam", "line", "free", "text", "still", "reach", "rest", "leaves", "turns", "mounted"})
"""Kinds whose names usually mean something else in a description: `ball` is not the mount."""
MAX_REASON_LENGTH = 300
"""Longest reason for leaving a section unchanged [characters]."""
MAX_GIST_LENGTH, MAX_GISTS_LENGTH = 200, 1_200
"""Longest description of a body for the Render Writer, unless all descriptions together are short [characters]."""


@dataclass(frozen=True)
class Unchanged:
    """A Writer's statement that its section need not change."""

    why: str


@dataclass(frozen=True)
class Change:
    """A change that a Writer is asked for."""

    instruction: str
    problems: Sequence[str] = ()
    """Problems of its section from the check of the whole case."""
    cards: str = ""
    """Debug Cards for it."""
    keep: Sequence[str] = ()
    """What holds now and must stay true."""
    derived: str = ""
    """Derived settings that the case leaves open."""
    left: str = ""
    """Sentence with the attempts and time left."""


def write_section(
    chat: Conversation,
    section: str,
    plan: CasePlan,
    request: str,
    supplied: str,
    cards: str,
    path: Path,
    shapes: Mapping[str, Any] | None = None,
    left: str = "",
) -> dict[str, Any]:
    """Have a Writer write its section for the first time.

    Args:
        chat: The conversation with the models.
        section: Name of the section.
        plan: The plan.
        request: Text of the request.
        supplied: Notes on the work of asset agents.
        cards: Debug Cards for the Writer.
        path: Future path of the case file.
        shapes: Shapes by asset agents, by body or static; they are put into the answer.
        left: Sentence with the attempts and time left.
    """
    question = render(
        "draft",
        section=section,
        pages=writer_pages(section, plan),
        request=request,
        plan=plan_for(section, plan),
        supplied="" if section == "render" else supplied,
        cards=cards,
        brief=plan.briefs.get(section, ""),  # type: ignore[call-overload]
        left=left,
    )

    def read(data: Any) -> dict[str, Any]:
        return _section_of(_with_shapes(data, section, shapes or {}), section, plan, path)

    prompt = writer_prompt(ROLES[section], language.rules(brief=True, reader=section))
    return chat.ask(section, prompt, question, read, read_pages=PageRequests())


def change_section(
    chat: Conversation,
    section: str,
    plan: CasePlan,
    case: Mapping[str, Any],
    change: Change,
    path: Path,
    request: str = "",
) -> dict[str, Any] | Refer | Unchanged:
    """Have a Writer change its section.

    Args:
        chat: The conversation with the models.
        section: Name of the section.
        plan: The plan.
        case: The present case.
        change: The required change.
        path: Path of the case file.
        request: Text of the request.

    Returns:
        The new section, a referral to another role, or why nothing has to change.
    """
    current = mapping(case, section)
    deforming = {body.kind for body in plan.bodies.values()} & DEFORMABLE_KINDS  # controls of them have further fields
    wrong = "\n".join(f"- {problem}" for problem in change.problems)
    named = "".join(f" `{kind}`" for kind in _named_controls(section, current, f"{change.instruction} {wrong}"))
    question = render(
        "change",
        request=request,
        event=plan.event,
        shared=plan.shared,
        params=yaml_text({"params": mapping(case, "params")}),
        names=names_for_owner(case, section=section),
        current=format_text(json.dumps({section: current}, ensure_ascii=False)).strip(),
        derived=change.derived,
        cards=change.cards,
        problems=wrong,
        keep=change.keep,
        left=change.left,
        instruction=change.instruction,
        pages=language.named_reference(
            section, f"{change.instruction} {_quoted(wrong)}{named}", _kinds_there(current) | deforming
        ),
    )

    def read(data: Any) -> dict[str, Any] | Refer | Unchanged:
        if isinstance(data, dict) and "refer" in data:
            answer: Refer = typed_parser(Refer)(data["refer"])
            if answer.section == section:
                raise Wrong(["/refer/section: that is your own section"])
            return answer
        if isinstance(data, dict) and "patch" in data:
            changed = _patched(data["patch"], section, case, plan, path)
            why = " ".join(str(data.get("why") or "").split())
            return changed if data["patch"] else Unchanged(why[:MAX_REASON_LENGTH])
        return _section_of(data, section, plan, path, mapping(case, "prefabs"))

    prompt = writer_prompt(ROLES[section], language.rules(brief=True, reader=section), change=True)
    return chat.ask(section, prompt, question, read, read_pages=PageRequests())


def _named_controls(section: str, data: Mapping[str, Any], text: str) -> list[str]:
    """Kinds of the controls that a text names."""
    controls = data.get("controls") if section == "actions" else None
    words = set(re.findall(r"[A-Za-z_][A-Za-z_0-9]*", text))
    named = [row for name, row in controls.items() if name in words] if isinstance(controls, Mapping) else []
    return sorted({str(row["kind"]) for row in named if isinstance(row, Mapping) and "kind" in row})


def _kinds_there(data: Any) -> set[str]:
    """All kinds in a section."""
    if isinstance(data, list):
        return {kind for row in data for kind in _kinds_there(row)}
    if not isinstance(data, Mapping):
        return set()
    kinds = {str(data["kind"])} if isinstance(data.get("kind"), str) else set()
    return kinds.union(*(_kinds_there(row) for row in data.values()))


def _quoted(problems: str) -> str:
    """Paths and quoted words in problems; their other words are plain English."""
    return " ".join(re.findall(r"`[^`]+`|(?<=- )/[^\s:]+", problems))


def plan_for(section: str, plan: CasePlan) -> str:
    """Return the parts of a plan that a section's Writer needs, as YAML, except what its prompt states elsewhere."""
    data: dict[str, Any] = {"event": plan.event, "duration": plan.duration}
    if plan.mode:
        data["mode"] = plan.mode
    if plan.params:
        data["params"] = plan.params
    always = {"scene": ("static",), "bodies": ()}.get(section)
    bodies = {}
    cut = section == "render" and sum(len(body.what) for body in plan.bodies.values()) > MAX_GISTS_LENGTH
    for name, body in plan.bodies.items():
        row = body.model_dump(mode="json", exclude_defaults=True)
        # Who films needs short descriptions; the Scene Writer needs only the kinds of moving bodies.
        if cut and len(body.what) > MAX_GIST_LENGTH:
            row["what"] = gist(body.what, MAX_GIST_LENGTH)
        bodies[name] = {"kind": body.kind} if always and body.kind not in always else row
    data["bodies"] = bodies
    if section != "render":
        data["shared"] = plan.shared
    if section == "actions":
        data["checks"] = {part: getattr(plan.checks, part) for part in FROZEN_PARTS if getattr(plan.checks, part)}
    elif section == "render":
        data["must come true"] = list(plan.says.values())
    if section in ("bodies", "render") and plan.assumptions:
        data["assumptions"] = plan.assumptions
    return yaml_text({key: row for key, row in data.items() if row})


def gist(text: str, most: int) -> str:
    """Cut a longer text to `most` characters: after a sentence in their second half, or else after a word."""
    ends = [found.end() for found in re.finditer(r"[.;](?=\s)", text) if most / 2 <= found.end() <= most]
    words = text[:most].rpartition(" ")[0] or text[:most]
    return f"{text[: ends[-1]] if ends else words.rstrip(' ,:-')} …"


def writer_pages(section: str, plan: CasePlan) -> str:
    """Return the pages that the Writer of a section gets for a plan."""
    brief = plan.briefs.get(section, "")  # type: ignore[call-overload]
    # Shared notes mention forces and motions that others write, so the Action Writer's kinds come from its brief alone.
    kinds = _kinds_for(section, plan, brief if section == "actions" else " ".join([brief, *plan.shared]))
    pages = language.reference_pages(section, kinds)
    if section in ("scene", "bodies") and (used := _prefabs_of(plan)):
        pages += "\n\nPrefabs\n\n" + language.prefabs(only=used)
    return pages


def _kinds_for(section: str, plan: CasePlan, words: str) -> set[str]:
    """Kinds that a Writer will need: those of its own bodies, and those that its brief names."""
    if section not in ("scene", "bodies"):
        mentioned = set(re.findall(r"[a-z][a-z_]+", _DENIED.sub("", words.lower())))
        given = needed_kinds(plan.model_copy(update={"checks": type(plan.checks)()}))
        found = given | kind_words.kinds_in(mentioned - set(plan.bodies)) - {"ball"}  # names of bodies are not kinds
        if not given & (DEFORMABLE_KINDS | {"pbd"}):
            found -= FIELD_CONTROLS
        if section == "actions":  # the Planner writes the measures; the Writer adds those that its brief quotes
            found -= set(language.measured_kinds()) - set(re.findall(r"`([a-z_]+)`", plan.briefs.get("actions", "")))
            parts = {part for word in mentioned - set(plan.bodies) for part in word.split("_")}  # of `door_spring`
            found |= {kind for kind, meant in CONTROL_WORDS.items() if {kind, *meant} & parts}
            denied = "release" in kind_words.kinds_in(set(re.findall(r"[a-z]+", words.lower()))) - found
            found |= {"release"} if "attach" in found and not denied else set()
            events = {str(row.get("kind")) for row in plan.checks.events.values()}
            found |= {kind for event in events for kind in CONTROLS_OF_EVENTS.get(event, ())}
            found |= language.schedules_in_examples(found)
            found |= {"piecewise"} if mentioned & IN_STAGES else set()
            found |= {"drive"} if given & MOTORED else set()
        elif LIGHT_WORDS.search(words):
            found.add("softbox")
        return found
    statics = section == "scene"
    own = {name: body for name, body in plan.bodies.items() if (body.kind == "static") == statics}
    found = needed_kinds(plan.model_copy(update={"bodies": own, "checks": type(plan.checks)()}))
    if statics:  # the moving bodies determine the solvers
        found |= {body.kind for body in plan.bodies.values()} | ({"fem"} if "fem" in words.lower() else set())
        said = " ".join([words, *(f"{name} {body.what}" for name, body in own.items())]).lower()
        found |= {BELT} if BELT_WORDS & set(re.findall(r"[a-z]+_velocity|[a-z]+", said)) else set()
        found |= {"pairs"} if re.search(r"\bpairs?\b", words) else set()  # friction of two bodies is set in the scene
    elif "articulated" in found:  # joints and links of mechanisms are told in shared notes
        named = kind_words.kinds_in(set(re.findall(r"[a-z_]+", words.lower())))
        found |= named & {*language.mount_kinds(), *language.shape_kinds()} - AS_WORDS
    return found


def needed_kinds(plan: CasePlan) -> set[str]:
    """Return the kinds of bodies, shapes, mounts, measures and events that a plan names."""
    found = set(plan.mode)
    for body in plan.bodies.values():
        words = set(re.findall(r"[a-z][a-z_]+", f"{body.kind} {body.shape} {body.mount} {body.what}".lower()))
        words |= {word.removesuffix("s") for word in words}
        found |= {body.kind, body.shape, body.mount} | (words & kind_words.known_kinds() - AS_WORDS)
        if body.count > 1:
            found |= {"line", "grid", "stack", "ring"} if not words & COPIES else set()
    for part in ("measures", "events"):
        found |= {str(row.get("kind")) for row in getattr(plan.checks, part).values()}
    return found


def _prefabs_of(plan: CasePlan) -> set[str]:
    from text2sim.spec_schema.reuse.catalogue import examples

    return {word for body in plan.bodies.values() for word in (body.kind, body.shape)} & set(examples())


def _with_shapes(data: Any, section: str, shapes: Mapping[str, Any]) -> Any:
    """Put the shapes of asset agents into an answer of the Scene or Body Writer."""
    if section not in ("scene", "bodies") or not isinstance(data, dict):
        return data
    inner = data.get(section, data)
    rows = inner.get("statics") if section == "scene" and isinstance(inner, dict) else inner
    if isinstance(rows, dict):
        for name, shape in shapes.items():
            if isinstance(rows.get(name), dict):
                rows[name] = {**rows[name], "shape": shape}
    return data


def _section_of(
    data: Any, section: str, plan: CasePlan, path: Path, prefabs: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Take the section out of an answer."""
    if not isinstance(data, dict):
        raise Wrong([f"answer with a mapping that has the key `{section}`"])
    inner = data.get(section, data)
    if section not in data and set(data) & {*SECTIONS, "text2sim"}:
        raise Wrong([f"`{section}` is your section, and the only one you write"])
    if not isinstance(inner, dict):
        raise Wrong([f"/{section}: has to be a mapping"])
    if section in data and (others := sorted({*SECTIONS, *PLANNER_PARTS} & set(data) - {section})):
        raise Wrong([f"/{other}: not yours; `refer` what has to change there, or leave it out" for other in others])
    inner = _without_planned(section, inner, plan)
    if wrong := section_faults(section, inner, plan, path, prefabs):
        raise Wrong(wrong)
    return inner


def _without_planned(section: str, data: dict[str, Any], plan: CasePlan) -> dict[str, Any]:
    """Remove the Planner's entries, which must not be changed."""
    if section != "actions":
        return data
    kept, wrong = dict(data), []
    for part in FROZEN_PARTS:
        if isinstance(kept.get(part), dict):
            planned = getattr(plan.checks, part)
            wrong += [
                f"/actions/{part}/{name}: it comes from the request, stands as {row}, and is not yours to change"
                for name, row in planned.items()
                if name in kept[part] and not same(kept[part][name], row)
            ]
            kept[part] = {name: row for name, row in kept[part].items() if name not in planned}
            if not kept[part]:
                del kept[part]
    if wrong:
        raise Wrong(wrong)
    return kept


def _patched(operations: Any, section: str, case: Mapping[str, Any], plan: CasePlan, path: Path) -> dict[str, Any]:
    if not isinstance(operations, list):
        raise Wrong(["/patch: has to be a list of operations"])
    rows = [(k, row) for k, row in enumerate(operations) if isinstance(row, dict)]
    wrong = [
        f"/patch/{k}: `{place}` is not below /{section}"
        for k, row in rows
        for place in (row.get("path"), row.get("from", row.get("path")))
        if not str(place).startswith(f"/{section}/") and str(place) != f"/{section}"
    ]
    frozen = tuple(f"/actions/{part}/{name}/" for part in FROZEN_PARTS for name in getattr(plan.checks, part))
    wrong += [
        f"/patch/{k}: {row['path']} comes from the request and is not yours to change"
        for k, row in rows
        if row.get("op") != "test" and f"{row.get('path')}/".startswith(frozen)
    ]
    if wrong:
        raise Wrong(wrong)
    try:
        # The case may not have this section yet.
        changed = apply_operations(copy.deepcopy({**case, section: mapping(case, section)}), operations)
    except PatchError as error:
        raise Wrong([f"/patch: {error}"]) from None
    return _section_of({section: changed.get(section) or {}}, section, plan, path, mapping(case, "prefabs"))
