"""Deceleration of a rolling ball by its rolling friction, with both friction cones, against 5/7 g b / r.

python -m benchmarks.rolling
"""

import tempfile
from pathlib import Path

from text2sim.harness.run import run_case
from text2sim.spec_schema.load import load_text

RADIUS, GRAVITY = 0.11, 9.81
SPAN = (0.1, 0.9)
"""Time over which the deceleration is measured [s]."""
CASE = """\
text2sim: 2
name: rolling
scene:
  duration: 1.0
  dt: 0.005
  contact: {{friction_cone: {cone}}}
  statics: {{floor: {{shape: {{kind: plane}}, material: {{friction: 0.6}}}}}}
bodies:
  ball:
    kind: rigid
    shape: {{kind: sphere, radius: 0.11}}
    material: {{mass: 0.43, friction: 0.6, rolling_friction: {b}}}
    pose: {{pos: [0, 0, 0.10999]}}
actions:
  controls: {{go: {{kind: initial_velocity, body: ball, linear: [5, 0, 0], angular: [0, 45.4545, 0]}}}}
  measures: {{v: {{kind: velocity, of: ball, axis: x}}}}
  expect:
    before: {{measure: v, at: 0.1, below: 9}}
    after: {{measure: v, at: 0.9, below: 9}}
"""


def deceleration(cone: str, b: float) -> float:
    """Return the deceleration [m/s2] of a ball with rolling friction b [m]."""
    with tempfile.TemporaryDirectory() as folder:
        result = run_case(load_text(CASE.format(cone=cone, b=b)), runs=Path(folder), film=False)
        before, after = (result.expectations[name]["value"] for name in ("before", "after"))
    return (before - after) / (SPAN[1] - SPAN[0])


if __name__ == "__main__":
    for b in (0.02, 0.06):
        for cone in ("elliptic", "pyramidal"):
            law = 5 / 7 * GRAVITY * b / RADIUS
            print(f"b = {b} m, {cone}: {deceleration(cone, b):.3f} m/s2, by the law {law:.3f}", flush=True)
