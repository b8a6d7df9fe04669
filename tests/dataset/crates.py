"""Hand-written runs: a crate that slides and turns, a ball behind it, a floor."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.dataset.item import Item
from text2sim.recording.record import RunRecord

Take = Callable[..., Item]
BOX = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
FACES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
])  # fmt: skip
HALF = {"floor": (4.0, 4.0, 0.1), "crate": (0.3, 0.2, 0.2), "ball": (0.15, 0.15, 0.15)}
COLOR = {"floor": (0.5, 0.5, 0.5), "crate": (0.8, 0.3, 0.2), "ball": (0.2, 0.4, 0.8)}
FRAMES = 9
CASE = """
text2sim: 2
name: {name}
prompt: A crate slides.
scene: {{duration: 0.8, statics: {{floor: {{shape: {{kind: plane, size: 8}}}}}}}}
bodies:
  crate: {{kind: rigid, shape: {{kind: box, size: [0.6, 0.4, 0.4]}}, pose: {{pos: [0, 0, 0.3]}}}}
  ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.15}}, pose: {{pos: [0, 1, 0.3]}}}}
render: {{cameras: {{main: {{kind: still, from: [0, -4, 2], look_at: [0, 0, 0.4]}}}}}}
"""
RECIPE = """
text2sim_dataset: 1
name: made_by_hand
licence: cc0-1.0
film: {quality: preview, size: [64, 36], fps: 10}
annotations: [cameras, depth, normals, instances, parts, flow, boxes, keypoints, contacts, visibility]
sources:
  one: {cases: [a], split: train}
  two: {cases: [b], split: test}
"""


def places(speed: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (F,), positions (F, 3, 3) and orientations (F, 3, 4) of floor, crate and ball."""
    time = np.linspace(0, 0.8, FRAMES)
    pos = np.zeros((FRAMES, 3, 3))
    pos[:, 0] = (0, 0, -0.1)
    pos[:, 1] = np.outer(time, (speed, 0.3 * speed, 0)) + (-0.6, 0, 0.3)
    pos[:, 2] = (0.3, 1.0, 0.3)
    quat = np.zeros((FRAMES, 3, 4))
    quat[..., 0] = 1
    quat[:, 1] = np.column_stack([np.cos(time), 0 * time, 0 * time, np.sin(time)])
    return time, pos, quat


def write_run(folder: Path, speed: float = 1.0, **evidence: Any) -> Path:
    """Write a run folder, as the harness leaves one."""
    for part in ("states", "geometry", "program"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    time, pos, quat = places(speed)
    index, links = {}, []
    for k, name in enumerate(HALF):
        np.savez(folder / "geometry" / f"{name}.npz", vertices=BOX * HALF[name], faces=FACES)
        index[k] = [{"mesh": f"{name}.npz", "pos": [0, 0, 0], "quat": [1, 0, 0, 0], "color": [*COLOR[name], 1.0]}]
        inertia = np.eye(3).tolist()
        links.append(
            {"body": name, "link": name, "mass": 1.0, "com": [0, 0, 0], "inertia": inertia, "fixed": name == "floor"}
        )
    layout = {"dt": 0.1, "every": 1, "gravity": [0, 0, -9.81], "links": links, "joints": [], "n_frames": FRAMES}
    nothing = np.zeros((FRAMES, 3, 3), np.float32)
    moving = nothing.copy()
    moving[:, 1, 0] = evidence.pop("goes", 0.0)
    np.savez(
        folder / "states" / "chunk_00000.npz",
        time=time, links_pos=pos.astype(np.float32), links_quat=quat.astype(np.float32), links_vel=moving,
        links_ang=nothing, qpos=np.zeros((FRAMES, 0), np.float32), dofs_velocity=np.zeros((FRAMES, 0), np.float32),
        dofs_control_force=np.zeros((FRAMES, 0), np.float32), contact_step=np.array([3, 3], np.int64),
        contact_links=np.array([[0, 1], [1, 2]]), contact_force=np.float32([[0, 0, 5], [1, 0, 0]]),
        contact_pos=np.float32([[0, -0.2, 0.1], [0.2, 0, 0.3]]), contact_penetration=np.float32([1e-4, 1e-4]),
        contact_normal_force=np.float32([5, 1]),
    )  # fmt: skip
    looks = {
        name: {"color": COLOR[name], "opacity": 1.0, "finish": "rough", "visible": True, "picture": None}
        for name in HALF
    }
    film = {
        "resolution": (64, 36), "fps": 10.0, "speed": 1.0, "start": 0.0, "end": 0.8, "motion_blur": 0.5,
        "cameras": {"main": {"kind": "dolly", "up": (0, 0, 1), "fov": 40.0, "pos": (0.0, -4.0, 2.0),
                             "to": (0.4, -3.8, 2.0), "look_at": (0, 0, 0.4), "f_stop": 4.0}},
        "shots": [], "background": (0.8, 0.8, 0.8), "ambient": 0.3, "lights": {}, "gain": 1.0, "tone": "agx",
        "backdrop": {"kind": "none", "level": 0.0, "center": (0, 0, 0), "radius": 5.0, "planes": []},
        "overlay": {"title": "never", "time": True, "values": [], "inset": False},
    }  # fmt: skip
    (folder / "states" / "layout.json").write_text(json.dumps(layout))
    (folder / "geometry" / "index.json").write_text(json.dumps(index))
    (folder / "program" / "looks.json").write_text(json.dumps(looks))
    (folder / "program" / "render.py").write_text("".join(f"{k.upper()} = {v!r}\n" for k, v in film.items()))
    (folder / "expanded.yaml").write_text(CASE.format(name=folder.name))
    found = {
        "verdict": "passed", "state": "finished", "expect": {}, "measures": {}, "events": {}, "time": {"reached": 0.8},
        "contacts": {"recorded": True}, "penetration": {"value": 1e-4}, "energy": None, "suspicions": [],
    }  # fmt: skip
    (folder / "evidence.json").write_text(json.dumps(found | evidence))
    RunRecord(folder.name, "finished", {"sim_digest": folder.name + str(speed)}, versions={"python": "3"}).write(folder)
    return folder
