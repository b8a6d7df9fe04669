"""Files of strangers, made here: each is used, or refused in a line that names it; none takes long."""

import io
import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from text2sim.compiler.build import resolve_case
from text2sim.lint import lint_case
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text

SECONDS = 4.0
"""Processor time [s] of the slowest, with that of its readers in processes of their own; most take milliseconds."""
HEAD = """\
text2sim: 2
name: odd
prompt: Something falls.
scene: {duration: 0.1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  it: """
MESH = "{{kind: rigid, shape: {{kind: mesh, file: {}}}, pose: {{pos: [0, 0, 1]}}}}\n"
MODEL = "{{kind: articulated, file: {}}}\n"
SKETCH = "{{kind: rigid, shape: {{kind: sketch, file: {}, height: 1, depth: 0.1}}, pose: {{pos: [0, 0, 1]}}}}\n"
CORNERS = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
SIDES = struct.pack("<12H", 0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2)


def gltf(sides: bytes = SIDES, *, accessors: Any = None, **changes: Any) -> tuple[dict[str, Any], bytes]:
    data = CORNERS + sides
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": accessors or [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": len(sides) // 2, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": len(sides)}],
        "buffers": [{"byteLength": len(data)}],
    } | changes, data  # fmt: skip


def glb(*made: Any, **changes: Any) -> bytes:
    document, data = gltf(*made, **changes)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def outside(uri: str) -> bytes:
    return json.dumps(gltf(buffers=[{"uri": uri, "byteLength": 72}])[0]).encode()


def picture(kind: str, pixels: np.ndarray) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, kind)
    return stream.getvalue()


BOARD = np.where((np.indices((1800, 1800)) // 12 % 2).all(axis=0), 0, 255).astype(np.uint8)
SIEVE = np.tile(np.where(np.indices((4, 4)).min(axis=0) < 2, 0, 255).astype(np.uint8), (400, 400))
THREADS = np.tile(np.uint8([0, 0, 255, 255]), (1600, 400))
PART = {"attributes": {"POSITION": 0}, "indices": 1}
EMPTY = [
    {"componentType": 5126, "count": 12_000_000, "type": "VEC3"},
    {"componentType": 5123, "count": 3, "type": "SCALAR"},
]
MJCF = '<mujoco><worldbody><body name="a"><joint/><geom size="0.1"/></body></worldbody></mujoco>'
CHECKERS = "".join(f'<texture name="t{k}" type="2d" builtin="checker" width="4096" height="4096"/>' for k in range(15))
URDF = '<robot name="r"><link name="a"><visual><geometry><mesh filename="{}"/></geometry></visual></link></robot>'
PLY = b"ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"
FINE = {"whole.glb", "shape.urdf"}
"""MuJoCo leaves out of a mesh that is only drawn what it does not have."""
FILES: dict[str, bytes] = {
    "whole.glb": glb(),
    "beyond.glb": glb(struct.pack("<12H", 0, 2, 1, 0, 1, 60_000, 1, 2, 3, 0, 3, 2)),
    "nothing.glb": glb(accessors=EMPTY),
    "count.glb": glb(accessors=[{"bufferView": 0, "componentType": 5126, "count": 1_000_000_000, "type": "VEC3"}]),
    "flat.glb": glb(nodes=[{"mesh": 0, "scale": [0, 0, 0]}]),
    "thin.glb": glb(nodes=[{"mesh": 0, "scale": [1, 0, 0]}]),
    "nodes.glb": glb(nodes=[{"mesh": 0}, *({"name": str(k)} for k in range(30_000))]),
    "tree.glb": glb(nodes=[{"mesh": 0, "translation": [k, 0, 0]} for k in range(2100)]),
    "crowd.glb": glb(SIDES * 1500, nodes=[{"mesh": 0}] * 4900),
    "often.glb": glb(SIDES * 1500, meshes=[{"primitives": [PART] * 3000}]),
    "parts.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"usemtl m\nf 1 2 3\n" * 30_000,
    "faces.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"f 1 2 3\n" * 400_000,
    "escape.glb": glb(buffers=[{"uri": "x\x1b[2K\rfake: ok\x1b[0m", "byteLength": 72}]),
    "passwd.gltf": outside("../../../../etc/passwd"),
    "gone.gltf": outside("gone.bin"),
    "scheme.gltf": outside("file:///etc/passwd"),
    "half.gltf": outside("half.bin"),
    "point.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1\n",
    "pair.obj": b"v 0 0 0\nv 1 0 0\nf 1 2\n",
    "one.obj": b"v 0 0 0\nf 1 1 1\n",
    "beyond.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 900\n",
    "million.ply": PLY % 1_000_000_000,
    "minus.ply": PLY % -3,
    "bytes.ply": b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty double x\nend_header\n\0\0",
    "huge.stl": b"\0" * 80 + struct.pack("<I", 4_000_000_000) + b"\0" * 100,
    "nan.stl": b"\0" * 80 + struct.pack("<I", 1) + struct.pack("<12f", *[float("nan")] * 12) + b"\0\0",
    "utf7.xml": b'<?xml version="1.0" encoding="UTF-7"?>' + MJCF.encode(),
    "odd.xml": b'<?xml version="1.0" encoding="no-such-thing"?>' + MJCF.encode(),
    "ref.xml": MJCF.replace("<joint/>", '<joint ref="abc"/>').encode(),
    "textures.xml": MJCF.replace("<worldbody>", f"<asset>{CHECKERS}</asset><worldbody>").encode(),
    "tied.xml": MJCF.replace("<worldbody>", '<equality><joint joint1="j" joint2="j" polycoef="0 1e6"/></equality><worldbody>').encode(),
    "tie.xml": MJCF.replace("<worldbody>", '<equality><joint joint1="j" polycoef="0 x"/></equality><worldbody>').encode(),
    "cubes.xml": MJCF.replace("<worldbody>", '<asset><texture builtin="flat" width="4096"/><texture builtin="flat" width="4096"/></asset><worldbody>').encode(),
    "range.xml": MJCF.replace("<joint/>", '<joint range="a b"/>').encode(),
    "attributes.xml": b"<mujoco " + b" ".join(b'a%d="1"' % k for k in range(50_000)) + b"/>",
    "mesh.urdf": URDF.format("gone.dae").encode(),
    "shape.urdf": URDF.format("beyond.obj").encode(),
    "mass.urdf": b'<robot name="r"><link name="a"><inertial><mass value="x"/></inertial></link></robot>',
    "sieve.png": picture("PNG", SIEVE),
    "threads.png": picture("PNG", THREADS),
    "wide.png": picture("PNG", np.full((1, 25_000_000), 119, np.uint8)),
    "board.png": picture("PNG", BOARD),
    "cut.png": picture("PNG", BOARD)[:900],
    "cut.jpg": picture("JPEG", BOARD)[:900],
    "bomb.png": picture("PNG", np.zeros((2, 2), np.uint8)).replace(struct.pack(">II", 2, 2), struct.pack(">II", 60_000, 60_000)),
    "not.jpg": b"GIF89a" + b"\0" * 100,
}  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def imported() -> None:
    """What reads files is imported before the clock runs."""
    import cv2  # noqa: F401
    import shapely  # noqa: F401
    import trimesh  # noqa: F401
    import yourdfpy  # noqa: F401


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_a_stranger(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for other, content in FILES.items():
        if other in (name, "beyond.obj"):
            (tmp_path / other).write_bytes(content)
    (tmp_path / "half.bin").write_bytes(CORNERS[:20])
    suffix = name.rpartition(".")[2]
    body = MODEL if suffix in ("xml", "urdf") else SKETCH if suffix in ("png", "jpg") else MESH
    begun, said, lines = sum(os.times()[:4]), "", set()
    try:
        lint_case(resolve_case(load_text(HEAD + body.format(name), tmp_path / "case.yaml")))
    except SpecError as error:
        said, lines = str(error), {problem.line for problem in error.problems}
    assert sum(os.times()[:4]) - begun < SECONDS
    assert (said == "") == (name in FINE), said
    assert not said or (name in said and lines == {6})
    assert not any(ord(c) < 32 and c != "\n" for c in said)
    told = capfd.readouterr()
    assert "\x1b" not in told.out + told.err, "a library of a reader says nothing by itself"
