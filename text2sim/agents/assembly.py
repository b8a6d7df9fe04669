"""Assembly of a case from sections, and routing of its problems to the role that must fix them."""

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from text2sim.agents.replies import SECTIONS, CasePlan
from text2sim.spec_schema.errors import Problem, SpecError, Text2SimError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.text.canonical import format_text
from text2sim.spec_schema.text.source import plain_text

Data = dict[str, Any]
FROZEN_PARTS = ("measures", "events", "expect")
PLANNER_PARTS = ("params", "waive", "variants", "sweeps", "prefabs", "name", "prompt")
"""Parts of a case that no Writer owns: the Planner patches them."""
_NAME_RULES = frozenset(
    f"unknown-{what}" for what in ("attach", "body", "camera", "event", "joint", "link", "measure", "spring")
)
"""Rules about names, which are meaningless while other sections are missing."""


@dataclass
class Examination:
    """Result of checking a case."""

    text: str
    loaded: LoadedCase | None = None
    errors: list[Problem] = field(default_factory=list)
    warnings: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    """Derived settings."""
    intended: Mapping[tuple[str, str], str] = field(default_factory=dict)
    """Owners' reasons for intended warnings, by rule and path."""
    seconds: float = 0.0
    """Estimated wall time of a run on two idle cores [s]; 0 if unknown."""
    cost: str = ""
    """What makes the run of deformable bodies dear; empty without any."""

    @property
    def derived(self) -> str:
        """One line with the settings that the case leaves open and the compiler derives."""
        rows = [note.partition(": ")[0] for note in self.notes]
        settings = [row for row in rows if " = " in row and not row.startswith(("max_pairs", "tolerance"))]
        found = "; ".join([*settings, *filter(None, [self.cost])])
        return f"derived at the latest check: {found}" if found else ""


def examine(text: str, path: Path) -> Examination:
    """Load, resolve and lint the text of a case as if it were read from `path`."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case

    examination = Examination(text)
    try:
        examination.loaded = load_text(text, path)
        resolution = resolve_case(examination.loaded)
        report = lint_case(resolution)
        problems, examination.seconds, examination.cost = list(report.problems), report.seconds, report.cost
        examination.notes = list(resolution.plan.notes)
    except SpecError as error:
        problems = error.problems
    except Text2SimError as error:
        problems = [Problem("", str(error), file=str(path), rule="asset")]
    examination.errors = [problem for problem in problems if problem.severity == "error"]
    examination.warnings = [problem for problem in problems if problem.severity != "error"]
    return examination


def case_text(plan: CasePlan, request: str, params: Mapping[str, Any], sections: Mapping[str, Any]) -> str:
    """Assemble a case in canonical form.

    The Planner's measures, events and expectations precede those of the Action Writer and override them.

    Args:
        plan: The plan.
        request: Text of the request; its first 2000 characters become `prompt`.
        params: Parameters of the case by name.
        sections: Sections by name, as their Writers wrote them.
    """
    actions = whole_actions(plan, sections.get("actions") or {})
    # `${` in the request is text, not an expression.
    prompt = " ".join(plain_text(request).split())[:2000].replace("${", "$${")
    document = {"text2sim": 2, "name": plan.name, "prompt": prompt, "params": dict(params)}
    document |= {name: sections[name] for name in SECTIONS if name != "actions" and sections.get(name)}
    return format_text(json.dumps({**document, "actions": actions}, ensure_ascii=False))


def whole_actions(plan: CasePlan, section: Mapping[str, Any]) -> Data:
    """Return an actions section that includes the Planner's measures, events and expectations."""
    actions = dict(section)
    for part in FROZEN_PARTS:
        given, own = getattr(plan.checks, part), actions.get(part)
        rows = own.items() if isinstance(own, dict) else ()
        actions[part] = given | {name: row for name, row in rows if name not in given}
        if not actions[part]:
            del actions[part]
    return actions


def section_faults(
    section: str, data: Any, plan: CasePlan, path: Path, prefabs: Mapping[str, Any] | None = None
) -> list[str]:
    """Return the faults in the form of one section while the other sections do not exist yet.

    Args:
        section: Name of the section.
        data: Its content.
        plan: The plan.
        path: Path of the case file.
        prefabs: Prefabs that the case itself defines.
    """
    document: Data = {"text2sim": 2, "name": "draft", "params": plan.params, "scene": {"duration": plan.duration}}
    if prefabs:
        document["prefabs"] = dict(prefabs)
    document["bodies"] = {"stand_in": {"kind": "rigid", "shape": {"kind": "box", "size": [1, 1, 1]}}}
    document[section] = data
    try:
        load_text(format_text(json.dumps(document, ensure_ascii=False)), path)
    except SpecError as error:
        own = [problem for problem in error.problems if owner_of(problem, ()) == section]
        unknown = _NAME_RULES
        if section == "actions" and any(body.count > 1 for body in plan.bodies.values()):
            unknown |= {"copy-variable"}  # a control may act on copies, which are in another section
        return [format_problem(problem) for problem in own if problem.rule not in unknown]
    return []


def owner_of(problem: Problem, frozen: Iterable[str]) -> str:
    """Return who can fix a problem: the owner of a section, or the Planner.

    Args:
        problem: The problem.
        frozen: Pointers to the parts that only the Planner may change.
    """
    steps = problem.path.split("/")
    section = steps[1] if len(steps) > 1 else ""
    if problem.path == "/actions/expect":  # concerns all expectations together
        return "plan"
    # Problems refer to a repeated entry by its numbered copies.
    if any(re.fullmatch(rf"{re.escape(pointer)}(_\d+)?(/.*)?", problem.path) for pointer in frozen):
        return "plan"
    return section if section in SECTIONS else "plan"


def format_problem(problem: Problem) -> str:
    """Format a problem for a model: place, message, nearest valid word, and rule."""
    hint = f"; did you mean `{problem.hint}`?" if problem.hint else ""
    return f"{problem.path or 'the case'}: {problem.message}{hint} [{problem.rule}]"


def names_for_owner(data: Mapping[str, Any], section: str = "") -> str:
    """List the names that the owner of one section may refer to: those of all other sections."""
    rows = []
    scene = data.get("scene") if isinstance(data.get("scene"), dict) else {}
    if section != "scene":
        rows.append(f"duration {(scene or {}).get('duration')}")
        rows.append("statics " + ", ".join((scene or {}).get("statics") or {}))
    if section != "bodies":
        rows.append("bodies " + ", ".join(_body_names(data.get("bodies") or {})))
    if section != "actions":
        actions = data.get("actions") or {}
        rows += [f"{part} {', '.join(actions.get(part) or {})}" for part in ("controls", *FROZEN_PARTS)]
    if section != "render":
        rows.append("cameras " + ", ".join((data.get("render") or {}).get("cameras") or {}))
    return "; ".join(row for row in rows if not row.endswith(" "))


def _body_names(bodies: Mapping[str, Any]) -> list[str]:
    rows = []
    for name, body in bodies.items():
        row = str(name)
        if isinstance(body, dict):
            mount = body.get("mount")
            links = body.get("links")
            if isinstance(mount, dict) and mount.get("kind") not in (None, "free", "fixed"):
                row += f" (on a {mount['kind']})"
            if isinstance(links, dict):
                row += f" (links {', '.join(f'{name}.{link}' for link in links)})"
            if "repeat" in body:
                row += "[*]"
        rows.append(row)
    return rows
