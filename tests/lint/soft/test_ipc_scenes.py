"""Scenes under contact model ipc: room between bodies, and controls that it ignores."""

import re
from pathlib import Path

import pytest
from lint_support import findings

DISHES = """\
scene: {{statics: {{table: {{shape: {{kind: box, size: [1, 0.6, 0.7]}}, place: {{on: floor, clearance: {0}}}}}}}}}
bodies:
  towel:
    kind: cloth
    solver: ipc
    shape: {{kind: sheet, size: [0.6, 0.4]}}
    material: {{thickness: 0.002}}
    place: {{on: table, clearance: {0}}}
  plate: {{kind: rigid, shape: {{kind: cylinder, radius: 0.1, height: 0.02}}, place: {{on: towel, clearance: {0}}}}}
"""


def test_ipc_needs_room_between_all_bodies(tmp_path: Path) -> None:
    found = findings(tmp_path, "ipc-clearance", DISHES.format(0))
    assert {problem.path.split("/")[-2] for problem in found} == {"table", "towel", "plate"}
    said = [float(x) for problem in found for x in re.findall(r"`clearance: ([\d.e-]+)`", problem.message)]
    # The cloth is 2 mm thick, of which 1 mm is in the sheet that is placed.
    assert max(said) == pytest.approx(0.0006)
    assert findings(tmp_path, "ipc-clearance", DISHES.format(0.0007)) == []


@pytest.mark.parametrize("contact", ["scene: {duration: 1}", "scene: {contact: {model: ipc}}"])
def test_ipc_refuses_impulses_wherever_it_is_derived(tmp_path: Path, contact: str) -> None:
    towel = (
        "bodies: {towel: {kind: cloth, solver: ipc, shape: {kind: sheet, size: [0.6, 0.4]}, pose: {pos: [0, 0, 0.5]}}}"
    )
    jelly = (
        "bodies: {jelly: {kind: soft, solver: fem, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 1]}}}"
    )
    hit = "actions: {controls: {hit: {kind: impulse, body: jelly, impulse: [0, 0, 1], at: 0.1}}}"
    (found,) = findings(tmp_path, "ipc-control", towel, jelly, hit, contact)
    assert found.path == "/actions/controls/hit/kind"
