"""A run of the engine, exported as a replay and for other programs."""

from pathlib import Path

import numpy as np
import pytest

from text2sim.exchange.usd import write_usd
from text2sim.harness.run import run_case
from text2sim.spec_schema.load import load_case

pytestmark = pytest.mark.usefixtures("engine")
CASE = """
text2sim: 2
name: drop
scene:
  duration: 0.3
  dt: 0.01
  statics:
    floor: {shape: {kind: plane}}
bodies:
  crate:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    material: {density: 500}
    place: {above: floor, at: [0, 0], clearance: 0.1}
    repeat: {kind: line, count: 2, step: [0.5, 0, 0]}
actions:
  measures:
    height: {kind: position, of: "crate[0]", axis: z}
  expect:
    lands: {measure: height, at: end, below: 0.12}
"""


def test_run_leaves_a_replay_and_can_be_exported(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    result = run_case(load_case(path), runs=tmp_path / "runs", film=False)
    assert result.evidence is not None
    replay = (result.folder / "replay.html").read_text("utf-8")
    assert '"name":"height"' in replay
    assert 'href="replay.html"' in (result.folder / "report.html").read_text("utf-8")
    again = run_case(load_case(path), runs=tmp_path / "runs", film=False)
    assert "report" not in again.timings, "nothing to do: not even that"

    pxr = pytest.importorskip("pxr")
    from pxr import Usd, UsdGeom

    assert pxr
    write_usd(result.folder, tmp_path / "drop.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "drop.usdc"))
    chunks = [np.load(path) for path in sorted((result.folder / "states").glob("chunk_*.npz"))]
    time, pos = (np.concatenate([chunk[name] for chunk in chunks]) for name in ("time", "links_pos"))
    crate = stage.GetPrimAtPath("/run/bodies/crate/crate_1")
    for t, wanted in zip(time, pos[:, -1], strict=True):
        matrix = np.array(UsdGeom.Xformable(crate).ComputeLocalToWorldTransform(t * stage.GetTimeCodesPerSecond()))
        np.testing.assert_allclose(matrix[3, :3], wanted, atol=1e-5)
