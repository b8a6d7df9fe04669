"""A plan is tried out when it comes in: what would make every later attempt impossible goes back at once."""

from pathlib import Path
from typing import Any

import pytest

from text2sim.agents.conversation import Wrong, typed_parser
from text2sim.agents.language import body_kinds
from text2sim.agents.models.parsing import read_reply
from text2sim.agents.rehearsal import held_at_start, plan_faults
from text2sim.agents.replies import CasePlan, Decision, Opening, PlannedBody
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

PLAN = """
name: gate
event: A weight on a cord swings into a row of skittles; a gate turns; a flag hangs.
mode: [rigid, cloth]
duration: 3.0
params: {pins: 6, pin_h: 0.3, drop: "${2 * pin_h}"}
bodies:
  floor: {kind: static, shape: plane}
  table: {kind: static, shape: table}
  bob: {kind: rigid, shape: sphere, mount: ball, what: "radius ${pin_h / 4}"}
  pin: {kind: rigid, shape: cylinder, count: 6}
  gate: {kind: rigid, shape: box, mount: hinge}
  arm: {kind: articulated}
  cord: {kind: rope}
  mug: {kind: cup}
  flag: {kind: cloth, shape: sheet}
  jelly: {kind: soft, shape: box}
shared: ["The bob starts ${drop} above the floor."]
says: {hits: a, falls: b, opens: c, lifts: d, whole: e}
keeps: [whole]
checks:
  measures:
    fallen: {kind: tilt, of: pin, stat: count, above: 45}
    opening: {kind: joint_position, of: gate}
    lift: {kind: displacement, of: arm.hand, axis: z}
    kept: {kind: volume, of: jelly, relative: true}
  events:
    strike: {kind: contact, between: [bob, "pin[0]"]}
    tipped: {kind: threshold, measure: fallen, above: "${pins - 0.5}", after: strike}
    freed: {kind: released, attach: grip}
  expect:
    hits: {event: strike, within: [0.2, 2.0]}
    falls: {event: tipped, before: freed}
    opens: {measure: opening, at: end, above: 0.4}
    lifts: {measure: lift, during: [1, 2], stat: max, above: 0.1}
    whole: {measure: kept, at: end, above: 0.8}
"""


def faults(text: str, **changes: Any) -> list[str]:
    data = parse_document(Source(text, "plan")).data
    for path, value in changes.items():
        *way, last = path.split("__")
        inner = data
        for step in way:
            inner = inner[step]
        inner[last] = value
    try:
        return plan_faults(typed_parser(CasePlan)(data), Path("case.yaml"))
    except Wrong as wrong:
        return wrong.reasons


def test_a_sound_plan_passes() -> None:
    assert faults(PLAN) == []


def test_a_shape_may_be_several_words() -> None:
    """Its Writer decides: another round of the plan costs a minute and thousands of tokens."""
    assert faults(PLAN, bodies__mug={"kind": "rigid", "shape": "box and cylinders"}) == []


def test_all_that_is_wrong_goes_back_at_once() -> None:
    rows = faults(
        PLAN, bodies__jelly__shape="blob", checks__measures__kept={"kind": "extent", "of": "jelly", "axis": "z"}
    )
    assert any("/bodies/jelly/shape" in row for row in rows) and any("`stat` is missing" in row for row in rows), rows


@pytest.mark.parametrize("name", ["layer", "i", "n", "row", "column", "u", "k", "pi", "sin"])
def test_names_that_expressions_know(name: str) -> None:
    (row,) = faults(PLAN, **{f"params__{name}": 1})
    assert row.startswith(f"/params/{name}: ")
    assert "choose another name" in row
    assert "column" in row, "the way out: which are taken"


@pytest.mark.parametrize(
    ("where", "value", "about"),
    [
        ("params__drop", "${2 * pin_hh}", "did you mean `pin_h`"),
        ("params__drop", "${1 / 0}", "/params/drop"),
        ("checks__expect__opens", {"measure": "opening", "at": "end", "above": "${pinz}"}, "did you mean `pins`"),
        ("shared", ["It starts ${dropp} up."], "/shared/0: `dropp` is not in `params`; did you mean `drop`"),
        ("bodies__bob__what", "an open ${", "/bodies/bob/what"),
        ("checks__measures__fallen", {"kind": "tilt", "of": "skittle", "stat": "max"}, "there is no body or static `skittle`"),
        ("checks__events__strike", {"kind": "contact", "between": ["bob", "pin[9]"]}, "`pin` has 6 copies"),
        ("checks__events__strike", {"kind": "contact", "between": ["bob", "gaet"]}, "did you mean `gate`"),
        ("checks__measures__fallen", {"kind": "tilt", "of": "pin"}, "give a `stat` that combines them"),
        ("checks__measures__opening", {"kind": "joint_position", "of": "mug"}, "/checks/measures/opening"),
        ("checks__measures__lift", {"kind": "volume", "of": "pin", "stat": "max"}, "/checks/measures/lift"),
        ("checks__measures__lift", {"kind": "strain", "of": "flag"}, "measure its `stretch`"),
        ("checks__expect__hits", {"event": "strke", "within": [0, 1]}, "did you mean `strike`"),
        ("checks__expect__hits", {"event": "strike", "within": [3.5, 4]}, "after the end of the run (3 s)"),
        ("checks__expect__opens", {"measure": "opening", "at": 3.2, "above": 0.4}, "is after the end of the run"),
        ("checks__expect__opens", {"measure": "opening", "during": [1, 9], "above": 0.4}, "lasts beyond the end of the run"),
        ("checks__expect__opens", {"measure": "opening", "at": "end", "over": 0.4}, "/checks/expect/opens"),
        ("checks__expect__opens", {"measure": "opening", "at": "end", "above": 0.4, "equals": 5, "tolerance": 1},
         "/checks/expect/opens: either `equals` with `tolerance`, or `above` and `below`"),
        ("bodies__mug", {"kind": "magnet"}, "/bodies/mug/kind: `magnet` is not"),
        ("bodies__mug", {"kind": "rigid", "shape": "spere"}, "did you mean `sphere`"),
        ("bodies__gate", {"kind": "rigid", "shape": "box", "mount": "hinged"}, "did you mean `hinge`"),
        ("bodies__gate", {"kind": "rigid", "weight": 3}, "/bodies/gate/weight: the form has no such field"),
        ("mode", ["fluid"], "`fluid` is not a mode"),
        ("assumption", ["it is windless"], "did you mean `assumptions`"),
        ("checks__expectations", {}, "did you mean `expect`"),
    ],
)  # fmt: skip
def test_what_the_checker_would_refuse_later(where: str, value: Any, about: str) -> None:
    assert about in "\n".join(faults(PLAN, **{where: value}))


@pytest.mark.parametrize(
    ("measure", "expect", "about"),
    [
        ({"kind": "speed", "of": "bob"}, {"at": "end", "above": -1}, "always satisfies"),
        ({"kind": "tilt", "of": "mug"}, {"at": "end", "below": 190}, "always satisfies"),
        ({"kind": "tilt", "of": "mug"}, {"at": "end", "above": 190}, "cannot-hold"),
        ({"kind": "share_in", "of": "jelly", "region": {"kind": "sphere", "center": [0, 0, 0], "radius": 1}},
         {"during": "all", "below": 1.5}, "always satisfies"),
        ({"kind": "displacement", "of": "mug", "axis": "x"}, {"at": "start", "below": 1}, "always satisfies"),
        ({"kind": "displacement", "of": "mug", "axis": "x"}, {"during": "all", "above": 0.5}, "cannot-hold"),
        ({"kind": "speed", "of": "bob"}, {"at": "end", "below": 5}, "holds if nothing happens at all"),
        ({"kind": "displacement", "of": "mug", "axis": "z"}, {"at": 2, "above": -0.1}, "name this expectation in `keeps`"),
        ({"kind": "tilt", "of": "pin", "stat": "count", "above": 45}, {"at": "end", "below": 3}, "holds if nothing"),
    ],
)  # fmt: skip
def test_expectations_that_say_nothing(measure: dict[str, Any], expect: dict[str, Any], about: str) -> None:
    changes = {"checks__measures__mine": measure, "checks__expect__mine": {"measure": "mine", **expect}}
    (row,) = faults(PLAN, says__mine="f", **changes)
    assert row.startswith("/checks/expect/mine")
    assert about in row


def test_events_that_say_nothing() -> None:
    settled = {"kind": "rest", "of": "mug", "for": 0.2}
    (row,) = faults(PLAN, checks__events__settled=settled, checks__expect__calm={"event": "settled"})
    assert "after: EVENT" in row
    assert faults(PLAN, checks__events__settled=settled | {"after": "strike"}, checks__expect__calm={"event": "settled"}) == []  # fmt: skip
    twice = {"measure": "opening", "at": "end", "below": 0.1}
    assert "contradiction" in "".join(
        faults(PLAN, checks__measures__lift={"kind": "position", "of": "bob", "axis": "z"},
               checks__expect__lifts={"measure": "lift", "at": "end", "above": 2},
               checks__expect__opens=twice | {"measure": "lift"})
    )  # fmt: skip


def test_a_change_is_nothing_while_nothing_happens() -> None:
    stretched = {"kind": "stretch", "of": "jelly", "change_from": "start"}

    def of(bound: float) -> list[str]:
        changes = {
            "checks__measures__mine": stretched,
            "checks__expect__mine": {"measure": "mine", "at": "end", "above": bound},
        }
        return faults(PLAN, says__mine="f", **changes)

    assert of(0.5) == []
    assert "`mine` is 0 then" in of(-0.5)[0]


def test_links_may_be_named_by_a_pattern() -> None:
    for part in ("*_wrist", "fore*", "*"):
        measure = {"kind": "joint_position", "of": f"arm.{part}", "stat": "max"}
        assert faults(PLAN, checks__measures__mine=measure) == []


PART_FACTS = [
    {"moved": "gate.post", "by": "bob"},
    {"moved": "pin[0]", "by": "flag.hem"},
    {"count": "pin.ring", "equals": 6},
    {"seen": "pin.ring"},
]


@pytest.mark.parametrize("fact", PART_FACTS, ids=str)
def test_a_fact_about_a_part_that_cannot_be_measured_goes_back(fact: dict[str, Any]) -> None:
    """The reference check of a case decides, as it does of events."""
    (wrong,) = faults(PLAN, facts={"wish": [fact]})
    assert wrong.startswith("/facts/wish: ")
    body = next(word.partition(".")[0] for word in fact.values() if "." in str(word))
    assert f"did you mean `{body}`?" in wrong
    assert "plan the part as a body of its own" in wrong


def test_facts_about_bodies_copies_links_and_parts_pass() -> None:
    links = [
        {"touched": "arm.hand", "by": "mug"},
        {"touched": "gate.post", "by": "bob"},
        {"moved": "pin[2]", "by": "bob"},
        {"seen": "arm.hand"},
        {"count": "arm.*_hand", "equals": 2},
        {"color": "gate.post", "like": "red"},
    ]
    assert faults(PLAN, facts={"wish": links}) == []


def test_a_measure_of_a_part_goes_back_with_the_way_out() -> None:
    (wrong,) = faults(PLAN, checks__measures__lift={"kind": "displacement", "of": "gate.post", "axis": "z"})
    assert "did you mean `gate`?; name a whole body, or plan the part as a body of its own" in wrong


def test_contacts_may_name_parts_of_rigid_bodies() -> None:
    event = {"kind": "contact", "between": ["bob.spike_*", "pin[0]"]}
    assert faults(PLAN, checks__events__strike=event) == []


BOWL = {"kind": "cylinder", "center": [0, 0, 0.1], "radius": 0.2, "height": 0.2}


def test_where_bodies_stand_is_not_known_yet() -> None:
    for measure, expect in (
        ({"kind": "position", "of": "bob", "axis": "z"}, {"at": "end", "above": -5}),
        ({"kind": "position", "of": "bob", "axis": "z"}, {"at": "end", "below": 5}),
        ({"kind": "distance", "between": ["bob", "mug"]}, {"at": "end", "above": 0.5}),
        ({"kind": "extent", "of": "pin", "axis": "z", "stat": "max"}, {"during": [1, 2], "below": 0.2}),
        ({"kind": "count_in", "of": "bob", "region": BOWL}, {"during": "all", "stat": "min", "above": 0.5}),
        ({"kind": "count_in", "of": "bob", "region": BOWL}, {"during": "all", "stat": "max", "below": 0.5}),
        ({"kind": "position", "of": "bob", "axis": "z"}, {"at": "start", "equals": 0.82, "tolerance": 0.03}),
        (
            {"kind": "position", "of": ["bob", "pin", "mug"], "axis": "z", "stat": "range"},
            {"at": "start", "below": 0.03},
        ),
    ):
        changes = {"checks__measures__mine": measure, "checks__expect__mine": {"measure": "mine", **expect}}
        assert faults(PLAN, **changes, keeps=["whole", "mine"], says__mine="it stays") == []


def test_what_may_start_near_may_stay_near() -> None:
    """Whoever sits in a wheel from the start has no way to go first."""
    plan = """\
name: rider
event: a rider stays in a wheel
possible: yes
mode: [rigid, articulated]
duration: 15.0
bodies: {ground: {kind: static, shape: plane}, wheel: {kind: articulated}, rider: {kind: rigid, shape: sphere}}
says: {stays: it stays}
keeps: [stays]
checks:
  measures: {apart: {kind: distance, between: [rider, wheel.tub]}}
  expect: {stays: {measure: apart, during: all, below: 0.08}}
"""
    assert faults(plan) == []


def test_bonds_of_what_breaks_come_later() -> None:
    """The Action Writer adds the control `bond` to which a plan may refer."""
    plan = """\
name: cup
event: a cup falls and breaks
possible: yes
mode: [rigid]
duration: 2.0
bodies: {ground: {kind: static, shape: plane}, cup: {kind: rigid, shape: cup, count: 40}}
says: {breaks: it breaks, lands: then}
checks:
  measures: {parts: {kind: pieces, of: "cup[*]"}, part: {kind: largest_piece, of: "cup[*]"}}
  events: {cracks: {kind: broken, bond: clay}, tears: {kind: threshold, measure: part, below: 0.5}}
  expect: {breaks: {measure: parts, at: end, above: 8}, lands: {event: cracks, before: tears}}
"""
    assert faults(plan) == []


def test_what_moved_may_be_quiet_again() -> None:
    speed, quiet = {"kind": "speed", "of": "bob"}, {"measure": "mine", "during": [2, "end"], "below": 0.1}
    changes = {"checks__measures__mine": speed, "checks__expect__mine": quiet, "says__mine": "f"}
    (row,) = faults(PLAN, **changes)
    assert "holds if nothing happens" in row
    fast = {"measure": "mine", "during": [0, 2], "stat": "max", "above": 1}
    assert faults(PLAN, **changes, checks__expect__fast=fast, says__fast="g") == []


def test_recorded_plans_pass() -> None:
    """Plans that led to accepted cases: nothing is refused that could have been built."""
    seen, refused = 0, (("mechanism", "planner-02.reply.md"), ("gear_train", "planner-02.reply.md"))  # and rightly so
    for file in sorted((Path(__file__).parent / "recorded").glob("*/planner-0[12].reply.md")):
        data = read_reply(file.read_text("utf-8"))[0]
        if "checks" in data and (file.parent.name, file.name) not in refused:
            seen += 1
            assert plan_faults(CasePlan.model_validate(data), Path("case.yaml")) == [], file
    assert seen >= 8


@pytest.mark.parametrize(
    ("form", "data", "about"),
    [
        (Decision, {"action": "repair", "why": "x", "waiver": {}}, "did you mean `waive`"),
        (Decision, {"action": "repair", "why": "x", "routes": [{"section": "scene", "instruction": "y", "card": []}]},
         "/routes/0/card: the form has no such field; did you mean `cards`?; it has section"),
        (Opening, {"event": "x", "dropped": ["a"]}, "did you mean `drop`"),
    ],
)  # fmt: skip
def test_nothing_of_a_decision_is_without_effect(form: Any, data: dict[str, Any], about: str) -> None:
    with pytest.raises(Wrong) as wrong:
        typed_parser(form)(data)
    assert about in "\n".join(wrong.value.reasons)


@pytest.mark.parametrize("kind", sorted(body_kinds()))
def test_every_kind_of_body_has_a_stand_in(kind: str) -> None:
    assert faults(PLAN, bodies__more={"kind": kind}) == []


@pytest.mark.parametrize(
    ("causes", "bound", "fault"),
    [
        (["bob"], ["opens"], ""),
        (["bob"], ["hits", "opens"], ""),
        (["grip"], ["falls", "opens"], ""),
        (["bob"], ["hits"], "`hits`: about `bob`, or an event of it"),
        (["bob"], ["falls"], "`falls`: about `bob`, or an event of it"),  # `tipped` counts from the strike
        (["grip"], ["falls"], "`falls`: about `grip`"),
        (["let_go"], ["falls"], ""),  # which release is meant is not known yet
        (["bob"], [], "nothing under `meets` can fail"),
        (["bob"], ["whole"], "nothing under `meets` can fail"),  # it is in `keeps`
    ],
)
def test_a_run_without_a_cause_has_to_show_something(causes: list[str], bound: list[str], fault: str) -> None:
    rows = faults(PLAN, meets={"felled": bound}, causes={"felled": causes})
    assert len(rows) == bool(fault)
    assert fault in "".join(rows)
    assert not rows or "/causes/felled: a run without `" in rows[0]


def test_a_repeated_expectation_counts_as_a_whole() -> None:
    checks = {"expect": {"full": {"measure": "m", "at": "end", "above": 1, "repeat": 3}, "moves": {"event": "e"}}}
    meets = {"filled": ["full_0", "full_2", "moves"], "other": ["full"]}
    plan = CasePlan.model_validate({"name": "a", "event": "b", "checks": checks, "meets": meets, "keeps": ["full_1"]})
    assert plan.meets == {"filled": ["full", "moves"], "other": ["full"]}
    assert plan.keeps == ["full"]
    assert CasePlan(name="c", event="d").keeps == []


def test_a_body_whose_kind_is_its_shape_may_say_so_twice() -> None:
    assert PlannedBody(kind="beam", shape="beam").shape == ""
    assert PlannedBody(kind="rigid", shape="box").shape == "box"


@pytest.mark.parametrize(("until", "doubted"), [(0.6, False), (1.2, True)])
def test_what_is_said_of_the_time_before_anything_happens_describes_the_start(until: float, doubted: bool) -> None:
    text = f"""
text2sim: 2
name: held
scene: {{duration: 2, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies: {{ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [0, 0, 0.1]}}}}}}
actions:
  controls: {{kick: {{kind: impulse, body: ball, impulse: [1, 0, 0], at: 0.8}}}}
  measures: {{x: {{kind: position, of: ball, axis: x}}}}
  expect: {{held: {{measure: x, during: [0.1, {until}], below: 5}}}}
"""
    found = held_at_start(load_text(text, Path("case.yaml")), ["held"])
    assert bool(found) == doubted
