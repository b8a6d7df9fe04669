"""Writers own one section, and what they may do in it is checked."""

import re
from pathlib import Path

import pytest

from tests.agents.scripted import Scripted, chat, fenced
from text2sim.agents import language
from text2sim.agents.assembly import case_text, examine, owner_of, section_faults
from text2sim.agents.conversation import RoleFailed
from text2sim.agents.replies import CasePlan, PlannedBody, Refer
from text2sim.agents.roles import ROLES, render, writer_prompt
from text2sim.agents.section_writer import (
    Change,
    Unchanged,
    _kinds_for,
    change_section,
    gist,
    plan_for,
    write_section,
    writer_pages,
)
from text2sim.compiler.soft.settings import MAX_PBD_STEP, STRETCH_ITERATIONS
from text2sim.lint.soft.cost import (
    RIGID_SUBSTEP_TIME,
    ROLLING_TIME,
    SAP_PIECE_TIME,
    SUBSTEP_TIME,
    SWEEP_TIME,
    TIME_PER_POINT,
)
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.colors import NAMED

PLAN = CasePlan.model_validate(
    {
        "name": "drop",
        "event": "A ball falls on the floor.",
        "duration": 0.5,
        "params": {"height": 0.5},
        "bodies": {"floor": {"kind": "static", "shape": "plane"}, "ball": {"kind": "rigid", "shape": "sphere"}},
        "says": {"lands": "It lands."},
        "checks": {
            "events": {"touch": {"kind": "contact", "between": ["ball", "floor"]}},
            "expect": {"lands": {"event": "touch", "within": [0.1, 0.5]}},
        },
        "briefs": {"bodies": "One ball."},
    }
)
SCENE = {"duration": 0.5, "dt": 0.005, "statics": {"floor": {"shape": {"kind": "plane"}}}}
BALL = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}, "pose": {"pos": [0, 0, "${height + 0.1}"]}}
SECTIONS = {"scene": SCENE, "bodies": {"ball": BALL}, "actions": {}, "render": {}}
CASE = {"params": {"height": 0.5}, **SECTIONS}
FILE = Path("drop/case.yaml")


def written(tmp_path: Path, *replies: str, section: str = "bodies"):
    model = Scripted({section: [fenced(reply) for reply in replies]})
    found = write_section(chat(tmp_path, model), section, PLAN, "A ball falls.", "", "", FILE)
    return found, model.questions(section)


def test_errors_of_form_go_back_to_the_writer(tmp_path: Path) -> None:
    bad = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: -1}, colour: red}}"
    good = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}}"
    found, asked = written(tmp_path, bad, good)
    assert found["ball"]["shape"]["radius"] == 0.1
    assert "/bodies/ball/shape/radius" in asked[1]
    assert "unknown key `colour`" in asked[1]


def test_a_control_may_vary_between_copies_that_are_planned() -> None:
    """The bodies, with their `repeat`, are written by another at the same time."""
    grips = PlannedBody(kind="rigid", shape="box", mount="slider", count=2)
    plan = PLAN.model_copy(update={"bodies": {**PLAN.bodies, "grip": grips}})
    position = {"kind": "ramp", "to": "${0.2 * i}", "start": 0, "end": 0.4}
    data = {"controls": {"pull": {"kind": "drive", "joint": "grip[*]", "position": position}}}
    assert section_faults("actions", data, plan, FILE) == []
    (wrong,) = section_faults("actions", data, PLAN, FILE)
    assert "varies between copies" in wrong


def test_a_section_may_come_without_its_key(tmp_path: Path) -> None:
    found, _ = written(tmp_path, "ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}")
    assert "ball" in found


def test_verbs_name_kinds_in_any_form_and_names_of_bodies_name_none() -> None:
    bodies = {"rope": PlannedBody(kind="rigid", shape="box"), "spin": PlannedBody(kind="rigid", shape="box")}
    plan = CasePlan(name="p", event="e", bodies=bodies)
    found = _kinds_for("actions", plan, "The arm drives the spin, which is released at 1 s.")
    assert {"drive", "release"} <= found
    assert "spin" not in found
    assert "- `release`" in language.named_reference("actions", "Let it be released later.")
    assert "- `attach`" in language.named_reference("actions", "Each row is sewn to its rod at 18 points.")
    assert "- `reach`" not in language.named_reference("actions", "The rods reach from x = -0.8 to 0.")
    assert "- `reach`" in language.named_reference("actions", "Use a `reach` of the hand.")


def test_a_brief_in_everyday_words_brings_the_pages_that_it_needs() -> None:
    cloth = {"sheet": PlannedBody(kind="cloth", shape="sheet")}
    plan = CasePlan(name="p", event="e", bodies=cloth)
    for words in ("It attaches the sheet to the rail.", "The sheet is sewn to six rings.", "Welded to the hoist."):
        assert "attach" in _kinds_for("actions", plan, words), words
    assert {"wind", "piecewise"} <= _kinds_for("actions", plan, "A faint wind."), (
        "its example is written with the latter"
    )
    assert "piecewise" not in _kinds_for("actions", plan, "It attaches the sheet.")
    assert "release" in _kinds_for("actions", plan, "It is attached from 0 to 1.9 s."), "by which an `attach` ends"
    assert {"spring", "attach"} <= _kinds_for("actions", plan, "door_spring pulls from the start; the tie_lines hold.")
    for words in ("One strong light, grazing the wall.", "Light comes in from the left."):
        assert "softbox" in _kinds_for("render", plan, words), words
    assert "softbox" not in _kinds_for("render", plan, "A light board, seen from the left.")
    assert "piecewise" in _kinds_for("actions", plan, "The rods push for a second and go back.")
    assert "piecewise" in _kinds_for("actions", plan, "At 6 rad/s until 8.8 s.")
    assert "release" not in _kinds_for("actions", plan, "The hook holds it, and it is never released.")
    pins = CasePlan(name="p", event="e", bodies={"pin": PlannedBody(kind="rigid", shape="cylinder", mount="slider")})
    assert "drive" in _kinds_for("actions", pins, "One control, `pull`, raises the pins.")
    assert "drive" not in _kinds_for("actions", plan, "One control, `pull`, raises the sheet.")
    hand = CasePlan(name="p", event="e", bodies={"hand": PlannedBody(kind="articulated", what="three fingers")})
    assert {"hinge", "slider", "cylinder"} <= _kinds_for(
        "bodies", hand, "Links on hinges, rods (cylinders) on sliders."
    )
    assert "hinge" not in _kinds_for("bodies", plan, "The sheet hangs from a bar on a hinge.")


def test_another_section_is_not_taken(tmp_path: Path) -> None:
    with pytest.raises(RoleFailed, match="the only one you write"):
        written(tmp_path, *["scene: {duration: 3}"] * 3)


def test_the_planners_expectations_are_not_overwritten(tmp_path: Path) -> None:
    easier = "actions: {expect: {lands: {event: touch, within: [0, 9]}, own: {event: touch, count: 1}}}"
    again = easier.replace("[0, 9]", "[0.1, 0.5]")
    found, asked = written(tmp_path, easier, again, section="actions")
    assert "/actions/expect/lands: it comes from the request" in asked[1]
    assert set(found["expect"]) == {"own"}
    text = case_text(PLAN, "A ball falls.", PLAN.params, SECTIONS | {"actions": found})
    assert "lands: {event: touch, within: [0.1, 0.5]}" in text
    assert examine(text, FILE).errors == []


def changed(tmp_path: Path, *replies: str, section: str = "bodies"):
    model = Scripted({section: [fenced(reply) for reply in replies]})
    case = {**CASE, "actions": {"events": dict(PLAN.checks.events), "expect": dict(PLAN.checks.expect)}}
    found = change_section(chat(tmp_path, model), section, PLAN, case, Change("Larger."), FILE)
    return found, model.questions(section)


def test_a_patch_on_the_own_section(tmp_path: Path) -> None:
    found, asked = changed(tmp_path, "patch: [{op: replace, path: /bodies/ball/shape/radius, value: 0.2}]")
    assert isinstance(found, dict)
    assert found["ball"]["shape"]["radius"] == 0.2
    assert "statics floor" in asked[0], "the names of the rest are told"
    assert "dt: 0.005" not in asked[0], "what stands in the rest is not"


def test_who_changes_controls_hears_what_they_can_do_with_what_deforms(tmp_path: Path) -> None:
    mat = PLAN.model_copy(update={"bodies": PLAN.bodies | {"mat": PlannedBody(kind="soft", shape="box")}})
    for plan, region in ((PLAN, False), (mat, True)):
        model = Scripted({"actions": [fenced("patch: []\nwhy: it is held")]})
        change_section(chat(tmp_path, model), "actions", plan, CASE, Change("Hold it by an `attach`."), FILE)
        assert ("the attached part" in model.questions("actions")[0]) is region


def test_why_nothing_changes_is_heard(tmp_path: Path) -> None:
    found, _ = changed(tmp_path, "patch: []\nwhy: it is large enough")
    assert found == Unchanged("it is large enough")
    assert "`why: …`" in writer_prompt(ROLES["bodies"], "", change=True), "how it is said"


def test_time_that_is_left_stands_in_letters_that_lead_to_a_run() -> None:
    left = "3 of 4 attempts are left; 12 minutes are left for everything."
    ask = {"request": "r", "requirements": {"wish": "r"}, "case": "c", "evidence": "", "left": left}
    assert left in render("open_ask", **ask)
    assert "by name" not in render("open_ask", **ask)
    assert "- `blue`: it is blue" in render("open_ask", **ask | {"requirements": {"blue": "it is blue", "two": "two"}})
    draft = {"section": "scene", "pages": "", "request": "r", "plan": "", "supplied": "", "cards": "", "brief": "b"}
    assert f"Left: {left}" in render("draft", **draft, left=left)
    assert "Left" not in render("draft", **draft, left="")


@pytest.mark.parametrize(
    ("section", "operation", "reason"),
    [
        ("bodies", "{op: replace, path: /scene/dt, value: 0.1}", "not below /bodies"),
        ("bodies", "{op: copy, from: /scene/dt, path: /bodies/ball/shape/radius}", "not below /bodies"),
        ("bodies", "{op: replace, path: /bodies/none/shape, value: 1}", "none"),
        ("actions", "{op: replace, path: /actions/expect/lands/within, value: [0, 9]}", "comes from the request"),
        ("actions", "{op: remove, path: /actions/events/touch}", "comes from the request"),
    ],
)
def test_a_patch_that_is_not_its_authors_goes_back(tmp_path: Path, section: str, operation: str, reason: str) -> None:
    found, asked = changed(tmp_path, f"patch: [{operation}]", "refer: {section: plan, why: I cannot}", section=section)
    assert isinstance(found, Refer)
    assert reason in asked[1]


def test_who_owns_a_problem() -> None:
    frozen = ("/actions/expect/lands",)
    for path, owner in {
        "/bodies/ball/shape": "bodies", "/actions/controls/push": "actions", "/actions/expect/lands/within": "plan",
        "/actions/expect/lands_too": "actions", "/params/height": "plan", "": "plan",
    }.items():  # fmt: skip
        assert owner_of(Problem(path, "wrong"), frozen) == owner


def test_the_colours_that_are_told_are_known() -> None:
    assert set(re.findall(r"`(\w+)`", language.COLORS_NOTE)) <= set(NAMED)


def test_a_writer_reads_what_its_plan_needs_and_little_more() -> None:
    pages = writer_pages("bodies", PLAN)
    assert "- `sphere`:" in pages
    assert "- `funnel`:" not in pages
    assert "`funnel`" in pages, "that there is more is said"
    several = PlannedBody(kind="rigid", shape="compound", what="a spring made of capsules")
    assert "- `capsule`:" in writer_pages("bodies", PLAN.model_copy(update={"bodies": {"spring": several}}))
    assert "SoftMaterial" not in pages
    assert "range_deg" not in pages, "nothing is mounted"
    sizes = {section: len(writer_pages(section, PLAN)) for section in SECTIONS}
    assert sum(sizes.values()) < 31_000, sizes
    assert len(language.reference_pages("bodies")) > 3 * len(pages)


def test_descriptions_are_cut_at_the_end_of_a_sentence_or_word() -> None:
    text = "A sign of oak, 0.4 x 0.3 m. It hangs on two chains; the wind moves it a little."
    assert gist(text, 40) == "A sign of oak, 0.4 x 0.3 m. …"
    assert gist(text, 60) == "A sign of oak, 0.4 x 0.3 m. It hangs on two chains; …"
    assert gist("A very long row of words, and no end of it", 27) == "A very long row of words …"


@pytest.mark.parametrize(
    ("section", "count", "whole"), [("render", 2, True), ("render", 9, False), ("actions", 9, True)]
)
def test_only_who_films_many_bodies_gets_short_descriptions(section: str, count: int, whole: bool) -> None:
    """Whoever moves them needs their measures: where a pivot is, where an eye."""
    sentence = "A ball of cork that was turned by hand, with a stripe around it. "
    bodies = {f"ball_{k}": PlannedBody(kind="rigid", what=sentence * 6) for k in range(count)}
    told = plan_for(section, PLAN.model_copy(update={"bodies": bodies}))
    assert ("…" not in told) is whole
    assert told.count("stripe around it") == count * (6 if whole else 3)


def test_what_a_plan_says_in_passing_brings_no_pages() -> None:
    agreed = PLAN.model_copy(update={"shared": ["torque that is needed: 93 N m; friction 0.5"]})
    actions = writer_pages("actions", agreed)
    assert "- `torque`:" not in actions, "a unit is no control"
    hold = writer_pages("actions", agreed.model_copy(update={"briefs": {"actions": "Two holds (`attach`)."}}))
    assert "- `attach`:" in hold
    assert "deform" not in hold.partition("- `attach`:")[2].partition("- `to`")[0].partition("  - ")[2], (
        "nothing deforms"
    )
    assert "noslip" not in writer_pages("scene", agreed)
    slippery = agreed.model_copy(update={"shared": ["The pair of puck and rink has friction 0.02."]})
    assert "ice: {between" in writer_pages("scene", slippery), "friction of a pair belongs to the scene"


def test_a_plan_with_a_conveyor_hears_how_a_surface_moves() -> None:
    assert "surface_velocity" not in writer_pages("scene", PLAN)
    body = PlannedBody(kind="static", shape="box", what="3 x 0.5 m conveyor, runs towards +x at 0.4 m/s")
    page = writer_pages("scene", PLAN.model_copy(update={"bodies": {**PLAN.bodies, "line": body}}))
    assert "surface_velocity: [0.4, 0, 0]" in page
    assert "- `surface_velocity` (3 numbers)" in page


def test_everyday_words_and_planned_events_bring_the_controls_that_they_mean() -> None:
    posts = PlannedBody(kind="static", shape="box", what="two uprights that reach the ground")
    agreed = PLAN.model_copy(
        update={
            "bodies": PLAN.bodies | {"post": posts},
            "briefs": {"actions": "Two balls are tied to the beam and let go in turn."},
        }
    )
    pages = writer_pages("actions", agreed)
    assert "- `attach`:" in pages
    assert "- `release`:" in pages
    assert "- `reach`:" not in pages, "a post reaches the ground"
    checks = agreed.checks.model_copy(update={"events": {"cleared": {"kind": "removed", "remove": "clear"}}})
    assert "- `remove`:" in writer_pages("actions", agreed.model_copy(update={"checks": checks}))


def test_a_mending_letter_has_the_pages_that_its_problems_name(tmp_path: Path) -> None:
    model = Scripted({"bodies": [fenced("patch: []")]})
    problems = ["/bodies/ball/mount: a ring of soft cloth would fit in a box or on a cone; give it a `hinge` [x]"]
    change_section(chat(tmp_path, model), "bodies", PLAN, CASE, Change("Mend this.", problems), FILE)
    asked = model.questions("bodies")[0]
    assert "- `hinge`:" in asked
    assert "- `cone`:" not in asked
    assert "- `cloth`:" not in asked


def test_a_change_reads_only_what_its_instruction_names(tmp_path: Path) -> None:
    model = Scripted({"bodies": [fenced("patch: []")]})
    keep, derived = ["lands: first happened at 0.3 s"], "derived: substeps = 4"
    change = Change("Put `ball` on a hinge; friction 0.2.", keep=keep, derived=derived)
    change_section(chat(tmp_path, model), "bodies", PLAN, CASE, change, FILE, "A ball falls on a floor.")
    asked = model.questions("bodies")[0]
    assert "range_deg" in asked, "a kind that is named comes with its fields"
    assert "Coulomb" in asked, "and so does a field"
    assert "restitution" not in asked
    assert "derived: substeps = 4" in asked
    assert "A ball falls on a floor." in asked
    assert asked.index("Keep, do not touch") < asked.index("lands: first") < asked.index("Put `ball`")
    assert sum(len(message.text) for message in model.asked[0].messages) < 6_000


@pytest.mark.parametrize(
    ("section", "instruction", "there", "told", "left_out", "most"),
    [
        (
            "bodies", "Give `crate` a worn look: `finish` metal, `pattern` stripes. Keep shape, place, mass and density.",
            {"rigid", "box"}, ("brushed_metal", "Pattern:", "`turned`"), ("in_front_of", "SoftMaterial", "`density`"), 1_800,
        ),
        ("bodies", "Raise `ball` to z = 1 (pose), nothing else.", {"rigid"}, ("`euler_deg`",), ("in_front_of", "Link"), 700),
        ("bodies", "Add a ball, on the table; density 800.", {"rigid"}, ("`in_front_of`", "Material:"), ("Heap",), 1_900),
        ("bodies", "Double the density.", {"soft"}, ("SoftMaterial:",), ("LiquidMaterial", "Part:"), 400),
        ("bodies", "Turn the look of each link.", {"articulated"}, ("Link:",), (), 1_400),
        ("scene", "A lighter look of the floor; leave its place as it is.", {"plane"}, ("Colour",), ("beside",), 300),
    ],
)  # fmt: skip
def test_a_change_hears_of_what_it_changes_and_of_nothing_that_is_not_there(
    section: str, instruction: str, there: set[str], told: tuple[str, ...], left_out: tuple[str, ...], most: int
) -> None:
    page = language.named_reference(section, instruction, there)
    assert [word for word in told if word not in page] == []
    assert [word for word in left_out if word in page] == []
    assert len(page) < most


def test_the_planner_is_told_how_long_all_of_it_may_take() -> None:
    known = {"request": "A ball falls.", "inputs": [], "requirements": "", "tried": ""}
    assert "There are 32 minutes by the clock" in render("plan_ask", **known, minutes=32.0)
    assert "minutes" not in render("plan_ask", **known, minutes=None)


def test_the_planner_is_told_what_each_kind_of_body_costs_as_runs_are_estimated() -> None:
    told = render("plan_ask", request="A ball falls.", inputs=[], requirements="", tried="", minutes=32.0)
    for sweeps, words in zip((STRETCH_ITERATIONS[0], STRETCH_ITERATIONS[-1]), ("if coarse", "if fine"), strict=True):
        found = re.search(rf"([\d.]+) ms and ([\d.]+) µs(?: a point)? {words}", told)
        assert found is not None
        assert float(found[1]) == pytest.approx(1e3 * (SUBSTEP_TIME["pbd"] + sweeps * SWEEP_TIME[0]), rel=0.1)
        assert float(found[2]) == pytest.approx(1e6 * (TIME_PER_POINT["pbd"] + sweeps * SWEEP_TIME[1]), rel=0.1)
    assert f"{1 / MAX_PBD_STEP:,.0f} substeps" in told
    base, each = RIGID_SUBSTEP_TIME["newton"]
    assert f"{1e3 * base:g} ms and {1e3 * each:g} ms a moving link" in told
    assert f"with `rolling_friction` {1e3 * ROLLING_TIME:g} ms a body" in told
    assert f"{1e3 * SUBSTEP_TIME['mpm']:g} ms and {1e6 * TIME_PER_POINT['mpm']:g} µs a particle" in told
    assert f"{1e3 * SUBSTEP_TIME['sap']:g} ms, {1e3 * TIME_PER_POINT['sap']:g} ms a tetrahedron" in told
    assert f"{1e3 * SAP_PIECE_TIME:g} ms for each convex rigid piece" in told
    assert f"{6 * 2**0.5:.1f} volume / c³ tetrahedra" in told, "as the lint counts them"
    assert "snow" not in told
    assert "snow that is hit at v" in render(
        "plan_ask", request="Snow falls.", inputs=[], requirements="", tried="", minutes=32.0
    )


@pytest.mark.parametrize("key", ["bodies: ", ""])
def test_shapes_of_asset_agents_are_put_in(tmp_path: Path, key: str) -> None:
    sculpted = {"kind": "capsule", "radius": 0.1, "length": 0.2}
    model = Scripted({"bodies": [fenced(f"{key}{{ball: {{kind: rigid, pose: {{pos: [0, 0, 1]}}}}}}")]})
    found = write_section(
        chat(tmp_path, model),
        "bodies",
        PLAN,
        "A ball falls.",
        "`ball`: its `shape`",
        "",
        FILE,
        {"ball": sculpted, "other": {}},
    )
    assert found["ball"]["shape"] == sculpted and set(found) == {"ball"}
    assert "leave out what is named here" in model.questions("bodies")[0]
