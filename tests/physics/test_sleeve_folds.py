"""A sleeve that is pushed together along an arm gathers into round folds around it."""

import numpy as np
import pytest

from tests.physics.conftest import rows

pytestmark = pytest.mark.engine

ARM, REACH, RISE = 0.05, 0.006, 0.08
CASE = f"""
scene:
  duration: 0.6
  statics: {{arm: {{shape: {{kind: cylinder, radius: {ARM}, height: 0.4}}, pose: {{pos: [0, 0, 0.5]}}}}}}
bodies:
  sleeve: {{kind: cloth, cell: {2 * REACH}, shape: {{kind: sleeve, radius: 0.058, height: 0.2}}, pose: {{pos: [0, 0, 0.5]}}}}
  ring:
    kind: driven
    shape: {{kind: tube, inner_radius: 0.051, outer_radius: 0.08, height: 0.02, segments: 12}}
    motion: {{kind: waypoints, times: [0, 0.5], positions: [[0, 0, 0], [0, 0, {RISE}]]}}
    pose: {{pos: [0, 0, 0.382]}}
actions: {{controls: {{pin: {{kind: attach, body: sleeve, region: {{edge: top}}, to: world}}}}}}
"""


def rings(height):
    return [np.abs(height[0] - start) < 1e-3 for start in np.unique(height[0].round(4))]


def test_it_gathers_into_round_folds(simulate, agree):
    points, _ = rows(simulate(CASE).states, "sleeve")
    radius, height = np.hypot(points[..., 0], points[..., 1]), points[..., 2]
    top = height[0] > 0.6 - 1e-6
    agree("its upper rim stays [m]", points[:, top], points[:1, top], within=1e-6)
    assert radius.min() > ARM, "none of it is in the arm"
    assert height[-1].min() > 0.382 + RISE, "none of it has passed the ring"
    # Points of a row of its mesh begin at one height; in a round fold they stay a circle.
    levels = rings(height)
    profile = np.array([radius[-1][row].mean() for row in levels])
    assert profile.max() > 0.058 + REACH, "it bulges where it is gathered"
    inner = profile[1:-1]
    assert ((inner > profile[:-2]) & (inner > profile[2:])).sum() >= 2, "in more than one fold"
    agree("rows stay circles [m]", np.array([radius[-1][row].std() for row in levels]), 0.0, within=1e-3)


def test_it_crumples_if_it_bends_easily(simulate):
    """With a `bending_compliance` of 1e4 folds run across each other: rows are not circles any more."""
    soft = CASE.replace(
        "pose: {pos: [0, 0, 0.5]}}\n  ring", "material: {bending_compliance: 1e4}, pose: {pos: [0, 0, 0.5]}}\n  ring"
    )
    points, _ = rows(simulate(soft).states, "sleeve")
    radius = np.hypot(points[-1, :, 0], points[-1, :, 1])
    assert "bending_compliance" in soft
    assert max(radius[row].std() for row in rings(points[..., 2])) > 3e-3
