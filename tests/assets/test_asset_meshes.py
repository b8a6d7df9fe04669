"""Mesh files of any origin: reports, repairs, refusals."""

import json
import os
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from text2sim.assets.confined import environment_without_keys
from text2sim.assets.mesh_intake import read_surface
from text2sim.assets.mesh_output import mesh_bytes
from text2sim.assets.mesh_repair import RepairGoal, parse_size, repair
from text2sim.assets.mesh_report import faults, report
from text2sim.assets.meshes import check_mesh, repair_mesh
from text2sim.assets.surface import TriangleMesh
from text2sim.compiler.shapes.casemesh import load_mesh, load_paint
from text2sim.spec_schema.errors import AssetError


def saved(mesh: trimesh.Trimesh, path: Path) -> Path:
    path.write_bytes(bytes(mesh.export(file_type=path.suffix[1:])) if path.suffix != ".obj" else obj(mesh))
    return path


def obj(mesh: trimesh.Trimesh) -> bytes:
    return str(mesh.export(file_type="obj")).encode()


def read(mesh: trimesh.Trimesh, folder: Path, name: str = "thing.stl") -> TriangleMesh:
    return read_surface(saved(mesh, folder / name))[0]


def broken_sphere() -> trimesh.Trimesh:
    """A unit sphere with two holes, some triangles turned around, a speck beside it, and a triangle twice."""
    ball = trimesh.creation.icosphere(3)
    faces = np.array(ball.faces)
    faces[200:260] = faces[200:260, ::-1]
    faces = np.concatenate([np.delete(faces, [3, 90, 91], axis=0), faces[:1]])
    return trimesh.util.concatenate(
        [
            trimesh.Trimesh(ball.vertices, faces, process=False),
            trimesh.creation.icosphere(0, 0.005).apply_translation((2, 0, 0)),
        ]
    )


def textured_ball(fineness: int = 4) -> trimesh.Trimesh:
    """A unit sphere with y up whose picture is green above and red below: the place in it says the height."""
    ball = trimesh.creation.icosphere(fineness)
    pixels = np.zeros((64, 64, 3), np.uint8)
    pixels[:32] = (0, 255, 0)
    pixels[32:] = (255, 0, 0)
    places = np.stack([np.full(len(ball.vertices), 0.5), ball.vertices[:, 1] / 2 + 0.5], axis=1)
    ball.visual = TextureVisuals(uv=places, material=PBRMaterial(baseColorTexture=Image.fromarray(pixels)))
    return ball


def test_report_on_a_sound_mesh(tmp_path: Path):
    found = check_mesh(saved(trimesh.creation.box((0.1, 0.2, 0.3)), tmp_path / "box.stl"))
    assert found.extent == pytest.approx((0.1, 0.2, 0.3))
    assert (found.watertight, found.winding, found.components, found.triangles) == (True, "outwards", 1, 12)
    assert found.volume == pytest.approx(0.006)
    assert found.problems == ()


def test_report_on_a_broken_mesh(tmp_path: Path):
    found = report(read(broken_sphere(), tmp_path), "thing.stl", 1)
    assert not found.watertight
    assert found.winding == "mixed"
    assert found.volume is None
    assert (found.components, found.specks) == (2, 1)
    assert any("open" in problem for problem in found.problems)


def test_thin_walls_are_reported(tmp_path: Path):
    shell = trimesh.creation.annulus(r_min=0.098, r_max=0.1, height=0.2)
    found = report(read(shell, tmp_path), "shell.stl", 1)
    assert found.thickness == pytest.approx(0.002, rel=0.1)
    assert any("thin walls" in note for note in found.notes)


def test_a_broken_mesh_is_repaired(tmp_path: Path):
    repaired = repair_mesh(saved(broken_sphere(), tmp_path / "ball.stl"), RepairGoal(size=0.2))
    assert repaired.report.problems == ()
    assert repaired.report.watertight
    assert repaired.report.volume == pytest.approx(4 / 3 * np.pi * 0.1**3, rel=0.02)
    said = " ".join(repaired.done)
    for word in ("closed holes", "face outwards", "1 loose speck", "scaled by"):
        assert word in said


def test_a_repaired_mesh_is_a_shape_of_the_language(tmp_path: Path):
    repaired = repair_mesh(saved(broken_sphere(), tmp_path / "ball.stl"), RepairGoal(size=0.2))
    (tmp_path / f"out{repaired.suffix}").write_bytes(repaired.content)
    shape = load_mesh(f"out{repaired.suffix}", tmp_path)
    assert shape.closed
    assert np.ptp(shape.vertices, axis=0) == pytest.approx([0.2] * 3, rel=0.01)
    assert shape.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)


def test_a_mesh_that_faces_inwards_is_turned(tmp_path: Path):
    ball = trimesh.creation.icosphere(2)
    ball.invert()
    repaired = repair(read(ball, tmp_path), RepairGoal())
    assert repaired.surface.volumes().sum() > 0
    assert faults(repaired.surface) == []


def test_the_wall_of_a_hollow_keeps_facing_into_it(tmp_path: Path):
    hollow = trimesh.creation.icosphere(3, 0.5)
    hollow.invert()
    shell = trimesh.util.concatenate([trimesh.creation.icosphere(3), hollow])
    repaired = repair(read(shell, tmp_path), RepairGoal())
    assert repaired.surface.volumes().sum() == pytest.approx(4 / 3 * np.pi * (1 - 0.125), rel=0.02)


def test_a_flat_mesh_is_not_closed_but_reported_as_flat(tmp_path: Path):
    repaired = repair(
        read(trimesh.Trimesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]), tmp_path),
        RepairGoal(),
    )
    assert len(repaired.surface.faces) == 2
    assert any("flat" in text for text in faults(repaired.surface))


@pytest.mark.parametrize("most", [200, 1000])
def test_many_triangles_become_few_and_stay_closed(tmp_path: Path, most: int):
    repaired = repair(read(trimesh.creation.icosphere(5), tmp_path), RepairGoal(triangles=most))
    assert len(repaired.surface.faces) <= most
    assert repaired.surface.watertight
    assert repaired.surface.volumes().sum() == pytest.approx(4 / 3 * np.pi, rel=0.05)


def test_a_picture_stays_where_it_was(tmp_path: Path):
    repaired = repair_mesh(
        saved(textured_ball(), tmp_path / "ball.glb"), RepairGoal(size=1.0, triangles=600, origin="mass")
    )
    assert repaired.suffix == ".glb"
    assert repaired.report.textured and repaired.report.watertight and repaired.report.triangles <= 600
    (tmp_path / "out.glb").write_bytes(repaired.content)
    (part,) = load_paint("out.glb", tmp_path)
    assert part.picture is not None and part.uvs is not None
    # y of the file is z of the case, and the place in the picture still says the height
    assert part.uvs[:, 1] == pytest.approx(part.vertices[:, 2] + 0.5, abs=0.03)


def test_parts_with_colours_of_their_own_keep_them(tmp_path: Path):
    scene = trimesh.Scene()
    for number, color in enumerate([(255, 0, 0, 255), (0, 0, 255, 255)]):
        ball = trimesh.creation.icosphere(4).apply_translation((3 * number, 0, 0))
        ball.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=color))
        scene.add_geometry(ball)
    (tmp_path / "two.glb").write_bytes(scene.export(file_type="glb"))  # type: ignore[arg-type]
    repaired = repair_mesh(tmp_path / "two.glb", RepairGoal(triangles=1000))
    (tmp_path / "out.glb").write_bytes(repaired.content)
    found = {part.rgba[:3]: part.vertices[:, 0].mean() for part in load_paint("out.glb", tmp_path) if part.rgba}
    assert found[1.0, 0.0, 0.0] < 0 < found[0.0, 0.0, 1.0]


def test_corner_colours_come_along(tmp_path: Path):
    ball = trimesh.creation.icosphere(4)
    ball.visual.vertex_colors = np.where(ball.vertices[:, 2:] > 0, (0, 255, 0, 255), (255, 0, 0, 255)).astype(np.uint8)
    (tmp_path / "ball.ply").write_bytes(bytes(ball.export(file_type="ply")))
    repaired = repair_mesh(tmp_path / "ball.ply", RepairGoal(triangles=800, origin="keep"))
    (tmp_path / "out.glb").write_bytes(repaired.content)
    surface, _ = read_surface(tmp_path / "out.glb")
    assert surface.rgba is not None
    high = surface.vertices[surface.faces][..., 2] > 0.2
    assert (surface.rgba[high] == (0, 255, 0, 255)).all()


@pytest.mark.parametrize(("up", "height"), [("x", 1.0), ("y", 2.0), ("z", 3.0), (None, 3.0)])
def test_the_axis_that_points_up_can_be_given(tmp_path: Path, up, height: float):
    path = saved(trimesh.creation.box((1, 2, 3)), tmp_path / "box.stl")
    surface, _ = read_surface(path, up)
    assert surface.extent[2] == pytest.approx(height)
    assert surface.volumes().sum() == pytest.approx(6.0), "turned, not mirrored"


def test_in_gltf_y_points_up(tmp_path: Path):
    surface, _ = read_surface(saved(trimesh.creation.box((1, 2, 3)), tmp_path / "box.glb"))
    assert surface.extent == pytest.approx((1, 3, 2))
    again = tmp_path / "again.glb"
    again.write_bytes(mesh_bytes(surface, ".glb"))
    assert read_surface(again)[0].extent == pytest.approx((1, 3, 2))


@pytest.mark.parametrize(("text", "meant"), [("0.3", (0.3, None)), ("z=2", (2.0, "z")), ("x=1e-2", (0.01, "x"))])
def test_sizes_are_read(text: str, meant: tuple):
    assert parse_size(text) == meant


@pytest.mark.parametrize("text", ["", "big", "-1", "w=1", "1,2", "1e999999", "nan"])
def test_invalid_sizes_are_reported(text: str):
    with pytest.raises(AssetError, match="size"):
        RepairGoal(*parse_size(text))


def test_a_size_is_along_the_axis_that_is_meant(tmp_path: Path):
    surface = read(trimesh.creation.box((1, 2, 4)), tmp_path)
    assert repair(surface, RepairGoal(size=0.2, along="y")).surface.extent == pytest.approx((0.1, 0.2, 0.4))
    assert repair(surface, RepairGoal(size=0.2)).surface.extent == pytest.approx((0.05, 0.1, 0.2))


def test_the_origin_goes_where_it_is_wanted(tmp_path: Path):
    cone = trimesh.creation.cone(1.0, 4.0, sections=64).apply_translation((5, 5, 5))
    base = repair(read(cone, tmp_path), RepairGoal()).surface.vertices
    assert base[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    mass = repair(read(cone, tmp_path), RepairGoal(origin="mass")).surface.vertices
    assert mass[:, 2].min() == pytest.approx(-1.0, rel=0.01)
    kept = repair(read(cone, tmp_path), RepairGoal(origin="keep")).surface.vertices
    assert kept[:, 2].min() == pytest.approx(5.0)
    # Closed, but planar: there is no mass whose centre could be found.
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    planar = repair(read(square, tmp_path), RepairGoal(origin="mass"))
    assert planar.surface.vertices.min(axis=0) == pytest.approx((-0.5, -0.5, 0.0))
    assert planar.done[-1] == "moved the origin to the middle of its extent, as it encloses no volume"


@pytest.mark.parametrize("openings", [False, True])
def test_the_opening_of_a_bowl_is_meant_and_a_hole_is_not(tmp_path: Path, openings: bool):
    bowl = trimesh.creation.icosphere(4)
    bowl.update_faces((bowl.triangles_center[:, 2] < 0.3) & (np.arange(len(bowl.faces)) != 2000))
    repaired = repair(read(bowl, tmp_path), RepairGoal(openings=openings))
    assert any("closed holes" in text for text in repaired.done)
    assert repaired.surface.watertight == openings
    lid = repaired.surface.vertices[repaired.surface.faces].mean(1)[:, 2] > 0.99 * repaired.surface.extent[2]
    assert lid.any() == openings


def test_a_mesh_that_cannot_be_closed_gets_a_skin(tmp_path: Path):
    half = trimesh.creation.icosphere(4)
    half.update_faces(half.triangles_center[:, 2] < 0.6)
    repaired = repair_mesh(saved(half, tmp_path / "bowl.stl"), RepairGoal(holes=3, wrap=True))
    assert repaired.report.watertight
    assert any("closed skin" in text for text in repaired.done)


# --- strangers ---------------------------------------------------------------------------------------------


def gltf(**parts) -> bytes:
    document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], **parts}
    return json.dumps(document).encode()


HOSTILE = {
    "empty.obj": (b"", "is empty"),
    "text.stl": (b"hello\n" * 20, "(cannot be read|no triangles)"),
    "zip.obj": (b"PK\x03\x04" + b"\0" * 100, "archive"),
    "zip.glb": (b"\x1f\x8b" + b"\0" * 100, "archive"),
    "other.fbx": (b"x", "must end in one of"),
    "short.glb": (b"glTF", "is not a .glb file"),
    "deep.gltf": (b"[" * 100_000, "is not a .gltf file"),
    "far.gltf": (gltf(buffers=[{"uri": "http://example.org/a.bin", "byteLength": 4}]), "needs other files"),
    "near.gltf": (gltf(images=[{"uri": "../../etc/passwd"}]), "needs other files"),
    "huge.gltf": (gltf(accessors=[{"count": 10**12, "type": "VEC3", "componentType": 5126}]), "declares more"),
    "points.obj": (b"v 0 0 0\nv 1 0 0\n", "(no triangles|cannot be read)"),
    "nan.obj": (b"v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", "(not finite|cannot be read)"),
    "large.obj": (b"v 0 0 0\nv 1e12 0 0\nv 0 1 0\nf 1 2 3\n", "coordinates above"),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "(cannot be read|does not have|no triangles)"),
    "line.obj": (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 1\n", "(no triangles|cannot be read)"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused_in_words(tmp_path: Path, name: str):
    content, words = HOSTILE[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(AssetError, match=words) as caught:
        repair(read_surface(tmp_path / name)[0], RepairGoal())
    assert "Traceback" not in str(caught.value)


def test_a_count_that_lies_is_refused(tmp_path: Path):
    header = struct.pack("<80sI", b"", 0xFFFFFFFF)
    (tmp_path / "lies.stl").write_bytes(header + b"\0" * 500)
    with pytest.raises(AssetError):
        check_mesh(tmp_path / "lies.stl")


def test_many_copies_of_a_mesh_are_counted_before_they_are_made(tmp_path: Path):
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.icosphere(6), geom_name="ball", node_name="n0")
    for number in range(30):
        scene.graph.update(f"m{number}", geometry="ball", matrix=np.eye(4))
    (tmp_path / "many.glb").write_bytes(scene.export(file_type="glb"))  # type: ignore[arg-type]
    with pytest.raises(AssetError, match="too many triangles"):
        read_surface(tmp_path / "many.glb")


def test_links_are_refused(tmp_path: Path):
    saved(trimesh.creation.box(), tmp_path / "box.stl")
    os.symlink(tmp_path / "box.stl", tmp_path / "link.stl")
    with pytest.raises(AssetError, match="symbolic link"):
        check_mesh(tmp_path / "link.stl")
    with pytest.raises(AssetError, match="does not exist"):
        check_mesh(tmp_path / "missing.stl")


@pytest.mark.parametrize("place", ["../secret.mtl", "/etc/passwd", "link.mtl"])
def test_materials_come_from_beside_the_file_alone(tmp_path: Path, place: str):
    folder = tmp_path / "folder"
    folder.mkdir()
    (tmp_path / "secret.mtl").write_text("newmtl a\nKd 1 0 0\n")
    os.symlink(tmp_path / "secret.mtl", folder / "link.mtl")
    text = f"mtllib {place}\nusemtl a\n".encode() + obj(trimesh.creation.box())
    (folder / "box.obj").write_bytes(text)
    surface, notes = read_surface(folder / "box.obj")
    assert all(paint.rgba[:3] != (1.0, 0.0, 0.0) for paint in surface.paints)
    assert any("left out" in note for note in notes)


def test_a_material_beside_the_file_is_read(tmp_path: Path):
    (tmp_path / "box.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (tmp_path / "box.obj").write_bytes(b"mtllib box.mtl\nusemtl a\n" + obj(trimesh.creation.box()))
    surface, notes = read_surface(tmp_path / "box.obj")
    assert notes == ()
    assert surface.paints[0].rgba[:3] == pytest.approx((1.0, 0.0, 0.0))


def test_the_child_gets_no_keys(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MESHY_API_KEY", "secret")
    monkeypatch.setenv("SOME_TOKEN", "secret")
    assert "secret" not in environment_without_keys().values()
