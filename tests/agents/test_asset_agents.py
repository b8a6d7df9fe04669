"""What comes with a request, and what asset agents make, is checked, tried and registered before anybody uses it."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image as Picture
from PIL import ImageDraw

from tests.agents.scripted import Scripted, fenced, quiet
from text2sim.agents import session as sessions
from text2sim.agents.asset_agents import Supplies, make_asset
from text2sim.agents.conversation import Conversation, RoleFailed
from text2sim.agents.inputs import add_inputs, describe_assets
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.planning import Request, asset_faults
from text2sim.agents.replies import Asset, CasePlan, PlannedBody
from text2sim.agents.session import Session, SessionWish
from text2sim.assets.manifest import read_manifest, verify_manifest
from text2sim.spec_schema.errors import RunError

URDF = """<robot name="lift">
  <link name="base"><collision><geometry><box size="0.2 0.2 0.05"/></geometry></collision>
    <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><collision><geometry><box size="0.3 0.04 0.04"/></geometry></collision>
    <inertial><mass value="0.5"/><inertia ixx="0.001" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="tilt" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="20" velocity="2"/></joint>
</robot>
"""


@pytest.fixture
def files(tmp_path: Path) -> Path:
    folder = tmp_path / "given"
    folder.mkdir()
    box = trimesh.creation.box((0.2, 0.3, 0.4))
    box.export(folder / "whole crate.stl")
    trimesh.Trimesh(box.vertices, box.faces[2:]).export(folder / "open.obj")
    (folder / "lift.urdf").write_text(URDF)
    (folder / "bad.urdf").write_text(URDF.replace("revolute", "screw"))
    Picture.new("RGB", (64, 48), "teal").save(folder / "sketch.png")
    return folder


def test_inputs_are_mended_checked_and_registered(files: Path, tmp_path: Path) -> None:
    case = tmp_path / "case"
    case.mkdir()
    names = add_inputs(
        case, [files / "whole crate.stl", files / "open.obj", files / "lift.urdf", files / "sketch.png"], "CC BY 4.0"
    )
    assert names == ["whole_crate", "open", "lift", "sketch"]
    assets = read_manifest(case).assets
    assert all(one.licence == "CC BY 4.0" and one.source == "user" for one in assets.values())
    assert not any(verify_manifest(case).values()), "the hashes are those of the files"
    assert assets["lift"].control["tilt"].range == (-1.0, 1.0)
    crate, opened, lift, sketch = describe_assets(case, names)
    assert "0.2 x 0.3 x 0.4 m" in crate
    assert "closed: it can be rigid, static or soft" in crate
    assert opened.count("closed") >= 1
    assert "`tilt` (hinge -1 to 1 rad" in lift
    assert "kind: articulated, file: assets/lift/lift.urdf" in lift
    assert "a picture, 64 x 48 pixels" in sketch


def test_a_second_file_of_the_name_replaces_nothing(files: Path, tmp_path: Path) -> None:
    case = tmp_path / "case"
    (case / "assets").mkdir(parents=True)
    (case / "assets" / "sketch.png").write_bytes(b"somebody's own")
    assert add_inputs(case, [files / "sketch.png", files / "sketch.png"], "") == ["sketch_2", "sketch_3"]
    assert (case / "assets" / "sketch.png").read_bytes() == b"somebody's own"


def test_an_input_that_cannot_be_used_is_said_before_anybody_is_asked(files: Path, tmp_path: Path) -> None:
    with pytest.raises(RunError, match=r"bad\.urdf.*screw"):
        Session.begin(tmp_path / "case", SessionWish("generate", "It lifts.", {"": "x"}), [], [files / "bad.urdf"])


def test_the_planner_is_told_and_sees(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = Scripted({"planner": [fenced("name: no\nevent: x\npossible: no\nwhy: it is a test")]})
    monkeypatch.setattr(sessions, "endpoint_of", lambda spec, case: model)
    wish = SessionWish("generate", "The crate tips over.", {"": "x"}, cards=False)
    Session.begin(tmp_path / "case", wish, [files / "sketch.png"], [files / "whole crate.stl"]).run(
        lambda event, what: None
    )
    asked = next(one for one in model.asked if one.role == "planner" and one.messages[-1].images)
    assert "shape: {kind: mesh, file: assets/whole_crate" in asked.messages[-1].text
    assert [image.name for image in asked.messages[-1].images] == ["sketch.png"]
    assert "cannot see" not in asked.messages[-1].text
    blind = Scripted(model.replies)
    blind.vision = False
    monkeypatch.setattr(sessions, "endpoint_of", lambda spec, case: blind)
    wish = SessionWish("generate", "The crate tips over.", {"": "x"}, cards=False)
    Session.begin(tmp_path / "other", wish, [files / "sketch.png"], []).run(lambda event, what: None)
    assert any("You cannot see these pictures" in row for row in blind.questions("planner"))


# --- asset agents ----------------------------------------------------------------------------------------------------

PLAN = CasePlan.model_validate(
    {"name": "x", "event": "e", "params": {"reach": 0.4},
     "bodies": {"jelly": {"kind": "soft"}, "vase": {"kind": "rigid"}, "rag": {"kind": "cloth"}, "arm": {"kind": "articulated"}}}
)  # fmt: skip
COMPOUND = "shape: {kind: compound, parts: {a: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}, b: {shape: {kind: sphere, radius: 0.05}, pose: {pos: [0, 0, 0.1]}}}}"
ARM = """
body:
  kind: articulated
  base: fixed
  links:
    post: {shape: {kind: box, size: [0.1, 0.1, 0.5]}}
    boom:
      parent: post
      shape: {kind: box, size: ["${reach}", 0.04, 0.04]}
      pose: {pos: [0.27, 0, 0.2]}
      material: {density: 500}
      joint: {kind: hinge, axis: y, anchor: [-0.2, 0, 0], actuator: {stiffness: 200, damping: 10, max_force: MOST}}
controls: ["`boom`: position, rad"]
"""


def supplied(tmp_path: Path, kind: str, body: str, *replies: str) -> tuple[Supplies, Scripted]:
    model = Scripted({"mesh" if kind == "mesh" else "articulation": [fenced(reply) for reply in replies]})
    case = tmp_path / "case"
    case.mkdir(exist_ok=True)
    endpoints: Any = {"": model}
    chat = Conversation(endpoints, CallLog(case / "calls"), Account(), Budget(), quiet)
    asset = Asset.model_validate({"kind": kind, "body": body, "what": "something"})
    return make_asset(chat, asset, PLAN, Request("Make it."), case), model


def test_the_mesh_agent_knows_what_its_body_takes(tmp_path: Path) -> None:
    found, model = supplied(tmp_path, "mesh", "jelly", "shape: {kind: plane}", "shape: {kind: sphere, radius: 0.1}")
    first, second = model.questions("mesh")
    assert "It is for a `soft` body, which takes the shapes box, sphere" in first
    assert "`plane` is not a shape of a soft body, which takes box" in second
    assert "sculpt, compound" in first
    system = model.asked[0].messages[0].text
    assert "kind: limb" in system and "Each part must reach well" in system
    assert found.shapes == {"jelly": {"kind": "sphere", "radius": 0.1}}
    assert "`jelly`: its `shape`" in found.words[0]


def test_a_shape_is_drawn_and_registered(tmp_path: Path) -> None:
    supplied(tmp_path, "mesh", "vase", COMPOUND)
    case = tmp_path / "case"
    asset = read_manifest(case).assets["vase"]
    assert (asset.kind, asset.source, asset.prompt) == ("shape", "procedural", "something")
    assert not any(verify_manifest(case).values())
    with Picture.open(case / "generation" / "previews" / "vase.png") as picture:
        assert len(picture.convert("RGB").getcolors(1_000_000) or []) > 50, "something is to be seen"


def test_a_cloth_that_cannot_be_meshed_goes_back(tmp_path: Path) -> None:
    right = "shape: {kind: sheet, size: [1, 1]}"
    _, model = supplied(tmp_path, "mesh", "rag", "shape: {kind: mesh, file: rag.xyz}", right)
    assert "must end in one of .obj" in model.questions("mesh")[1]


def test_what_is_wrong_with_a_mechanism_goes_back(tmp_path: Path) -> None:
    with pytest.raises(RoleFailed, match="there is no link `pots`"):
        supplied(tmp_path, "mechanism", "arm", *[ARM.replace("parent: post", "parent: pots").replace("MOST", "50")] * 3)


@pytest.mark.usefixtures("engine")
@pytest.mark.timeout(600)
def test_a_mechanism_is_moved_in_the_engine_before_it_is_used(tmp_path: Path) -> None:
    weak, strong = ARM.replace("MOST", "0.0005"), ARM.replace("MOST", "50")
    found, model = supplied(tmp_path, "mechanism", "arm", weak, strong)
    assert "/body/links/boom/joint: asked to go 0.15, without gravity, it came" in model.questions("articulation")[1]
    asset = read_manifest(tmp_path / "case").assets["arm"]
    moved = asset.control["boom"].moved
    assert asset.kind == "mechanism"
    assert moved is not None
    assert moved == pytest.approx(0.15, rel=0.5), "it came half of the way at least"
    assert "Tried in the engine: `arm.boom` (hinge" in found.words[0]
    assert json.loads(json.dumps(found.bodies["arm"]["links"]["boom"]["shape"]["size"]))[0] == "${reach}"
    assert (tmp_path / "case" / "generation" / "previews" / "arm.png").is_file()


def test_what_a_sketch_shows_is_told_in_coordinates(tmp_path: Path) -> None:
    sketch = Picture.new("L", (200, 100), 255)
    pen = ImageDraw.Draw(sketch)
    pen.rectangle([20, 20, 60, 79], fill=0)
    pen.rectangle([100, 50, 139, 79], fill=0)
    sketch.save(tmp_path / "blocks.png")
    noise = np.random.default_rng(1).integers(0, 256, (90, 90, 3), np.uint8)
    Picture.fromarray(noise).save(tmp_path / "photo.png")
    (case := tmp_path / "case").mkdir()
    blocks, photo = describe_assets(case, add_inputs(case, [tmp_path / "blocks.png", tmp_path / "photo.png"], ""))
    assert "2 wide and 1 high" in blocks
    corners = re.findall(r"\(([\d.e-]+), ([\d.e-]+)\)", blocks.partition("part 1:")[2])
    points = np.array(corners, float)
    assert points.min(axis=0) == pytest.approx([80 / 60, 0], abs=0.03)
    assert points.max(axis=0) == pytest.approx([2.0, 0.5], abs=0.03)
    assert "outlines" not in photo


def test_a_mesh_is_for_a_body_with_a_shape() -> None:
    """An articulated body has none: every answer of the Mesh agent would be refused."""
    bodies = {
        "rig": PlannedBody(kind="articulated"),
        "nut": PlannedBody(kind="rigid"),
        "base": PlannedBody(kind="static"),
        "bag": PlannedBody(kind="cloth"),
    }
    assets = [Asset(kind="mesh", body=name, what="a thread") for name in (*bodies, "bolt")]
    assert asset_faults(assets, bodies) == [
        "`rig` is articulated, which takes no mesh: ask for a `mechanism`, or plan the part as a body of its own",
        "`bolt` is not a body of the plan",
    ]
