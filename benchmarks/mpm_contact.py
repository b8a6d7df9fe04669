"""Contact of mpm bodies: gaps between bodies that start near each other, and how deep a pressed one sinks into a plate.

python -m benchmarks.mpm_contact
"""

import tempfile
from pathlib import Path

from text2sim.harness.run import run_case
from text2sim.spec_schema.load import load_text

CELL = 0.012
FOAM = (
    "{kind: soft, solver: mpm, shape: {kind: box, size: [0.12, 0.12, %g]}, pose: {pos: [0, 0, %g]}, "
    "material: {youngs_modulus: 12000, poisson_ratio: %g, density: 250}}"
)
HEAD = """\
text2sim: 2
name: mpm_contact
scene:
  duration: %g
  dt: 0.002
  mpm: {cell: 0.012, bounds: {min: [-0.2, -0.2, -0.06], max: [0.2, 0.2, 0.36]}}
  statics: {floor: {shape: {kind: plane}, material: {friction: 0.4}}}
bodies:
"""
NEAR = """\
actions:
  measures:
    top: {kind: extent, of: low, axis: z, stat: max}
    bottom: {kind: extent, of: high, axis: z, stat: min}
  expect: {top: {measure: top, at: end, below: 9}, bottom: {measure: bottom, at: end, below: 9}}
"""
PRESSED = """\
  press:
    kind: rigid
    shape: {kind: cylinder, radius: 0.1, height: 0.04}
    material: {density: 3000, friction: 0.4, soft_reach: %g}
    mount:
      kind: slider
      axis: [0, 0, -1]
      range: [0, 0.1]
      actuator: {stiffness: 100000, damping: 2000, max_force: 2000}
    pose: {pos: [0, 0, 0.155]}
actions:
  controls: {push: {kind: drive, joint: press, position: {kind: ramp, from: 0, to: 0.06, start: 0.05, end: 0.6}}}
  measures:
    top: {kind: extent, of: foam, axis: z, stat: max}
    bottom: {kind: extent, of: press, axis: z, stat: min}
  expect: {top: {measure: top, at: end, below: 9}, bottom: {measure: bottom, at: end, below: 9}}
"""


def gap(text: str) -> float:
    """Return the height of the lower end of one body above the upper end of the other, at the end [m]."""
    with tempfile.TemporaryDirectory() as folder:
        found = run_case(load_text(text), runs=Path(folder), film=False).expectations
    return found["bottom"]["value"] - found["top"]["value"]


if __name__ == "__main__":
    for cells in (0.02, 0.5, 1.0, 2.0):
        low, high = FOAM % (0.06, 0.036, 0.4), FOAM % (0.06, 0.096 + cells * CELL, 0.4)
        left = gap(f"{HEAD % 0.5}  low: {low}\n  high: {high}\n{NEAR}")
        print(f"two foams, {cells:g} cells apart at the start: {left / CELL:.2f} cells after 0.5 s", flush=True)
    for reach in (0.006, 0.02):
        sunk = -gap(f"{HEAD % 0.9}  foam: {FOAM % (0.12, 0.066, 0.3)}\n{PRESSED % reach}")
        print(f"a foam pressed by a plate with soft_reach {reach:g} m: {1000 * sunk:.1f} mm inside it", flush=True)
