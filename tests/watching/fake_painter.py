"""Speaks the protocol of the painter's process; its films are a few words."""

import json
import os
import sys
import time
from pathlib import Path


def main() -> None:
    """Carry out orders until the input ends."""
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        order = json.loads(line)
        if "cancel" in order:
            continue
        out = Path(order["out"])
        while not (out / "status.json").exists():
            time.sleep(0.01)
        if "film breaks" in (out / "case.yaml").read_text():
            os.abort()
        if not (out / "states").exists():
            print(json.dumps({"order": order["order"], "frames": 0}), flush=True)
            continue
        film = out / "video.mp4"
        film.write_text(f"take {out.name}, {order['width']} wide, {order['colors'].get('ball')}")
        print(json.dumps({"order": order["order"], "camera": "main", "film": str(film)}), flush=True)
        print(json.dumps({"order": order["order"], "frames": 3}), flush=True)


if __name__ == "__main__":
    main()
