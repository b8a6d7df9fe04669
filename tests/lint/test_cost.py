"""What the estimates of the wall time of soft bodies say."""

from math import ceil
from pathlib import Path

from text2sim.agents.assembly import examine

TOFU = """
text2sim: 2
name: tofu
scene: {duration: 2.5, dt: 0.002, mpm: {cell: 0.006}}
bodies:
  tofu:
    kind: soft
    solver: mpm
    shape: {kind: box, size: [0.168, 0.06, 0.06]}
    material: {model: elastic, youngs_modulus: 20000.0, density: 1000}
    pose: {pos: [0, 0, 0.1]}
"""


def test_particles_and_substeps_are_told_before_a_run(tmp_path: Path) -> None:
    examined = examine(TOFU, tmp_path / "case.yaml")
    # Particles lie 0.64 cells apart, and the engine wants 2 % of a second per metre of cell: 17 substeps in 2 ms.
    count = ceil(0.168 * 0.06 * 0.06 / (0.64 * 0.006) ** 3)
    assert f"{count:,} mpm particles in cells of 6 mm, 8,500 substeps per simulated second" in examined.derived
    assert "cells one and a half times as large it is 5 times as fast" in examined.derived


def test_a_scene_of_rigid_bodies_tells_no_particles(tmp_path: Path) -> None:
    ball = "text2sim: 2\nname: a\nbodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}}\n"
    assert examine(ball, tmp_path / "case.yaml").cost == ""
