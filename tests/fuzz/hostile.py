"""Model files that nobody should have made, and bodies that use them."""

import json
import random
import struct
from typing import Any

Content = bytes | str
"""Of a file; of a link, where it leads to."""

TETRAHEDRON = b"v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
_MANY = b"".join(b"v %d %d %d\n" % (i % 97, i % 89, i % 83) for i in range(60_000))
_FANS = b"".join(b"f %d %d %d\n" % (i, i + 1, i + 2) for i in range(1, 59_000))

OBJ: tuple[Content, ...] = (
    TETRAHEDRON, b"", b"\0" * 2000, b"v", b"v 0 0\nf 1 2 3\n", b"v 0 0 0\nf 1 1 1\n", b"f 1 2 3\n", b"f 0 0 0\n" + TETRAHEDRON,
    TETRAHEDRON + b"f 1 2 99999999999999999999\n", TETRAHEDRON + b"f -1 -2 -99\n", TETRAHEDRON + b"f 1/9/9 2/9/9 3/9/9\n",
    b"v nan nan nan\n" + TETRAHEDRON, TETRAHEDRON.replace(b"0.1", b"1e300"), TETRAHEDRON.replace(b"0.1", b"1e-300"),
    TETRAHEDRON.replace(b"0.1", b"inf"), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\n", TETRAHEDRON.replace(b"\n", b"\\\n"),
    b"mtllib ../../../../etc/passwd\nusemtl x\n" + TETRAHEDRON, b"mtllib /etc/passwd\n" + TETRAHEDRON, _MANY + _FANS,
    b"mtllib m.mtl\nusemtl a\n" + TETRAHEDRON, b"f " + b"1 " * 100_000 + b"\n" + TETRAHEDRON, _MANY, b"v 1" + b"0" * 100_000,
    "/etc/passwd", "../../../../etc/passwd", "mesh.obj", "\u202e.obj",
)  # fmt: skip
STL: tuple[Content, ...] = (
    b"", b"\0" * 84, b"\0" * 80 + b"\xff" * 4, b"\0" * 80 + struct.pack("<I", 3) + b"\0" * 20, b"solid x\nfacet normal",
    b"\0" * 80 + struct.pack("<I", 1) + struct.pack("<12f", *([float("nan")] * 12)) + b"\0\0", b"solid " + b"a" * 100_000,
    b"\0" * 80 + struct.pack("<I", 2) + struct.pack("<12f", 0, 0, 1, 0, 0, 0, 1e38, 0, 0, 0, 1e38, 0) * 2 + b"\0\0\0\0",
    b"solid\nfacet normal 0 0 1\nouter loop\nvertex 1e999 a 0\nendloop\nendfacet\nendsolid\n", "/dev/zero", "/proc/self/environ",
)  # fmt: skip


def _glb(document: Any, binary: bytes = b"\0" * 64) -> bytes:
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    parts = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts


def _gltf(**changes: Any) -> dict[str, Any]:
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 64}], **changes,
    }  # fmt: skip


def _accessor(**changes: Any) -> bytes:
    return _glb(_gltf(accessors=[{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", **changes}]))


GLB: tuple[Content, ...] = (
    b"", b"glTF", b"glTF" + b"\xff" * 16, _glb(_gltf()), _glb(b"{"), _glb(b"[" * 50_000), _glb({}), _glb([]), _glb(_gltf(meshes=[])),
    _accessor(count=4_000_000_000), _accessor(count=-3), _accessor(count="x"), _accessor(componentType=1), _accessor(type="MAT9"),
    _accessor(bufferView=7), _accessor(byteOffset=2**40), _accessor(sparse={"count": 10**9}), _glb(_gltf(nodes=[{"children": [0]}])),
    _glb(_gltf(buffers=[{"uri": "../../../../etc/passwd", "byteLength": 64}])), _glb(_gltf(nodes=[{"mesh": 0, "scale": [1e300] * 3}])),
    _glb(_gltf(buffers=[{"uri": "file:///etc/passwd", "byteLength": 64}])), _glb(_gltf(images=[{"uri": "/etc/passwd"}])),
    _glb(_gltf(buffers=[{"uri": "http://localhost:9/x", "byteLength": 64}])), _glb(_gltf(bufferViews=[{"buffer": 9, "byteLength": 1}])),
    _glb(_gltf(nodes=[{"children": [1, 1]}] + [{"children": [i, i]} for i in range(2, 40)] + [{"mesh": 0}])),
    _glb(_gltf(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5, "extensions": {"KHR_draco_mesh_compression": {}}}]}])),
)  # fmt: skip


def _mjcf(body: str, before: str = "", head: str = "") -> bytes:
    return f"{head}<mujoco>{before}<worldbody>{body}</worldbody></mujoco>".encode()


_ARM = '<body name="a"><joint name="j" axis="0 1 0"/><geom size="0.1"/>{}</body>'
_LAUGHS = (
    "<!DOCTYPE x ["
    + '<!ENTITY a0 "ha">'
    + "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 10))
    + "]>"
)
MJCF: tuple[Content, ...] = (
    b"", b"<", b"<mujoco/>", b"<robot/>", _mjcf(_ARM.format("")), _mjcf(_ARM.format("&a9;"), head=_LAUGHS), "\ufeff".encode() * 9,
    _mjcf(_ARM.format("&x;"), head='<!DOCTYPE x [<!ENTITY x SYSTEM "file:///etc/passwd">]>'), _mjcf("<body>" * 5000 + "</body>" * 5000),
    _mjcf('<include file="model.xml"/>'), _mjcf('<include file="../../../etc/passwd"/>'), _mjcf('<include file="/etc/passwd"/>'),
    _mjcf(_ARM.format(""), '<asset><mesh name="m" file="../../../../etc/passwd"/></asset>'),
    _mjcf(_ARM.format('<geom type="mesh" mesh="m"/>'), '<compiler meshdir="/etc"/><asset><mesh name="m" file="passwd"/></asset>'),
    _mjcf(_ARM.format('<geom type="mesh" mesh="m"/>'), '<asset><mesh name="m" file="mesh.obj" scale="1e300 0 -1"/></asset>'),
    _mjcf('<replicate count="100000000" offset="0 0 1">' + _ARM.format("") + "</replicate>"), _mjcf(_ARM.format("") * 3),
    _mjcf('<composite type="grid" count="1000 1000 1" spacing="0.1"><geom size="0.01"/></composite>'), _mjcf(_ARM.format('<geom size="nan"/>')),
    _mjcf(_ARM.format('<flexcomp type="grid" count="500 500 500" spacing="1 1 1" name="f"/>')), _mjcf(_ARM.format('<geom size="1e300"/>')),
    _mjcf(_ARM.format('<geom size="-1"/>')), _mjcf(_ARM.format('<joint name="k" axis="0 0 0"/>')), _mjcf(_ARM.format('<geom type="plane"/>')),
    _mjcf(_ARM.format(""), '<extension><plugin plugin="/tmp/evil.so"/></extension>'), _mjcf(_ARM.format(""), '<size memory="900G" nkey="9"/>'),
    _mjcf(_ARM.format(""), '<asset><hfield name="h" nrow="90000" ncol="90000" size="1 1 1 1"/></asset>'),
    _mjcf(_ARM.format(""), '<asset><texture name="t" type="2d" builtin="flat" width="90000" height="90000"/></asset>'),
    _mjcf(_ARM.format(""), '<equality><weld body1="a" body2="nope"/></equality>'), _mjcf('<body name="a">' + "<geom size='1'/>" * 20_000 + "</body>"),
    _mjcf(_ARM.format("")).decode().encode("utf-16"), _mjcf(_ARM.format("")).replace(b'"a"', b'"\xff\xfe"'), "/etc/passwd", "..",
)  # fmt: skip


def _urdf(mesh: str, more: str = "") -> bytes:
    shape = f'<geometry><mesh filename="{mesh}"/></geometry>'
    mass = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    joint = '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint>'
    return f'<robot name="r"><link name="a"/><link name="b">{mass}<collision>{shape}</collision></link>{joint}{more}</robot>'.encode()


URDF: tuple[Content, ...] = (
    b"<robot/>", _urdf("mesh.obj"), _urdf("package://pkg/mesh.obj"), _urdf("package://../../../../etc/passwd"), _urdf("package:///etc/passwd"),
    _urdf("file:///etc/passwd"), _urdf("/etc/passwd"), _urdf("../../../../etc/passwd.obj"), _urdf("http://localhost:9/mesh.obj"), _urdf("~/x.obj"),
    _urdf("mesh.obj", '<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>'), _urdf("mesh.obj", "<link name='c'/>"),
    _urdf("mesh.obj").replace(b'"1"', b'"1e300"'), _urdf("mesh.obj").replace(b'"1"', b'"nan"'), _urdf("mesh.obj").replace(b'"1"', b'"__import__"'),
    _urdf("mesh.obj").replace(b'value="1"', b'value="-1"'), _urdf("mesh.obj").replace(b"revolute", b"\xc3\xa9"), _urdf("$(find pkg)/mesh.obj"),
    b'<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>', _urdf("mesh.obj", "<xacro:include filename='/etc/passwd'/>"),
    _urdf("mesh.obj", '<material name="m"><texture filename="/etc/passwd"/></material>'), _urdf("mesh.obj") * 2, _urdf("m.glb"),
    b'<robot name="r">' + b"".join(b'<link name="l%d"/>' % i for i in range(5000)) + b"</robot>",
    _urdf("mesh.obj", '<transmission><plugin filename="evil.so"/></transmission>'), _urdf("mesh.obj", "<gazebo/>" * 5000),
)  # fmt: skip

KINDS = {"mesh.obj": OBJ, "mesh.stl": STL, "mesh.glb": GLB, "model.xml": MJCF, "model.urdf": URDF}


def hostile_files(chance: random.Random) -> tuple[dict[str, Content], dict[str, Any]]:
    """Return files for a case's folder, and a body that uses one of them."""
    name = chance.choice(list(KINDS))
    content = chance.choice(KINDS[name])
    if isinstance(content, bytes) and chance.random() < 0.3 and content:
        at = chance.randrange(len(content))
        content = (
            content[:at]
            + chance.choice((b"", b"\0", b"9", b"-", b"<", b'"', b"\xff\xff"))
            + content[at + chance.randrange(9) :]
        )
    files: dict[str, Content] = {
        "mesh.obj": TETRAHEDRON,
        "m.mtl": b"newmtl a\nmap_Kd ../../../etc/passwd\nmap_Kd /dev/zero\n",
    }
    files[name] = content
    if name.startswith("model"):
        return files, {"kind": "articulated", "file": name, "base": chance.choice(("fixed", "free"))}
    shape = {
        "kind": "mesh",
        "file": name,
        "scale": chance.choice((1, 0.001, 1e6)),
        "collision": chance.choice(("hull", "decompose", "exact")),
    }
    return files, {"kind": "rigid", "shape": shape, "pose": {"pos": [9, 0, 2]}}
