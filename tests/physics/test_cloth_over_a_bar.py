"""Cloth over a bar: friction holds the longer side, as a belt's on a drum."""

from math import exp, pi

import numpy as np
import pytest

from tests.physics.conftest import rows

pytestmark = pytest.mark.engine

LENGTH, FOLD = 0.8, 0.025
"""Length of the strips and radius of their fold [m]."""
STRIPS = {
    # friction, part to the left, bending
    "slips": (0.1, 0.60, "rigidity: 1.0e-5"),
    "holds": (0.1, 0.55, "rigidity: 1.0e-5"),
    "slips_rough": (0.3, 0.74, "rigidity: 1.0e-5"),
    "holds_rough": (0.3, 0.68, "rigidity: 1.0e-5"),
    "stands_off": (0.1, 0.60, "bending_compliance: 1.0e-4"),
}
CASE = """
scene:
  duration: 0.6
  pbd: {bounds: {min: [-0.6, -0.5, -1], max: [0.6, 1.2, 1.6]}}
  statics: {bar: {shape: {kind: cylinder, radius: 0.015, height: 1}, pose: {pos: [0, 0.3, 1], euler_deg: [90, 0, 0]}, material: {friction: 0.01}}}
bodies:
""" + "\n".join(
    f"  {name}: {{kind: cloth, cell: 0.02, shape: {{kind: sheet, size: [{LENGTH}, 0.06], over: {FOLD}, over_at: {part}}},"
    f" material: {{area_density: 0.3, friction: {friction}, {bending}}}, pose: {{pos: [0, {0.15 * k}, 1]}}}}"
    for k, (name, (friction, part, bending)) in enumerate(STRIPS.items())
)


@pytest.fixture(scope="module")
def trial(simulate):
    return simulate(CASE)


def test_the_recording_says_what_lies_where_on_the_flat_cloth(trial):
    """The engine keeps texture coordinates of what has a texture only; a pattern needs them where a cloth is bent."""
    for cloth in trial.states.deformables:
        faces, uvs = cloth.geometry["faces"], cloth.geometry["uvs"] * (LENGTH, 0.06)
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
        straight, flat = (np.linalg.norm(np.diff(at[edges], axis=1)[:, 0], axis=1) for at in (cloth.seen[0], uvs))
        assert straight == pytest.approx(flat, rel=0.06), "chords round the bar are a little shorter than arcs"


def test_a_strip_slides_off_a_bar_as_a_belt_does(trial):
    """A belt round half a bar slips from a ratio of forces of `exp(pi mu)` on, here that of the lengths that hang."""
    for name, (friction, part, _) in STRIPS.items():
        left, right = (side * LENGTH - pi / 2 * FOLD for side in (part, 1 - part))
        points, _ = rows(trial.states, name)
        down = points[:, :, 2].min(axis=1)
        moved = down[trial.time.searchsorted(0.3)] - down[-1]
        slips = left / right > exp(pi * friction) and name != "stands_off"
        assert (moved > 0.05) if slips else (abs(moved) < 0.01), f"{name}: {left / right:.2f}, sinks by {moved:.3f} m"
