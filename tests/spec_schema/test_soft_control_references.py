"""Controls of bodies that deform: what they may say, and what is said of them where they may not."""

from typing import Any

import pytest

from text2sim.spec_schema.names.references import check_references

CONTROL = "/actions/controls/it"
PUSH = {"kind": "force", "force": [0, 0, 1]}
FLOW = {"kind": "airflow", "velocity": [3, 0, 0]}
TOP, BACK = {"face": "top"}, {"edge": "back"}
SAND = {"kind": "granular", "shape": {"kind": "box", "size": [0.2, 0.2, 0.2]}, "pose": {"pos": [3, -3, 1]}}

FLAGS = {
    "kind": "cloth",
    "shape": {"kind": "sheet", "size": [0.3, 0.2]},
    "repeat": {"kind": "line", "count": 2, "step": [1, 0, 0], "start": [-1, 2, 2]},
}
HELD = {"kind": "attach", "body": "ball", "to": "nail", "strength": 5}
FREE = {"kind": "release", "attach": "it", "at": 1}

FIRING: list[tuple[str, str, str | None, dict[str, Any]]] = [
    # rule, where, hint, edits
    ("not-soft", f"{CONTROL}/region", "point", {CONTROL: {**PUSH, "body": "ball", "region": TOP}}),
    ("not-soft", f"{CONTROL}/drag", None, {CONTROL: {**PUSH, "body": "ball", "drag": 2}}),
    ("not-soft", f"{CONTROL}/points", None, {CONTROL: {"kind": "attach", "body": "ball", "to": "nail", "points": 2}}),
    ("no-strength", f"{CONTROL}/strength", None, {CONTROL: {**HELD, "body": "jelly"}}),
    ("no-strength", f"{CONTROL}/strength", None, {CONTROL: {**HELD, "body": "curtain", "to": "world"}}),
    (
        "no-strength",
        f"{CONTROL}/strength",
        None,
        {"/bodies/flags": FLAGS | {"repeat": FLAGS["repeat"] | {"count": 3}}, CONTROL: {**HELD, "body": "flags", "to": "${'world' if i == 1 else 'nail'}"}},
    ),
    ("itself", f"{CONTROL}/to", None, {"/bodies/flags": FLAGS, CONTROL: {"kind": "attach", "body": "flags", "to": "flags[*]"}}),
    (
        "itself",
        f"{CONTROL}/to",
        None,
        {CONTROL: {"kind": "attach", "body": "curtain", "region": BACK, "to": "curtain", "to_region": BACK}},
    ),
    ("not-soft", f"{CONTROL}/to_region", None, {CONTROL: {**HELD, "body": "curtain", "to_region": BACK}}),
    ("not-soft", f"{CONTROL}/to_region", None, {CONTROL: {**HELD, "to_region": TOP}}),
    ("itself", f"{CONTROL}/to", None, {CONTROL: {"kind": "attach", "body": "curtain", "region": BACK, "to": "curtain"}}),
    (
        "pairs",
        f"{CONTROL}/to",
        None,
        {"/bodies/flags": FLAGS, CONTROL: {"kind": "attach", "body": "curtain", "region": BACK, "to": "flags"}},
    ),
    ("no-strength", f"{CONTROL}/strength", None, {CONTROL: HELD | {"at": 0.5}}),
    ("no-strength", f"{CONTROL}/strength", None, {CONTROL: HELD | {"pivot": TOP}}),
    ("no-strength", f"{CONTROL}/strength", None, {CONTROL: HELD, "/actions/controls/free": FREE}),
    ("unknown-bond", "/actions/events/off/bond", "it", {CONTROL: HELD, "/actions/events/off": {"kind": "broken", "bond": "itt"}}),
    ("never-released", "/actions/events/off/bond", None, {"/actions/events/off": {"kind": "broken", "bond": "grip"}}),
    ("no-pivot", f"{CONTROL}/pivot", None, {CONTROL: {"kind": "attach", "body": "curtain", "to": "hook", "pivot": TOP}}),
    ("no-pivot", f"{CONTROL}/pivot", None, {CONTROL: {"kind": "attach", "body": "ball", "to": "world", "pivot": TOP}}),
    ("soft-torque", f"{CONTROL}/kind", None, {CONTROL: {"kind": "torque", "body": "jelly", "torque": [0, 0, 1]}}),
    ("soft-point", f"{CONTROL}/point", "region", {CONTROL: {**PUSH, "body": "jelly", "point": [0, 0, 0]}}),
    ("soft-frame", f"{CONTROL}/frame", None, {CONTROL: {**PUSH, "body": "jelly", "frame": "body"}}),
    (
        "soft-point",
        f"{CONTROL}/point",
        None,
        {CONTROL: {"kind": "impulse", "body": "jelly", "impulse": [0, 0, 1], "at": 1, "point": [0, 0, 0.1]}},
    ),
    ("no-cloth", f"{CONTROL}/body", None, {CONTROL: {**FLOW, "body": "jelly"}}),
    ("no-cloth", f"{CONTROL}/body", None, {CONTROL: {**FLOW, "body": "ball"}}),
    ("no-cloth", f"{CONTROL}/body/1", None, {CONTROL: {**FLOW, "body": ["curtain", "jelly"]}}),
    ("unknown-link", f"{CONTROL}/body", "jelly", {CONTROL: {**PUSH, "body": "jelly.top"}}),
    ("soft-holder", f"{CONTROL}/to", None, {CONTROL: {"kind": "attach", "body": "curtain", "to": "jelly"}}),
    ("soft-holder", f"{CONTROL}/to", None, {CONTROL: {"kind": "attach", "body": "ball", "to": "jelly"}}),
    ("not-held", f"{CONTROL}/body", None, {"/bodies/sand": SAND, CONTROL: {"kind": "attach", "body": "sand", "to": "world"}}),
    ("points", f"{CONTROL}/points", None, {CONTROL: {"kind": "attach", "body": "curtain", "points": 3, "to": "hook"}}),
    (
        "no-world",
        f"{CONTROL}/to",
        None,
        {"/scene/statics": None, "/bodies/brick": None, "/actions/measures": None, "/actions/events": None,
         "/actions/expect": None, "/actions/controls/clear_post": None, "/actions/controls/joints": None, CONTROL: {"kind": "attach", "body": "ball", "to": "world"}},
    ),
    ("unknown-event", "/actions/controls/let_go/on", "impact", {"/actions/controls/let_go": {"kind": "release", "attach": "grip", "on": "impct"}}),
]  # fmt: skip

SILENT: list[dict[str, Any]] = [
    {CONTROL: {**HELD, "body": "curtain"}},
    {CONTROL: {**HELD, "body": "curtain", "at": 0.5}, "/actions/controls/free": FREE},
    {CONTROL: {**HELD, "body": "curtain", "region": BACK, "to": "curtain", "to_region": {"edge": "front"}}},
    {"/bodies/flags": FLAGS, CONTROL: {**HELD, "body": "flags", "region": BACK, "to": "curtain"}},
    {CONTROL: HELD, "/actions/events/off": {"kind": "broken", "bond": "it"}},
    {CONTROL: {**PUSH, "body": "jelly", "region": TOP, "drag": 3}},
    {CONTROL: {"kind": "impulse", "body": "jelly", "impulse": [0, 0, 1], "at": 1, "point": TOP}},
    {CONTROL: {"kind": "initial_velocity", "body": "curtain", "linear": [1, 0, 0], "angular": [0, 0, 1]}},
    {"/bodies/sand": SAND, CONTROL: {"kind": "initial_velocity", "body": "sand", "linear": [1, 0, 0]}},
    {CONTROL: {"kind": "attach", "body": "curtain", "region": BACK, "points": 16, "to": "hook[*]"}},
    {CONTROL: {"kind": "attach", "body": "curtain", "region": BACK, "to": "world", "at": 0.5}},
    {CONTROL: {"kind": "attach", "body": "jelly", "region": TOP, "to": "drum", "stiffness": 200}},
    {CONTROL: {"kind": "attach", "body": "ball", "to": "world"}},
    {CONTROL: {"kind": "attach", "body": "ball", "to": "nail", "pivot": TOP}},
    {"/actions/controls/let_go": {"kind": "release", "attach": "grip", "on": "impact"}},
    {CONTROL: {**FLOW, "body": "curtain", "during": [0.5, 1]}},
    {CONTROL: {"kind": "wind", "direction": "x", "acceleration": 3, "during": [0.5, 1]}},
]


@pytest.mark.parametrize(("rule", "where", "hint", "edits"), FIRING)
def test_fires_alone(stage, rule, where, hint, edits):
    problems = check_references(stage(edits))
    assert [(p.rule, p.path, p.hint) for p in problems] == [(rule, where, hint)]


@pytest.mark.parametrize("edits", SILENT)
def test_stays_silent(stage, edits):
    assert check_references(stage(edits)) == []
