"""Loads that draw out cloth, and what only looks like one."""

from pathlib import Path

import pytest
from lint_support import findings

STRIP = """\
scene: {duration: 1, statics: {bar: {shape: {kind: box, size: [2, 0.04, 0.04]}, pose: {pos: [0, 0, 2]}}}}
bodies:
  strip: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.2, 0.4]}, pose: {pos: [0, 0, 1.78], euler_deg: [90, 0, 0]}}
  load: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 1.53]}}
actions:
  controls:
    top: {kind: attach, body: strip, region: {edge: back}, to: bar}
    low: {kind: attach, body: strip, region: {edge: front}, to: load}
"""
OTHERS = {
    "welded to a static": "actions: {controls: {weld: {kind: attach, body: load, to: bar}}}",
    "on a spring": "actions: {controls: {coil: {kind: spring, body: load, to: bar, stiffness: 100}}}",
    "on foam": "bodies: {foam: {kind: soft, shape: {kind: box, size: [0.3, 0.3, 0.1]}, pose: {pos: [0, 0, 1.42]}}}",
    "on a shelf": "scene: {statics: {shelf: {shape: {kind: box, size: [1, 1, 0.1]}, pose: {pos: [0, 0, 1.43]}}}}",
    "fixed": "bodies: {load: {mount: {kind: fixed}}}",
    "light": "bodies: {load: {material: {mass: 0.02}}}",
    "with nothing above": "actions: {controls: {top: null}}",
    "above": "bodies: {load: {pose: {pos: [0, 0.2, 1.9]}}}",
    "of elastic cloth": "bodies: {strip: {material: {youngs_modulus: 1.0e6, thickness: 0.001}}}",
}


def test_a_load_that_hangs_on_light_cloth(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "cloth-overloaded", STRIP)
    assert "`load` hangs on `strip`, 1 kg on 0.024 kg of cloth" in found.message


@pytest.mark.parametrize("how", OTHERS)
def test_what_draws_nothing_out(tmp_path: Path, how: str) -> None:
    assert findings(tmp_path, "cloth-overloaded", STRIP, OTHERS[how]) == []
