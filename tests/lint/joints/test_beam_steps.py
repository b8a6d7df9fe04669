"""Stiff beams: derived substeps, and problems where the case gives too few."""

from pathlib import Path

import pytest
from lint_support import expect_words

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.load import load_case

RULER = """
scene: {{duration: 1.0, dt: {dt}{scene}}}
bodies:
  ruler:
    kind: beam
    size: [0.3, 0.03, 0.001]
    youngs_modulus: 2.0e11
    damping_ratio: {ratio}
    material: {{density: 7800}}
    pose: {{pos: [0, 0, 1]}}
"""


@pytest.mark.parametrize(("ratio", "substeps"), [(0.01, 17), (0.02, 9), (0.2, 2)])
def test_substeps_follow_from_the_damping_of_a_beam(tmp_path: Path, ratio: float, substeps: int) -> None:
    """The substep is 1.6 zeta / w1 with w1 = 57 rad/s, at most 0.2 / w1; a little more with the least damping."""
    text = RULER.format(dt=0.005, scene="", ratio=ratio)
    (tmp_path / "case.yaml").write_text("text2sim: 2\nname: probe\n" + text)
    assert resolve_case(load_case(tmp_path)).settings.substeps == substeps


@pytest.mark.parametrize(
    ("scene", "dt", "ratio", "says"),
    [
        ("", 0.005, 0.01, ""),
        (", substeps: 9", 0.005, 0.01, ""),
        (", substeps: 4", 0.005, 0.01, "scene.substeps of 17, a damping_ratio of 0.045"),
        ("", 0.01, 0.0, "scene.substeps of 141"),  # more than are derived
        (", substeps: 1", 0.02, 0.0, "scene.dt of 0.01 s with scene.substeps of 200"),  # more than there can be
    ],
)
def test_a_beam_that_flies_apart(tmp_path: Path, scene: str, dt: float, ratio: float, says: str) -> None:
    expect_words(tmp_path, "stiff-beam", says, RULER.format(scene=scene, dt=dt, ratio=ratio), path="/bodies/ruler")
