"""An engine process that speaks the protocol without simulating; the prompt of the case selects its behaviour."""

import json
import os
import queue
import sys
import threading
import time
from pathlib import Path

import numpy as np
import yaml

DT = 0.01


def record(out: Path, case: dict, *, frames: int) -> None:
    """Write a recording of one ball in free fall above a floor."""
    states, geometry = out / "states", out / "geometry"
    states.mkdir(exist_ok=True)
    geometry.mkdir(exist_ok=True)
    inertia = np.eye(3).tolist()
    links = [
        {"body": name, "link": f"{name}_baselink", "mass": 1.0, "com": [0, 0, 0], "inertia": inertia, "fixed": fixed}
        for name, fixed in (("floor", True), ("ball", False))
    ]
    layout = {"dt": DT, "every": 1, "gravity": [0, 0, -9.81], "links": links, "joints": []}
    (states / "layout.json").write_text(json.dumps(layout))
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    np.savez(geometry / "ball.npz", vertices=corners, faces=faces)
    piece = {"mesh": "ball.npz", "pos": [0, 0, 0], "quat": [1, 0, 0, 0], "color": [1.0, 0.0, 0.0, 1.0]}
    (geometry / "index.json").write_text(json.dumps({"1": [piece]}))
    time_ = np.arange(frames) * DT
    pos = np.zeros((frames, 2, 3), np.float32)
    pos[:, 1, 2] = case["bodies"]["ball"]["pose"]["pos"][2] - 4.9 * time_**2
    quat = np.tile(np.float32([1, 0, 0, 0]), (frames, 2, 1))
    zero, none = np.zeros((frames, 2, 3), np.float32), np.zeros((frames, 0), np.float32)
    np.savez(
        states / "chunk_00000.npz", time=time_, links_pos=pos, links_quat=quat, links_vel=zero, links_ang=zero,
        qpos=none, dofs_velocity=none, dofs_control_force=none,
        contact_step=np.zeros(0, np.int32), contact_links=np.zeros((0, 2), np.int32),
        contact_force=np.zeros((0, 3), np.float32), contact_pos=np.zeros((0, 3), np.float32),
        contact_penetration=np.zeros(0, np.float32), contact_normal_force=np.zeros(0, np.float32),
        contact_count=np.zeros(0, np.int32),
    )  # fmt: skip


def main() -> None:
    """Carry out orders until the input ends."""
    orders: queue.Queue[dict | None] = queue.Queue()
    cancelled: set[int] = set()

    def listen() -> None:
        for line in sys.stdin:
            order = json.loads(line)
            if "cancel" in order:
                cancelled.add(order["cancel"])
            else:
                orders.put(order)
        orders.put(None)

    def tell(**news: object) -> None:
        print(json.dumps(news), flush=True)

    threading.Thread(target=listen, daemon=True).start()
    if Path("does_not_start").exists():
        print("Traceback (most recent call last):\nImportError: no engine here", file=sys.stderr)
        sys.exit(1)
    tell(ready=True, memory=1_000_000)
    while (order := orders.get()) is not None:
        number, out = order["order"], Path(order["out"])
        case = yaml.safe_load((out / "case.yaml").read_text())
        wish = case["prompt"]
        tell(order=number, phase="build")
        tell(order=number, phase="simulate")
        answer = {"state": "finished"}
        if "crashes" in wish:
            os.abort()
        if "hangs" in wish:
            time.sleep(3600)
        begun = time.monotonic()
        while "slow" in wish and number not in cancelled and time.monotonic() - begun < 30:
            time.sleep(0.01)
        if number in cancelled:
            answer = {"state": "interrupted", "message": "stopped from outside"}
        if "diverges" in wish:
            where = {"body": "ball", "quantity": "speed", "time": 0.05}
            answer = {"state": "diverged", "message": "diverged at t = 0.05 s", "where": where}
        if "fails" in wish:
            answer = {"state": "failed", "message": "GenesisException: no", "traceback": _traceback(order["program"])}
        else:
            record(out, case, frames=round(case["scene"]["duration"] / DT) + 1)
        (out / "status.json").write_text(json.dumps(answer))
        tell(order=number, **answer)
        tell(memory=9_000_000_000 if "grows" in wish else 1_000_000)


def _traceback(program: str) -> str:
    """One that ends in the line of the program that adds the ball."""
    path = Path(program) / "bodies.py"
    line = next(i for i, text in enumerate(path.read_text().splitlines(), 1) if "scene.add_entity" in text)
    return f'Traceback (most recent call last):\n  File "{path}", line {line}, in add_ball\nGenesisException: no\n'


if __name__ == "__main__":
    main()
