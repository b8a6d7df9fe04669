"""Writes the collision shapes of rigid bodies, which may differ from what is drawn.

    OUT/geometry/solids.json   link -> solids: kind, pose in the link's frame, size [m] or mesh in geometry/<hash>.npz,
                               and the part of a compound

Sizes: box: full lengths; sphere: radius; cylinder: radius, height; capsule: radius, length of the straight part.
Cylinders and capsules lie along z.
"""

from pathlib import Path
from types import SimpleNamespace

import genesis as gs
import numpy as np
from contacts import part_of
from files import write_json, write_mesh
from recorder import multiply, rotate

PRIMITIVES = {
    gs.GEOM_TYPE.BOX: "box",
    gs.GEOM_TYPE.SPHERE: "sphere",
    gs.GEOM_TYPE.CYLINDER: "cylinder",
    gs.GEOM_TYPE.CAPSULE: "capsule",
    gs.GEOM_TYPE.PLANE: "plane",
}


def write_solids(solver, offsets: np.ndarray, folder: Path) -> None:
    """Writes the collision shapes of every rigid link of a built scene.

    Args:
        solver: The engine's solver of rigid bodies.
        offsets: Pose of each link's solver frame in its authored frame, shape (L, 7).
        folder: Folder of the geometry.
    """
    index: dict[int, list[dict]] = {}
    for geom in solver.geoms if solver.is_active else ():
        pos, quat = offsets[geom.link.idx, :3], offsets[geom.link.idx, 3:]
        row = {
            "kind": PRIMITIVES.get(geom.type, "mesh"),
            "pos": (pos + rotate(quat, np.asarray(geom.init_pos, float))).tolist(),
            "quat": multiply(quat, np.asarray(geom.init_quat, float)).tolist(),
        }
        if row["kind"] == "mesh":
            shape = SimpleNamespace(verts=geom.init_verts, faces=geom.init_faces, normals=None, uvs=None)
            row["mesh"] = write_mesh(folder, shape)
        else:
            row["size"] = _size(row["kind"], np.asarray(geom.init_verts, float))
        if part := part_of(geom):
            row["part"] = part
        index.setdefault(geom.link.idx, []).append(row)
    write_json(folder / "solids.json", index)


def _size(kind: str, vertices: np.ndarray) -> list[float]:
    """Returns the size of a primitive [m], from the vertices of the engine's mesh, which lie on its surface."""
    x, y, z = np.abs(vertices).max(axis=0).tolist()
    around = float(np.hypot(vertices[:, 0], vertices[:, 1]).max())
    return {
        "box": [2 * x, 2 * y, 2 * z],
        "sphere": [float(np.linalg.norm(vertices, axis=1).max())],
        "cylinder": [around, 2 * z],
        "capsule": [around, 2 * (z - around)],
        "plane": [],
    }[kind]
