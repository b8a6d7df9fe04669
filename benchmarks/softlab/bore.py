"""What the grid makes of a bore: how deep a soft body that is pressed sinks into its wall, and which radius is free.

A soft cylinder stands in a tube that is closed below, 20 mm thinner than its bore, and a pull along the tube, like a
weight of 25 times gravity, makes it bulge against the wall. At the foot the pressure is `rho a h`, 25 kPa, which is
0.8 times what the body is stiff.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.softlab.lab import Lab

SCENE = """
scene:
  duration: 0.16
  dt: 0.002
  gravity: [0, 0, -250]
  mpm: {cell: "${cell}", bounds: {min: [-0.16, -0.16, -0.08], max: [0.16, 0.16, 0.26]}}
  statics:
    tube:
      shape: {kind: tube, inner_radius: "${bore}", outer_radius: "${bore + 0.05}", height: 0.24, segments: "${staves}"}
      pose: {pos: [0, 0, 0.12]}
      material: {friction: 0.01, soft_reach: "${reach}"}
    foot: {shape: {kind: cylinder, radius: 0.1, height: 0.05}, pose: {pos: [0, 0, -0.025]}, material: {friction: 0.01}}
bodies:
  plug:
    kind: soft
    solver: mpm
    shape: {kind: cylinder, radius: "${bore - 0.02}", height: 0.1}
    material: {model: neo_hookean, youngs_modulus: 3e4, poisson_ratio: 0.4}
    pose: {pos: [0, 0, 0.06]}
waive: {thin-wall: it is a trial, narrow-opening: it is a trial}
"""


@dataclass(frozen=True)
class Bore:
    """One row of the table; lengths in m."""

    cell: float
    reach: float
    staves: int
    bore: float
    free: float
    """Radius within which 99 of 100 particles near the wall are."""
    sunk: float
    """How deep the deepest is in the wall; negative: how far from it."""
    out: float
    """Part of the particles that are a cell or more deep in the wall."""


TRIALS = (
    (0.01, 0.00125, 12),
    (0.01, 0.005, 12),
    (0.01, 0.01, 12),
    (0.0125, 0.0125, 12),
    (0.01, 0.00125, 36),
    (0.01, 0.01, 36),
)
"""Cell [m], `soft_reach` [m], staves."""
BORE = 0.05


def measure(lab: Lab, cell: float, reach: float, staves: int) -> Bore:
    """Run one trial."""
    run = lab.run(SCENE, "bore", cell=cell, reach=reach, staves=staves, bore=BORE)
    points = run.points("plug")[run.time > 0.08]
    low = points[:, :, 2] < 0.05
    # The bore is a polygon: how far a particle is beyond its nearest side, of which the apothem is the bore.
    angle = np.arctan2(points[..., 1], points[..., 0])
    step = 2 * np.pi / staves
    across = np.hypot(points[..., 0], points[..., 1]) * np.cos((angle % step) - step / 2)
    near = across[low]
    # A particle stands for half its distance on each side.
    half = 0.32 * cell
    outer = near[near > np.quantile(near, 0.75)] + half
    return Bore(
        cell, reach, staves, BORE,
        free=float(np.quantile(outer, 0.99)), sunk=float(near.max() + half - BORE),
        out=float((across > BORE + cell).mean()),
    )  # fmt: skip


def table(rows: list[Bore]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| cell | `soft_reach` | staves, width in cells | bore radius | free of it | lost of the radius, in cells "
        "| deepest in the wall | more than a cell deep |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for one in rows:
        width = 2 * one.bore * np.tan(np.pi / one.staves) / one.cell
        lost = (one.bore - one.free) / one.cell
        lines.append(
            f"| {1e3 * one.cell:g} mm | {1e3 * one.reach:g} mm, {one.reach / one.cell:.3g} cells | {one.staves}, "
            f"{width:.1f} | {1e3 * one.bore:g} mm | {1e3 * one.free:.1f} mm | {lost:+.2f} | "
            f"{1e3 * one.sunk:+.1f} mm | {one.out:.1%} |"
        )
    return "\n".join(lines)
