"""Loads one model with MuJoCo from bytes and writes a description of it. `inspection.py` runs it in a child process.

    python inspection_child.py mjcf|urdf FOLDER

FOLDER has `model.xml` and `files/`; `result.json` is written into it.
"""

import json
import math
import sys
from pathlib import Path

MEMORY_LIMIT = 6 * 1024**3
PROCESSOR_LIMIT = 100
MAX_CORNERS = 1000

# Options that the engine sets when it reads a URDF. MuJoCo neither checks inertias here, which `urdf.py` does for the
# links that the engine merges, nor reads visual meshes.
URDF_OPTIONS = (
    '<mujoco><compiler fusestatic="false" strippath="false" inertiafromgeom="false" balanceinertia="true" '
    'discardvisual="true" autolimits="true" boundmass="1e-15" boundinertia="1e-15"/></mujoco></robot>'
)
JOINTS = {0: "free", 1: "ball", 2: "slider", 3: "hinge"}
GEOMS = {0: "plane", 2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box", 7: "mesh"}
# Of MuJoCo's mjtTrn, mjtWrap and mjtBias.
ON_JOINT, ON_TENDON, WRAPS_JOINT, AFFINE = (0, 1), 3, 1, 1


def main(kind: str, folder: Path) -> None:
    """Inspect the model in a folder."""
    limit_resources()
    import mujoco

    text = (folder / "model.xml").read_text("utf-8")
    assets = {path.name: path.read_bytes() for path in (folder / "files").iterdir()}
    if kind == "urdf":
        end = text.rindex("</robot>")
        text = text[:end] + URDF_OPTIONS
    try:
        model = mujoco.MjModel.from_xml_string(text, assets)  # type: ignore[attr-defined]
        found = describe(model)
    except ValueError as error:
        found = {"error": " ".join(str(error).split())}
    (folder / "result.json").write_text(json.dumps(found), "utf-8")


def limit_resources(memory: int = MEMORY_LIMIT, seconds: int = PROCESSOR_LIMIT) -> None:
    """Limit memory [bytes] and processor time [s] of this process, where the system can."""
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    except (ImportError, OSError, ValueError):
        pass


def describe(model) -> dict:
    """Return everything that the compiler needs from a model.

    Raises:
        ValueError: if a number of the compiled model is not finite.
    """
    return {
        "bodies": [
            {
                "name": model.body(i).name,
                "parent": int(model.body_parentid[i]),
                "pos": row(model.body_pos[i]),
                "quat": row(model.body_quat[i]),
                "mass": number(model.body_mass[i]),
            }
            for i in range(model.nbody)
        ],
        "joints": [joint(model, i) for i in range(model.njnt)],
        "geoms": [geom(model, i) for i in range(model.ngeom)],
        "loops": int(model.neq),
        "motors": int(model.nu),
    }


def joint(model, i: int) -> dict:
    """Return a joint, with its motor as the engine reads it."""
    kind = JOINTS[int(model.jnt_type[i])]
    dof = int(model.jnt_dofadr[i])
    limited = bool(model.jnt_limited[i]) and kind in ("hinge", "slider")
    return {
        "name": model.jnt(i).name,
        "kind": kind,
        "body": int(model.jnt_bodyid[i]),
        "axis": row(model.jnt_axis[i]),
        "pos": row(model.jnt_pos[i]),
        "range": row(model.jnt_range[i]) if limited else None,
        "damping": number(model.dof_damping[dof]),
        "friction": number(model.dof_frictionloss[dof]),
        "armature": number(model.dof_armature[dof]),
        "spring": number(model.jnt_stiffness[i]),
        "motor": motor(model, i) if kind in ("hinge", "slider") else None,
    }


def motor(model, i: int) -> dict | None:
    """Return gains and limit of the one motor on a joint, None if there is none or several."""
    mine = [
        k
        for k in range(model.nu)
        if int(model.actuator_trntype[k]) in ON_JOINT and int(model.actuator_trnid[k, 0]) == i
    ]
    if not mine:
        tendons = {
            t
            for t in range(model.ntendon)
            for w in range(int(model.tendon_adr[t]), int(model.tendon_adr[t]) + int(model.tendon_num[t]))
            if int(model.wrap_type[w]) == WRAPS_JOINT and int(model.wrap_objid[w]) == i
        }
        mine = [
            k
            for k in range(model.nu)
            if int(model.actuator_trntype[k]) == ON_TENDON and int(model.actuator_trnid[k, 0]) in tendons
        ]
    if len(mine) != 1:
        return None
    (k,) = mine
    gear = number(model.actuator_gear[k, 0])
    limits = []
    affine = int(model.actuator_biastype[k]) == AFFINE
    if model.actuator_forcelimited[k]:
        limits += row(model.actuator_forcerange[k])
    if model.actuator_ctrllimited[k] and not affine:
        limits += [gear * x for x in row(model.actuator_ctrlrange[k])]
    if model.jnt_actfrclimited[i]:
        limits += row(model.jnt_actfrcrange[i])
    return {
        "stiffness": -gear * number(model.actuator_biasprm[k, 1]) if affine else 0.0,
        "damping": -gear * number(model.actuator_biasprm[k, 2]) if affine else 0.0,
        "limit": min(map(abs, limits)) if limits else None,
    }


def geom(model, i: int) -> dict:
    """Return a geom; a mesh as corners of its convex hull, in the geom's frame.

    Raises:
        ValueError: if the engine has no geom of this type, or it is a plane.
    """
    kind = GEOMS.get(int(model.geom_type[i]))
    name = model.body(int(model.geom_bodyid[i])).name
    if kind is None:
        raise ValueError(f"a geom of `{name}` has a type that the engine does not have")
    if kind == "plane":
        raise ValueError(f"a geom of `{name}` is a plane, which only a static can be; use a box")
    return {
        "kind": kind,
        "body": int(model.geom_bodyid[i]),
        "pos": row(model.geom_pos[i]),
        "quat": row(model.geom_quat[i]),
        "size": row(model.geom_size[i]),
        "touches": bool(model.geom_contype[i] or model.geom_conaffinity[i]),
        "corners": corners(model, int(model.geom_dataid[i])) if kind == "mesh" else [],
    }


def corners(model, mesh: int) -> list[list[float]]:
    """Return vertices of the convex hull of a mesh: all if there are few, else the extreme ones in many directions."""
    import numpy as np

    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    points = model.mesh_vert[first : first + count]
    graph = int(model.mesh_graphadr[mesh])
    if graph >= 0:
        hull = int(model.mesh_graph[graph])
        points = points[model.mesh_graph[graph + 2 + hull : graph + 2 + 2 * hull]]
    if len(points) > MAX_CORNERS:
        # Directions evenly over the sphere, on a golden spiral, and those of the axes.
        k = np.arange(MAX_CORNERS)
        z, turn = 1 - (2 * k + 1) / MAX_CORNERS, math.pi * (3 - math.sqrt(5)) * k
        r = np.sqrt(1 - z**2)
        directions = np.concatenate([np.stack([r * np.cos(turn), r * np.sin(turn), z], 1), np.eye(3), -np.eye(3)])
        points = points[np.unique((points @ directions.T).argmax(axis=0))]
    return [row(point) for point in points]


def row(values) -> list[float]:
    """Return plain finite numbers."""
    return [number(value) for value in values]


def number(value) -> float:
    """Return a plain number.

    Raises:
        ValueError: if it is not finite.
    """
    value = float(value)
    if not math.isfinite(value):
        raise ValueError("the model has a number that is not finite")
    return value


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
