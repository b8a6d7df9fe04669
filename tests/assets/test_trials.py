"""Trials of assets: reports on mechanisms, responses of joints, meshes in the engine."""

import copy
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from typer.testing import CliRunner

from text2sim.asset_intake.mechanism_check import check_mechanism, draw_preview
from text2sim.asset_intake.probe import probe
from text2sim.asset_intake.register import add
from text2sim.asset_intake.tiny_case import TrialOutcome, import_into_engine
from text2sim.assets.manifest import read_manifest, verify_manifest
from text2sim.cli.main import app
from text2sim.spec_schema.errors import AssetError

ARM = """\
<mujoco model="arm">
  <compiler angle="radian"/>
  <worldbody>
    <body name="base">
      <geom type="box" size="0.1 0.1 0.05" mass="2"/>
      <body name="upper" pos="0 0 0.05">
        <joint name="shoulder" type="hinge" axis="0 1 0" range="-1 1" damping="0.1"/>
        <geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.03" mass="1"/>
        <body name="hand" pos="0 0 0.4">
          <joint name="grip" type="slide" axis="0 0 1" range="0.02 0.1" damping="1"/>
          <geom type="box" size="0.04 0.04 0.02" mass="0.2"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="shoulder" kp="60" kv="6" forcerange="-30 30"/>
  </actuator>
</mujoco>
"""
LEVER: dict[str, Any] = {
    "kind": "articulated",
    "links": {
        "post": {"shape": {"kind": "box", "size": [0.1, 0.1, 0.4]}},
        "lever": {
            "parent": "post",
            "shape": {"kind": "box", "size": [0.4, 0.04, 0.04]},
            "pose": {"pos": [0.0, 0.08, 0.2]},
            "joint": {"kind": "hinge", "axis": "y", "actuator": {"stiffness": 20, "damping": 2, "max_force": 10}},
        },
    },
}


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    path = tmp_path / "arm.xml"
    path.write_text(ARM)
    return path


def test_report_on_a_mechanism(arm: Path):
    found = check_mechanism(arm)
    assert found.kind == "mjcf"
    assert found.mass == pytest.approx(3.2)
    shoulder, grip = found.control["shoulder"], found.control["grip"]
    assert (shoulder.kind, shoulder.unit, shoulder.range) == ("hinge", "rad", (-1.0, 1.0))
    assert shoulder.actuator is not None and shoulder.actuator.max_force == pytest.approx(30.0)
    assert (grip.kind, grip.unit, grip.actuator) == ("slider", "m", None)


def test_report_on_a_mechanism_of_the_language():
    found = check_mechanism(LEVER)
    assert found.kind == "body"
    assert list(found.control) == ["lever"]
    assert found.control["lever"].actuator is not None


def test_a_mechanism_is_drawn(arm: Path):
    picture = np.asarray(Image.open(BytesIO(draw_preview(arm))).convert("L"), float)
    assert picture.shape == (480, 640)
    assert picture.min() < 200, "there is something darker than the ground"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<robot name='r'/>", "begins with <robot>"),
        ("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>", "arm.xml"),
        ("<!DOCTYPE x [<!ENTITY a 'b'>]><mujoco/>", "arm.xml"),
        ("<mujoco><asset><mesh file='../../etc/passwd.obj'/></asset></mujoco>", "arm.xml"),
    ],
)
def test_other_bodies_and_files_are_refused(tmp_path: Path, text: str, words: str):
    (tmp_path / "arm.xml").write_text(text)
    with pytest.raises(AssetError, match=words):
        check_mechanism(tmp_path / "arm.xml")


def test_files_outside_of_the_root_are_refused(arm: Path, tmp_path: Path):
    (tmp_path / "root").mkdir()
    with pytest.raises(AssetError, match="is not in"):
        check_mechanism(arm, tmp_path / "root")
    (tmp_path / "link.xml").symlink_to(arm)
    with pytest.raises(AssetError, match="symbolic link"):
        check_mechanism(tmp_path / "link.xml")
    with pytest.raises(AssetError, match="kind `articulated`"):
        check_mechanism({"kind": "rigid"})


def test_a_mechanism_comes_into_a_case_with_all_its_files(tmp_path: Path):
    (tmp_path / "from" / "meshes").mkdir(parents=True)
    part = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="obj")
    (tmp_path / "from" / "meshes" / "part.obj").write_text(str(part))
    text = ARM.replace(
        '<compiler angle="radian"/>',
        '<compiler angle="radian" meshdir="meshes"/><asset><mesh name="p" file="part.obj"/></asset>',
    )
    text = text.replace(
        '<geom type="box" size="0.04 0.04 0.02" mass="0.2"/>', '<geom type="mesh" mesh="p" mass="0.2"/>'
    )
    (tmp_path / "from" / "arm.xml").write_text(text)
    case = tmp_path / "case"
    case.mkdir()
    added = add(case, tmp_path / "from" / "arm.xml", "robot")
    assert added.asset.file == "assets/robot/robot.xml"
    assert list(added.asset.parts) == ["assets/robot/part.obj"]
    assert set(read_manifest(case).assets["robot"].control) == {"shoulder", "grip"}
    assert verify_manifest(case) == {"robot": []}
    (case / "assets" / "robot" / "part.obj").write_text("v 0 0 0\n")
    assert "part.obj" in verify_manifest(case)["robot"][0]


def test_the_command_line_takes_a_mesh_in_and_lists_it(tmp_path: Path):
    (tmp_path / "box.stl").write_bytes(bytes(trimesh.creation.box((1, 2, 3)).export(file_type="stl")))
    (tmp_path / "case").mkdir()
    cli = CliRunner()
    file, case = str(tmp_path / "box.stl"), str(tmp_path / "case")
    done = cli.invoke(app, ["asset", "add", case, file, "--name", "box", "--size", "z=0.3", "--licence", "CC0"])
    assert done.exit_code == 0, done.output
    done = cli.invoke(app, ["asset", "list", case])
    assert done.exit_code == 0 and "box: mesh, assets/box.obj, 0.1 x 0.2 x 0.3 m, 12 triangles" in done.output
    assert cli.invoke(app, ["asset", "check", file, "--json"]).exit_code == 0
    (tmp_path / "case" / "assets" / "box.obj").write_text("changed\n")
    assert cli.invoke(app, ["asset", "list", case]).exit_code == 2


@pytest.mark.usefixtures("engine")
def test_joints_answer_a_small_signal(arm: Path):
    found = probe(arm)
    assert found.ok, found.message
    assert set(found.joints) == {"shoulder", "grip"}
    assert found.given == ("grip",), "the file has no motor on it"
    shoulder = found.joints["shoulder"]
    assert shoulder.moved == pytest.approx(shoulder.target, rel=0.5)
    grip = found.joints["grip"]
    assert grip.target == pytest.approx(0.016), "two fifths of the room that it has"
    assert grip.moved == pytest.approx(grip.target, rel=0.5)
    assert found.control["shoulder"].moved == shoulder.moved


@pytest.mark.usefixtures("engine")
def test_a_joint_with_a_motor_that_is_too_weak_does_not_answer():
    weak = copy.deepcopy(LEVER)
    weak["links"]["lever"]["joint"]["actuator"]["max_force"] = 0.001
    found = probe(weak)
    assert found.state == "finished"
    assert not found.ok
    assert not found.joints["lever"].answers


@pytest.mark.usefixtures("engine")
def test_the_engine_loads_a_repaired_mesh(tmp_path: Path):
    ball = trimesh.creation.icosphere(3, 0.1)
    (tmp_path / "ball.stl").write_bytes(bytes(ball.export(file_type="stl")))
    added = add(tmp_path, tmp_path / "ball.stl", "ball")
    found = import_into_engine(tmp_path / added.asset.file)
    assert found.ok, found.message
    assert found.mass == pytest.approx(1000 * ball.volume, rel=0.01)
    (tmp_path / "bad.obj").write_text("v 0 0 0\n")
    assert not import_into_engine(tmp_path / "bad.obj").ok


@pytest.mark.parametrize("initial", [{"le*": 0.5}, {"lever": "${1 / 2}"}, {"le*": 0.1, "lever": 0.5}])
def test_a_joint_is_driven_from_where_the_body_starts(initial: dict[str, Any], monkeypatch: pytest.MonkeyPatch):
    cases = []
    outcome = TrialOutcome("crashed", "", 0.0, {})
    monkeypatch.setattr("text2sim.asset_intake.probe.run_trial", lambda loaded: cases.append(loaded.case) or outcome)
    probe({**LEVER, "initial": initial})
    assert cases[0].actions.controls["drive_0"].position.values == pytest.approx([0.5, 0.65])


def test_a_joint_that_the_manifest_cannot_name_is_not_listed(tmp_path: Path):
    (tmp_path / "arm.xml").write_text(ARM.replace('"grip"', f'"{"g" * 201}"'))
    added = add(tmp_path, tmp_path / "arm.xml", "arm")
    assert [*added.asset.control] == ["shoulder"]
    assert added.asset.notes[-1].endswith("with names of 200 characters or fewer; 1 are not listed")
    assert read_manifest(tmp_path).assets["arm"] == added.asset


BEAM = """\
<robot name="beam">
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><mesh filename="../parts/box.obj"/></geometry></collision>
  </link>
</robot>
"""


def test_a_file_whose_meshes_lie_beside_its_folder_needs_the_root(tmp_path: Path) -> None:
    for name in ("urdf", "parts", "case"):
        (tmp_path / "beam" / name).mkdir(parents=True)
    file, case = tmp_path / "beam/urdf/beam.urdf", tmp_path / "beam/case"
    file.write_text(BEAM)
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "beam/parts/box.obj")
    for command in (["check", str(file)], ["add", str(case), str(file)]):
        answer = CliRunner().invoke(app, ["asset", *command])
        assert "`--root DIR`" in str(answer.exception)
        answer = CliRunner().invoke(app, ["asset", *command, "--root", str(tmp_path / "beam")])
        assert answer.exit_code == 0, answer.output
    assert (case / "assets/beam/beam.urdf").is_file()
    assert (case / "assets/beam/box.obj").is_file()
    # The root has nothing to do with other errors.
    ending = '<joint name="j" type="fixed"><parent link="x"/><child link="base"/></joint></robot>'
    file.write_text(
        BEAM.replace('<mesh filename="../parts/box.obj"/>', '<sphere radius="1"/>').replace("</robot>", ending)
    )
    answer = CliRunner().invoke(app, ["asset", "check", str(file)])
    assert "refers to a link `x`" in str(answer.exception) and "--root" not in str(answer.exception)


def test_a_file_of_the_engine_is_looked_at_as_the_case_names_it() -> None:
    report = check_mechanism(Path("genesis:urdf/go2/urdf/go2.urdf"))
    assert report.kind == "urdf"
    assert sum(name.endswith("_hip_joint") for name in report.control) == 4
