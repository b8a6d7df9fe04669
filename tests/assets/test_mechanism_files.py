"""Files that models name: which are read, which are refused, and where they lead."""

import os
import struct
from pathlib import Path

import pytest

from tests.assets.conftest import Refused, Write
from tests.assets.models import ARM, TETRAHEDRON, mjcf
from text2sim.assets.mechanism import load_mechanism
from text2sim.spec_schema.errors import AssetError


@pytest.mark.parametrize(
    "name",
    [
        "",
        "/etc/passwd.xml",
        "../m.xml",
        "a/../../m.xml",
        "gone.xml",
        "https://x.org/m.xml",
        "meshes",
        "meshes/part.obj",
    ],
)
def test_only_a_model_in_the_case_is_read(name: str, write: Write, tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(mjcf(""))
    with pytest.raises(AssetError):
        load_mechanism(write({}), name)


def test_links_out_of_the_case_are_not_followed(refused: Refused, write: Write, tmp_path: Path) -> None:
    (tmp_path / "outside.obj").write_text(TETRAHEDRON)
    (tmp_path / "outside.xml").write_text(mjcf(""))
    folder = write({})
    (folder / "link.obj").symlink_to(tmp_path / "outside.obj")
    (folder / "link.xml").symlink_to(tmp_path / "outside.xml")
    (folder / "way").symlink_to(tmp_path)
    for file in ("link.obj", "way/outside.obj"):
        assert "leads out" in refused(mjcf("", f"<asset><mesh file='{file}'/></asset>"))
    with pytest.raises(AssetError, match="leads out"):
        load_mechanism(folder, "link.xml")


def test_names_that_lead_nowhere_are_refused(write: Write) -> None:
    folder = write({})
    (folder / "round.xml").symlink_to(folder / "about.xml")
    (folder / "about.xml").symlink_to(folder / "round.xml")
    for name in ("round.xml", "x" * 300 + ".xml"):
        with pytest.raises(AssetError):
            load_mechanism(folder, name)


def test_a_pipe_is_no_file(refused: Refused, write: Write) -> None:
    os.mkfifo(write({}) / "pipe.obj")
    assert "does not exist" in refused(mjcf("", "<asset><mesh file='pipe.obj'/></asset>"))


def test_meshes_have_a_size_limit(refused: Refused, write: Write) -> None:
    with (write({}) / "big.stl").open("wb") as stream:
        stream.truncate(65 * 2**20)
    assert "too large (65 MiB; at most 64 MiB)" in refused(mjcf("", "<asset><mesh file='big.stl'/></asset>"))


def test_a_broken_mesh_is_refused(refused: Refused) -> None:
    lying = b"\0" * 80 + struct.pack("<I", 2**31)
    message = refused(
        mjcf("<geom type='mesh' mesh='m'/>", "<asset><mesh name='m' file='m.stl'/></asset>"),
        **{"m.stl": lying},
    )
    assert "MuJoCo" in message


def test_materials_come_with_meshes_and_stay_in_the_case(write: Write, tmp_path: Path) -> None:
    (tmp_path / "secret.png").write_bytes(b"png")
    files = {
        "arm.urdf": ARM.replace(
            '<visual><geometry><mesh filename="meshes/part', '<visual><geometry><mesh filename="look/skin'
        ),
        "look/skin.obj": "mtllib paint/skin.mtl\nmtllib ../../secret.mtl\n" + TETRAHEDRON,
        "look/paint/skin.mtl": "\n".join(
            ["newmtl a", "map_Kd -s 1 1 1 ../wood.png", "map_Bump ../../../secret.png", "map_Ks /etc/hosts"]
        ),
        "look/wood.png": b"wood",
    }
    arm = load_mechanism(write(files), "arm.urdf")
    found = dict(arm.files)
    assert set(found) == {"part.obj", "skin.obj", "skin.mtl", "wood.png"}
    assert found["skin.obj"].startswith(b"mtllib skin.mtl\n\n")
    assert found["skin.mtl"].split(b"\n") == [b"newmtl a", b"map_Kd wood.png", b"", b""]


@pytest.mark.parametrize(
    ("head", "read"),
    [
        ("mtllib\tskin.mtl\n", b"mtllib skin.mtl\n"),
        ("mtllib skin.mtl\r\n", b"mtllib skin.mtl\n"),
        ("o a\rmtllib skin.mtl\r", b"o a\rmtllib skin.mtl\r"),
        ("o a\rmtllib ../../secret.mtl\r", b"o a\r\r"),
        ("# mtllib ../../secret.mtl\n", b"# \n"),
    ],
)
def test_materials_are_found_where_readers_find_them(head: str, read: bytes, write: Write) -> None:
    files = {"arm.urdf": ARM, "meshes/part.obj": head + TETRAHEDRON, "meshes/skin.mtl": "newmtl a\nmap_Kd\ta b.png"}
    found = dict(load_mechanism(write(files | {"meshes/a b.png": b"wood"}), "arm.urdf").files)
    assert found.get("part_2.obj", found["part.obj"]).startswith(read)
    assert ("skin.mtl" in found) == (b"skin" in read)
    if "skin.mtl" in found:
        assert found["skin.mtl"] == b"newmtl a\nmap_Kd a_b.png" and found["a_b.png"] == b"wood"
