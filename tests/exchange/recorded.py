"""A hand-written run in the recorder's format: boxes, an arm of two links, a cloth, grains."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

BOX = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32)
BOX_FACES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
])  # fmt: skip
FRAMES, DT = 6, 0.02
SIDE = 4
"""Vertices along each side of the cloth."""
LIGHTS: dict[str, Any] = {
    "sun": {"kind": "sun", "strength": 3.0, "color": (1, 1, 1), "direction": (0, 0, -1), "angle": 0.01},
    "key": {"kind": "softbox", "strength": 2.0, "color": (1, 0.9, 0.8), "direction": (1, 0, -1), "at": (0, 0, 0.5),
            "distance": 4.0, "size": 2.0},
    "bulb": {"kind": "lamp", "strength": 5.0, "color": (1, 1, 1), "pos": (0, 1, 2), "radius": 0.1},
    "spot": {"kind": "spot", "strength": 5.0, "color": (1, 1, 1), "pos": (0, -1, 2), "look_at": (0, 0, 0),
             "angle": 0.8, "blur": 0.2},
    "fill": {"kind": "environment", "strength": 0.5, "color": (1, 1, 1), "horizon": (0.5, 0.5, 0.5)},
}  # fmt: skip
FILM: dict[str, Any] = {
    "resolution": (64, 36), "fps": 25.0, "speed": 1.0, "start": 0.0, "end": 0.1, "motion_blur": 0.0,
    "cameras": {
        "main": {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0.0, -4.0, 2.0), "look_at": (0, 0, 0.4)},
        "round": {"kind": "orbit", "up": (0, 0, 1), "fov": 30.0, "look_at": (0, 0, 0.5), "radius": 3.0, "height": 1.0,
                  "start": 0.0, "turn": 1.5, "f_stop": 2.8},
    },
    "shots": [], "background": (0.8, 0.8, 0.8), "ambient": 0.3, "lights": LIGHTS, "gain": 0.8, "tone": "agx",
    "backdrop": {"kind": "none", "level": 0.0, "center": (0, 0, 0), "radius": 5.0, "planes": []},
    "overlay": {"title": None, "time": False, "values": [], "inset": False},
}  # fmt: skip
LINKS = [
    # body, link, mass, where its mesh is in it, half sizes, colour
    ("floor", "floor", 0.0, (0, 0, -0.1), (2.0, 2.0, 0.1), (0.6, 0.6, 0.6)),
    ("box[0]", "box", 2.0, (0, 0, 0), (0.1, 0.1, 0.1), (0.8, 0.1, 0.1)),
    ("box[1]", "box", 2.0, (0, 0, 0), (0.1, 0.1, 0.1), (0.1, 0.1, 0.8)),
    ("arm", "upper", 1.0, (0, 0, 0.2), (0.03, 0.03, 0.2), (0.2, 0.7, 0.2)),
    ("arm", "lower", 1.0, (0, 0, 0.2), (0.02, 0.02, 0.2), (0.2, 0.7, 0.2)),
]


def write_run(folder: Path, *, cloth: bool = True, grains: bool = True, frames: int = FRAMES) -> Path:
    """Write the run into a folder."""
    for part in ("states", "geometry", "program"):
        (folder / part).mkdir(parents=True)
    time = np.arange(frames) * DT
    rows, index = [], {}
    for k, (body, link, mass, pos, half, color) in enumerate(LINKS):
        mesh = f"mesh_{'_'.join(map(str, half))}.npz"
        np.savez(folder / "geometry" / mesh, vertices=BOX * np.float32(half), faces=BOX_FACES)
        index[str(k)] = [{"mesh": mesh, "pos": pos, "quat": (1, 0, 0, 0), "color": (*color, 1.0)}]
        rows.append({"body": body, "link": link, "mass": mass, "com": (0, 0, 0), "fixed": body == "floor",
                     "inertia": np.eye(3).tolist()})  # fmt: skip
    pos, quat = np.zeros((frames, len(LINKS), 3), np.float32), np.zeros((frames, len(LINKS), 4), np.float32)
    pos[:, 1] = np.stack([0 * time - 0.5, 2 * time, 1 - 4.9 * time**2], axis=1)
    pos[:, 2] = (0.5, 0, 0.1)  # it lies still
    pos[:, 3:] = (0, 0.5, 0.1)
    half_turn = np.pi * time / time[-1] * 0.9
    quat[..., 0] = 1
    quat[:, 1] = np.stack([np.cos(half_turn), np.sin(half_turn), 0 * time, 0 * time], axis=1)
    quat[frames // 2 :, 1] *= -1  # the same orientation: an engine may change sides
    quat[:, 4] = np.stack([np.cos(time), 0 * time, np.sin(time), 0 * time], axis=1)
    layout: dict[str, Any] = {"dt": DT, "every": 1, "duration": DT * (frames - 1), "n_frames": frames,
                              "gravity": [0, 0, -9.81], "links": rows, "joints": [], "deformables": []}  # fmt: skip
    arrays: dict[str, Any] = {"time": time, "qpos": np.zeros((frames, 0), np.float32), "links_pos": pos}
    arrays |= {"links_quat": quat, "links_vel": pos * 0, "links_ang": pos * 0}
    arrays |= {"dofs_velocity": arrays["qpos"], "dofs_control_force": arrays["qpos"]}
    arrays |= {
        "contact_step": np.array([2, 2, 4], np.int32), "contact_links": np.array([[0, 1], [0, 2], [1, 2]], np.int32),
        "contact_force": np.float32([[0, 0, 9], [0, 0, 20], [0, 0, 1]]), "contact_normal_force": np.float32([9, 20, 1]),
        "contact_pos": np.float32([[-0.5, 0, 0], [0.5, 0, 0], [0, 0, 0.3]]),
        "contact_penetration": np.float32([1e-4, 1e-4, 1e-4]), "contact_count": np.ones(3, np.int32),
    }  # fmt: skip
    _add_soft(folder, layout, arrays, cloth=cloth, grains=grains)
    np.savez(folder / "states" / "chunk_00000.npz", **arrays)
    (folder / "states" / "layout.json").write_text(json.dumps(layout))
    (folder / "geometry" / "index.json").write_text(json.dumps(index))
    looks = {body: {"color": color, "opacity": 1.0, "finish": "painted", "visible": True, "picture": None}
             for body, *_, color in LINKS}  # fmt: skip
    (folder / "program" / "looks.json").write_text(json.dumps(looks))
    text = "".join(f"{key.upper()} = {value!r}\n" for key, value in FILM.items())
    (folder / "program" / "render.py").write_text(text)
    return folder


def cloth_points(frames: int = FRAMES) -> np.ndarray:
    """Vertices of the cloth, shape (F, SIDE^2, 3): a sheet that bends upwards in its middle."""
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-0.3, 0.3, SIDE)] * 2, indexing="ij"))
    rise = np.arange(frames)[:, None] * 0.02 * (1 - (x**2 + y**2) * 4)
    return np.stack([np.broadcast_to(x, rise.shape), np.broadcast_to(y, rise.shape), 1.2 + rise], axis=2)


def _add_soft(folder: Path, layout: dict, arrays: dict, *, cloth: bool, grains: bool) -> None:
    frames, painted = len(arrays["time"]), []
    points, surface = [np.zeros((frames, 0, 3))], [np.zeros((frames, 0, 3))]
    if cloth:
        k = np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)
        faces = np.stack([k, k + SIDE, k + 1, k + 1, k + SIDE, k + SIDE + 1], axis=-1).reshape(-1, 3)
        sheet = cloth_points(frames)
        uvs = (sheet[0, :, :2] + 0.3) / 0.6
        np.savez(folder / "geometry" / "soft_0.npz", faces=faces, uvs=uvs)
        Image.fromarray(np.uint8([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 0]]])).save(
            folder / "geometry" / "check.png"
        )
        layout["deformables"].append({"body": "sheet", "kind": "cloth", "solver": "pbd", "spacing": 0.2,
                                      "points": [0, SIDE**2], "surface": [0, SIDE**2], "mass": 0.1})  # fmt: skip
        painted.append({"color": (1, 1, 1, 1), "texture": "check.png"})
        points.append(sheet)
        surface.append(sheet)
    if grains:
        first = points[-1].shape[1]
        heap = np.random.default_rng(1).uniform(-0.2, 0.2, (7, 3)) + (0, 0, 0.3)
        fallen = heap - np.linspace(0, 0.1, frames)[:, None, None] * (0, 0, 1)
        np.savez(folder / "geometry" / f"soft_{len(painted)}.npz", rest=heap)
        layout["deformables"].append({"body": "sand", "kind": "granular", "solver": "mpm", "spacing": 0.02,
                                      "points": [first, first + 7], "surface": None, "mass": 0.1})  # fmt: skip
        painted.append({"color": (0.8, 0.7, 0.4, 1)})
        points.append(fallen)
    if painted:
        (folder / "geometry" / "soft_index.json").write_text(json.dumps(painted))
        arrays["soft_velocity"] = arrays["soft_spin"] = np.zeros((frames, len(painted), 3), np.float32)
        arrays["soft_kinetic"] = arrays["soft_speed"] = np.zeros((frames, len(painted)), np.float32)
        arrays["soft_points"] = np.concatenate(points, axis=1).astype(np.float32)
        arrays["soft_surface"] = np.concatenate(surface, axis=1).astype(np.float32)
