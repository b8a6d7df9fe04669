"""The part by which the solver lets a hanging cloth stretch, against the estimate that sets its iterations."""

from tests.physics.conftest import rows
from text2sim.compiler.soft.settings import own_stretch

HANGING = """
scene: {duration: 1.5, dt: 0.005, record: {rate: 20}, substeps: 10, pbd: {stretch_iterations: ITERATIONS}}
bodies:
  strip:
    kind: cloth
    cell: 0.01
    shape: {kind: sheet, size: [0.06, 0.5]}
    material: {damping: 5}
    pose: {pos: [0, 0, 1], euler_deg: [90, 0, 0]}
actions: {controls: {hang: {kind: attach, body: strip, region: {edge: back}, to: world}}}
"""


def test_a_cloth_that_hangs_stretches_as_estimated(simulate, agree):
    """3 g h^2 L / (n c^2), for n iterations in substeps h, within a third: half a percent and two of its length."""
    for iterations in (2, 8):
        trial = simulate(HANGING.replace("ITERATIONS", str(iterations)))
        points, _ = rows(trial.states, "strip")
        length = points[..., 2].max(axis=1) - points[..., 2].min(axis=1)
        longer = length[-6:].mean() / length[0] - 1
        estimate = own_stretch(0.5, 0.01, 0.0005, iterations, 9.81)
        agree(f"stretch with {iterations} iterations", longer, estimate, within=estimate / 3)
