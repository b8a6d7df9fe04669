"""USD, read back with OpenUSD itself."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exchange.recorded import DT, FRAMES, LINKS, cloth_points, write_run
from text2sim.exchange.usd import write_usd
from text2sim.templates.viewpoints import aperture_radius

pxr = pytest.importorskip("pxr")
from pxr import Usd, UsdGeom, UsdLux, UsdPhysics, UsdShade, UsdUtils  # noqa: E402

RATE = 25.0
PATHS = ["/run/statics/floor", "/run/bodies/box/box_0", "/run/bodies/box/box_1", "/run/bodies/arm/upper",
         "/run/bodies/arm/lower"]  # fmt: skip


@pytest.fixture(scope="module")
def stage(run: Path, tmp_path_factory: pytest.TempPathFactory) -> Usd.Stage:
    path = tmp_path_factory.mktemp("usd") / "run.usdc"
    write_usd(run, path)
    return Usd.Stage.Open(str(path))


def pose(prim: Usd.Prim, code: float) -> tuple[np.ndarray, np.ndarray]:
    matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(code))
    return matrix[3, :3], matrix[:3, :3].T  # it multiplies rows


def test_every_recorded_pose_is_a_pose_of_the_stage(stage: Usd.Stage, recorded: dict[str, np.ndarray]) -> None:
    for k, path in enumerate(PATHS):
        prim = stage.GetPrimAtPath(path)
        assert prim.GetCustomDataByKey("text2sim:body") == LINKS[k][0]
        for frame, time in enumerate(recorded["time"]):
            pos, turn = pose(prim, time * RATE)
            np.testing.assert_allclose(pos, recorded["links_pos"][frame, k], atol=1e-5)
            wanted = Rotation.from_quat(np.roll(recorded["links_quat"][frame, k], -1)).as_matrix()
            np.testing.assert_allclose(turn, wanted, atol=1e-5)


def test_orientations_turn_the_short_way_between_samples(stage: Usd.Stage, recorded: dict[str, np.ndarray]) -> None:
    # The recording changes from q to -q there, which is no turn at all.
    middle = (FRAMES // 2 - 0.5) * DT
    angle = 0.9 * np.pi * 2 * middle / recorded["time"][-1]
    _, turn = pose(stage.GetPrimAtPath(PATHS[1]), middle * RATE)
    np.testing.assert_allclose(turn, Rotation.from_euler("x", angle).as_matrix(), atol=1e-3)


def test_the_stage_has_units_and_a_time_span(stage: Usd.Stage) -> None:
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert (stage.GetTimeCodesPerSecond(), stage.GetStartTimeCode()) == (RATE, 0.0)
    assert stage.GetEndTimeCode() == pytest.approx((FRAMES - 1) * DT * RATE)
    assert stage.GetDefaultPrim().GetPath() == "/run"


def test_copies_of_a_shape_are_instances_that_wear_their_material_within(stage: Usd.Stage) -> None:
    boxes = [stage.GetPrimAtPath(f"{path}/shape_0") for path in PATHS[1:3]]
    assert all(box.IsInstance() for box in boxes)
    colors, sources = set(), set()
    for box in boxes:
        mesh = box.GetPrototype().GetChild("mesh")
        points = UsdGeom.Mesh(mesh).GetPointsAttr()
        assert np.abs(np.array(points.Get())).max() == pytest.approx(0.1)
        sources.add(points.GetPropertyStack()[0].path)
        material, _ = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()
        surface, _, _ = material.ComputeSurfaceSource()
        colors.add(tuple(round(x, 3) for x in surface.GetInput("diffuseColor").Get()))
    assert len(sources) == 1, "the file holds the points once"
    assert colors == {(0.604, 0.01, 0.01), (0.01, 0.01, 0.604)}, "sRGB 0.8 and 0.1, made linear"


def test_bodies_at_rest_have_no_samples(stage: Usd.Stage) -> None:
    still, falling = (stage.GetPrimAtPath(path).GetAttribute("xformOp:translate") for path in (PATHS[2], PATHS[1]))
    assert still.GetNumTimeSamples() == 0
    assert falling.GetNumTimeSamples() == FRAMES


def test_cloth_is_a_mesh_whose_points_move(stage: Usd.Stage) -> None:
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/run/bodies/sheet"))
    for frame, wanted in enumerate(cloth_points()):
        points = np.array(mesh.GetPointsAttr().Get(frame * DT * RATE))
        np.testing.assert_allclose(points, wanted, atol=1e-5)
    assert mesh.GetDoubleSidedAttr().Get()
    uvs = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    np.testing.assert_allclose(uvs, (wanted[:, :2] + 0.3) / 0.6, atol=1e-6)
    low, high = np.array(mesh.GetExtentAttr().Get(0))
    np.testing.assert_allclose([low, high], [(-0.3, -0.3, 1.2), (0.3, 0.3, 1.2)], atol=1e-6)


def test_grains_are_points_as_wide_as_they_lie_apart(stage: Usd.Stage, recorded: dict[str, np.ndarray]) -> None:
    grains = UsdGeom.Points(stage.GetPrimAtPath("/run/bodies/sand"))
    assert list(grains.GetWidthsAttr().Get()) == pytest.approx([0.02])
    last = np.array(grains.GetPointsAttr().Get((FRAMES - 1) * DT * RATE))
    np.testing.assert_allclose(last, recorded["soft_points"][-1, -7:], atol=1e-6)


def test_cameras_are_those_of_the_film(stage: Usd.Stage) -> None:
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/run/cameras/main")).GetCamera(0)
    assert camera.frustum.position == pytest.approx((0, -4, 2))
    assert camera.GetFieldOfView(camera.FOVVertical) == pytest.approx(40.0)
    way = np.array([0, 4, -1.6]) / np.hypot(4, 1.6)
    assert tuple(camera.frustum.ComputeViewDirection()) == pytest.approx(tuple(way), abs=1e-6)
    orbit = stage.GetPrimAtPath("/run/cameras/round").GetAttribute("xformOp:translate")
    assert orbit.GetNumTimeSamples() > 1
    assert tuple(orbit.Get(0)) == pytest.approx((3, 0, 1.5))


def test_lenses_are_as_wide_as_those_of_the_film(stage: Usd.Stage) -> None:
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/run/cameras/round"))
    focal = camera.GetFocalLengthAttr().Get() / 10 * UsdGeom.GetStageMetersPerUnit(stage)
    assert focal / (2 * camera.GetFStopAttr().Get()) == pytest.approx(aperture_radius(30.0, 2.8), rel=1e-6)


def test_lights_and_masses(stage: Usd.Stage) -> None:
    kinds = {prim.GetName(): prim.GetTypeName() for prim in stage.GetPrimAtPath("/run/lights").GetChildren()}
    assert kinds == {"sun": "DistantLight", "key": "RectLight", "bulb": "SphereLight", "spot": "SphereLight",
                     "fill": "DomeLight"}  # fmt: skip
    sun = UsdLux.DistantLight(stage.GetPrimAtPath("/run/lights/sun"))
    assert sun.GetIntensityAttr().Get() == pytest.approx(3.0 * 0.8), "scaled by the film's brightness"
    _, turn = pose(sun.GetPrim(), 0)
    np.testing.assert_allclose(turn @ (0, 0, -1), (0, 0, -1), atol=1e-6)
    assert UsdPhysics.MassAPI(stage.GetPrimAtPath(PATHS[1])).GetMassAttr().Get() == 2.0
    assert not stage.GetPrimAtPath(PATHS[1]).HasAPI(UsdPhysics.RigidBodyAPI), "no solver shall move it"


def test_archive_holds_its_pictures(run: Path, tmp_path: Path) -> None:
    write_usd(run, tmp_path / "run.usdz")
    assert [path.name for path in tmp_path.iterdir()] == ["run.usdz"], "and leaves nothing beside it"
    layers, assets, missing = UsdUtils.ComputeAllDependencies(str(tmp_path / "run.usdz"))
    assert (len(layers), len(assets), missing) == (1, 1, [])


def test_pictures_lie_beside_a_plain_file(run: Path, tmp_path: Path) -> None:
    write_usd(run, tmp_path / "run.usda", every=2)
    assert (tmp_path / "run_textures" / "picture_0.png").is_file()
    stage = Usd.Stage.Open(str(tmp_path / "run.usda"))
    falling = stage.GetPrimAtPath(PATHS[1]).GetAttribute("xformOp:translate")
    assert falling.GetTimeSamples() == pytest.approx([k * DT * RATE for k in (0, 2, 4, 5)]), "the last is kept"


def test_a_run_that_diverged_is_written_up_to_there(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", cloth=False, grains=False)
    chunk = folder / "states" / "chunk_00000.npz"
    with np.load(chunk) as file:
        arrays = dict(file)
    arrays["links_pos"][3:, 1] = np.nan
    np.savez(chunk, **arrays)
    assert write_usd(folder, tmp_path / "run.usdc")["frames"] == 3


def test_a_sky_is_a_sun_and_a_dome(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", cloth=False, grains=False)
    text = (folder / "program/render.py").read_text()
    sky = {"sky": {"kind": "sky", "strength": 3.0, "direction": (0, 0, -1), "turbidity": 3.0}}
    (folder / "program/render.py").write_text(text + f"LIGHTS = {sky!r}\n")
    write_usd(folder, tmp_path / "run.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    lights = stage.GetPrimAtPath("/run/lights").GetChildren()
    assert {prim.GetName(): prim.GetTypeName() for prim in lights} == {"sky": "DistantLight", "sky_dome": "DomeLight"}


def test_links_whose_names_differ_in_signs_are_kept_apart(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", cloth=False, grains=False)
    layout = (folder / "states/layout.json").read_text().replace('"upper"', '"foot-l"').replace('"lower"', '"foot_l"')
    (folder / "states/layout.json").write_text(layout)
    write_usd(folder, tmp_path / "run.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "run.usdc"))
    arm = stage.GetPrimAtPath("/run/bodies/arm").GetChildren()
    assert [(prim.GetName(), prim.GetCustomDataByKey("text2sim:link")) for prim in arm] == [
        ("foot_l", "foot-l"), ("foot_l_", "foot_l")
    ]  # fmt: skip
