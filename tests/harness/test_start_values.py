"""Values at the start: what the lint says of a case before its run is what evidence finds in the first frame."""

import json

import numpy as np
import pytest

from text2sim.compiler.build import resolve_case
from text2sim.evidence.measures import evaluate
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.lint.facts import Facts
from text2sim.lint.script.measure_bounds import values_of
from text2sim.lint.script.start_values import _COLLECTIVE, _PER_TARGET, UNDEFORMED
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.measures import Measure
from text2sim.spec_schema.published.language_reference import section_kinds

SIZE = (0.3, 0.2, 0.1)
BOX = {"kind": "rigid", "shape": {"kind": "box", "size": SIZE}}
BODIES = {
    "brick": BOX | {"pose": {"pos": [1, 2, 3], "euler_deg": [0, 0, 30]}},
    "pin": BOX | {"pose": {"pos": [0, -2, 0.5]}, "repeat": {"kind": "line", "count": 3, "step": [0.5, 0.1, 0]}},
    "gate": BOX | {"pose": {"pos": [-3, 0, 1]}, "mount": {"kind": "hinge", "axis": "z"}},
}
CONTROLS = {
    "throw": {"kind": "initial_velocity", "body": "brick", "linear": [3, -4, 12]},
    "whirl": {"kind": "initial_velocity", "body": "pin[1]", "linear": [0, 2, 0], "angular": [1, 2, -2]},
}
BALL = {"kind": "sphere", "center": [0, -2, 0.5], "radius": 0.7}
MEASURES = {
    "x": {"kind": "position", "of": "brick", "axis": "x"},
    "lowest": {"kind": "position", "of": "pin", "axis": "y", "stat": "min"},
    "mean": {"kind": "position", "of": "pin", "axis": "x", "stat": "mean"},
    "spread": {"kind": "position", "of": "pin", "axis": "x", "stat": "std"},
    "range": {"kind": "position", "of": "pin", "axis": "x", "stat": "range"},
    "sum": {"kind": "position", "of": "pin", "axis": "x", "stat": "sum"},
    "right": {"kind": "position", "of": "pin", "axis": "x", "stat": "count", "above": 0.4},
    "climb": {"kind": "velocity", "of": "brick", "axis": "z"},
    "speed": {"kind": "speed", "of": "brick"},
    "fastest": {"kind": "speed", "of": "pin", "stat": "max"},
    "turning": {"kind": "angular_speed", "of": "pin", "stat": "max"},
    "about": {"kind": "angular_velocity", "of": "pin[1]", "axis": "z"},
    "turns": {"kind": "turns", "of": "pin[1]", "axis": "z"},
    "moved": {"kind": "displacement", "of": "brick"},
    "tilt": {"kind": "tilt", "of": "brick"},
    "tall": {"kind": "extent", "of": "pin", "axis": "z", "stat": "range"},
    "end": {"kind": "extent", "of": "pin", "axis": "x", "stat": "max"},
    "gap": {"kind": "distance", "between": ["brick", "pin"]},
    "near": {"kind": "distance", "between": ["pin", "pin"]},
    "inside": {"kind": "count_in", "of": "pin", "region": BALL},
    "push": {"kind": "momentum", "of": "brick", "axis": "y"},
    "still": {"kind": "energy", "of": "gate", "part": "kinetic"},
    "angle": {"kind": "joint_position", "of": "gate"},
    "rate": {"kind": "joint_velocity", "of": "gate"},
    "bent": {"kind": "bend", "of": "gate"},
    "both": {"kind": "position", "of": ["brick", "pin[2]"], "axis": "x", "stat": "mean"},
    "twice": {"kind": "position", "of": ["pin[1:3]", "pin", "pin[0]"], "axis": "x", "stat": "sum"},
    "reach": {"kind": "extent", "of": ["pin", "brick"], "axis": "x", "stat": "range"},
    "pushes": {"kind": "momentum", "of": ["brick", "pin[1]"], "axis": "y"},
    "there": {"kind": "count_in", "of": ["pin[0]", "brick", "pin[1:3]"], "region": BALL},
    "change": {"kind": "position", "of": "brick", "axis": "x", "change_from": "start"},
    "peak": {"kind": "position", "of": "brick", "axis": "x", "so_far": "max"},
    "swung": {"kind": "position", "of": "brick", "axis": "x", "so_far": "range"},
    "swung_both": {"kind": "position", "of": ["brick", "pin[2]"], "axis": "x", "stat": "mean", "so_far": "range"},
}


@pytest.fixture(scope="module")
def facts() -> Facts:
    case = {"text2sim": 2, "name": "a", "scene": {"duration": 1}, "bodies": BODIES}
    return Facts(resolve_case(load_text(json.dumps(case | {"actions": {"measures": MEASURES, "controls": CONTROLS}}))))


@pytest.fixture
def recorded(new_run, facts):
    """What evidence says of a recording whose first frame is as the case has it."""
    run = new_run(duration=0.01)
    rows = {row.entity: row for row in facts.rows.velocities}
    for name in BODIES:
        for copy in facts.placed[name]:
            moving = {"vel": rows[copy.name].linear, "ang": rows[copy.name].angular} if copy.name in rows else {}
            link = run.add_link(copy.name, mass=facts.masses[copy.name], pos=copy.pos, quat=copy.quat, **moving)
            run.add_box(link, np.array(SIZE) / 2)
    run.add_joint("gate", "gate", "hinge", link=link)
    return evaluate(RecordedCase.load(run.write(), facts.case))


@pytest.mark.parametrize("name", MEASURES)
def test_the_start_is_what_evidence_finds_there(name, facts, recorded):
    found, known = recorded[name], values_of(facts, name)
    assert found.problem == ""
    assert known.start == pytest.approx(found.values[0], abs=1e-5)
    assert known.unit == found.unit


ELSEWHERE = {"joint_position", "joint_velocity", "joint_force", "difference", "ratio", "volume"}
"""Kinds whose value at the start is found outside the tables."""
UNKNOWN = {
    "angular_momentum", "contact_count", "contact_force", "folded_area", "folds", "gap", "largest_piece", "leaked",
    "penetration", "pieces", "self_penetration", "share_in", "spring_force", "submerged", "surface_level", "threaded",
    "wrinkling",
}  # fmt: skip
"""Kinds of which the lint does not say how they start."""


def test_every_kind_is_known_at_the_start_or_set_apart():
    known = {*_PER_TARGET, *_COLLECTIVE, *UNDEFORMED}
    assert (known | ELSEWHERE | UNKNOWN) ^ {*section_kinds(Measure)} == set(), "a row in start_values.py, or in UNKNOWN"
    assert known & UNKNOWN == set()


def test_every_known_start_is_compared():
    compared = {measure["kind"] for measure in MEASURES.values()}
    assert {*_PER_TARGET, *_COLLECTIVE} - compared == set(), "a row is missing in MEASURES"
