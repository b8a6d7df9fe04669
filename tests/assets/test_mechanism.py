"""Model files of any origin: contents of valid ones, messages about invalid ones."""

from pathlib import Path

import pytest

from tests.assets.conftest import Refused, Write
from tests.assets.models import ARM, TETRAHEDRON, mjcf
from text2sim.assets import inspection
from text2sim.assets.mechanism import Mechanism, load_mechanism
from text2sim.spec_schema.errors import AssetError

GRIPPER = """\
<mujoco model="gripper">
  <compiler angle="degree" meshdir="meshes"/>
  <option timestep="0.001"/>
  <asset><mesh file="part.obj"/></asset>
  <worldbody>
    <geom type="plane" size="5 5 1"/>
    <body pos="0 0 0.3">
      <geom type="box" size="0.1 0.05 0.02"/>
      <body name="left"><joint name="grip" type="slide" axis="1 0 0" range="0 0.05"/><geom type="mesh" mesh="part"/></body>
      <body name="pendulum"><joint type="hinge" axis="0 1 0" range="-90 45"/><geom size="0.02" mass="0.5"/></body>
    </body>
  </worldbody>
  <actuator><position joint="grip" kp="200" kv="20" forcerange="-9 9"/></actuator>
</mujoco>
"""


def joint(mechanism: Mechanism, name: str):
    return next(joint for joint in mechanism.joints if joint.name == name)


class TestUrdf:
    def test_links_joints_limits_and_masses_are_read(self, write: Write) -> None:
        arm = load_mechanism(write({"arm.urdf": ARM}), "arm.urdf")
        assert (arm.kind, arm.link_names) == ("urdf", ("base", "upper", "hand"))
        shoulder = joint(arm, "shoulder")
        assert (shoulder.kind, shoulder.link, shoulder.limit, shoulder.motor) == (
            "hinge",
            "upper",
            30.0,
            None,
        )
        assert (shoulder.range, shoulder.damping) == (pytest.approx((-1, 2)), pytest.approx(0.3))
        assert arm.links[2].mass == pytest.approx(2)
        assert arm.inertialess

    def test_the_document_keeps_only_what_the_engine_reads(self, write: Write) -> None:
        arm = load_mechanism(write({"arm.urdf": ARM}), "arm.urdf")
        for word in ("gazebo", "plugin", "safety_controller", "meshes/"):
            assert word not in arm.text
        assert arm.sources == ("arm.urdf", "meshes/part.obj")
        assert dict(arm.files) == {"part.obj": TETRAHEDRON.encode()}
        assert any("safety_controller" in note for note in arm.notes)

    def test_a_link_without_visual_is_drawn_as_it_touches(self, write: Write) -> None:
        arm = load_mechanism(write({"arm.urdf": ARM}), "arm.urdf")
        assert arm.text.count("<cylinder") == 2
        assert any("base" in note for note in arm.notes)

    def test_a_package_is_a_folder_of_the_case(self, write: Write) -> None:
        text = ARM.replace("meshes/part.obj", "package://my_arm/meshes/part.obj")
        folder = write({"robots/urdf/arm.urdf": text, "robots/meshes/part.obj": TETRAHEDRON})
        assert load_mechanism(folder, "robots/urdf/arm.urdf").sources[1] == "robots/meshes/part.obj"

    def test_two_meshes_of_one_name_keep_apart(self, write: Write) -> None:
        text = ARM.replace('<visual><geometry><mesh filename="meshes', '<visual><geometry><mesh filename="fine')
        arm = load_mechanism(write({"arm.urdf": text, "fine/part.obj": TETRAHEDRON + "# fine\n"}), "arm.urdf")
        assert [name for name, _ in arm.files] == ["part.obj", "part_2.obj"]

    @pytest.mark.parametrize(
        ("old", "new", "words"),
        [
            (
                '<child link="upper"/>',
                '<child link="uper"/>',
                "refers to a link `uper` that does not exist; did you mean `upper`?",
            ),
            ('<parent link="base"/>', '<parent link="hand"/>', "links form a cycle: upper -> hand -> upper"),
            ('name="wrist" type="fixed"', 'name="shoulder" type="fixed"', "two joints named `shoulder`"),
            ('<link name="hand"/>', '<link name="upper"/>', "two links named `upper`"),
            ('<link name="hand"/>', '<link name="hand"/><link name="spare"/>', "several roots (base, spare)"),
            ('<link name="hand"/>', "<link/>", "a link without a name"),
            ('name="shoulder" type', "type", "a joint without a name"),
            ('<robot name="arm">', "<robot>", "a robot without a name"),
            ('<parent link="base"/>', "", "joint `shoulder` has no parent link; give it `<parent link="),
            ('<child link="upper"/>', "<child/>", "joint `shoulder` has no child link"),
            ('name="shoulder" type="revolute"', 'name="shoulder"', "joint `shoulder` has no type; the engine has"),
            (
                "<robot",
                '<?xml version="1.0" encoding="gbk"?><robot',
                "an encoding that cannot be read; save it as UTF-8",
            ),
            (
                "<robot",
                '<?xml version="1.0" encoding="foo"?><robot',
                "an encoding that cannot be read; save it as UTF-8",
            ),
            ('type="revolute"', 'type="floating"', "use `base: free` for a free root"),
            ('type="revolute"', 'type="planar"', "the engine has revolute"),
            ('lower="-1"', 'lower="3"', "lower limit (3) above its upper (2)"),
            ('<limit lower="-1" upper="2" effort="30" velocity="5"/>', "", "has no `<limit>`"),
            ('xyz="0 1 0"', 'xyz="0 0 0"', "axis of length zero"),
            ('mass value="2"', 'mass value="-2"', "mass of -2 kg"),
            ('mass value="2"', 'mass value="nan"', 'not finite: value="nan" (line 4)'),
            ('izz="0.004"', 'izz="0.4"', "inertia that no body can have"),
            ('ixx="0.02"', 'ixx="-0.02"', "inertia that no body can have"),
            (
                'filename="meshes/part.obj"/>',
                'filename="meshes/gone.obj"/>',
                "`meshes/gone.obj`, which does not exist",
            ),
            ('filename="meshes/part.obj"/>', 'filename="/etc/hostname"/>', "an absolute path; copy it"),
            ('filename="meshes/part.obj"/>', 'filename="file:///etc/x.obj"/>', "not a file of the case"),
            ('filename="meshes/part.obj"/>', 'filename="http://x.org/p.obj"/>', "not a file of the case"),
            ('filename="meshes/part.obj"/>', 'filename="package://else/p.obj"/>', "copy its package"),
            (
                'filename="meshes/part.obj"/>',
                'filename="../../secret.obj"/>',
                "leads out of the case's folder",
            ),
            (
                'filename="meshes/part.obj" scale',
                'filename="arm.urdf" scale',
                "must end in one of .obj, .stl for contact",
            ),
            ("<gazebo>", "<xacro:macro name='x'/><gazebo>", "xacro robot.urdf.xacro > robot.urdf"),
        ],
    )
    def test_models_that_cannot_be_simulated_are_refused_with_the_reason(
        self, old: str, new: str, words: str, refused: Refused, tmp_path: Path
    ) -> None:
        (tmp_path / "secret.obj").write_text(TETRAHEDRON)
        assert ARM.count(old) >= 1
        message = refused(ARM.replace(old, new, 1), "arm.urdf")
        assert message.startswith("`arm.urdf` ")
        assert words in message

    def test_a_long_chain_of_links_is_read_and_an_endless_one_refused(self, write: Write) -> None:
        def chain(links: int) -> str:
            box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
            rows = [f'<link name="l{k}">{box}</link>' for k in range(links)]
            for k in range(1, links):
                rows.append(
                    f'<joint name="j{k}" type="continuous"><parent link="l{k - 1}"/><child link="l{k}"/></joint>'
                )
            return f"<robot name='c'>{''.join(rows)}</robot>"

        long = load_mechanism(write({"c.urdf": chain(500)}), "c.urdf")
        assert len(long.joints) == 499
        with pytest.raises(AssetError, match="has 501 links"):
            load_mechanism(write({"c.urdf": chain(501)}), "c.urdf")

    def test_a_free_root_must_weigh_something(self, write: Write) -> None:
        text = ARM.replace('<link name="base">', '<link name="frame"/><link name="base">').replace(
            '<joint name="wrist"',
            '<joint name="turn" type="continuous"><parent link="frame"/><child link="base"/></joint>'
            '<joint name="wrist"',
        )
        folder = write({"arm.urdf": text})
        assert load_mechanism(folder, "arm.urdf").link_names[0] == "frame"
        light = text.replace('<mass value="2"/>', '<mass value="0"/>').replace(
            "<collision><geometry><cyl", "<contact><geometry><cyl"
        )
        light = light.replace(
            '</geometry></collision></link>\n  <link name="upper">',
            '</geometry></contact></link>\n  <link name="upper">',
        )
        with pytest.raises(AssetError, match="is movable and has no mass"):
            load_mechanism(write({"arm.urdf": light}), "arm.urdf", base="free")


class TestMjcf:
    def test_everything_has_a_name_and_units(self, write: Write) -> None:
        gripper = load_mechanism(write({"m.xml": GRIPPER}), "m.xml")
        assert gripper.link_names == ("link_0", "left", "pendulum")
        assert joint(gripper, "pendulum").range == pytest.approx((-1.5708, 0.7854), abs=1e-4)
        motor = joint(gripper, "grip").motor
        assert motor is not None
        assert (motor.stiffness, motor.damping, motor.limit) == (200, 20, 9)
        assert gripper.links[3].mass == 0.5

    def test_the_stage_and_the_options_are_left_out(self, write: Write) -> None:
        gripper = load_mechanism(write({"m.xml": GRIPPER}), "m.xml")
        assert "plane" not in gripper.text
        assert "<option" not in gripper.text
        assert [note for note in gripper.notes if "option" in note]
        assert [note for note in gripper.notes if "ground plane" in note]

    def test_shapes_are_known_for_bounds(self, write: Write) -> None:
        gripper = load_mechanism(write({"m.xml": GRIPPER}), "m.xml")
        (box,), (mesh,) = gripper.links[1].geoms, gripper.links[2].geoms
        assert (box.kind, box.size) == ("box", (0.1, 0.05, 0.02))
        assert (mesh.kind, len(mesh.corners)) == ("mesh", 4)

    @pytest.mark.parametrize(("base", "free"), [(None, False), ("fixed", False), ("free", True)])
    def test_the_case_sets_whether_the_root_is_free(self, base: str | None, free: bool, write: Write) -> None:
        gripper = load_mechanism(write({"m.xml": GRIPPER}), "m.xml", base=base)
        assert any(joint.kind == "free" for joint in gripper.joints) == free
        loose = load_mechanism(write({"n.xml": mjcf("<freejoint/>")}), "n.xml", base=base)
        assert any(joint.kind == "free" for joint in loose.joints) == (base != "fixed")

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            (mjcf("", "<include file='other.xml'/>"), "insert the content of the other file"),
            (mjcf("<include file='/etc/passwd'/>"), "`<include>`"),
            (mjcf("", "<extension><plugin plugin='mujoco.sdf.torus'/></extension>"), "no plugins"),
            (mjcf("<plugin plugin='x'/>"), "no plugins"),
            (mjcf("<composite type='cable' count='99999 1 1'/>"), "`<composite>`"),
            (mjcf("<replicate count='1000000'><geom size='1'/></replicate>"), "use `repeat` in the case"),
            (mjcf("", "<asset><hfield name='h' file='h.png'/></asset>"), "height field"),
            (mjcf("", "<asset><model file='x.xml'/></asset>"), "`<model>`"),
            (mjcf("<geom type='hfield' hfield='h'/>"), "geom of type `hfield`"),
            (mjcf("<geom type='plane' size='1 1 1'/>"), "only a static can be"),
            (mjcf("", "<asset><mesh file='../../secret.obj'/></asset>"), "leads out of the case's folder"),
            (mjcf("", "<compiler meshdir='/usr/share'/><asset><mesh file='x.obj'/></asset>"), "an absolute path"),
            (mjcf("", "<asset><mesh name='m' file='gone.obj'/></asset>"), "does not exist in the case's folder"),
            (mjcf("", "<asset><texture file='meshes/part.obj'/></asset>"), "must end in one of .png"),
            (mjcf("", "<asset><texture type='2d' builtin='flat' width='99999' height='9'/></asset>"), "4096 x 4096"),
            (mjcf("<joint type='hinge' ref='30'/>"), "remove `ref`"),
            (mjcf("<geom size='nan'/>"), "not finite"),
            (mjcf("<geom size='-1'/>"), "refused by MuJoCo"),
            (mjcf("<body name='b'/>"), "refused by MuJoCo"),
            ("<robot name='x'/>", "begins with <robot>; MJCF begins with <mujoco>"),
            ("<mujoco><worldbody></mujoco>", "not well-formed XML"),
            ("", "not well-formed XML"),
            ("<mujoco>" + "<worldbody>" * 200, "nested more than 100 deep"),
            ("<mujoco>" + "<option/>" * 30_000 + "</mujoco>", "more than 20000 elements"),
            ("<mujoco>" + " " * 3_000_000 + "</mujoco>", "too large (2.9 MiB; at most 2 MiB)"),
            ("<!DOCTYPE m SYSTEM 'file:///etc/passwd'><mujoco/>", "declares a document type"),
            (b"\xff\xfe" + "<!DOCTYPE m [<!ENTITY a 'b'>]><mujoco/>".encode("utf-16-le"), "declares a document type"),
        ],
    )  # fmt: skip
    def test_models_that_cannot_be_simulated_are_refused_with_the_reason(
        self, text: str | bytes, words: str, refused: Refused, tmp_path: Path
    ) -> None:
        (tmp_path / "secret.obj").write_text(TETRAHEDRON)
        assert words in refused(text)

    def test_an_entity_bomb_does_not_go_off(self, refused: Refused) -> None:
        levels = "".join(f"<!ENTITY e{k + 1} '{f'&e{k};' * 10}'>" for k in range(20))
        assert "document type" in refused(f"<!DOCTYPE m [<!ENTITY e0 'ha'>{levels}]><mujoco model='&e20;'/>")

    def test_ignored_parts_cannot_ask_for_memory(self, write: Write) -> None:
        text = mjcf("", "<size memory='900G'/>")
        assert load_mechanism(write({"m.xml": text}), "m.xml").link_names == ("b",)

    def test_a_model_that_brings_mujoco_down_brings_nothing_else_down(
        self, refused: Refused, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        crash = tmp_path / "crash.py"
        crash.write_text("import os; os.abort()")
        monkeypatch.setattr(inspection, "SCRIPT", crash)
        assert "crashes MuJoCo (signal 6)" in refused(mjcf("<geom size='0.123'/>"))

    def test_a_model_sees_no_keys(self, refused: Refused, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        monkeypatch.setenv("MESHY_API_KEY", "secret")
        script = tmp_path / "script.py"
        script.write_text(
            'import os, sys; sys.exit(f\'seen: {sorted({*os.environ} & {"MESHY_API_KEY", "PYTHONPATH"})}\')'
        )
        monkeypatch.setattr(inspection, "SCRIPT", script)
        assert "seen: []" in refused(mjcf("<geom size='0.124'/>"))

    def test_a_model_that_takes_too_long_is_given_up(
        self, refused: Refused, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        slow = tmp_path / "slow.py"
        slow.write_text("import time; time.sleep(60)")
        monkeypatch.setattr(inspection, "SCRIPT", slow)
        monkeypatch.setattr(inspection, "TIMEOUT", 0.3)
        assert "takes MuJoCo more than 0.3 s" in refused(mjcf("<geom size='0.124'/>"))
