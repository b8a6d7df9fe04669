"""Joints of a chain that carries something heavy."""

import math
from pathlib import Path

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.load import load_case

CASE = """
text2sim: 2
name: loaded
scene: {{duration: 1}}
bodies:
  line: {{kind: chain, links: 20, link_length: 0.05, radius: 0.003, pose: {{pos: [0, 0, 2.5]}}{more}}}
"""
PAYLOAD = ", payload: {shape: {kind: sphere, radius: 0.115}, material: {density: 7850}}"
LINK = 7800 * (math.pi * 0.003**2 * 0.044 + 4 / 3 * math.pi * 0.003**3)
"""Mass [kg] of a link: a cylinder of 44 mm, and a ball."""
LOAD = 7850 * 4 / 3 * math.pi * 0.115**3
"""Mass [kg] of the payload: 50 kg."""
REACH = 20 * 0.05 + 0.115
"""From the upper end to the payload's centre [m]."""


@pytest.mark.parametrize(
    ("more", "armature"),
    [
        ("", 0.02 * LINK * 0.05**2),
        (PAYLOAD, 2e-6 * LOAD * REACH**2),
        (PAYLOAD + ", joint: {armature: 3.0e-4}", 3e-4),
        (PAYLOAD.replace("7850", "2") + ", material: {density: 40000}", 0.02 * LINK * 40000 / 7800 * 0.05**2),
    ],
)
def test_a_heavy_payload_asks_for_armature_unless_the_author_gives_it(tmp_path: Path, more: str, armature: float):
    """0.02 m l2 of a link, and 2e-6 M L2 of the payload at least: less is lost in 32 bits (generators.py)."""
    (tmp_path / "case.yaml").write_text(CASE.format(more=more))
    tree = resolve_case(load_case(tmp_path)).lowering.trees["line"]
    links = list(tree.links())
    assert len(links) == 20 + bool("payload" in more)
    found = [link.joint.armature for link in links[1:]]
    assert found == pytest.approx([armature] * len(found), rel=1e-6)


BY_HAND = """
text2sim: 2
name: by_hand
scene: {{duration: 1}}
bodies:
  line:
    kind: articulated
    links:
      seg:
        repeat: 21
        parent: "seg_${{k - 1}}"
        shape: {{kind: capsule, radius: 0.003, length: 0.044}}
        pose: {{pos: [0, 0, "${{-0.05 if k else 0}}"]}}
        joint: {{kind: ball, anchor: [0, 0, 0.025]{more}}}
      load:
        parent: seg_20
        shape: {{kind: sphere, radius: 0.115}}
        material: {{mass: {mass}}}
        pose: {{pos: [0, 0, -0.14]}}
        joint: {{kind: ball, anchor: [0, 0, 0.115]}}
    material: {{density: 7800}}
    pose: {{pos: [0, 0, 2.5]}}
"""


@pytest.mark.parametrize(
    ("text", "precision", "substeps"),
    [
        (CASE.format(more=""), "32", 4),
        (CASE.format(more=PAYLOAD), "32", 12),
        (CASE.format(more=PAYLOAD + ", anchored: false"), "64", 12),
        (CASE.format(more=PAYLOAD + ", joint: {armature: 0}"), "64", 28),
        (BY_HAND.format(mass=50, more=""), "64", 28),
        (BY_HAND.format(mass=50, more=", armature: 0.01"), "32", 4),
        (BY_HAND.format(mass=0.1, more=""), "32", 4),
    ],
)
def test_light_links_beside_a_heavy_load_get_short_steps_and_double_precision(
    tmp_path: Path, text: str, precision: str, substeps: int
):
    """Of the load's inertia a link has 1e-7. h < 1 / w with w = 2 sqrt(2 g M / (m l)), 4e-4 s for 11 g, 5 cm and 50 kg.

    Armature counts as A / l2 of mass: the 1.2e-4 kg m2 of a chain that carries these 50 kg make 50 g of its 11.
    """
    (tmp_path / "case.yaml").write_text(text)
    settings = resolve_case(load_case(tmp_path)).settings
    assert (settings.precision, settings.substeps) == (precision, pytest.approx(substeps, abs=1))


def test_what_is_said_of_the_time_constant_is_true(tmp_path: Path):
    """Of short substeps it is not two."""
    reasons = []
    for substeps in (1, 28):
        (tmp_path / "case.yaml").write_text(
            CASE.format(more="").replace("duration: 1", f"duration: 1, substeps: {substeps}")
        )
        settings = resolve_case(load_case(tmp_path)).settings
        reasons.append((settings.timeconst, settings.why["timeconst"].split(":")[0]))
    assert reasons == [(0.02, "two substeps"), (0.002, "the shortest that is derived")]
