"""Every rule about names fires where it should, alone, and nowhere in a valid case."""

from typing import Any

import pytest

from text2sim.spec_schema.names.references import check_references

CONTROL, MEASURE, EVENT, EXPECT = (f"/actions/{part}/it" for part in ("controls", "measures", "events", "expect"))
LINKS = "/bodies/arm/links"
SPHERE = {"kind": "sphere", "radius": 0.1}
CHAIR = {
    "kind": "rigid",
    "pose": {"pos": [1, 1, 1]},
    "shape": {
        "kind": "compound",
        "parts": {
            "seat": {"shape": {"kind": "box", "size": [0.2, 0.2, 0.02]}},
            "leg_0": {"shape": {"kind": "box", "size": [0.02, 0.02, 0.2]}},
            "leg_1": {"shape": {"kind": "box", "size": [0.02, 0.02, 0.2]}},
            "eye": {"shape": SPHERE, "decor": True},
        },
    },
}
BOX = {"kind": "box", "min": [-1, -1, -1], "max": [1, 1, 1]}

FIRING: list[tuple[str, str, str | None, dict[str, Any]]] = [
    # rule, where, hint, edits
    ("unknown-body", "/bodies/brick/place/on", "floor", {"/bodies/brick/place/on": "flor"}),
    ("unknown-body", "/render/cameras/main/look_at", "ball", {"/render/cameras/main/look_at": "bal"}),
    (
        "unknown-body",
        f"{CONTROL}/body",
        "brick",
        {CONTROL: {"kind": "force", "body": "brik", "force": [0, 0, 1]}},
    ),
    ("no-copies", f"{MEASURE}/of", "ball", {MEASURE: {"kind": "speed", "of": "ball[0]"}}),
    ("no-such-copy", f"{MEASURE}/of", None, {MEASURE: {"kind": "speed", "of": "brick[12]"}}),
    ("no-such-copy", f"{MEASURE}/of", None, {MEASURE: {"kind": "speed", "of": "brick[5:5]", "stat": "max"}}),
    ("no-such-copy", f"{MEASURE}/of", None, {MEASURE: {"kind": "speed", "of": "brick[5:13]", "stat": "max"}}),
    ("unknown-link", f"{MEASURE}/of", "hand", {MEASURE: {"kind": "speed", "of": "arm.hnd"}}),
    ("unknown-link", f"{MEASURE}/of", "ball", {MEASURE: {"kind": "speed", "of": "ball.hand"}}),
    (
        "part",
        "/bodies/ball/place/facing",
        "arm",
        {"/bodies/ball/pose": None, "/bodies/ball/place": {"on": "arm.hand", "facing": "arm.hand"}},
    ),
    ("duplicate-name", "/bodies/floor", None, {"/bodies/floor": {"kind": "ragdoll", "height": 1.0}}),
    ("circular-place", "/scene/statics/floor/place", None, {"/scene/statics/floor/place": {"on": "brick"}}),
    ("time-step", "/scene/dt", None, {"/scene/dt": 0.1, "/scene/duration": 0.05, "/actions": {}}),
    ("after-end", "/render/during", None, {"/render/during": [3, 4]}),
    ("too-many", "/scene/dt", None, {"/scene/dt": 1e-9, "/scene/record": {"rate": 50}}),
    ("too-many", "/scene/record/rate", None, {"/scene/dt": 1e-6, "/scene/record": {"rate": 1e9}}),
    ("rate", "/scene/record/rate", None, {"/scene/record": {"rate": 0.1}}),
    ("too-many", "/render", None, {"/render/fps": 240, "/render/speed": 0.01, "/scene/duration": 60}),
    ("no-final", "/render/quality", None, {"/render/quality": "final"}),
    ("range", "/bodies/drum/mount/range_deg", None, {"/bodies/drum/mount/range_deg": [10, 20]}),
    (
        "range",
        f"{LINKS}/elbow/joint/range_deg",
        None,
        {f"{LINKS}/elbow/joint/range_deg": [10, 20], "/bodies/arm/initial": None},
    ),
    # articulated bodies
    ("tree", f"{LINKS}/second", None, {f"{LINKS}/second": {"shape": SPHERE}}),
    ("tree", f"{LINKS}/base/joint", None, {f"{LINKS}/base/joint": {"kind": "fixed"}}),
    ("tree", f"{LINKS}/hand", None, {f"{LINKS}/hand/joint": None}),
    ("tree", "/bodies/arm/joints", None, {"/bodies/arm/joints": {"elbow": {"damping": 1}}}),
    ("unknown-link", f"{LINKS}/hand/parent", "elbow", {f"{LINKS}/hand/parent": "elbw"}),
    ("circular-tree", f"{LINKS}/elbow/parent", None, {f"{LINKS}/elbow/parent": "hand"}),
    (
        "unknown-link",
        "/bodies/arm/loops/l/between/1",
        "base",
        {"/bodies/arm/loops": {"l": {"between": ["hand", "bas"]}}},
    ),
    (
        "unknown-link",
        "/bodies/arm/loops/l/between/0",
        None,
        {"/bodies/arm/loops": {"l": {"between": ["world", "base"]}}},
    ),
    (
        "tree",
        "/bodies/arm/loops/l/between",
        None,
        {"/bodies/arm/loops": {"l": {"between": ["hand", "hand"]}}},
    ),
    ("unknown-joint", "/bodies/arm/initial/hand", None, {"/bodies/arm/initial": {"hand": 0.1}}),
    ("unknown-joint", "/bodies/arm/initial/elbo", "elbow", {"/bodies/arm/initial": {"elbo": 0.1}}),
    ("range", "/bodies/arm/initial/elbow", None, {"/bodies/arm/initial": {"elbow": 2.0}}),
    # controls
    ("not-free", f"{CONTROL}/body", None, {CONTROL: {"kind": "initial_velocity", "body": "drum"}}),
    ("not-free", f"{CONTROL}/body", None, {CONTROL: {"kind": "initial_velocity", "body": "floor"}}),
    (
        "not-dynamic",
        f"{CONTROL}/body",
        None,
        {CONTROL: {"kind": "impulse", "body": "paddle", "impulse": [1, 0, 0], "at": 1}},
    ),
    (
        "not-dynamic",
        f"{CONTROL}/body",
        None,
        {CONTROL: {"kind": "torque", "body": "nail", "torque": [1, 0, 0]}},
    ),
    ("no-joint", f"{CONTROL}/joint", None, {CONTROL: {"kind": "drive", "joint": "ball", "position": 1}}),
    ("no-joint", f"{CONTROL}/joint", None, {CONTROL: {"kind": "drive", "joint": "curtain", "position": 1}}),
    (
        "no-joint",
        f"{CONTROL}/joint",
        "arm.elbow",
        {CONTROL: {"kind": "drive", "joint": "arm", "position": 1}},
    ),
    ("no-joint", f"{CONTROL}/joint", None, {CONTROL: {"kind": "drive", "joint": "arm.hand", "position": 1}}),
    (
        "no-actuator",
        f"{CONTROL}/joint",
        None,
        {f"{LINKS}/elbow/joint/actuator": None, CONTROL: {"kind": "drive", "joint": "arm.elbow", "force": 1}},
    ),
    ("no-gain", f"{CONTROL}/position", None, {CONTROL: {"kind": "drive", "joint": "drum", "position": 1}}),
    ("no-gain", "/actions/controls/turn/velocity", None, {"/bodies/drum/mount/actuator": {"stiffness": 5}}),
    ("not-dynamic", f"{CONTROL}/body", None, {CONTROL: {"kind": "attach", "body": "floor", "to": "ball"}}),
    ("itself", f"{CONTROL}/to", None, {CONTROL: {"kind": "attach", "body": "ball", "to": "ball"}}),
    ("pairs", f"{CONTROL}/to", None, {CONTROL: {"kind": "attach", "body": "brick", "to": "hook"}}),
    (
        "no-such-copy",
        f"{CONTROL}/to",
        None,
        {CONTROL: {"kind": "attach", "body": "brick", "to": "brick[${i + 1}]"}},
    ),
    (
        "unknown-attach",
        f"{CONTROL}/attach",
        "grip",
        {CONTROL: {"kind": "release", "attach": "grib", "at": 1}},
    ),
    (
        "unknown-attach",
        f"{CONTROL}/attach",
        None,
        {CONTROL: {"kind": "release", "attach": "launch", "at": 1}},
    ),
    ("order", "/actions/controls/let_go/at", None, {"/actions/controls/grip/at": 2}),
    (
        "after-end",
        f"{CONTROL}/during",
        None,
        {CONTROL: {"kind": "force", "body": "ball", "force": [0, 0, 1], "during": [4, 5]}},
    ),
    (
        "empty-span",
        f"{CONTROL}/during",
        None,
        {CONTROL: {"kind": "force", "body": "ball", "force": [0, 0, 1], "during": [1, 1]}},
    ),
    (
        "empty-span",
        f"{CONTROL}/during",
        None,
        {CONTROL: {"kind": "torque", "body": "ball", "torque": [0, 0, 1], "during": [0, 0]}},
    ),
    # measures
    ("needs-stat", MEASURE, None, {MEASURE: {"kind": "speed", "of": "brick"}}),
    ("needs-stat", MEASURE, None, {MEASURE: {"kind": "speed", "of": "arm.*"}}),
    ("needs-stat", MEASURE, None, {MEASURE: {"kind": "bend", "of": "arm.*"}}),
    ("unknown-link", f"{MEASURE}/of", None, {MEASURE: {"kind": "speed", "of": "arm.wing_*", "stat": "max"}}),
    (
        "part-pattern",
        f"{CONTROL}/body",
        None,
        {CONTROL: {"kind": "torque", "body": "arm.*", "torque": [0, 0, 1]}},
    ),
    ("not-dynamic", f"{MEASURE}/of", None, {MEASURE: {"kind": "tilt", "of": "floor"}}),
    ("no-joint", f"{MEASURE}/of", None, {MEASURE: {"kind": "joint_velocity", "of": "ball"}}),
    ("itself", f"{MEASURE}/between/1", None, {MEASURE: {"kind": "distance", "between": ["ball", "ball"]}}),
    (
        "unknown-body",
        f"{MEASURE}/by",
        "ball",
        {MEASURE: {"kind": "contact_force", "of": "floor", "by": "bal"}},
    ),
    ("contacts-not-recorded", "/actions/events/impact", None, {"/scene/record": {"contacts": False}}),
    # lists
    ("unknown-body", f"{MEASURE}/of/1", "ball", {MEASURE: {"kind": "displacement", "of": ["brick[0]", "bal"], "stat": "max"}}),
    ("unknown-body", f"{MEASURE}/by/1", "ball", {MEASURE: {"kind": "contact_count", "of": ["ball"], "by": ["brick", "bal"]}}),
    ("no-such-copy", f"{MEASURE}/of/1", None, {MEASURE: {"kind": "speed", "of": ["ball", "brick[12]"], "stat": "max"}}),
    ("unknown-link", f"{MEASURE}/of/0", "hand", {MEASURE: {"kind": "speed", "of": ["arm.hnd", "ball"], "stat": "max"}}),
    ("not-dynamic", f"{MEASURE}/of/2", None, {MEASURE: {"kind": "tilt", "of": ["ball", "drum", "floor"], "stat": "max"}}),
    ("no-joint", f"{MEASURE}/of/1", None, {MEASURE: {"kind": "joint_velocity", "of": ["drum", "ball"], "stat": "max"}}),
    ("measure-kind", f"{MEASURE}/of/1", None, {MEASURE: {"kind": "joint_position", "of": ["drum", "hook"], "stat": "max"}}),
    ("measure-kind", f"{MEASURE}/of/1", None, {MEASURE: {"kind": "bend", "of": ["drum", "ball"], "stat": "max"}}),
    ("needs-stat", MEASURE, None, {MEASURE: {"kind": "speed", "of": ["ball", "drum"]}}),
    ("needs-stat", MEASURE, None, {MEASURE: {"kind": "bend", "of": ["drum", "arm.elbow"]}}),
    ("needs-stat", MEASURE, None, {MEASURE: {"kind": "speed", "of": ["brick"]}}),
    ("unknown-body", f"{EVENT}/of/1", "ball", {EVENT: {"kind": "enters", "of": ["brick", "bal"], "region": BOX}}),
    ("driven-subject", f"{EVENT}/of/1", None, {EVENT: {"kind": "leaves", "of": ["brick", "paddle"], "region": BOX}}),
    ("no-limit", f"{EVENT}/of/1", None, {EVENT: {"kind": "joint_limit", "of": ["hook", "drum"]}}),
    (
        "driven-subject",
        f"{EVENT}/measure",
        None,
        {MEASURE: {"kind": "speed", "of": ["paddle", "paddle"]}, EVENT: {"kind": "threshold", "measure": "it", "above": 1}},
    ),
    # events
    (
        "driven-subject",
        f"{EVENT}/between",
        None,
        {EVENT: {"kind": "contact", "between": ["paddle", "floor"]}},
    ),
    ("itself", f"{EVENT}/between/1", None, {EVENT: {"kind": "separation", "between": ["ball", "ball"]}}),
    ("driven-subject", f"{EVENT}/of", None, {EVENT: {"kind": "rest", "of": "paddle"}}),
    ("not-dynamic", f"{EVENT}/of", None, {EVENT: {"kind": "rest", "of": "nail"}}),
    (
        "driven-subject",
        f"{EVENT}/measure",
        None,
        {EVENT: {"kind": "threshold", "measure": "paddle_height", "above": 1}},
    ),
    (
        "unknown-measure",
        f"{EVENT}/measure",
        "height",
        {EVENT: {"kind": "threshold", "measure": "heigth", "above": 1}},
    ),
    ("unknown-event", f"{EVENT}/after", "impact", {EVENT: {"kind": "rest", "of": "ball", "after": "impct"}}),
    ("circular-after", "/actions/events/impact/after", None, {"/actions/events/impact/after": "settled"}),
    ("no-domain", EVENT, None, {"/scene/domain": None, EVENT: {"kind": "left_domain", "of": "ball"}}),
    ("no-limit", f"{EVENT}/of", None, {EVENT: {"kind": "joint_limit", "of": "drum"}}),
    ("unknown-attach", f"{EVENT}/attach", "grip", {EVENT: {"kind": "released", "attach": "gripp"}}),
    (
        "never-released",
        f"{EVENT}/attach",
        None,
        {"/actions/controls/let_go": None, EVENT: {"kind": "released", "attach": "grip"}},
    ),
    ("after-end", f"{MEASURE}/change_from", None, {MEASURE: {"kind": "speed", "of": "ball", "change_from": 3.5}}),
    # expectations
    ("unknown-event", f"{EXPECT}/event", "impact", {EXPECT: {"event": "impac"}}),
    ("unknown-event", f"{EXPECT}/on", "impact", {EXPECT: {"event": "settled", "on": "impac", "within": [0, 1]}}),
    ("unknown-event", f"{EXPECT}/before", "settled", {EXPECT: {"event": "impact", "before": "setled"}}),
    ("impossible", f"{EXPECT}/before", None, {EXPECT: {"event": "impact", "before": "impact"}}),
    ("impossible", f"{EXPECT}/count", None, {EXPECT: {"event": "impact", "count": [3, 2]}}),
    ("impossible", f"{EXPECT}/count", None, {EXPECT: {"event": "impact", "count": -1}}),
    ("after-end", f"{EXPECT}/within", None, {EXPECT: {"event": "impact", "within": [4, 5]}}),
    ("unknown-measure", f"{EXPECT}/measure", "height", {EXPECT: {"measure": "hight", "at": 1, "above": 1}}),
    ("after-end", f"{EXPECT}/at", None, {EXPECT: {"measure": "height", "at": 3.5, "above": 1}}),
    ("after-end", f"{EXPECT}/during", None, {EXPECT: {"measure": "height", "during": [1, 3.5], "above": 1}}),
    ("impossible", EXPECT, None, {EXPECT: {"measure": "height", "at": 1, "above": 2, "below": 1}}),
    (
        "impossible",
        EXPECT,
        None,
        {EXPECT: {"measure": "height", "at": 1, "equals": 2, "tolerance": 0.1, "below": 1}},
    ),
    (
        "driven-subject",
        f"{EXPECT}/measure",
        None,
        {EXPECT: {"measure": "paddle_height", "at": 1, "above": 1}},
    ),
    *(
        (rule, f"{place}/region/moves_with", None,
         {place: {"kind": kind, "of": "ball", "region": {"kind": "sphere", "center": [0, 0, 0], "radius": 1, "moves_with": by}}})
        for place, kind in ((MEASURE, "count_in"), (EVENT, "enters"))
        for rule, by in (("carrier", "brick"), ("unknown-body", "nothing_of_the_kind"))
    ),
    *(
        (rule, f"{MEASURE}/frame", None,
         {MEASURE: {"kind": "extent", "of": "ball", "axis": "z", "stat": "max", "frame": frame}})
        for rule, frame in (("carrier", "brick"), ("unknown-body", "nothing_of_the_kind"))
    ),
    *(
        ("no-thread", f"{MEASURE}/{side}", None, {MEASURE: {"kind": "threaded", "of": of, "by": by}})
        for side, of, by in (
            ("of", "ball", "brick"),
            ("of", "arm", "arm.elbow"),
            ("of", "jelly", "post"),
            ("by", "drum", "arm.hand"),
            ("by", "drum", "ball"),
        )
    ),
    *(
        (rule, f"{MEASURE}/measures{at}", hint, {MEASURE: {"kind": kind, "measures": names}, **more})
        for rule, at, hint, kind, names, more in (
            ("unknown-measure", "/1", "height", "ratio", ["ball_speed", "heigt"], {}),
            ("measure-kind", "", None, "difference", ["ball_speed", "height"], {}),
            ("measure-kind", "", None, "difference", ["height", "angle"],
             {"/actions/measures/angle": {"kind": "joint_position", "of": "arm.elbow"}}),
        )
    ),
    *(
        (rule, where, hint, {"/bodies/chair": CHAIR, **edits})
        for rule, where, hint, edits in (
            ("unknown-link", f"{MEASURE}/of", "chair", {MEASURE: {"kind": "speed", "of": "chair.leg_0"}}),
            ("unknown-link", f"{MEASURE}/of", "leg_*", {MEASURE: {"kind": "contact_count", "of": "chair.log_*"}}),
            ("unknown-link", f"{MEASURE}/by", "seat",
             {MEASURE: {"kind": "contact_force", "of": "ball", "by": "chair.set"}}),
            ("unknown-link", f"{EVENT}/between/0", None, {EVENT: {"kind": "contact", "between": ["chair.eye", "ball"]}}),
            ("part", f"{EVENT}/between/0", "chair", {EVENT: {"kind": "contact", "between": ["chair.seat", "jelly"]}}),
            ("part", f"{MEASURE}/by", "chair", {MEASURE: {"kind": "penetration", "of": "jelly", "by": "chair.seat"}}),
        )
    ),
]  # fmt: skip

SILENT: list[dict[str, Any]] = [
    {},
    {MEASURE: {"kind": "speed", "of": "brick[2:5]", "stat": "max"}},
    {MEASURE: {"kind": "speed", "of": "brick[3]"}},
    {MEASURE: {"kind": "position", "of": "floor", "axis": "z"}},
    {MEASURE: {"kind": "extent", "of": "floor", "axis": "z", "stat": "max", "frame": "ball"}},
    {
        MEASURE: {"kind": "contact_force", "of": "paddle", "by": "ball"},
        EVENT: {"kind": "threshold", "measure": "it", "above": 1},
    },
    {MEASURE: {"kind": "displacement", "of": ["ball", "brick[2:5]", "arm.hand"], "stat": "max"}},
    {MEASURE: {"kind": "speed", "of": ["ball", "ball"]}},
    {MEASURE: {"kind": "extent", "of": ["floor", "ball"], "axis": "z", "stat": "max"}},
    {MEASURE: {"kind": "contact_count", "of": ["ball", "brick"], "by": ["floor", "paddle"]}},
    {MEASURE: {"kind": "count_in", "of": ["ball", "brick"], "region": BOX}},
    {
        MEASURE: {"kind": "speed", "of": ["paddle", "ball"], "stat": "max"},
        EVENT: {"kind": "threshold", "measure": "it", "above": 1},
    },
    {MEASURE: {"kind": "threaded", "of": "drum", "by": ["arm.elbow", "post[0]"]}},
    {MEASURE: {"kind": "ratio", "measures": ["ball_speed", "height"]}},
    {
        MEASURE: {"kind": "difference", "measures": ["height", "slid"]},
        "/actions/measures/slid": {"kind": "joint_position", "of": "hook[0]"},
    },
    {EVENT: {"kind": "enters", "of": ["ball", "brick[3]"], "region": BOX}},
    {EVENT: {"kind": "joint_limit", "of": ["hook", "arm.elbow"]}},
    {EVENT: {"kind": "contact", "between": ["paddle", "ball"]}},
    {EVENT: {"kind": "contact", "between": ["brick", "brick"]}},
    {"/bodies/chair": CHAIR, EVENT: {"kind": "contact", "between": ["chair.leg_*", "floor"]}},
    {"/bodies/chair": CHAIR, MEASURE: {"kind": "contact_force", "of": ["chair.seat", "ball"], "by": "brick[2]"}},
    {EVENT: {"kind": "joint_limit", "of": "hook"}},
    {CONTROL: {"kind": "attach", "body": "brick", "to": "ball"}},
    {CONTROL: {"kind": "attach", "body": "brick[0:8]", "to": "hook"}},
    {CONTROL: {"kind": "attach", "body": "brick", "to": "brick[${(i + 1) % n}]"}},
    {CONTROL: {"kind": "initial_velocity", "body": "doll", "linear": [1, 0, 0]}},
    {CONTROL: {"kind": "force", "body": "arm.hand", "force": [0, 0, 1]}},
    # What only the compiler knows is left to it.
    {CONTROL: {"kind": "force", "body": "doll.head", "force": [0, 0, 1]}},
    {"/bodies/arm/links": None, "/bodies/arm/initial": None, "/bodies/arm/file": "assets/arm.xml"},
    {"/bodies/arm/loops": {"l": {"between": ["hand", "world"]}}},
    {EXPECT: {"measure": "height", "at": 3, "above": 1}},
]


@pytest.mark.parametrize(("rule", "where", "hint", "edits"), FIRING)
def test_fires_alone(stage, rule, where, hint, edits):
    problems = check_references(stage(edits))
    assert [(p.rule, p.path, p.hint) for p in problems] == [(rule, where, hint)]


@pytest.mark.parametrize("edits", SILENT)
def test_stays_silent(stage, edits):
    assert check_references(stage(edits)) == []


def test_the_names_that_exist_are_listed(stage):
    (problem,) = check_references(stage({EXPECT: {"event": "bonk"}}))
    assert problem.message == "there is no event `bonk`; there are impact, settled"


def test_a_rule_points_at_the_line(stage):
    loaded = stage({EXPECT: {"event": "impac"}})
    (problem,) = check_references(loaded)
    line = loaded.source.lines[problem.line - 1]
    assert line[problem.column - 1 :].startswith("impac}")


def test_all_at_once_in_the_order_of_the_file(stage):
    edits = {
        EXPECT: {"event": "impac"},
        MEASURE: {"kind": "speed", "of": "bal"},
        "/bodies/brick/place/on": "flor",
    }
    problems = check_references(stage(edits))
    assert [p.rule for p in problems] == ["unknown-body", "unknown-body", "unknown-event"]
    assert [p.line for p in problems] == sorted(p.line for p in problems)


def test_a_rate_of_recording_that_is_taken_over_from_the_message_is_enough(stage):
    edits = {"/scene/duration": 0.3, "/scene/record": {"rate": 3}}
    (problem,) = (p for p in check_references(stage(edits)) if p.rule == "rate")
    assert problem.message == "records only the start: a run of 0.3 s needs at least 3.4"
    problems = check_references(stage(edits | {"/scene/record": {"rate": 3.4}}))
    assert not [p for p in problems if p.rule == "rate"]


def test_what_comes_too_late_to_matter_is_a_warning(stage):
    edits = {CONTROL: {"kind": "impulse", "body": "ball", "impulse": [1, 0, 0], "at": 3}}
    assert [p.severity for p in check_references(stage(edits))] == ["warning"]
