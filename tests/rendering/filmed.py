"""A box, a plain film section."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

BOX = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
BOX_FACES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
])  # fmt: skip
FILM: dict[str, Any] = {
    "resolution": (64, 36),
    "fps": 10.0,
    "speed": 1.0,
    "start": 0.0,
    "end": 0.4,
    "motion_blur": 0.0,
    "cameras": {
        "main": {"kind": "still", "up": (0, 0, 1), "fov": 40.0, "pos": (0.0, -4.0, 2.0), "look_at": (0, 0, 0.4)}
    },
    "shots": [],
    "background": (0.8, 0.8, 0.8),
    "ambient": 0.3,
    "lights": {"dome": {"kind": "environment", "strength": 1.0, "color": (1, 1, 1), "horizon": (1, 1, 1)}},
    "gain": 1.0,
    "tone": "agx",
    "backdrop": {"kind": "none", "level": 0.0, "center": (0, 0, 0), "radius": 5.0, "planes": []},
    "overlay": {"title": None, "time": False, "values": [], "inset": False},
}
MakeRun = Callable[..., Path]
