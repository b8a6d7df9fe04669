"""What can be bonded, and what refers to bonds."""

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references

CASE = """\
text2sim: 2
name: bonded
scene: {duration: 2, statics: {floor: {shape: {kind: plane}}, table: {shape: {kind: box, size: [1, 1, 0.1]}}}%s}
bodies:
  brick: {kind: rigid, shape: {kind: box, size: [0.2, 0.1, 0.1]}, place: {on: table}, repeat: {kind: line, count: 3, step: [%s, 0, 0]}}
  flag: {kind: cloth, shape: {kind: sheet, size: [0.5, 0.5]}, pose: {pos: [0, 0, 3]}}
  arm: {kind: articulated, links: {base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}}, pose: {pos: [2, 0, 1]}}
actions:
  controls: {glue: {kind: bond, of: %s, strength: 1.0e5}}
  measures: {parts: {kind: pieces, of: "%s"}}
  events: {cracks: {kind: broken, bond: %s}}
"""
RODS = """\
text2sim: 2
name: rods
scene: {duration: 2, statics: {floor: {shape: {kind: plane}}}}
bodies:
  rod: {kind: rigid, shape: {kind: box, size: [0.7, 0.02, 0.02]}, pose: {pos: [0.3, 0, 1]}, repeat: {kind: line, count: 2, step: [0.7, 0, 0]}}
actions: {controls: {glue: {kind: bond, of: "rod[*]", strength: 1.0e5, gap: 0}%s}}
"""


def case(of: str = '"brick[*]"', step: float = 0.2, measured: str = "brick[*]", bond: str = "glue", scene: str = ""):
    return load_text(CASE % (scene, step, of, measured, bond))


def test_neighbours_are_bonded_at_the_faces_that_they_share():
    rows = resolve_case(case('["brick[*]", table]')).plan.bonds
    pairs = {(row.a, row.b): row for row in rows}
    assert list(pairs) == [
        ("brick[0]", "brick[1]"), ("brick[0]", "table"), ("brick[1]", "brick[2]"), ("brick[1]", "table"),
        ("brick[2]", "table"),
    ]  # fmt: skip
    side, foot = pairs["brick[0]", "brick[1]"], pairs["brick[1]", "table"]
    assert side.area == pytest.approx(0.01)
    assert foot.area == pytest.approx(0.02)
    assert foot.normal == pytest.approx((0, 0, -1))
    assert foot.center[2] == pytest.approx(0.05, abs=1e-3)


def test_what_does_not_touch_is_not_bonded():
    with pytest.raises(SpecError, match="no two of these bodies share a flat face within 0.0005 m"):
        resolve_case(case(step=0.25))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"of": "[flag, table]"}, "`flag` cannot be bonded; only whole rigid and driven bodies, and statics"),
        ({"of": "[arm.base, table]"}, "`arm.base` cannot be bonded"),
        ({"of": "[floor, table]"}, "none of these bodies moves"),
        ({"of": '"brick[1]"'}, "`brick[1]` is a single body; name its copies"),
        ({"bond": "glu"}, "there is no control `glu` of kind bond"),
        ({"of": "[arm, table]", "measured": "brick[*]"}, "`brick` has no pieces: it is rigid"),
        ({"scene": ", contact: {model: sap}"}, "contact model sap has no bonds"),
    ],
)
def test_what_is_refused(given, said):
    found = check_references(case(**given))
    assert any(said in problem.message for problem in found), [problem.message for problem in found]
    assert all(problem.line and problem.column for problem in found)


def test_a_slender_rod_is_bonded_at_its_ends_although_rounding_leaves_a_gap():
    (end,) = (row for row in resolve_case(rods()).plan.bonds)
    assert end.area == pytest.approx(0.0004)


def test_what_is_bonded_cannot_be_attached_too():
    with pytest.raises(SpecError, match=r"`rod\[0\]` and `rod\[1\]` are joined by a `bond` already"):
        resolve_case(rods(', hold: {kind: attach, body: "rod[0]", to: "rod[1]", at: 1}'))


def rods(control: str = ""):
    return load_text(RODS % control)


def test_a_scene_has_a_largest_number_of_bonds(monkeypatch):
    monkeypatch.setattr("text2sim.compiler.controls.MAX_BONDS", 1)
    with pytest.raises(SpecError, match="the scene has 2 bonds, and the engine can solve some 1"):
        resolve_case(case())
