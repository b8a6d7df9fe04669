"""Every problem that the checker and the lint can report has an owner who is asked, and a legal answer that mends it.

Walked over: every part of a case, every rule of the lint by its example, and every place of a case that is spoilt.
"""

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.agents.scripted import quiet
from tests.lint.lint_support import data_of
from text2sim.agents import revising
from text2sim.agents.agreement import Agreement
from text2sim.agents.assembly import FROZEN_PARTS, examine, owner_of
from text2sim.agents.attempt_report import AttemptReport, Choices
from text2sim.agents.decision_faults import decision_faults, foreign_operations
from text2sim.agents.existing_case import plan_of_case
from text2sim.agents.offered_cards import OfferedCards
from text2sim.agents.replies import SECTIONS, CasePlan, Decision, Fragments, Refer
from text2sim.agents.section_writer import _patched
from text2sim.lint.rules import EARLIER_RULES, RULES, Rule
from text2sim.spec_schema.changes.diff import operations
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.text.canonical import format_text
from text2sim.spec_schema.text.document import pointer

DECK = OfferedCards(None, quiet)
WHY = "it is meant, for a test"


def agreed(plan: CasePlan) -> Agreement:
    agreement = Agreement(plan, quiet)
    agreement.adopt_plan(plan, plan.checks.expect)
    return agreement


def decided(agreement: Agreement, text: str, folder: Path, rules: frozenset[str] = frozenset(), **work: Any) -> str:
    """The case after a decision that the Planner may take; fails if it may not."""
    decision = Decision(action="repair", why=WHY, **work)
    wrong = decision_faults(
        decision, agreement, text, AttemptReport(rules=rules), DECK, folder / "case.yaml", Choices(anew=True)
    )
    assert wrong == []
    return agreement.changed(text, decision)[0]


def written(section: str, before: Any, after: Any, plan: CasePlan, folder: Path) -> Any:
    """The case after its Writer has patched a section as it may; fails if it may not."""
    own = operations({section: before.get(section) or {}}, {section: after.get(section) or {}})
    return before | {section: _patched(own, section, before, plan, folder / "case.yaml")}


# --- every part of a case --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("key", [*Case.model_fields, "lights", ""])
def test_every_part_has_an_owner_who_may_change_it(key: str) -> None:
    for path in (f"/{key}", f"/{key}/x/y") if key else ("",):
        owner = owner_of(Problem(path, "wrong"), ())
        assert owner in (*SECTIONS, "plan")
        Refer.model_validate({"section": owner, "why": WHY})  # whoever is asked in error can pass it on
        if owner == "plan" and key:
            assert foreign_operations([{"op": "remove", "path": path}]) == []
        elif key:
            assert owner == key, "the Writer of the section in which it stands"
            assert foreign_operations([{"op": "remove", "path": path}]), "and nobody else"


@pytest.mark.parametrize("part", FROZEN_PARTS)
def test_what_the_planner_has_put_into_actions_is_the_planners(part: str) -> None:
    place = f"/actions/{part}/mine"
    for path in (place, place + "/of"):
        assert owner_of(Problem(path, "wrong"), [place]) == "plan"
        assert (
            owner_of(Problem(path + "s" if path == place else f"/actions/{part}/mines/of", "wrong"), [place])
            == "actions"
        )
    assert owner_of(Problem("/actions/expect", "of all together"), ()) == "plan"


# --- every rule of the lint ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def assets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A case's folder, with the files that examples name."""
    import numpy as np
    import trimesh

    folder = tmp_path_factory.mktemp("meshes")
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    box.export(folder / "closed.obj")
    trimesh.Trimesh(box.vertices, box.faces[2:]).export(folder / "open.obj")
    trimesh.Trimesh(box.vertices, np.fliplr(box.faces), process=False).export(folder / "inverted.obj")
    trimesh.creation.torus(0.2, 0.05, major_sections=160, minor_sections=80).export(folder / "fine.obj")
    trimesh.creation.torus(0.2, 0.04).export(folder / "ring.obj")
    channel = trimesh.boolean.difference(
        [trimesh.creation.box((0.2, 0.2, 0.1)), trimesh.creation.box(bounds=[[-0.05, -0.2, 0], [0.05, 0.2, 0.2]])]
    )
    channel.export(folder / "channel.obj")
    return folder


def test_a_duration_that_is_worked_out_is_no_error() -> None:
    assert plan_of_case("scene: {duration: '${T}'}", "example").duration == 4.0
    assert plan_of_case("scene: {duration: 2}", "example").duration == 2.0


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.id)
def test_what_a_rule_finds_can_be_mended_by_who_is_asked(rule: Rule, assets: Path) -> None:
    before, path = data_of(rule.example), assets / "case.yaml"
    text = format_text(json.dumps(before))
    plan = plan_of_case(text, "example")
    found = examine(text, path)
    problems = [p for p in [*found.errors, *found.warnings] if p.rule == rule.id]
    assert problems
    free = plan.model_copy(update={"checks": Fragments()})
    after = data_of(rule.example, rule.fix)
    for problem in problems:
        # A draft: nothing of it is the Planner's yet, but what is outside of sections.
        mine = owner_of(problem, ())
        if mine != "plan" and (before.get(mine) or {}) != (after.get(mine) or {}):
            written(mine, before, after, free, assets)
        # As a plan has it: what is expected is the Planner's, and so is what has no Writer.
        agreement = agreed(plan)
        owner = owner_of(problem, agreement.pointers)
        assert owner == (
            "plan" if mine == "actions" and problem.path.startswith(agreement.pointers or ("-",)) else mine
        )
        # Whoever is asked and cannot mend it refers it; the Planner can always say that it is meant, with effect.
        waived = examine(decided(agreement, text, assets, frozenset({rule.id}), waive={rule.id: WHY}), path)
        assert not [one for one in [*waived.errors, *waived.warnings] if one.rule == rule.id]
    # The cure itself is a patch that each section's Writer may make, or the Planner.
    data = before
    for section in SECTIONS:
        if (data.get(section) or {}) != (after.get(section) or {}):
            data = written(section, data, after, free, assets)
    rest = operations(
        data,
        {key: value for key, value in after.items() if key not in SECTIONS}
        | {s: data[s] for s in SECTIONS if s in data},
    )
    cured = format_text(json.dumps(data))
    if rest:
        cured = decided(agreed(free), cured, assets, patch=rest)
    now = examine(cured, path)
    assert not [one for one in [*now.errors, *now.warnings] if one.rule == rule.id]


@pytest.mark.parametrize("rule", EARLIER_RULES)
def test_what_is_found_before_the_lint_can_be_waived(rule: str) -> None:
    text = format_text(json.dumps(data_of("{}") | {"waive": {rule: WHY}}))
    assert "waive" in revising.data_of(text)
    assert not [one for one in examine(text, Path("case.yaml")).errors if one.rule == "unknown-rule"]


# --- every place of a case -------------------------------------------------------------------------------------------

WHOLE: dict[str, Any] = {
    "text2sim": 2,
    "name": "whole",
    "prompt": "A gate opens and lets a ball roll down a slide onto a bell.",
    "params": {"radius": 0.1, "height": "${4 * radius}"},
    "prefabs": {"peg": {"doc": "A peg.", "params": {"r": {"kind": "number", "default": 0.02, "doc": "Its radius [m]."}},
                        "body": {"kind": "rigid", "shape": {"kind": "sphere", "radius": "${r}"}}}},
    "scene": {
        "duration": 1.0, "dt": 0.01, "gravity": [0, 0, -9.81], "contact": {"model": "rigid"},
        "statics": {"floor": {"shape": {"kind": "plane"}},
                    "slide": {"shape": {"kind": "box", "size": [1, 0.4, 0.05]}, "pose": {"pos": [0, 0, 0.4], "euler_deg": [0, 20, 0]}}},
    },
    "bodies": {
        "ball": {"kind": "rigid", "shape": {"kind": "sphere", "radius": "${radius}"}, "material": {"density": 500, "friction": 0.5},
                 "pose": {"pos": [-0.3, 0, "${height + 0.4}"]}, "look": {"color": "red"}},
        "gate": {"kind": "rigid", "shape": {"kind": "box", "size": [0.02, 0.4, 0.2]}, "pose": {"pos": [2, 0, 1]},
                 "mount": {"kind": "hinge", "axis": "y", "actuator": {"stiffness": 50, "damping": 5}}},
        "pegs": {"use": "peg", "with": {"r": 0.03}, "repeat": {"kind": "line", "count": 3, "step": [0.2, 0, 0]}, "pose": {"pos": [0, 2, 0.5]}},
    },
    "actions": {
        "controls": {"open": {"kind": "drive", "joint": "gate", "position": {"kind": "ramp", "to": 1.0, "start": 0.1, "end": 0.5}}},
        "measures": {"z": {"kind": "position", "of": "ball", "axis": "z"}, "angle": {"kind": "joint_position", "of": "gate"}},
        "events": {"hit": {"kind": "contact", "between": ["ball", "slide"]}},
        "expect": {"rolls": {"event": "hit", "within": [0, 0.9]}, "opens": {"measure": "angle", "at": "end", "above": 0.5}},
    },
    "render": {"resolution": [160, 90], "fps": 10,
               "cameras": {"main": {"kind": "still", "from": [3, -4, 2], "look_at": "ball", "fov_deg": 40}},
               "lights": {"key": {"kind": "sun", "direction": [0, -1, -2], "strength": 3}}},
    "variants": {"heavy": {"bodies": {"ball": {"material": {"density": 900}}}}},
    "sweeps": {"sizes": {"grid": {"params.radius": [0.1, 0.12]}}},
    "waive": {"idle-motor": "the gate is left alone at first"},
}  # fmt: skip


def places(value: Any, way: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    if way:
        yield way
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from places(inner, (*way, key))


def spoilt(way: tuple[str | int, ...], kind: str) -> dict[str, Any]:
    data = copy.deepcopy(WHOLE)
    inner = data
    for step in way[:-1]:
        inner = inner[step]  # type: ignore[index]
    if kind == "value":
        inner[way[-1]] = {"zz": [None]} if not isinstance(inner[way[-1]], dict) else "zz"  # type: ignore[index]
    else:
        inner[f"{way[-1]}_zz"] = inner.pop(way[-1])  # type: ignore[arg-type]
    return data


WAYS = [way for way in places(WHOLE) if way not in (("text2sim",), ("name",), ("prompt",))]


def test_the_whole_case_is_sound() -> None:
    assert examine(format_text(json.dumps(WHOLE)), Path("case.yaml")).errors == []


@pytest.mark.parametrize("kind", ["value", "key"])
@pytest.mark.parametrize("section", [*SECTIONS, "plan"])
def test_what_is_spoilt_anywhere_is_mended_by_who_is_asked(section: str, kind: str, tmp_path: Path) -> None:
    plan, path = plan_of_case(json.dumps(WHOLE), "whole"), tmp_path / "case.yaml"
    agreement = agreed(plan)
    seen = 0
    for way in WAYS:
        mine = owner_of(Problem(pointer(way), ""), agreement.pointers)
        if mine != section or way in [(name,) for name in SECTIONS] or way == ("actions", "expect"):
            continue  # whole sections are written anew, and expectations are put in by the program
        data = spoilt(way, kind)
        text = format_text(json.dumps(data))
        problems = examine(text, path).errors
        if not problems:
            continue  # a name that is another one now, and nothing asks for it
        seen += 1
        owners = {owner_of(problem, agreement.pointers) for problem in problems}
        # Asked is the owner of the place; where the trouble shows elsewhere, that one can refer it to the owner.
        for other in owners - {mine}:
            assert Refer.model_validate({"section": mine, "why": WHY}).section == mine, other
        if mine != "plan":
            mended = written(mine, data, WHOLE, plan, tmp_path)
            assert mended[mine] == WHOLE[mine] or mine == "actions", way
            continue
        frozen = way[0] == "actions"
        work: dict[str, Any] = {"patch": operations(data, WHOLE)}
        if frozen:
            part, name = str(way[1]), str(way[2])
            if kind == "key" and len(way) == 3:
                continue  # gone: the contract puts it back
            work = {"restate": {"why": WHY, "checks": {part: {name: WHOLE["actions"][part][name]}}}}
            checks = Fragments.model_construct(**{p: data["actions"][p] for p in FROZEN_PARTS})
            if not isinstance(data["actions"][part][name], dict):
                continue  # no form of a plan accepts it
            mended = agreed(plan.model_copy(update={"checks": checks}))
        else:
            mended = agreed(plan)
            mended.adopt_values(text)
        assert examine(decided(mended, text, tmp_path, **work), path).errors == [], way
    assert seen >= 5, "places at which something can be wrong"
