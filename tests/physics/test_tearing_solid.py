"""Soft bodies with a tear strength: bars that are drawn out, and a block through which a wire is lowered."""

import numpy as np

from tests.physics.conftest import rows

BARS = """
scene: {duration: 1, dt: 0.004, gravity: [0, 0, 0], record: {rate: 125}}
bodies:
  weak: {kind: soft, solver: mpm, cell: 0.02, shape: {kind: box, size: [0.24, 0.08, 0.08]}, material: {youngs_modulus: 2e4, tear_stretch: 1.25}}
  tough: {kind: soft, solver: mpm, cell: 0.02, shape: {kind: box, size: [0.24, 0.08, 0.08]}, material: {youngs_modulus: 2e4, tear_stretch: 1.5}, pose: {pos: [0, 0.2, 0]}}
  plain: {kind: soft, solver: mpm, cell: 0.02, shape: {kind: box, size: [0.24, 0.08, 0.08]}, material: {youngs_modulus: 2e4}, pose: {pos: [0, 0.4, 0]}}
  hand: {kind: driven, shape: {kind: box, size: [0.05, 0.5, 0.05]}, material: {touch_soft: false}, pose: {pos: [0.2, 0.2, 0]}, motion: {kind: waypoints, ease: linear, times: [0, 1], positions: [[0, 0, 0], [0.12, 0, 0]]}}
actions:
  controls:
"""
CLAMPS = """
    left_{0}: {{kind: attach, body: {0}, region: {{box: {{min: [-0.2, -0.1, -0.1], max: [-0.09, 0.1, 0.1]}}}}, to: world}}
    right_{0}: {{kind: attach, body: {0}, region: {{box: {{min: [0.09, -0.1, -0.1], max: [0.2, 0.1, 0.1]}}}}, to: hand}}
"""


def test_a_bar_breaks_at_its_tear_stretch_and_is_elastic_below(simulate, agree):
    """Its clamps are 0.18 m apart at first, and a bar of constant section is stretched evenly.

    Ends that cannot narrow are stretched more than the middle, so it breaks up to 6 % earlier.
    """
    trial = simulate(BARS + "".join(CLAMPS.format(name) for name in ("weak", "tough", "plain")))
    stretch = 1 + 0.12 * trial.time / 0.18
    bodies = {body.body: body for body in trial.states.deformables}
    for name, limit in (("weak", 1.25), ("tough", 1.5)):
        share = bodies[name].torn.mean(axis=1)
        agree(
            f"stretch of the bar `{name}` as it breaks",
            stretch[np.argmax(share > 0)],
            0.97 * limit,
            within=0.03 * limit,
        )
        assert 0.02 < share[-1] < 0.2, "it has broken in one or two sections, not everywhere"
    assert not bodies["plain"].torn.any()
    bent = {name: rows(trial.states, name)[0] - bodies[name].rest for name in bodies}
    below = stretch < 1.4
    agree("as without a strength [m]", bent["tough"][below], bent["plain"][below], within=1e-4)


BLOCK = """
scene: {duration: 0.6, dt: 0.002, statics: {plate: {shape: {kind: box, size: [0.3, 0.2, 0.05]}, pose: {pos: [0, 0, -0.025]}}}}
bodies:
  tofu: {kind: soft, solver: mpm, cell: 0.01, shape: {kind: box, size: [0.12, 0.05, 0.06]}, material: {youngs_modulus: 1.5e4, tear_stretch: 1.2}, pose: {pos: [0, 0, 0.0325]}}
  wire:
    kind: driven
    shape: {kind: cylinder, radius: 0.004, height: 0.12}
    pose: {pos: [0, 0, 0.08], euler_deg: [90, 0, 0]}
    material: {soft_reach: 0.01}
    motion: {kind: waypoints, ease: linear, times: [0, 0.4], positions: [[0, 0, 0], [0, 0, -0.085]]}
actions:
  controls:
    apart: {kind: force, body: tofu, region: {box: {min: [0.02, -0.1, -0.1], max: [0.1, 0.1, 0.1]}}, force: [2, 0, 0], scale: {kind: piecewise, times: [0, 0.42, 0.44], values: [0, 0, 1]}}
  measures:
    pieces: {kind: pieces, of: tofu}
    largest: {kind: largest_piece, of: tofu}
"""


def test_a_wire_cuts_and_the_cut_does_not_heal(simulate, agree):
    """A wire of two and a half cells with its reach halves a block; the halves still touch, and part when one of them is pulled."""
    trial = simulate(BLOCK)
    cut = trial.time > 0.42
    agree("pieces", trial.measure("pieces")[cut], 2, within=0)
    agree("part in the larger half", trial.measure("largest")[cut], 0.5, within=0.03)
    points, _ = rows(trial.states, "tofu")
    moved = points[-1, :, 0] - points[np.argmax(cut), :, 0]
    right = points[0, :, 0] > 0.02
    assert moved[right].mean() > 0.01, "it is pulled off"
    agree("way of the other half [m]", moved[points[0, :, 0] < -0.02].mean(), 0, within=4e-3)
