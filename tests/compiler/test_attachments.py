"""Attachments of rigid bodies: pivots, and what is attached twice."""

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text

DOOR = """
text2sim: 2
name: door
scene: {duration: 2.0, statics: {beam: {shape: {kind: box, size: [2, 0.1, 0.1]}, pose: {pos: [0, 0, 2.05]}}}}
bodies:
  door: {kind: rigid, shape: {kind: box, size: [0.5, 0.05, 0.6]}, pose: {pos: [0, 0, 1.7]}}
actions:
  measures: {fall: {kind: position, of: door, axis: z}}
  events: {low: {kind: threshold, measure: fall, below: 1.0}}
  controls:
    first: {kind: attach, body: door, to: beam, pivot: {face: top}}
"""


def attached(more: str = ""):
    return resolve_case(load_text(DOOR + more)).plan.welds


def test_a_pivot_is_a_point_in_the_frame_of_the_attached_body():
    (weld,) = attached()
    assert weld.pivot == pytest.approx((0, 0, 0.3))


def test_what_is_joined_cannot_be_joined_again():
    second = "    second: {kind: attach, body: door, to: beam, at: 1.0}\n"
    with pytest.raises(SpecError, match="`door` and `beam` are joined by `first` already; a hinge is a `mount`"):
        attached(second)
    attached(second + "    free: {kind: release, attach: first, at: 0.5}\n")
    attached(second + "    free: {kind: release, attach: first, on: low}\n")
