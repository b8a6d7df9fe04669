"""Adapter of MuJoCo; an adapter of another engine is a function like `simulate`, see docs/benchmark.md."""

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
        times: Times of the wanted states [s].
        step: Time step [s].
    """
    mj = mujoco()
    model = mj.MjModel.from_xml_path(str(folder / "scene.xml"))
    model.opt.timestep = step
    data = mj.MjData(model)
    _set_start(model, data, scene)
    motors = [(model.actuator(f"{row['body']}/{row['joint']}").id, row) for row in scene["controls"]]
    forces = [(model.body(row["mjcf"]).id, row) for row in scene["forces"]]
    recorder = _Recorder(model, scene)
    frame, count = 0, round(times[-1] / step)
    for k in range(count + 1):
        mj.mj_forward(model, data)
        if frame < len(times) and k * step >= times[frame] - step / 2:
            recorder.record(data)
            frame += 1
        for motor, row in motors:
            data.ctrl[motor] = _control(row, (k + 1) * step)
        data.xfrc_applied[:] = 0.0
        for body, row in forces:
            if row["start"] - 1e-9 <= k * step < row["end"] - 1e-9:
                data.xfrc_applied[body] += [*row["force"], *row["torque"]]
        mj.mj_step(model, data)
    return {name: np.array(values) for name, values in recorder.states.items()}


def _set_start(model: Any, data: Any, scene: dict[str, Any]) -> None:
    for row in scene["initial_joints"]:
        data.qpos[model.joint(f"{row['body']}/{row['joint']}").qposadr[0]] = row["position"]
    for row in scene["initial_joint_velocities"]:
        data.qvel[model.joint(f"{row['body']}/{row['joint']}").dofadr[0]] = row["velocity"]
    for row in scene["initial_velocities"]:
        joint = model.joint(row["body"])
        start, pose = int(joint.dofadr[0]), int(joint.qposadr[0])
        data.qvel[start : start + 3] = row["linear"]
        w, x, y, z = data.qpos[pose + 3 : pose + 7]
        angular = np.zeros(3)  # in the body's frame
        mujoco().mju_rotVecQuat(angular, np.array(row["angular"], float), np.array((w, -x, -y, -z)))
        data.qvel[start + 3 : start + 6] = angular


class _Recorder:
    """Collects the states that an adapter returns."""

    def __init__(self, model: Any, scene: dict[str, Any]) -> None:
        self._model, self._rows = model, scene["links"]
        self._links = [None if row["fixed"] else model.body(row["mjcf"]).id for row in scene["links"]]
        self._joints = [_joint(model, row) for row in scene["joints"]]
        self.states: dict[str, list[Any]] = {n: [] for n in ("pos", "quat", "vel", "ang", "joint_pos", "joint_vel")}

    def record(self, data: Any) -> None:
        """Add the current state."""
        mj, model, speed = mujoco(), self._model, np.zeros(6)
        pos = np.array([row["pos"] for row in self._rows], float)
        quat = np.array([row["quat"] for row in self._rows], float)
        vel, ang = np.zeros_like(pos), np.zeros_like(pos)
        for row, body in enumerate(self._links):
            if body is not None:
                pos[row], quat[row] = data.xpos[body], data.xquat[body]
                mj.mj_objectVelocity(model, data, mj.mjtObj.mjOBJ_BODY, body, speed, 0)
                ang[row], vel[row] = speed[:3], speed[3:]
        joint_pos = [0.0 if j is None else data.qpos[model.jnt_qposadr[j]] for j in self._joints]
        joint_vel = [0.0 if j is None else data.qvel[model.jnt_dofadr[j]] for j in self._joints]
        for name, values in zip(self.states, (pos, quat, vel, ang, joint_pos, joint_vel), strict=True):
            self.states[name].append(values)


def _control(row: dict[str, Any], t: float) -> float:
    """The `ctrl` of a motor; the feedback of position and velocity is part of the motor in `scene.xml`."""
    target = _target(row, t)
    if row["mode"] == "force":
        return target
    if row["mode"] == "velocity":
        return row["damping"] * target
    return row["stiffness"] * target + row["damping"] * (target - _target(row, t - row["every"])) / row["every"]


def _target(row: dict[str, Any], t: float) -> float:
    """The target at a time [s], interpolated linearly in its table."""
    k, part = divmod(max(t / row["every"], 0.0), 1.0)
    first, then = (row["targets"][min(int(k) + more, len(row["targets"]) - 1)] for more in (0, 1))
    return first + part * (then - first)


def _joint(model: Any, row: dict[str, Any]) -> int | None:
    return model.joint(f"{row['body']}/{row['joint']}").id if row["kind"] in ("hinge", "slider") else None
