"""Binary glTF, read back with other libraries."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from exchange.recorded import DT, FRAMES, LINKS, cloth_points, write_run
from text2sim.exchange import gltf
from text2sim.exchange.gltf import MOST_TARGETS, write_gltf
from text2sim.spec_schema.errors import RunError

pygltflib = pytest.importorskip("pygltflib")

TYPES = {5126: np.float32, 5123: np.uint16, 5125: np.uint32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
UPRIGHT = Rotation.from_euler("x", -90, degrees=True)


class Document:
    """What a .glb file says."""

    def __init__(self, path: Path) -> None:
        self.gltf = pygltflib.GLTF2().load(str(path))
        self.names = {node.name: k for k, node in enumerate(self.gltf.nodes)}

    def array(self, accessor: int) -> np.ndarray:
        row = self.gltf.accessors[accessor]
        view = self.gltf.bufferViews[row.bufferView]
        data = self.gltf.binary_blob()[view.byteOffset : view.byteOffset + view.byteLength]
        return np.frombuffer(data, TYPES[row.componentType]).reshape(row.count, WIDTHS[row.type])

    def track(self, node: str, path: str) -> tuple[np.ndarray, np.ndarray] | None:
        """Times and values of what moves of a node."""
        animation = self.gltf.animations[0]
        for channel in animation.channels:
            if channel.target.node == self.names[node] and channel.target.path == path:
                sampler = animation.samplers[channel.sampler]
                return self.array(sampler.input)[:, 0], self.array(sampler.output)
        return None


@pytest.fixture(scope="module")
def path(run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("gltf") / "run.glb"
    write_gltf(run, path)
    return path


@pytest.fixture(scope="module")
def document(path: Path) -> Document:
    return Document(path)


def test_nodes_move_as_recorded(document: Document, recorded: dict[str, np.ndarray]) -> None:
    for k, name in ((1, "box[0]"), (4, "arm.lower")):
        node = document.gltf.nodes[document.names[name]]
        assert node.extras["body"] == LINKS[k][0]
        moved = document.track(name, "translation")
        if moved is None:
            np.testing.assert_allclose(node.translation, recorded["links_pos"][0, k], atol=1e-6)
        else:
            np.testing.assert_allclose(moved[0], recorded["time"], atol=1e-6)
            np.testing.assert_allclose(moved[1], recorded["links_pos"][:, k], atol=1e-5)
        turned = document.track(name, "rotation")
        assert turned is not None
        np.testing.assert_allclose(np.linalg.norm(turned[1], axis=1), 1, atol=1e-6)
        assert ((turned[1][1:] * turned[1][:-1]).sum(axis=1) > 0).all(), "a reader goes the short way"
        wanted = Rotation.from_quat(np.roll(recorded["links_quat"][:, k], -1, axis=1)).as_matrix()
        np.testing.assert_allclose(Rotation.from_quat(turned[1]).as_matrix(), wanted, atol=1e-5)


def test_bodies_at_rest_have_no_track(document: Document) -> None:
    assert document.track("box[1]", "translation") is None
    assert document.track("box[1]", "rotation") is None


def test_copies_share_their_geometry(document: Document) -> None:
    meshes = [document.gltf.meshes[document.gltf.nodes[document.names[name]].mesh] for name in ("box[0]", "box[1]")]
    first, second = (mesh.primitives[0] for mesh in meshes)
    assert first.attributes.POSITION == second.attributes.POSITION
    assert first.material != second.material


def test_another_reader_puts_it_upright(path: Path) -> None:
    scene = trimesh.load(path)
    assert scene.bounds[:, 1] == pytest.approx([-0.2, 1.2], abs=1e-5), "from below the floor to the cloth, y is up"
    matrix, _ = scene.graph["box[0]"]
    np.testing.assert_allclose(matrix[:3, 3], UPRIGHT.apply([-0.5, 0, 1]), atol=1e-6)


def test_cloth_is_morphed_from_frame_to_frame(document: Document) -> None:
    mesh = document.gltf.meshes[document.gltf.nodes[document.names["sheet"]].mesh]
    primitive = mesh.primitives[0]
    first = document.array(primitive.attributes.POSITION)
    np.testing.assert_allclose(first, cloth_points()[0], atol=1e-6)
    times, weights = document.track("sheet", "weights") or (None, np.zeros(0))
    weights = weights.reshape(FRAMES, -1)
    deltas = np.array([document.array(target["POSITION"]) for target in primitive.targets])
    for frame, wanted in enumerate(cloth_points()):
        np.testing.assert_allclose(first + np.tensordot(weights[frame], deltas, 1), wanted, atol=1e-5)
    np.testing.assert_allclose(times, np.arange(FRAMES) * DT, atol=1e-6)


def test_grains_are_small_solids_that_move(document: Document, recorded: dict[str, np.ndarray]) -> None:
    mesh = document.gltf.meshes[document.gltf.nodes[document.names["sand"]].mesh]
    primitive = mesh.primitives[0]
    first = document.array(primitive.attributes.POSITION)
    solid = trimesh.Trimesh(first, document.array(primitive.indices).reshape(-1, 3), process=False)
    assert solid.is_volume, "closed, with all sides outwards"
    assert solid.volume == pytest.approx(7 * 4 / 3 * 0.01**3, rel=1e-4)
    last = first + document.array(primitive.targets[-1]["POSITION"])
    middles = last.reshape(7, 6, 3).mean(axis=1)
    np.testing.assert_allclose(middles, recorded["soft_points"][-1, -7:], atol=1e-6)


def test_grains_that_are_too_many_are_points(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gltf, "MOST_MORPHED", FRAMES * (16 + 7))
    write_gltf(run, tmp_path / "run.glb")
    document = Document(tmp_path / "run.glb")
    primitive = document.gltf.meshes[document.gltf.nodes[document.names["sand"]].mesh].primitives[0]
    assert primitive.mode == gltf.POINTS
    assert document.array(primitive.attributes.POSITION).shape == (7, 3)


def test_cloth_wears_its_picture(document: Document) -> None:
    mesh = document.gltf.meshes[document.gltf.nodes[document.names["sheet"]].mesh]
    material = document.gltf.materials[mesh.primitives[0].material]
    assert material.doubleSided
    image = document.gltf.images[document.gltf.textures[material.pbrMetallicRoughness.baseColorTexture.index].source]
    view = document.gltf.bufferViews[image.bufferView]
    data = document.gltf.binary_blob()[view.byteOffset : view.byteOffset + view.byteLength]
    assert data.startswith(b"\x89PNG")
    uvs = document.array(mesh.primitives[0].attributes.TEXCOORD_0)
    np.testing.assert_allclose(uvs[0], (0, 1), atol=1e-6)  # the lower left corner


def test_cameras(document: Document) -> None:
    assert [camera.name for camera in document.gltf.cameras] == ["main", "round"]
    assert document.gltf.cameras[0].perspective.yfov == pytest.approx(np.radians(40))
    node = document.gltf.nodes[document.names["camera main"]]
    ahead = Rotation.from_quat(node.rotation).apply([0, 0, -1])
    np.testing.assert_allclose(ahead, np.array([0, 4, -1.6]) / np.hypot(4, 1.6), atol=1e-6)
    assert document.track("camera round", "translation") is not None


def test_too_many_frames_of_deformable_bodies_are_refused_with_advice(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", frames=MOST_TARGETS + 40)
    with pytest.raises(RunError, match=r"write USD \(--usd\), or fewer frames \(--every 2\)"):
        write_gltf(folder, tmp_path / "run.glb")
    assert not (tmp_path / "run.glb").exists()
    assert write_gltf(folder, tmp_path / "run.glb", every=2)["frames"] <= MOST_TARGETS


def test_rigid_bodies_may_move_for_as_long_as_they_like(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", cloth=False, grains=False, frames=MOST_TARGETS + 40)
    assert write_gltf(folder, tmp_path / "run.glb")["frames"] == MOST_TARGETS + 40
