"""Elastic sheets: cloth that stretches as its material says, and cloth that is stretched at the start."""

import numpy as np
import pytest

from tests.physics.conftest import rows

pytestmark = pytest.mark.engine

PULLED = """
scene: {gravity: [0, 0, 0], duration: 1, dt: 0.005, record: {rate: 100}}
bodies:
  strip: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.1, 0.4]}, material: {area_density: 1, youngs_modulus: 1.0e+6, damping: 20}, pose: {pos: [0, 0, 1.2], euler_deg: [90, 0, 0]}}
  bar: {kind: rigid, shape: {kind: box, size: [0.12, 0.01, 0.01]}, material: {mass: 0.02}, mount: {kind: free, damping: 8}, pose: {pos: [0, 0, 0.994]}}
  ring: {kind: cloth, cell: 0.02, shape: {kind: sleeve, radius: 0.1, height: 0.04}, material: {area_density: 1, youngs_modulus: 1.0e+6, prestretch: 1.6, damping: 40, air_resistance: 0}, pose: {pos: [1, 0, 1], euler_deg: [90, 0, 0]}}
  post: {kind: rigid, shape: {kind: cylinder, radius: 0.01, height: 0.2}, mount: {kind: fixed}, pose: {pos: [-1.12, 0, 1]}}
  puller: {kind: rigid, shape: {kind: cylinder, radius: 0.01, height: 0.2}, material: {mass: 0.3, friction: 0.01}, mount: {kind: slider, axis: x, damping: 20}, pose: {pos: [-0.89, 0, 1]}}
  loop: {kind: cloth, cell: 0.01, shape: {kind: sleeve, radius: 0.13, height: 0.03}, material: {area_density: 1, youngs_modulus: 1.0e+6, prestretch: 1.5, damping: 40, friction: 0.01, air_resistance: 0}, pose: {pos: [-1, 0, 1]}}
actions:
  controls:
    out: {kind: force, body: puller, force: [25, 0, 0]}
    top: {kind: attach, body: strip, region: {edge: back}, to: world}
    low: {kind: attach, body: strip, region: {edge: front}, to: bar}
    pull: {kind: force, body: bar, force: [0, 0, -10]}
"""


def test_a_sheet_stretches_as_its_material_says(simulate, agree):
    """A strip of width b, length L and tension modulus `E t` gets longer by `F L / (E t b)` under a force F.

    Its ends, whose width is kept, are stiffer by up to `1 / (1 - nu^2) = 9/8`, over about a width in all. A ring that nothing holds draws together to its length over `prestretch`, and keeps its width.
    """
    trial = simulate(PULLED)
    late = trial.time > 0.8
    pulled = 10 * 0.4 / (1e6 * 1e-3 * 0.1)
    longer = 0.994 - trial.pos("bar")[late, 2].mean()
    agree("a strip that a force pulls gets longer [m]", longer, pulled * (1 - 0.25 / 9), within=0.12 * pulled)
    points, speed = rows(trial.states, "strip")
    moved = np.gradient(points.mean(axis=1), trial.time, axis=0)
    agree("points that a light bar holds have its velocity [m/s]", speed[late][1:-1], moved[late][1:-1], within=0.02)
    points, _ = rows(trial.states, "ring")
    across = points[late] - points[late].mean(axis=1, keepdims=True)
    radius = np.hypot(across[..., 0], across[..., 2])
    agree("a ring draws together [m]", radius.mean(), 0.1 / 1.6, within=0.03 * 0.1)
    agree("it stays round [m]", radius.std(), 0.0, within=0.004)
    # A loop round two posts: `2 (distance) + 2 pi r = L / p (1 + F / (2 E t b))`, with r out to the middle of its points.
    apart = trial.pos("puller")[late, 0].mean() + 1.12
    length = 2 * np.pi * 0.13 / 1.5 * (1 + 25 / (2 * 1e6 * 1e-3 * 0.03))
    agree("two posts in a stretched loop are apart by [m]", apart, length / 2 - np.pi * 0.015, within=0.06 * apart)
    agree("and as wide [m]", np.ptp(across[..., 1], axis=1).mean(), 0.04, within=0.004)
