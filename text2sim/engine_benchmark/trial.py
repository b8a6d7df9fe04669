"""Runs a benchmark in an engine, as a process: `python -m …trial ENGINE FOLDER OUT STEP`."""

import importlib
import json
import resource
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

ENGINES = {"mujoco": "text2sim.engine_benchmark.mujoco_engine:simulate"}
Adapter = Callable[[Path, dict[str, Any], list[float], float], dict[str, NDArray[np.floating]]]
"""Simulates a benchmark.

Args: the folder; the content of its `benchmark.json`; the times [s] of the wanted states; the time step [s].

Returns, for each of these times (F) and each of the L links and J joints in the order of `benchmark.json`:
`pos` (F, L, 3) [m] and `quat` (F, L, 4) (w, x, y, z) of the link's frame; `vel` (F, L, 3) [m/s] of its centre of mass;
`ang` (F, L, 3) [rad/s] in the world frame; `joint_pos` (F, J) [rad or m] and `joint_vel` (F, J) [rad/s or m/s] of
hinges and sliders.
"""


def adapter_of(engine: str) -> Adapter:
    """Return the adapter of an engine: `mujoco`, or `MODULE:FUNCTION`."""
    module, _, name = ENGINES.get(engine, engine).partition(":")
    return getattr(importlib.import_module(module), name)


def main() -> None:
    """Simulate, and write the states in the form of a recording."""
    engine, folder, out, step = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]), float(sys.argv[4])
    scene = json.loads((folder / "benchmark.json").read_text("utf-8"))
    adapter, begun = adapter_of(engine), perf_counter()
    states = adapter(folder, scene, scene["times"], step)
    seconds = perf_counter() - begun
    links, joints = (len(scene["links"]),), (len(scene["joints"]),)
    shapes = {"pos": (*links, 3), "quat": (*links, 4), "vel": (*links, 3), "ang": (*links, 3)}
    for name, shape in (shapes | {"joint_pos": joints, "joint_vel": joints}).items():
        wanted = (len(scene["times"]), *shape)
        if np.shape(states[name]) != wanted:
            sys.exit(f"the adapter's `{name}` has the shape {np.shape(states[name])}, not {wanted}")
    _write_states(out, scene, states)
    unit = 1 if sys.platform == "darwin" else 1024
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
    (out / "trial.json").write_text(json.dumps({"seconds": seconds, "memory": memory}))


def _write_states(out: Path, scene: dict[str, Any], states: dict[str, Any]) -> None:
    """Write states in the form of a recording, so that measures are evaluated as for any run."""
    (out / "states").mkdir(parents=True, exist_ok=True)
    (out / "geometry").mkdir(exist_ok=True)
    (out / "geometry/index.json").write_text("{}")
    layout = scene["layout"]
    (out / "states/layout.json").write_text(json.dumps(layout))
    frames, last = len(scene["times"]), layout["joints"][-1] if layout["joints"] else {"q": [0, 0], "dofs": [0, 0]}
    qpos, speeds = np.zeros((frames, last["q"][1])), np.zeros((frames, last["dofs"][1]))
    for k, row in enumerate(layout["joints"]):
        if row["kind"] in ("hinge", "slider"):
            qpos[:, row["q"][0]], speeds[:, row["dofs"][0]] = states["joint_pos"][:, k], states["joint_vel"][:, k]
    none = {
        "contact_step": np.zeros(0, np.int32), "contact_links": np.zeros((0, 2), np.int32),
        "contact_force": np.zeros((0, 3)), "contact_pos": np.zeros((0, 3)),
        "contact_penetration": np.zeros(0), "contact_normal_force": np.zeros(0), "contact_count": np.zeros(0, np.int32),
    }  # fmt: skip
    np.savez(
        out / "states/chunk_00000.npz", time=np.array(scene["times"]), links_pos=states["pos"],
        links_quat=states["quat"], links_vel=states["vel"], links_ang=states["ang"], qpos=qpos, dofs_velocity=speeds,
        dofs_control_force=np.zeros_like(speeds), **none,
    )  # fmt: skip


if __name__ == "__main__":
    main()
