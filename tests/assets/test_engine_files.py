"""`genesis:PATH`: asset files of the engine, and no others."""

import subprocess
import sys
from pathlib import Path

import pytest

from text2sim.assets import engine_files
from text2sim.assets.engine_files import asset_folder, engine_assets
from text2sim.assets.mechanism import load_mechanism
from text2sim.compiler.build import resolve_case
from text2sim.compiler.shapes.casemesh import load_mesh, load_paint
from text2sim.spec_schema.errors import AssetError, SpecError
from text2sim.spec_schema.load import load_text

ARM = "genesis:urdf/simple/two_link_arm.urdf"
PYRAMID = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
CASE = """\
text2sim: 2
name: arm
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  thing:
    kind: articulated
    file: FILE
"""


@pytest.fixture
def assets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in the place of the engine's assets, with a secret beside it."""
    root = tmp_path / "assets"
    (root / "meshes").mkdir(parents=True)
    (root / "meshes" / "part.obj").write_text(PYRAMID)
    (tmp_path / "secret.obj").write_text(PYRAMID)
    (tmp_path / "secret.xml").write_text("<mujoco/>")
    monkeypatch.setattr(engine_files, "engine_assets", lambda: root.resolve())
    engine_files._list_files.cache_clear()
    return root


def test_a_mechanism_of_the_engine_is_read_with_all_its_files(tmp_path: Path):
    arm = load_mechanism(tmp_path, ARM)
    assert [joint.name for joint in arm.joints if joint.kind != "free"] == ["baseHinge", "interArm"]
    iiwa = load_mechanism(tmp_path, "genesis:urdf/kuka_iiwa/model.urdf")
    assert len(iiwa.files) > 5
    assert iiwa.sources[0] == "genesis:urdf/kuka_iiwa/model.urdf"
    assert all(source.startswith("genesis:urdf/kuka_iiwa/") for source in iiwa.sources)


def test_a_mesh_of_the_engine_is_a_shape(tmp_path: Path):
    assert load_mesh("genesis:meshes/duck.obj", tmp_path).volume > 0
    assert load_paint("genesis:meshes/duck.obj", tmp_path)
    text = CASE.replace("kind: articulated", "kind: rigid").replace(
        "file: FILE", "shape: {kind: mesh, file: 'genesis:meshes/duck.obj', scale: 0.1}"
    )
    (entity,) = resolve_case(load_text(text, tmp_path / "case.yaml")).plan.bodies[0].entities
    assert entity.morph == "MJCF"


def test_the_engine_is_found_without_being_imported(tmp_path: Path):
    program = (
        "import sys\nfrom pathlib import Path\nfrom text2sim.assets.mechanism import load_mechanism\n"
        f"load_mechanism(Path({str(tmp_path)!r}), {ARM!r})\nassert 'genesis' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("genesis:", "must be `genesis:` and a path inside the engine's assets"),
        ("genesis:/etc/passwd", "must be `genesis:` and a path"),
        ("genesis:../secret.xml", "must be `genesis:` and a path"),
        ("genesis:meshes/../../secret.xml", "must be `genesis:` and a path"),
        ("genesis:meshes\\part.obj", "with forward slashes"),
        ("genesis:link/secret.xml", "leads out of the engine's assets"),
        ("genesis:secret.xml", "leads out of the engine's assets"),
        ("genesis:meshes", "is not among the engine's assets"),
        ("genesis:meshes/prat.obj", "did you mean `genesis:meshes/part.obj`?"),
        ("genesis:" + "x/" * 90, "is not among the engine's assets"),
        ("genesis:http://example.org/x.xml", "with forward slashes"),
    ],
)
def test_nothing_outside_of_the_assets_is_read(file: str, words: str, assets: Path):
    (assets / "link").symlink_to(assets.parent, target_is_directory=True)
    (assets / "secret.xml").symlink_to(assets.parent / "secret.xml")
    with pytest.raises(AssetError) as caught:
        load_mechanism(assets.parent, file)
    assert words in str(caught.value)
    assert str(caught.value).startswith(f"`{file}` ")


def test_a_mesh_cannot_leave_the_assets_either(assets: Path):
    (assets / "meshes" / "out.obj").symlink_to(assets.parent / "secret.obj")
    with pytest.raises(AssetError, match="is outside the engine's assets"):
        load_mesh("genesis:meshes/out.obj", assets.parent)
    with pytest.raises(AssetError, match=r"mesh file `genesis:\.\./secret.obj` must be"):
        load_mesh("genesis:../secret.obj", assets.parent)


def test_a_model_of_the_engine_refers_to_its_own_files_only(assets: Path):
    for mesh, words in (
        ("../secret.obj", "leads out of the engine's assets"),
        ("/etc/x.obj", "is an absolute path"),
        ("gone.obj", "does not exist in the engine's assets"),
    ):
        (assets / "m.xml").write_text(
            f"<mujoco><asset><mesh file='{mesh}'/></asset><worldbody><body><geom size='1'/></body></worldbody></mujoco>"
        )
        with pytest.raises(AssetError) as caught:
            load_mechanism(assets.parent, "genesis:m.xml")
        assert words in str(caught.value)
        assert "copy" not in str(caught.value)


def test_a_missing_engine_is_reported_at_the_line_of_the_case(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(engine_files, "engine_assets", lambda: None)
    with pytest.raises(SpecError) as caught:
        resolve_case(load_text(CASE.replace("FILE", ARM)))
    (problem,) = caught.value.problems
    assert (problem.path, problem.line, problem.rule) == ("/bodies/thing/file", 7, "asset")
    assert problem.message == f"`{ARM}` comes with the engine, which is not installed: pip install genesis-world"


def test_a_file_of_the_case_may_be_called_as_it_likes(tmp_path: Path):
    found = asset_folder(tmp_path, "genesis/arm.urdf")
    assert (found.root, found.own) == (tmp_path.resolve(), True)
    root = engine_assets()
    assert root is not None and (root / "urdf").is_dir()
