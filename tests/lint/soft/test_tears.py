"""Bodies with a tear strength: what is too thin to cut them, their own weight, solvers in which nothing tears."""

from pathlib import Path

import pytest
from lint_support import findings

JELLY = """\
bodies:
  a: {kind: soft, shape: {kind: box, size: [0.2, 0.2, 0.2]}, material: {%s}, pose: {pos: [0, 0, 1]}}
"""
WIRE = """\
bodies:
  tofu: {{kind: soft, cell: 0.009, shape: {{kind: box, size: [0.2, 0.2, 0.05]}}, material: {{tear_stretch: {limit}}}, pose: {{pos: [0, 0, 0.026]}}}}
  wire:
    kind: driven
    shape: {{kind: cylinder, radius: 0.0015, height: 0.3}}
    material: {{soft_reach: {reach}}}
    pose: {{pos: [0, 0, 0.12], euler_deg: [90, 0, 0]}}
    motion: {{kind: oscillate, axis: z, amplitude: 0.06, frequency: 0.5}}
"""


@pytest.mark.parametrize(("limit", "reach", "count"), [(1.1, 0.009, 0), (1.2, 0.009, 1), (1.1, 0.002, 1)])
def test_a_thin_cutter_cuts_what_tears_early(tmp_path: Path, limit: float, reach: float, count: int) -> None:
    """A wire of 3 mm has 2.1 cells of 9 mm with a reach of one; 1.1 needs 2 cells, 1.2 needs 2.5."""
    found = findings(tmp_path, "thin-wall", WIRE.format(limit=limit, reach=reach))
    assert [problem.severity for problem in found] == ["warning"] * count
    assert all("closes behind it" in problem.message and "soft_reach" in problem.message for problem in found)


@pytest.mark.parametrize(
    ("limit", "held", "count"), [(1.05, False, 0), (1.02, False, 1), (1.05, True, 1), (1.2, True, 0)]
)
def test_what_its_own_weight_tears(tmp_path: Path, limit: float, held: bool, count: int) -> None:
    """A cube of 20 cm and 20 kPa is stretched by a tenth as it hangs, and bulges by 3 % as it stands."""
    body = JELLY % f"youngs_modulus: 2e+4, tear_stretch: {limit}"
    hang = "actions: {controls: {p: {kind: attach, body: a, region: {face: top}, to: world}}}"
    assert len(findings(tmp_path, "tears-itself", body, *[hang] * held)) == count


def test_only_mpm_sticks(tmp_path: Path) -> None:
    body = JELLY % "adhesion: 100"
    (found,) = findings(tmp_path, "unheeded-stuff", body, "scene: {contact: {model: sap}}")
    assert "adhesion is ignored" in found.message


def test_only_mpm_tears(tmp_path: Path) -> None:
    body = JELLY % "tear_stretch: 1.2"
    (found,) = findings(tmp_path, "unheeded-stuff", body, "scene: {contact: {model: sap}}")
    assert "tear_stretch is ignored" in found.message
    assert findings(tmp_path, "unheeded-stuff", body) == []
    force = (
        "actions: {controls: {p: {kind: force, body: a, region: {corner: [left, front, top]}, force: [1e+5, 0, 0]}}}"
    )
    assert findings(tmp_path, "tearing-force", body, force) == [], "it is meant to"
