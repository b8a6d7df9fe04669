"""Bodies and shapes from files: what lies in the program, which names count, and where mistakes are reported."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from text2sim.compiler.build import compile_case, plan_case
from text2sim.compiler.plan import Plan
from text2sim.compiler.trees.link_trees import tree_extents
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.load import load_case

ARM = """\
<robot name="arm">
  <link name="base">
    <inertial><mass value="3"/><inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
  </link>
  <link name="upper">
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.2"/><geometry><mesh filename="parts/bracket.obj"/></geometry></collision>
  </link>
  <link name="hand">
    <inertial><mass value="0.1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.05"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="30" velocity="5"/>
  </joint>
  <joint name="wrist" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="0 0 0.4"/></joint>
</robot>
"""

PENDULUM = """\
<mujoco>
  <worldbody>
    <body name="rod">
      <joint name="pin" type="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -1" size="0.02"/>
    </body>
  </worldbody>
  <actuator><motor joint="pin"/></actuator>
</mujoco>
"""

HEAD = """\
text2sim: 1
name: probe
scene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}
"""

Make = Callable[..., Plan]


def bracket() -> trimesh.Trimesh:
    """An L of 0.2 m x 0.2 m, 0.04 m wide and 0.06 m thick."""
    corners = np.array([(0, 0), (0.2, 0), (0.2, 0.04), (0.04, 0.04), (0.04, 0.2), (0, 0.2)], float)
    return trimesh.creation.extrude_triangulation(corners, np.array([(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]), 0.06)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A case's folder with an arm, a pendulum and meshes."""
    mesh = bracket()
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices] + [f"f {a} {b} {c}" for a, b, c in mesh.faces + 1]
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/bracket.obj").write_text("\n".join(lines))
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    crate = trimesh.creation.box((0.2, 0.1, 0.3))
    crate.unmerge_vertices()
    picture = Image.fromarray(np.arange(48, dtype=np.uint8).reshape(4, 4, 3))
    crate.visual = trimesh.visual.TextureVisuals(uv=crate.vertices[:, :2] + 0.5, image=picture)
    crate.export(tmp_path / "crate.glb")
    return tmp_path


@pytest.fixture
def make(folder: Path) -> Make:
    """Plan a case whose text begins below the scene."""

    def plan(text: str) -> Plan:
        (folder / "case.yaml").write_text(HEAD + text)
        return plan_case(load_case(folder))

    return plan


@pytest.fixture
def problems(make: Make) -> Callable[[str], list[Problem]]:
    """Return what is wrong with a case."""

    def find(text: str) -> list[Problem]:
        with pytest.raises(SpecError) as found:
            make(text)
        return found.value.problems

    return find


def body_with(rest: str, file: str = "arm.urdf") -> str:
    return f"bodies:\n  arm:\n    kind: articulated\n    file: {file}\n    {rest}\n"


DRIVEN = "joints: {shoulder: {actuator: {stiffness: 100, damping: 10}}}"


class TestModelFiles:
    def test_the_program_holds_document_and_meshes(self, make: Make, folder: Path, tmp_path_factory) -> None:
        make(body_with(DRIVEN))
        out = tmp_path_factory.mktemp("program")
        compile_case(load_case(folder), out)
        assert sorted(path.name for path in (out / "models/arm").iterdir()) == ["arm.urdf", "bracket.obj"]
        assert 'filename="bracket.obj"' in (out / "models/arm/arm.urdf").read_text()
        text = (out / "bodies.py").read_text()
        assert str(folder) not in text
        assert 'file=str(HERE / "models/arm/arm.urdf")' in text

    def test_a_urdf_is_driven_only_where_the_case_says_so(self, make: Make) -> None:
        plan = make(body_with("joints: {shoulder: {damping: 0.5, actuator: {stiffness: 100, damping: 10}}}"))
        assert plan.unpowered == ("arm",)
        (motor,) = plan.motors
        assert (motor.joint, motor.stiffness, motor.damping, motor.max_force) == ("shoulder", 100, 10, 30.0)
        (change,) = plan.changes
        assert (change.joint, change.damping, change.friction, change.armature) == (
            "shoulder",
            0.5,
            None,
            None,
        )

    def test_patterns_name_many_joints_and_names_overrule_them(self, make: Make) -> None:
        joints = '"*": {damping: 0.5, friction: 0.1, actuator: {stiffness: 100}}, shoulder: {damping: 0.2}'
        plan = make(body_with(f'joints: {{{joints}}}\n    initial: {{"sh*": 0.25}}'))
        ((motor,), (change,)) = plan.motors, plan.changes
        assert (motor.joint, motor.stiffness) == ("shoulder", 100)
        assert (change.joint, change.damping, change.friction) == ("shoulder", 0.2, 0.1)
        assert plan.initial == {"arm": {"shoulder": 0.25}}

    def test_the_case_can_lower_the_limit_of_a_motor(self, make: Make) -> None:
        (motor,) = make(body_with("joints: {shoulder: {actuator: {stiffness: 9, max_force: 4}}}")).motors
        assert motor.max_force == 4

    def test_the_motors_of_mjcf_stay_in_the_file(self, make: Make) -> None:
        plan = make(body_with("initial: {pin: 0.5}", "pendulum.xml"))
        assert (plan.motors, plan.changes, plan.unpowered) == ((), (), ())
        assert plan.initial == {"arm": {"pin": 0.5}}

    def test_friction_colour_and_mass_are_the_files_unless_said(self, make: Make) -> None:
        (entity,) = make(body_with("", "pendulum.xml")).bodies[0].entities
        assert (entity.friction, entity.rho, entity.surface) == (None, None, None)
        text = body_with("look: {color: red}\n    material: {friction: 0.2}", "pendulum.xml")
        (entity,) = make(text).bodies[0].entities
        assert entity.friction == 0.2
        assert entity.surface is not None

    def test_a_urdf_has_the_friction_of_the_case(self, make: Make) -> None:
        (entity,) = make(body_with("")).bodies[0].entities
        assert (entity.friction, entity.rho) == (0.5, None)

    def test_fixed_links_that_are_named_are_kept(self, make: Make) -> None:
        measure = "actions:\n  measures:\n    h: {kind: position, of: arm.hand, axis: z}\n"
        assert make(body_with("") + measure).bodies[0].entities[0].options["keep"] == ("hand",)
        assert make(body_with("")).bodies[0].entities[0].options["keep"] == ()

    def test_copies_share_the_files(self, make: Make) -> None:
        plan = make(body_with("repeat: {kind: line, count: 3, step: [1, 0, 0]}"))
        assert len(plan.bodies[0].entities) == 3
        assert sorted(plan.files) == ["models/arm/arm.urdf", "models/arm/bracket.obj"]

    def test_what_was_left_out_is_explained(self, folder: Path, make: Make) -> None:
        (folder / "arm.urdf").write_text(ARM.replace("</robot>", "<gazebo/></robot>"))
        assert any("gazebo" in note for note in make(body_with("")).notes)

    def test_placed_by_its_bounds_at_the_start(self, make: Make) -> None:
        (entity,) = make(body_with("place: {on: floor, at: [1, 2]}")).bodies[0].entities
        assert entity.pos == pytest.approx((1, 2, 0.05))
        text = body_with("initial: {pin: 1.5707963}\n    place: {on: floor, at: [0, 0]}", "pendulum.xml")
        (entity,) = make(text).bodies[0].entities
        assert entity.pos[2] == pytest.approx(0.02, abs=1e-6)


class TestNames:
    @pytest.mark.parametrize(
        ("rest", "line", "rule", "hint", "words"),
        [
            ("joints: {'leg_*': {damping: 1}}", 8, "unknown-joint", None, "no joint `leg_*`; there are shoulder"),
            ("initial: {'s*': 9}", 8, "range", None, "starts outside its range"),
            ("joints: {shoulde: {damping: 1}}", 8, "unknown-joint", "shoulder", "no joint `shoulde`; there are shoulder"),
            ("initial: {sholder: 1}", 8, "unknown-joint", "shoulder", "there is no joint `sholder`"),
            ("initial: {shoulder: 3}", 8, "range", None, "171.89 deg is not from -57.2958 to 114.592"),
            ("initial: {shoulder: 45}", 8, "range", None, "it is in radians: 45 deg is ${radians(45)}"),
            ("material: {mass: 3}", 8, "file-decides", None, "the masses are those of the file"),
            ("material: {density: 300}", 8, "file-decides", None, "the masses are those of the file"),
            ("self_collision: true", 8, "file-decides", None, "the file decides which of its links touch"),
            ("loops: {a: {between: [base, hand]}}", 8, "tree", None, "a file has its own"),
        ],
    )  # fmt: skip
    def test_what_the_file_does_not_have_is_reported_where_it_is_named(
        self,
        rest: str,
        line: int,
        rule: str,
        hint: str | None,
        words: str,
        problems: Callable[[str], list[Problem]],
    ) -> None:
        (problem,) = problems(body_with(rest))
        assert (problem.line, problem.rule, problem.hint) == (line, rule, hint)
        assert words in problem.message

    @pytest.mark.parametrize(
        ("section", "row", "rule", "words"),
        [
            (
                "controls",
                "{kind: drive, joint: arm.elbow, position: 1}",
                "unknown-joint",
                "`arm` has no joint `elbow`",
            ),
            (
                "controls",
                "{kind: drive, joint: arm.upper, position: 1}",
                "unknown-joint",
                "`upper`, which is a link",
            ),
            ("controls", "{kind: drive, joint: arm, position: 1}", "no-joint", "has one joint; name it: arm.shoulder"),
            ("controls", "{kind: drive, joint: arm.shoulder, position: 1}", "no-actuator", "has no actuator"),
            (
                "controls",
                "{kind: force, body: arm.shoulder, force: [1, 0, 0]}",
                "unknown-link",
                "`shoulder`, which is a joint",
            ),
            ("measures", "{kind: joint_position, of: arm.elbow}", "unknown-joint", "there are shoulder"),
            ("measures", "{kind: speed, of: arm.foot}", "unknown-link", "there are base, upper, hand"),
            ("events", "{kind: joint_limit, of: arm.wrist}", "unknown-joint", "`wrist`"),
        ],
    )
    def test_selectors_are_checked_against_the_file(
        self, section: str, row: str, rule: str, words: str, problems: Callable[[str], list[Problem]]
    ) -> None:
        (problem,) = problems(body_with("") + f"actions:\n  {section}:\n    x: {row}\n")
        assert (problem.line, problem.rule) == (11, rule)
        assert words in problem.message

    def test_a_motor_without_gain_cannot_hold_a_position(self, problems: Callable[[str], list[Problem]]) -> None:
        drive = "actions:\n  controls:\n    x: {kind: drive, joint: arm.pin, position: 1}\n"
        (problem,) = problems(body_with("", "pendulum.xml") + drive)
        assert problem.rule == "no-gain"

    def test_a_file_that_cannot_be_used_is_reported_at_its_name(
        self, folder: Path, problems: Callable[[str], list[Problem]]
    ) -> None:
        (folder / "parts/bracket.obj").unlink()
        (problem,) = problems(body_with("place: {on: floor}"))
        assert (problem.path, problem.line, problem.rule) == ("/bodies/arm/file", 7, "asset")
        assert problem.message == "`arm.urdf` refers to `parts/bracket.obj`, which does not exist in the case's folder"

    @pytest.mark.parametrize(
        "body", ["{kind: ragdoll, height: 1.7}", "{kind: chain, links: 3, link_length: 0.1, radius: 0.01}"]
    )
    def test_the_links_of_generated_bodies_are_known_too(
        self, body: str, problems: Callable[[str], list[Problem]]
    ) -> None:
        (problem,) = problems(f"bodies:\n  b: {body}\nactions: {{measures: {{m: {{kind: speed, of: b.nose}}}}}}\n")
        assert problem.rule == "unknown-link"


def mesh_body(rest: str, shape: str = "file: parts/bracket.obj") -> str:
    return f"bodies:\n  m: {{kind: rigid, shape: {{kind: mesh, {shape}}}, {rest}}}\n"


class TestMeshes:
    def test_mass_is_that_of_the_solid_not_of_its_hull(self, make: Make) -> None:
        plan = make(mesh_body("material: {density: 2000}"))
        model = next(data for path, data in plan.files.items() if path.endswith(".xml")).decode()
        assert 'density="2000"' in model
        assert 'inertia="exact"' in model

    def test_a_given_mass_is_spread_over_the_solid(self, make: Make) -> None:
        plan = make(mesh_body("material: {mass: 2.0}"))
        assert f'density="{2.0 / bracket().volume:.9g}"' in plan.files["models/m.xml"].decode()

    def test_an_open_surface_counts_as_its_hull(self, folder: Path, make: Make) -> None:
        path = folder / "parts/bracket.obj"
        path.write_text("\n".join(path.read_text().splitlines()[:-1]))
        model = make(mesh_body("material: {mass: 2.0}")).files["models/m.xml"].decode()
        assert 'inertia="convex"' in model
        assert f'density="{2.0 / bracket().convex_hull.volume:.9g}"' in model

    def test_it_is_drawn_with_its_picture_unless_a_colour_is_given(self, make: Make) -> None:
        glb = "file: crate.glb"
        painted = make(mesh_body("look: {finish: metal}", glb))
        assert "<texture" in painted.files["models/m.xml"].decode()
        assert [path for path in painted.files if path.endswith(".png")]
        assert painted.bodies[0].entities[0].surface is None
        plain = make(mesh_body("look: {color: red}", glb))
        assert "<texture" not in plain.files["models/m.xml"].decode()
        assert plain.bodies[0].entities[0].surface is not None

    def test_gltf_stands_upright(self, make: Make) -> None:
        (entity,) = make(mesh_body("place: {on: floor}", "file: crate.glb")).bodies[0].entities
        assert entity.pos[2] == pytest.approx(0.05)

    def test_scale_reaches_contact_and_look(self, make: Make) -> None:
        plan = make(mesh_body("material: {}", "file: parts/bracket.obj, scale: 2.5"))
        assert 'scale="2.5 2.5 2.5"' in plan.files["models/m.xml"].decode()
        drawn = next(
            data for path, data in plan.files.items() if path.endswith(".obj") and "bracket" not in path
        ).decode()
        assert max(float(line.split()[1]) for line in drawn.splitlines() if line.startswith("v ")) == pytest.approx(0.5)

    @pytest.mark.parametrize("mount", ["free", "fixed", "hinge"])
    def test_pieces_are_the_engines_business_on_every_mount(self, mount: str, make: Make) -> None:
        plan = make(mesh_body(f"mount: {{kind: {mount}}}", "file: parts/bracket.obj, collision: decompose"))
        assert plan.bodies[0].entities[0].options["contact"] == "decompose"
        assert 'contype="4" conaffinity="8"' in plan.files["models/m.xml"].decode()

    def test_a_mesh_that_cannot_be_used_is_reported_at_its_name(self, problems: Callable[[str], list[Problem]]) -> None:
        (problem,) = problems("bodies:\n  m: {kind: rigid, shape: {kind: mesh, file: parts/braket.obj}}\n")
        assert problem.path == "/bodies/m/shape/file"
        assert "does not exist" in problem.message

    def test_meshes_of_one_body_touch_alike(self, problems: Callable[[str], list[Problem]]) -> None:
        parts = {
            name: {"shape": {"kind": "mesh", "file": "parts/bracket.obj", "collision": collision}}
            for name, collision in (("a", "hull"), ("b", "decompose"))
        }
        shape = json.dumps({"kind": "compound", "parts": parts})
        (problem,) = problems(f"bodies:\n  m: {{kind: rigid, shape: {shape}}}\n")
        assert problem.path == "/bodies/m/shape"
        assert "give all of them the same `collision`" in problem.message


class TestBounds:
    """Bounds of trees of links, as placing needs them."""

    def test_of_a_chain(self, folder: Path, make: Make) -> None:
        make("bodies:\n  c: {kind: chain, links: 10, link_length: 0.1, radius: 0.01}\n")
        chain = load_case(folder).case.bodies["c"]
        low, high = tree_extents(chain, (1.0, 0.0, 0.0, 0.0), folder)
        assert low[:2] == pytest.approx((-0.01, -0.01), abs=1e-6)
        assert high[:2] == pytest.approx((0.01, 0.01), abs=1e-6)
        assert low[2] == pytest.approx(-1.0, abs=0.02)

    def test_of_links_with_start_positions(self, make: Make) -> None:
        text = """\
bodies:
  arm:
    kind: articulated
    links:
      post: {shape: {kind: box, size: [0.1, 0.1, 1.0]}}
      bar: {parent: post, shape: {kind: box, size: [0.1, 0.1, 0.8]}, pose: {pos: [0, 0, 0.9]},
            joint: {kind: hinge, axis: y, anchor: [0, 0, -0.4]}}
    initial: {bar: 1.5707963267948966}
    place: {on: floor, at: [0, 0]}
  cap: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, place: {on: arm, at: [0, 0]}}
"""
        plan = make(text)
        arm, cap = (group.entities[0] for group in plan.bodies)
        assert arm.pos == pytest.approx((0, 0, 0.5))
        assert cap.pos[2] == pytest.approx(0.5 + 0.5 + 0.05 + 0.05)

    def test_of_a_doll(self, folder: Path, make: Make) -> None:
        make("bodies:\n  d: {kind: ragdoll, height: 1.7, place: {on: floor}}\n")
        low, high = tree_extents(load_case(folder).case.bodies["d"], (1.0, 0.0, 0.0, 0.0), folder)
        assert high[2] - low[2] == pytest.approx(1.7, abs=0.05)
