"""Light ropes with heavy loads: derived substeps, and problems where the case gives too few."""

from pathlib import Path

import pytest
from lint_support import expect_words, findings

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.load import load_case

ROPE = """
scene: {{duration: 1.0, dt: 0.005{scene}}}
bodies:
  rope: {{kind: rope, length: 1.0, radius: 0.004, segments: 20, material: {{mass: 0.05}}, pose: {{pos: [0, 0, 2]}}}}
  load: {{kind: rigid, shape: {{kind: box, size: [0.1, 0.1, 0.1]}}, material: {{mass: {mass}}}, pose: {{pos: [0, 0, 0.94]}}}}
actions:
  controls: {{tie: {{kind: attach, body: rope.link_19, to: load}}}}
"""


@pytest.mark.parametrize(("mass", "substeps"), [(0.01, 2), (10, 13), (40, 26)])
def test_substeps_follow_from_what_a_rope_carries(tmp_path: Path, mass: float, substeps: int) -> None:
    """2 sqrt(2 M g / (m l)) times the substep is 1 at most; M has the 50 g of the rope in it, m l is 2.5 g x 50 mm."""
    (tmp_path / "case.yaml").write_text("text2sim: 2\nname: probe\n" + ROPE.format(scene="", mass=mass))
    assert resolve_case(load_case(tmp_path)).settings.substeps == substeps


@pytest.mark.parametrize(
    ("scene", "mass", "says"),
    [
        (", substeps: 1", 10, "scene.substeps of 13"),
        (", substeps: 13", 10, ""),
        ("", 10, ""),
        ("", 400, "scene.substeps of 80"),  # more than are derived
        ("", 4000, "scene.dt of 0.004 s with scene.substeps of 200"),  # more than there can be
        (", substeps: 1, gravity: [0, 0, 0]", 10, ""),
    ],
)
def test_a_rope_that_its_load_would_tear_apart(tmp_path: Path, scene: str, mass: float, says: str) -> None:
    expect_words(tmp_path, "rope-load", says, ROPE.format(scene=scene, mass=mass), path="/bodies/rope")


def test_the_armature_of_a_loaded_chain_counts(tmp_path: Path) -> None:
    """Without it 500 kg on 40 links of 2 g would ask for 261 substeps; with it they hold at 8 (1.25 ms)."""
    chain = """
scene: {duration: 1, substeps: 9}
bodies:
  line:
    kind: chain
    links: 40
    link_length: 0.025
    radius: 0.002
    pose: {pos: [0, 0, 2.5]}
    payload: {shape: {kind: sphere, radius: 0.17}, material: {mass: 500}}
"""
    assert not findings(tmp_path, "rope-load", chain)
    assert findings(tmp_path, "rope-load", chain.replace("mass: 500}}", "mass: 500}}\n    joint: {armature: 0}"))


@pytest.mark.parametrize(("substeps", "found"), [(4, True), (28, False)])
def test_links_in_a_row_that_a_case_lists_are_a_chain(tmp_path: Path, substeps: int, found: bool) -> None:
    text = f"""
scene: {{duration: 1, substeps: {substeps}}}
bodies:
  line:
    kind: articulated
    links:
      seg:
        repeat: 21
        parent: "seg_${{k - 1}}"
        shape: {{kind: capsule, radius: 0.003, length: 0.044}}
        pose: {{pos: [0, 0, "${{-0.05 if k else 0}}"]}}
        joint: {{kind: hinge, axis: y, anchor: [0, 0, 0.025]}}
      load:
        parent: seg_20
        shape: {{kind: sphere, radius: 0.115}}
        material: {{mass: 50}}
        pose: {{pos: [0, 0, -0.14]}}
        joint: {{kind: hinge, axis: y, anchor: [0, 0, 0.115]}}
    material: {{density: 7800}}
    pose: {{pos: [0, 0, 2.5]}}
"""
    assert [problem.path for problem in findings(tmp_path, "rope-load", text)] == ["/bodies/line"] * found
