"""Friction of pairs: between what there is, and can rub."""

import pytest

from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references

CASE = """\
text2sim: 2
name: rubbing
scene:
  duration: 1
  contact: {%s pairs: {ice: {between: %s, friction: 0.05}}}
  statics: {floor: {shape: {kind: plane}}, wall: {shape: {kind: box, size: [1, 1, 1]}, pose: {pos: [4, 0, 0.5]}}}
bodies:
  puck: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, repeat: {kind: line, count: 3, step: [1, 0, 0]}}
  flag: {kind: cloth, shape: {kind: sheet, size: [0.5, 0.5]}, pose: {pos: [0, 0, 3]}}
"""


@pytest.mark.parametrize("between", ["[puck, floor]", '["puck[0]", "puck[1]"]', "[wall, puck]"])
def test_bodies_and_statics_rub(between):
    assert check_references(load_text(CASE % ("", between))) == []


@pytest.mark.parametrize(
    ("between", "model", "where", "said"),
    [
        ("[pucks, floor]", "", "/between/0", "there is no body or static `pucks`"),
        ("[floor, wall]", "", "/between", "two statics never touch"),
        ("[flag, floor]", "", "/between/0", "`flag` deforms"),
        ("[puck, floor]", "model: ipc,", "", "contact model ipc combines the friction of both bodies"),
    ],
)
def test_what_cannot_rub_is_said_where_it_stands(between, model, where, said):
    (problem,) = check_references(load_text(CASE % (model, between)))
    assert problem.path == f"/scene/contact/pairs/ice{where}"
    assert problem.message.startswith(said)
    assert problem.line == 5
