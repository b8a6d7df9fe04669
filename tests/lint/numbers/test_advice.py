"""Advice that is followed to the letter: its rule no longer reports anything, although messages round."""

import re
from pathlib import Path

import pytest
from lint_support import findings

BALL = (
    "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: 1.29}, pose: {pos: [0, 0, 1]}}}"
)
ACT = "scene: {duration: 1, dt: 0.0109, substeps: 1}\nactions: {controls: {act: {body: ball, %s}}}\n" + BALL
STAND = """\
scene: {dt: 0.01, contact: {timeconst: %s}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  under: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {mass: 0.1}, place: {on: floor, at: [0, 0]}}
  over: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {mass: 150}, place: {on: under, at: [0, 0]}}
"""
FEM = "bodies: {bar: {kind: soft, solver: fem, cell: %s, shape: {kind: box, size: [0.5, 0.0633, 0.0633]}, pose: {pos: [0, 0, 1]}}}"
CLOTH = """\
scene: {dt: 0.004, substeps: 1}
bodies:
  flag:
    kind: cloth
    shape: {kind: sheet, size: [0.4, 0.4]}
    material: {area_density: 0.1283, air_resistance: %s}
    pose: {pos: [0, 0, 1]}
"""
STEP = """\
scene: {duration: 1, dt: %s}
actions:
  controls:
    act: {kind: force, body: ball, force: [0, 0, 1], scale: {kind: piecewise, times: [0, 0.1, 0.1126], values: [0, 0, 1]}}
"""
SPRING = """\
scene: {dt: %s, statics: {beam: {shape: {kind: box, size: [1, 0.1, 0.1]}, pose: {pos: [0, 0, 2]}}}}
actions: {controls: {act: {kind: spring, body: ball, to: beam, stiffness: 15000, damping: 3}}}
"""
WALL = """\
scene: {mpm: {cell: 0.01231}, statics: {wall: {shape: {kind: box, size: [1, 1, %s]}}}}
bodies: {sand: {kind: granular, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.3]}}}
"""
FUNNEL = """\
scene: {mpm: {cell: 0.01233}, statics: {funnel: {shape: {kind: funnel, top_radius: 0.2, bottom_radius: %s, height: 0.2, thickness: 0.05}}}}
bodies: {sand: {kind: granular, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.5]}}}
"""
FOOT = """\
scene: {mpm: {cell: 0.01233}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  jelly: {kind: soft, solver: mpm, shape: {kind: box, size: [0.3, 0.3, 0.2]}, place: {on: floor, at: [0, 0]}}
  pole: {kind: rigid, shape: {kind: box, size: [%s, 0.1, 0.6]}, place: {on: jelly, at: [0, 0]}}
"""
FOLLOWED = [
    ("fast-spin", ACT % "kind: initial_velocity, angular: [0, 0, %s]", "80", r"at most (\S+) rad/s"),
    ("violent-push", ACT % "kind: impulse, impulse: [0, 0, %s], at: 0.1", "30", r"at most (\S+) N s"),
    ("violent-push", ACT % "kind: force, during: [0, 0.05], force: [0, 0, %s]", "5000", r"at most (\S+) N"),
    ("violent-push", ACT % "kind: force, during: [0, 0.95], force: [0, 0, %s]", "1450", r"at most (\S+) N"),
    ("fast-schedule", STEP + BALL, "0.02", r"scene.dt of (\S+)"),
    ("stiff-spring", SPRING + BALL, "0.02", r"scene.dt of (\S+) or less"),
    ("mass-ratio", STAND, "0.02", r"contact.timeconst of (\S+) s"),
    ("too-few-elements", FEM, "0.03", r"`cell: (\S+)`"),
    ("thin-wall", WALL, "0.005", r"make it (\S+) (mm) or thicker"),
    ("narrow-opening", FUNNEL, "0.02", r"use a radius of (\S+) (mm)"),
    ("narrow-foot", FOOT, "0.01", r"make the foot (\S+) (mm) wide"),
    ("drag-diverges", CLOTH, "1", r"use (\S+) at most"),
]


@pytest.mark.parametrize(("rule", "case", "value", "advice"), FOLLOWED)
def test_advice_that_is_followed_to_the_letter(rule: str, case: str, value: str, advice: str, tmp_path: Path) -> None:
    (found,) = findings(tmp_path, rule, case % value)
    given = re.search(advice, found.message)
    assert given is not None, found.message
    assert findings(tmp_path, rule, case % (float(given[1]) / (1000 if given.lastindex == 2 else 1))) == []
