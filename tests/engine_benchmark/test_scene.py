"""Contents of the neutral files, and their simulation in MuJoCo."""

from math import cos, pi, sin, sqrt
from pathlib import Path

import mujoco
import numpy as np
import pytest

from text2sim.compiler.build import plan_case
from text2sim.engine_benchmark.controls import tables
from text2sim.engine_benchmark.mjcf import build, obstacles
from text2sim.engine_benchmark.mujoco_engine import simulate
from text2sim.engine_benchmark.reference import Runs, references
from text2sim.engine_benchmark.statement import Statement, read_statement
from text2sim.engine_benchmark.usd import write_usd
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_case

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks/engines"
ARM = """\
text2sim: 2
name: arm
scene: {{duration: 2.0, dt: 0.002, statics: {{floor: {{shape: {{kind: plane}}, pose: {{pos: [0, 0, -2]}}}}}}}}
bodies:
  arm:
    kind: articulated
    base: fixed
    links:
      hub: {{shape: {{kind: sphere, radius: 0.02}}}}
      bob:
        parent: hub
        shape: {{kind: compound, parts: {{ball: {{shape: {{kind: sphere, radius: 0.05}}, pose: {{pos: [0, 0, -0.5]}}}}}}}}
        joint: {{kind: hinge, axis: y, actuator: {{stiffness: 3, damping: 0.2, max_force: 7}}}}
    pose: {{pos: [0, 0, 1], euler_deg: [0, 0, 30]}}
    initial: {{bob: 0.05}}
actions:
  controls: {controls}
  measures: {{angle: {{kind: joint_position, of: arm.bob}}, touch: {{kind: contact_count, of: arm}}}}
"""


def case(folder: Path, controls: str = "{}"):
    (folder / "case.yaml").write_text(ARM.format(controls=controls))
    return load_case(folder)


def test_masses_gravity_and_shapes_are_those_of_the_case(tmp_path):
    plan = plan_case(case(tmp_path))
    model = build(plan).compile()
    assert model.opt.timestep == pytest.approx(0.002)
    assert model.opt.gravity.tolist() == [0, 0, -9.81]
    bob = model.body("arm/bob")
    assert bob.mass[0] == pytest.approx(1000 * 4 / 3 * pi * 0.05**3)
    assert bob.ipos.tolist() == pytest.approx([0, 0, -0.5])
    assert model.geom("floor").type[0] == mujoco.mjtGeom.mjGEOM_PLANE
    hub, ball = (model.geom(name).id for name in ("arm/hub_0", "arm/bob_0@ball"))
    assert model.geom_contype[hub] == model.geom_conaffinity[hub] == model.geom_contype[ball] == 1  # meets the floor
    assert model.nexclude == 1  # and not each other


def test_a_pendulum_swings_as_its_equation(tmp_path):
    """w^2 = m g L / (m L^2 + 2/5 m r^2); the step is of first order."""
    plan = plan_case(case(tmp_path))
    (tmp_path / "scene.xml").write_text(build(plan).to_xml())
    link = {"pos": [0, 0, 1], "quat": [1, 0, 0, 0]}
    scene = {
        "links": [{**link, "fixed": True, "mjcf": "arm/hub"}, {**link, "fixed": False, "mjcf": "arm/bob"}],
        "joints": [{"body": "arm", "joint": "bob", "kind": "hinge"}],
        "initial_joints": [{"body": "arm", "joint": "bob", "position": 0.05}],
        "initial_joint_velocities": [], "initial_velocities": [], "controls": [], "forces": [],
    }  # fmt: skip
    times = [0.1 * k for k in range(21)]
    made = simulate(tmp_path, scene, times, 0.0005)
    w = sqrt(9.81 * 0.5 / (0.5**2 + 0.4 * 0.05**2))
    assert made["joint_pos"][:, 0] == pytest.approx([0.05 * cos(w * t) for t in times], abs=2e-4)
    assert made["joint_vel"][:, 0] == pytest.approx([-0.05 * w * sin(w * t) for t in times], abs=1e-3)
    assert made["ang"][:, 1, :2] == pytest.approx(  # about an axis that is turned by 30 degrees
        made["joint_vel"] * np.array([[-0.5, sqrt(0.75)]]), abs=1e-6
    )


@pytest.mark.parametrize(
    ("schedule", "value"),
    [
        (
            "{kind: ramp, from: 0.1, to: 0.5, start: 0.5, end: 1.5, ease: linear}",
            lambda t: 0.05 if t < 0.5 else 0.1 + 0.4 * min(t - 0.5, 1),
        ),
        (
            "{kind: sine, amplitude: 0.3, frequency: 2, offset: 0.1, phase_deg: 90}",
            lambda t: 0.1 + 0.3 * cos(4 * pi * t),
        ),
        ("{kind: steps, times: [0, 1], values: [0.2, 0.4]}", lambda t: 0.2 if t < 1 else 0.4),
        ("{kind: piecewise, times: [0, 1, 2], values: [0, 1, 0]}", lambda t: 1 - abs(t - 1)),
        ("0.7", lambda t: 0.7),
    ],
)
def test_controls_are_tables_of_the_schedules(tmp_path, schedule, value):
    controls = f"{{move: {{kind: drive, joint: arm.bob, position: {schedule}}}}}"
    (row,) = tables(plan_case(case(tmp_path, controls)))
    assert (row["stiffness"], row["damping"], row["max_force"]) == (3, 0.2, 7)
    assert row["targets"] == pytest.approx([value(0.002 * k) for k in range(1001)], abs=1e-8)


def test_the_motor_is_the_case_s_spring_and_damper(tmp_path):
    controls = "{move: {kind: drive, joint: arm.bob, position: 0.7}}"
    model = build(plan_case(case(tmp_path, controls))).compile()
    assert model.actuator_biasprm[0][:3].tolist() == [0, -3, -0.2]
    assert model.actuator_forcerange[0].tolist() == [-7, 7]


def test_joints_of_the_usd_stage_join_the_right_bodies(tmp_path):
    usd = pytest.importorskip("pxr.Usd")
    from pxr import Gf, UsdGeom, UsdPhysics

    plan = plan_case(load_case(BENCHMARKS.parents[1] / "cases/crank_slider"))
    write_usd(build(plan).compile(), plan, tmp_path / "scene.usda")
    stage, cache = usd.Stage.Open(str(tmp_path / "scene.usda")), UsdGeom.XformCache()
    joints = [UsdPhysics.Joint(prim) for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)]
    assert sorted(joint.GetPrim().GetTypeName() for joint in joints) == [
        "PhysicsPrismaticJoint", "PhysicsRevoluteJoint", "PhysicsRevoluteJoint", "PhysicsSphericalJoint",
    ]  # fmt: skip
    for joint in joints:
        sides = []
        for body, pos, rot in (
            (joint.GetBody0Rel(), joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
            (joint.GetBody1Rel(), joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
        ):
            world = cache.GetLocalToWorldTransform(stage.GetPrimAtPath(body.GetTargets()[0]))
            sides.append(np.array(Gf.Matrix4d(Gf.Rotation(rot.Get()), Gf.Vec3d(pos.Get())) * world))
        assert np.abs(sides[0] - sides[1]).max() < 1e-6
    piston = UsdPhysics.MassAPI(stage.GetPrimAtPath("/benchmark/engine_piston")).GetMassAttr().Get()
    assert piston == pytest.approx(2700 * 0.08 * 0.06 * 0.06)


def test_a_reference_ends_where_halving_the_step_still_changes_it():
    times = np.linspace(0, 1, 11)
    rows = [{"x": times * 0}, {"x": times**4}, {"x": times * 0}]  # the last two differ by t^4
    runs = Runs([], times, rows, {"x": "m"}, [])
    found = references(runs, Statement.model_validate({"observables": {"x": {"tolerance": 0.02}}}))["x"]
    assert found["until"] == pytest.approx(0.3)  # 0.3^4 = 0.0081 is below half of 0.02, 0.4^4 = 0.0256 is not
    assert found["convergence"]["changes"] == pytest.approx([0.0081, 0.0081])
    stated = {"observables": {"x": {"tolerance": 0.02, "analytic": "t ** 4"}}}
    found = references(runs, Statement.model_validate(stated))["x"]
    assert found["until"] == 1.0
    assert found["convergence"]["errors"] == pytest.approx([1, 0, 1])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "observables: {angel: {}}",
            "1:15: error: there is no measure `angel` that can be compared; there are angle; did",
        ),
        ("observables: {touch: {}}", "there is no measure `touch` that can be compared"),
        ("observables: {angle: {analytic: 'cos(w * t)'}}", "1:33: error: "),
        ("observables: {angle: {analytic: '1 / t'}}", "1:33: error: "),
        ("observables: {angle: {analytic: '[t, t]'}}", "1:33: error: "),
        ("observables: {angle: {tolerance: -1}}", "1:34: error: "),
    ],
)
def test_problems_of_a_statement_are_located(tmp_path, text, words):
    loaded = case(tmp_path)
    (tmp_path / "benchmark.yaml").write_text(text)
    with pytest.raises(SpecError) as error:
        read_statement(loaded)
    assert words in str(error.value)


def test_every_benchmark_of_the_repository_can_be_written():
    folders = sorted(path.parent for path in BENCHMARKS.glob("*/case.yaml"))
    assert len(folders) == 11
    for folder in folders:
        loaded = load_case(folder)
        assert read_statement(loaded).about
        assert obstacles(plan_case(loaded)) == []


def test_obstacles_are_reported():
    plan = plan_case(load_case(BENCHMARKS.parents[1] / "cases/sand_hourglass"))
    assert obstacles(plan) == ["bodies of the family mpm"]


def test_what_breaks_is_not_left_out_in_silence(tmp_path):
    text = (
        "text2sim: 2\nname: hung\nscene: {duration: 1, statics: {hook: {shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, 1]}}}}\n"
        "bodies: {cork: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, 0.9]}}}\n"
        "actions: {controls: {hold: {kind: attach, body: cork, to: hook, strength: 5}}}\n"
    )
    (tmp_path / "case.yaml").write_text(text)
    assert obstacles(plan_case(load_case(tmp_path))) == ["bonds and attachments that break"]
