"""What the estimates of the wall time of soft bodies say."""

import re
from math import ceil
from pathlib import Path

import pytest

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
    # Particles lie 0.64 cells apart, and where all is slow a metre of cell gives 5 % of a second: 7 substeps in 2 ms.
    count = ceil(0.168 * 0.06 * 0.06 / (0.64 * 0.006) ** 3)
    assert f"{count:,} mpm particles in cells of 6 mm, 3,500 substeps per simulated second" in examined.derived
    assert "cells one and a half times as large it is about 4.3 times as fast" in examined.derived


SHEET = """
text2sim: 2
name: sheet
scene: {duration: 1, dt: 0.005, substeps: 4, pbd: {particle_size: SIZE}}
bodies: {sheet: {kind: cloth, shape: {kind: sheet, size: [1.0, 1.0]}, pose: {pos: [0, 0, 0.3]}}}
"""


def test_coarser_cloth_saves_less_than_its_particles_since_a_substep_has_a_fixed_cost(tmp_path: Path) -> None:
    told = examine(SHEET.replace("SIZE", "0.0133"), tmp_path / "case.yaml").derived
    # Measured in one process, in turns: 36.2 ms a substep with 0.0133 m (32 sweeps), 15.6 ms with 0.02 m (16 sweeps).
    words = re.search(r"particles one and a half times as large it is about ([\d.]+) times as fast", told)
    assert words is not None, told
    assert float(words[1]) == pytest.approx(36.2 / 15.6, rel=0.15)
    told = examine(SHEET.replace("SIZE", "0.0133, stretch_iterations: 4"), tmp_path / "case.yaml").derived
    words = re.search(r"about ([\d.]+) times as fast", told)  # 15.3 and 8.8 ms with 4 sweeps
    assert words is not None and float(words[1]) == pytest.approx(15.3 / 8.8, rel=0.15)


def test_a_scene_of_rigid_bodies_tells_no_particles(tmp_path: Path) -> None:
    ball = "text2sim: 2\nname: a\nbodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}}\n"
    assert examine(ball, tmp_path / "case.yaml").cost == ""


def test_rigid_pieces_of_a_scene_with_fem_bodies_are_counted(tmp_path: Path) -> None:
    """The engine fills each with tetrahedra: 16 capsules of a ring, and the box that it lies on."""
    tower = "  tower: {kind: soft, solver: fem, cell: 0.03, shape: {kind: box, size: [0.06, 0.06, 0.2]}, pose: {pos: [0, 0, 1]}}\n"
    bodies = {
        "ring": "{kind: torus, radius: 0.02, bar_radius: 0.004, segments: 16}, pose: {pos: [0.5, 0, 1]}",
        "plate": "{kind: box, size: [0.2, 0.2, 0.1]}, pose: {pos: [0.5, 0, 0.5]}",
    }
    rows = "".join(f"  {name}: {{kind: rigid, shape: {shape}}}\n" for name, shape in bodies.items())
    text = f"text2sim: 2\nname: a\nscene: {{duration: 1, dt: 0.005, substeps: 1}}\nbodies:\n{tower}"
    alone, together = (examine(text + more, tmp_path / "case.yaml") for more in ("", rows))
    assert "17 convex rigid pieces take 0.04 s each in 200 substeps" in together.cost
    assert "convex" not in alone.cost
    assert together.seconds - alone.seconds == pytest.approx(200 * 17 * 0.04, rel=0.05)


def test_free_bodies_with_rolling_friction_take_a_millisecond_each(tmp_path: Path) -> None:
    def seconds(rolling: float, cone: str) -> float:
        logs = f"material: {{rolling_friction: {rolling}}}, repeat: {{kind: line, count: 40, step: [0.3, 0, 0]}}"
        scene = f"scene: {{duration: 2, dt: 0.005, substeps: 2, contact: {{friction_cone: {cone}}}}}"
        shape = "shape: {kind: cylinder, radius: 0.06, height: 0.3}"
        text = f"text2sim: 2\nname: a\n{scene}\nbodies: {{log: {{kind: rigid, {shape}, {logs}}}}}\n"
        return examine(text, tmp_path / "case.yaml").seconds

    assert seconds(0.003, "elliptic") - seconds(0.0, "elliptic") == pytest.approx(800 * 40 * 1e-3)
    assert seconds(0.003, "pyramidal") == seconds(0.0, "pyramidal")
