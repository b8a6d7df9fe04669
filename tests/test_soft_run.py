"""One run with bodies of two solvers that deform: what is recorded of them, and what the film shows of them."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

CASE = """\
text2sim: 2
name: soft_run
prompt: A soft cube, a heap of sand and some water fall on the floor, a flag hangs nowhere.
scene:
  duration: 0.12
  statics: {floor: {shape: {kind: plane}}}
bodies:
  cube:
    kind: soft
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    material: {youngs_modulus: 100000.0, density: 400}
    cell: 0.03
    look: {color: [0.9, 0.1, 0.1]}
    pose: {pos: [0, 0, 0.3]}
  sand:
    kind: granular
    shape: {kind: box, size: [0.08, 0.08, 0.08]}
    look: {color: [0.9, 0.8, 0.1]}
    pose: {pos: [0.2, 0, 0.08]}
  water:
    kind: liquid
    shape: {kind: box, size: [0.08, 0.08, 0.08]}
    look: {color: [0.1, 0.1, 0.9]}
    pose: {pos: [-0.2, 0, 0.08]}
  flag:
    kind: cloth
    shape: {kind: sheet, size: [0.2, 0.2]}
    cell: 0.04
    look: {color: [0.1, 0.8, 0.1]}
    pose: {pos: [0, 0.3, 0.3], euler_deg: [60, 0, 0]}
render:
  fps: 25
  resolution: [192, 108]
  cameras:
    front: {kind: still, from: [0.5, -1.2, 0.6], look_at: [0, 0.1, 0.15]}
    near: {kind: follow, body: flag, offset: [0, -0.6, 0.2]}
"""
BODIES = ["cube", "sand", "water", "flag"]


@pytest.fixture(scope="module")
def run(engine: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("soft_run")
    (place / "case.yaml").write_text(CASE)
    command = [sys.executable, "-m", "text2sim", "run", str(place), "--runs", str(place / "runs"), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=500, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    answer = json.loads(done.stdout)
    return Path((answer["cases"] if "cases" in answer else answer["runs"])[0]["folder"])


def test_points_and_surfaces_of_every_body_are_recorded(run: Path) -> None:
    rows = json.loads((run / "states" / "layout.json").read_text())["deformables"]
    assert [(row["body"], row["solver"]) for row in rows] == [(b, "pbd" if b == "flag" else "mpm") for b in BODIES]
    assert [row["surface"] is None for row in rows] == [False, True, True, False]
    chunk = np.load(min((run / "states").glob("chunk_*.npz")))
    assert chunk["soft_points"].shape[1] == rows[-1]["points"][1]
    assert chunk["soft_surface"].shape[1] == rows[-1]["surface"][1]
    for k, row in enumerate(rows):
        geometry = np.load(run / "geometry" / f"soft_{k}.npz")
        points = chunk["soft_points"][:, slice(*row["points"])]
        assert points[0] == pytest.approx(geometry["rest"], abs=1e-6)
        assert geometry["masses"].sum() == pytest.approx(row["mass"])
        if row["surface"] is not None:
            surface = chunk["soft_surface"][:, slice(*row["surface"])]
            gaps = np.linalg.norm(surface[:, :, None] - points[:, None], axis=-1).min(axis=2)
            assert gaps.max() < 1.5 * row["spacing"]
            assert geometry["faces"].max() < surface.shape[1]


def test_momentum_and_energy_are_those_of_free_fall(run: Path) -> None:
    chunks = [np.load(path) for path in sorted((run / "states").glob("chunk_*.npz"))]
    time, velocity, kinetic, speed = (
        np.concatenate([chunk[name] for chunk in chunks])
        for name in ("time", "soft_velocity", "soft_kinetic", "soft_speed")
    )
    mass = json.loads((run / "states" / "layout.json").read_text())["deformables"][0]["mass"]
    falling = time < 0.1
    assert velocity[falling, 0, 2] == pytest.approx(-9.81 * time[falling], abs=0.02)
    assert kinetic[falling, 0] == pytest.approx(mass * (9.81 * time[falling]) ** 2 / 2, rel=0.05, abs=1e-3)
    assert speed[falling, 0] == pytest.approx(9.81 * time[falling], abs=0.02)


def test_the_film_shows_all_of_them_in_their_colors(run: Path) -> None:
    seen = json.loads((run / "visibility.json").read_text())
    for sample in seen["front"]:
        assert set(BODIES) < set(sample["shares"])
    picture = np.asarray(Image.open(run / "first.png").convert("RGB")).astype(float)
    low, high = picture.min(axis=2), picture.max(axis=2)
    for channel, body in [(0, "cube"), (1, "flag"), (2, "water")]:
        colored = (picture[:, :, channel] == high) & (high > 1.8 * (picture.sum(axis=2) - high - low) + 20)
        share = seen["front"][0]["shares"][body]
        assert colored.mean() == pytest.approx(share, rel=0.5), body


def test_a_camera_follows_a_body_that_deforms(run: Path) -> None:
    states = json.loads((run / "visibility.json").read_text())["near"]
    shares = [sample["shares"].get("flag", 0.0) for sample in states]
    assert min(shares) > 0.02
    assert max(shares) < 1.5 * min(shares)
