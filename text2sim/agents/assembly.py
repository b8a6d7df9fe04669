"""Assembly of a case from sections, and routing of its problems to the role that has to mend them."""

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
PLANNERS = ("params", "waive", "variants", "sweeps", "prefabs", "name", "prompt")
"""Parts of a case that no Writer owns: the Planner patches them."""
_OF_NAMES = frozenset(f"unknown-{what}" for what in ("attach", "body", "camera", "event", "joint", "link", "measure"))
"""Rules about names, which mean nothing while the rest of the case is not there."""


@dataclass
class Examination:
    """What the checker says of a case."""

    text: str
    loaded: LoadedCase | None = None
    errors: list[Problem] = field(default_factory=list)
    warnings: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    """Derived settings."""
    seconds: float = 0.0
    """Wall time that a run takes on two idle cores; 0 if that is not known."""

    @property
    def derived(self) -> str:
        """Settings that the case leaves open, on one line, as far as an author may want to know them."""
        rows = [note.partition(": ")[0] for note in self.notes]
        told = [row for row in rows if " = " in row and not row.startswith(("max_pairs", "tolerance"))]
        return f"derived: {'; '.join(told)}" if told else ""

    @property
    def ok(self) -> bool:
        """Whether it can be run."""
        return not self.errors


def examine(text: str, path: Path) -> Examination:
    """Load, resolve and lint a case as if it stood in the file `path`."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case

    found = Examination(text)
    try:
        found.loaded = load_text(text, path)
        resolution = resolve_case(found.loaded)
        report = lint_case(resolution)
        problems, found.seconds = list(report.problems), report.seconds
        found.notes = list(resolution.plan.notes)
    except SpecError as error:
        problems = error.problems
    except Text2SimError as error:
        problems = [Problem("", str(error), file=str(path), rule="asset")]
    found.errors = [problem for problem in problems if problem.severity == "error"]
    found.warnings = [problem for problem in problems if problem.severity != "error"]
    return found


def case_text(plan: CasePlan, request: str, params: Mapping[str, Any], sections: Mapping[str, Any]) -> str:
    """Put a case together, in the canonical form.

    The Planner's measures, events and expectations come first among those of the Action Writer, and stand whatever that
    one wrote.
    """
    actions = whole_actions(plan, sections.get("actions") or {})
    # Somebody's words are no expression, whatever stands in them.
    prompt = " ".join(plain_text(request).split())[:2000].replace("${", "$${")
    document = {"text2sim": 2, "name": plan.name, "prompt": prompt, "params": dict(params)}
    document |= {name: sections[name] for name in SECTIONS if name != "actions" and sections.get(name)}
    return format_text(json.dumps({**document, "actions": actions}, ensure_ascii=False))


def whole_actions(plan: CasePlan, section: Mapping[str, Any]) -> Data:
    """Return a section of actions with the Planner's measures, events and expectations put in."""
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
    """Say what is wrong with the form of one section, while the others are not there yet.

    Args:
        section: Which.
        data: What it says.
        plan: The plan.
        path: Where the case stands.
        prefabs: Those of the case itself, which may be used.
    """
    document: Data = {"text2sim": 2, "name": "draft", "params": plan.params, "scene": {"duration": plan.duration}}
    if prefabs:
        document["prefabs"] = dict(prefabs)
    document["bodies"] = {"stand_in": {"kind": "rigid", "shape": {"kind": "box", "size": [1, 1, 1]}}}
    document[section] = data
    try:
        load_text(format_text(json.dumps(document, ensure_ascii=False)), path)
    except SpecError as error:
        mine = [problem for problem in error.problems if owner_of(problem, ()) == section]
        return [said(problem) for problem in mine if problem.rule not in _OF_NAMES]
    return []


def owner_of(problem: Problem, frozen: Iterable[str]) -> str:
    """Say who can mend a problem: the owner of a section, or the Planner.

    Args:
        problem: What is wrong.
        frozen: Pointers to what only the Planner may change.
    """
    steps = problem.path.split("/")
    section = steps[1] if len(steps) > 1 else ""
    if problem.path == "/actions/expect":  # of all expectations together
        return "plan"
    # An entry with `repeat` is told of by its numbers.
    if any(re.fullmatch(rf"{re.escape(pointer)}(_\d+)?(/.*)?", problem.path) for pointer in frozen):
        return "plan"
    return section if section in SECTIONS else "plan"


def said(problem: Problem) -> str:
    """Return a problem as it is said to a model: where, what, the nearest right word, and the rule."""
    hint = f"; did you mean `{problem.hint}`?" if problem.hint else ""
    return f"{problem.path or 'the case'}: {problem.message}{hint} [{problem.rule}]"


def names_in(data: Mapping[str, Any], without: str = "") -> str:
    """Say which names there are in a case, leaving one section out: what its owner may refer to."""
    rows = []
    scene = data.get("scene") if isinstance(data.get("scene"), dict) else {}
    if without != "scene":
        rows.append(f"duration {(scene or {}).get('duration')}")
        rows.append("statics " + ", ".join((scene or {}).get("statics") or {}))
    if without != "bodies":
        rows.append("bodies " + ", ".join(_body_names(data.get("bodies") or {})))
    if without != "actions":
        actions = data.get("actions") or {}
        rows += [f"{part} {', '.join(actions.get(part) or {})}" for part in ("controls", *FROZEN_PARTS)]
    if without != "render":
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
