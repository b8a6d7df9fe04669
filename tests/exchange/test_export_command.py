"""The command `text2sim export`, and untrusted runs."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from exchange.recorded import write_run
from text2sim.cli.main import app
from text2sim.exchange.gltf import write_gltf
from text2sim.spec_schema.errors import RunError


def test_writes_all_requested_files_without_changing_the_run(run: Path, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    before = {path: path.stat().st_mtime_ns for path in run.rglob("*")}
    glb, usd = tmp_path / "a.glb", tmp_path / "a.usdc"
    done = CliRunner().invoke(app, ["export", str(run), "--gltf", str(glb), "--usd", str(usd), "--json"])
    assert done.exit_code == 0, done.output
    rows = json.loads(done.stdout)["files"]
    assert {row["file"]: row["bytes"] for row in rows} == {str(p): p.stat().st_size for p in (usd, glb)}
    assert [row["bodies"] for row in rows] == [6, 6]
    assert {path: path.stat().st_mtime_ns for path in run.rglob("*")} == before


def test_asks_for_a_file(run: Path) -> None:
    done = CliRunner().invoke(app, ["export", str(run)])
    assert done.exit_code == 2
    assert "name a file to write" in done.output


def _no_states(folder: Path) -> None:
    (folder / "states" / "chunk_00000.npz").unlink()


def _torn_states(folder: Path) -> None:
    path = folder / "states" / "chunk_00000.npz"
    path.write_bytes(path.read_bytes()[:200])


def _torn_mesh(folder: Path) -> None:
    next((folder / "geometry").glob("mesh_0.1*")).write_bytes(b"PK\3\4 no mesh")


def _file_outside(folder: Path) -> None:
    index = folder / "geometry" / "index.json"
    text = index.read_text().replace("mesh_2.0_2.0_0.1.npz", "../../stolen.npz")
    index.write_text(text)


def _no_picture(folder: Path) -> None:
    (folder / "geometry" / "check.png").write_text("<svg/>")


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_no_states, "not the recording of a run"),
        (_torn_states, "damaged|not the recording"),
        (_torn_mesh, "geometry is damaged"),
        (_file_outside, "names a file outside of it"),
        (_no_picture, "not a picture"),
    ],
)
def test_broken_runs_are_refused_in_words(tmp_path: Path, spoil: Callable[[Path], None], message: str) -> None:
    folder = write_run(tmp_path / "run")
    spoil(folder)
    with pytest.raises(RunError, match=message):
        write_gltf(folder, tmp_path / "run.glb")
    assert [path.name for path in tmp_path.iterdir()] == ["run"], "nothing half-made stays"


@pytest.mark.parametrize("name", ["run.gltf", "no/such/folder/run.glb"])
def test_files_that_cannot_be_written(run: Path, tmp_path: Path, name: str) -> None:
    with pytest.raises(RunError, match=r"ends in \.glb|no such folder"):
        write_gltf(run, tmp_path / name)
