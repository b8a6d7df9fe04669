"""The adapter of MuJoCo. That of another engine is one function like `simulate`, see docs/benchmark.md."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.engine_benchmark.mujoco_door import mujoco


def simulate(folder: Path, scene: dict[str, Any], times: list[float], step: float) -> dict[str, NDArray[np.floating]]:
    """Simulate a benchmark; see `trial.Adapter`.

    Args:
        folder: Folder of the benchmark.
        scene: Content of its `benchmark.json`.
        times: Times at which states are wanted [s].
        step: Time step [s].
    """
    mj = mujoco()
    model = mj.MjModel.from_xml_path(str(folder / "scene.xml"))
    model.opt.timestep = step
    data = mj.MjData(model)
    links = [_body(model, row) for row in scene["links"]]
    joints = [_joint(model, row) for row in scene["joints"]]
    for row in scene["initial_joints"]:
        data.qpos[model.joint(f"{row['body']}/{row['joint']}").qposadr[0]] = row["position"]
    for row in scene["initial_velocities"]:
        start = int(model.joint(row["body"]).dofadr[0])
        data.qvel[start : start + 3] = row["linear"]
        turn = np.zeros(3)  # MuJoCo wants it in the body's frame
        mj.mju_rotVecQuat(turn, np.array(row["angular"], float), np.array(_turned_back(data, model, row["body"])))
        data.qvel[start + 3 : start + 6] = turn
    motors = [(model.actuator(f"{row['body']}/{row['joint']}").id, row) for row in scene["controls"]]
    forces = [(model.body(row["mjcf"]).id, row) for row in scene["forces"]]
    made: dict[str, list[Any]] = {name: [] for name in ("pos", "quat", "vel", "ang", "joint_pos", "joint_vel")}
    place, speed = np.array([row["pos"] for row in scene["links"]], float), np.zeros(6)
    turned = np.array([row["quat"] for row in scene["links"]], float)
    frame, count = 0, round(times[-1] / step)
    for k in range(count + 1):
        mj.mj_forward(model, data)
        if frame < len(times) and k * step >= times[frame] - step / 2:
            pos, quat, vel, ang = place.copy(), turned.copy(), np.zeros_like(place), np.zeros_like(place)
            for row, body in enumerate(links):
                if body is not None:
                    pos[row], quat[row] = data.xpos[body], data.xquat[body]
                    mj.mj_objectVelocity(model, data, mj.mjtObj.mjOBJ_BODY, body, speed, 0)
                    ang[row], vel[row] = speed[:3], speed[3:]
            made["joint_pos"].append([0.0 if j is None else data.qpos[model.jnt_qposadr[j]] for j in joints])
            made["joint_vel"].append([0.0 if j is None else data.qvel[model.jnt_dofadr[j]] for j in joints])
            for name, values in (("pos", pos), ("quat", quat), ("vel", vel), ("ang", ang)):
                made[name].append(values)
            frame += 1
        for motor, row in motors:
            data.ctrl[motor] = _control(row, (k + 1) * step)
        data.xfrc_applied[:] = 0.0
        for body, row in forces:
            if row["start"] - 1e-9 <= k * step < row["end"] - 1e-9:
                data.xfrc_applied[body] += [*row["force"], *row["torque"]]
        mj.mj_step(model, data)
    return {name: np.array(values) for name, values in made.items()}


def _control(row: dict[str, Any], t: float) -> float:
    """What pushes a motor: stiffness x target + damping x its speed; what `scene.xml` takes off is in the motor."""
    target = _target(row, t)
    if row["mode"] == "force":
        return target
    if row["mode"] == "velocity":
        return row["damping"] * target
    return row["stiffness"] * target + row["damping"] * (target - _target(row, t - row["every"])) / row["every"]


def _target(row: dict[str, Any], t: float) -> float:
    """The target at a time [s], between the rows of the table on a straight line."""
    k, part = divmod(max(t / row["every"], 0.0), 1.0)
    first, then = (row["targets"][min(int(k) + more, len(row["targets"]) - 1)] for more in (0, 1))
    return first + part * (then - first)


def _body(model: Any, row: dict[str, Any]) -> int | None:
    return None if row["fixed"] else model.body(row["mjcf"]).id


def _joint(model: Any, row: dict[str, Any]) -> int | None:
    return model.joint(f"{row['body']}/{row['joint']}").id if row["kind"] in ("hinge", "slider") else None


def _turned_back(data: Any, model: Any, body: str) -> Any:
    start = int(model.joint(body).qposadr[0])
    w, x, y, z = data.qpos[start + 3 : start + 7]
    return w, -x, -y, -z
