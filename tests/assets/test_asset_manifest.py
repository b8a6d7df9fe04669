"""The manifest of a case's assets: located errors, canonical text, verification."""

import os
import threading
from pathlib import Path

import pytest
import trimesh

from text2sim.asset_intake.register import add
from text2sim.assets.manifest import (
    FILE,
    Asset,
    Control,
    Manifest,
    Motor,
    manifest_text,
    parse_manifest,
    problems_of,
    read_manifest,
    register,
    verify_manifest,
)
from text2sim.assets.mesh_repair import RepairGoal
from text2sim.assets.safe_write import place_in, write_asset
from text2sim.spec_schema.errors import AssetError, SpecError
from text2sim.spec_schema.text.source import Source

SHA = "0123456789abcdef" * 4
ODD = 'yes: no #1 "${drop}" \\ — ü ' * 12
TEAPOT = Asset(
    file="assets/teapot.glb",
    kind="mesh",
    source="meshy",
    licence="CC0",
    sha256=SHA,
    bytes=12,
    size=(0.3, 0.2, 1e-7),
    triangles=2000,
    closed=False,
    prompt=ODD,
    notes=("dropped 3 loose specks: tiny", "on"),
    parts={"assets/teapot/my part.obj": SHA},
    control={
        "lid: 1": Control(kind="hinge", unit="rad", range=(-0.5, 1.0), actuator=Motor(stiffness=3.0), moved=0.1),
        "knob": Control(kind="slider", unit="m"),
    },
)


def written(text: str) -> Source:
    return Source(text, "manifest.yaml")


def test_round_trip():
    manifest = Manifest(assets={"teapot": TEAPOT, "on": TEAPOT})
    text = manifest_text(manifest)
    assert parse_manifest(written(text)) == manifest
    assert manifest_text(parse_manifest(written(text))) == text
    assert parse_manifest(written(manifest_text(Manifest()))) == Manifest()


def test_without_a_file_there_are_no_assets(tmp_path: Path):
    assert read_manifest(tmp_path) == Manifest()
    assert verify_manifest(tmp_path) == {}


@pytest.mark.parametrize(
    ("line", "number", "words"),
    [
        ("    kind: mash", 5, "did you mean `mesh`"),
        ("    sha256: abc", 7, "SHA-256"),
        ("    bytes: -3", 8, "at least 0"),
        ("    file: ../../etc/passwd", 4, "inside the case's folder"),
        ("    colour: red", 9, "unknown key `colour`"),
    ],
)
def test_problems_are_located(line: str, number: int, words: str):
    rows = [
        "text2sim_assets: 1",
        "assets:",
        "  cup:",
        "    file: assets/cup.obj",
        "    kind: mesh",
        "    source: user",
        f"    sha256: '{SHA}'",
        "    bytes: 3",
    ]
    key = line.split(":")[0]
    rows = [line if row.split(":")[0] == key else row for row in rows]
    rows += [line] if line not in rows else []
    with pytest.raises(SpecError) as caught:
        parse_manifest(written("\n".join(rows) + "\n"))
    (problem,) = caught.value.problems
    assert problem.line == number
    assert words in str(problem)


def test_a_file_is_named_as_in_its_folder(tmp_path: Path):
    # `/bin` is a link on many machines, `bin` in a case is not.
    manifest = Manifest(assets={"cup": TEAPOT.model_copy(update={"file": "bin/cup.obj"})})
    assert parse_manifest(written(manifest_text(manifest))) == manifest


def test_the_last_asset_that_fits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    full = Manifest(assets={f"cup_{number}": TEAPOT for number in range(1000)})
    monkeypatch.setattr("text2sim.assets.manifest.read_manifest", lambda case: full)
    with pytest.raises(AssetError, match="`assets/manifest.yaml` has 1,000 assets"):
        register(tmp_path, "more", TEAPOT)
    assert len(register(tmp_path, "cup_1", TEAPOT).assets) == 1000


@pytest.mark.parametrize("text", ["", "[]", "a: &x 1\nb: *x\n", "text2sim_assets: 2\n", "!!python/object:os.system {}"])
def test_other_documents_are_refused(text: str):
    with pytest.raises(SpecError):
        parse_manifest(written(text))


def test_files_that_changed_are_found(tmp_path: Path):
    (tmp_path / "box.stl").write_bytes(bytes(trimesh.creation.box((1, 2, 3)).export(file_type="stl")))
    add(tmp_path, tmp_path / "box.stl", "box", goal=RepairGoal(size=0.3), licence="CC0")
    asset = read_manifest(tmp_path).assets["box"]
    assert asset.size == pytest.approx((0.1, 0.2, 0.3))
    assert (asset.closed, asset.triangles, asset.licence) == (True, 12, "CC0")
    assert verify_manifest(tmp_path) == {"box": []}
    (tmp_path / asset.file).write_text("v 0 0 0\n")
    found = verify_manifest(tmp_path)
    assert "has changed since" in found["box"][0]
    (problem,) = problems_of(tmp_path, found)
    assert problem.path == "/assets/box" and problem.line == 4
    (tmp_path / asset.file).unlink()
    assert "does not exist" in verify_manifest(tmp_path)["box"][0]


def test_two_at_a_time_lose_nothing(tmp_path: Path):
    threads = [threading.Thread(target=register, args=(tmp_path, f"asset_{number}", TEAPOT)) for number in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(read_manifest(tmp_path).assets) == 12


@pytest.mark.parametrize(
    "file", ["", "/etc/passwd", "../x", "a/../../x", "a\\b", "C:x", "~/x", "a\0b", "a\nb", ".", "link/x", "assets/out"]
)
def test_nothing_is_written_outside_of_the_case(tmp_path: Path, file: str):
    case = tmp_path / "case"
    (case / "assets").mkdir(parents=True)
    os.symlink(tmp_path, case / "link")
    os.symlink(tmp_path / "elsewhere", case / "assets" / "out")
    with pytest.raises(AssetError):
        write_asset(case, file, b"x")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case"]


def test_a_manifest_that_is_a_link_is_neither_read_nor_written(tmp_path: Path):
    case = tmp_path / "case"
    (case / "assets").mkdir(parents=True)
    (tmp_path / "other.yaml").write_text(manifest_text(Manifest()))
    os.symlink(tmp_path / "other.yaml", case / FILE)
    with pytest.raises(AssetError, match="symbolic link"):
        read_manifest(case)
    with pytest.raises(AssetError, match="symbolic link"):
        register(case, "teapot", TEAPOT)
    assert "teapot" not in (tmp_path / "other.yaml").read_text()


@pytest.mark.parametrize("name", ["", "../x", "a b", "1a", "x" * 49, "a/b", "ü"])
def test_names_are_those_of_the_language(tmp_path: Path, name: str):
    (tmp_path / "box.stl").write_bytes(bytes(trimesh.creation.box().export(file_type="stl")))
    with pytest.raises(AssetError, match="is not a name"):
        add(tmp_path, tmp_path / "box.stl", name)


def test_pictures_are_looked_at(tmp_path: Path):
    from PIL import Image

    Image.new("RGB", (8, 4)).save(tmp_path / "logo.png")
    (tmp_path / "fake.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"x" * 50)
    added = add(tmp_path, tmp_path / "logo.png", "logo")
    assert added.asset.kind == "texture" and "8 x 4 pixels" in added.asset.notes
    with pytest.raises(AssetError, match="not a readable picture"):
        add(tmp_path, tmp_path / "fake.png", "fake")


def test_places_inside_are_places(tmp_path: Path):
    assert place_in(tmp_path, "assets/a b.obj") == tmp_path / "assets" / "a b.obj"
