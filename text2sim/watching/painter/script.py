"""What a program says about its film: its `render.py`, read without the engine.

The module makes options and cameras of the engine. Here the engine is a stand-in that only takes notes of what it is
asked for, so that the cameras of a preview move exactly as those of the film.
"""

import sys
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np


@dataclass
class Noted:
    """Something that the engine was asked to make."""

    what: str
    options: dict[str, Any] = field(default_factory=dict)


class Engine:
    """Stands in for the engine's module and all that is in it."""

    def __init__(self, name: str = "genesis") -> None:
        self._name = name

    def __getattr__(self, name: str) -> "Engine":
        if name.startswith("__"):
            raise AttributeError(name)
        return Engine(f"{self._name}.{name}")

    def __call__(self, **options: Any) -> Noted:
        """Take note of something that is made."""
        return Noted(self._name.rpartition(".")[2], options)


class Script:
    """Cameras, lights and cadence of a program."""

    def __init__(self, text: str) -> None:
        module = ModuleType("render")
        before = sys.modules.get("genesis")
        sys.modules["genesis"] = Engine()  # type: ignore[assignment]
        try:
            exec(compile(text, "render.py", "exec"), module.__dict__)
            options = module.vis_options().options
            self.cameras: dict[str, dict[str, Any]] = module.add_cameras(self)
        finally:
            if before is None:
                del sys.modules["genesis"]
            else:
                sys.modules["genesis"] = before
        self.resolution: tuple[int, int] = module.RESOLUTION
        self.fps, self.speed = float(module.FPS), float(module.SPEED)
        self.start, self.end = float(module.START), float(module.END)
        self.background, self.ambient = options["background_color"], options["ambient_light"]
        self.lights = [_light(note) for note in options["lights"]]
        self.camera_pose = module.camera_pose

    def add_camera(self, **options: Any) -> dict[str, Any]:
        """Take note of a camera: `fov` [deg], `near` and `far` [m]."""
        return options

    def frames(self, last: float) -> int:
        """How many pictures the film has if the recording ends at `last` [s]."""
        return max(1, round((min(self.end, last) - self.start) / self.speed * self.fps))

    def moment(self, frame: int) -> float:
        """Simulated time of a picture [s]."""
        return self.start + frame * self.speed / self.fps


def _light(note: Noted) -> tuple[tuple[float, ...], tuple[float, ...]]:
    options = note.options
    color = tuple(options["intensity"] * part for part in options["color"])
    if "pos" in options:
        return (*options["pos"], 1.0), color
    way = np.array(options["dir"], float)
    return (*(way / np.linalg.norm(way)).tolist(), 0.0), color


def projection(pos: Any, look_at: Any, up: Any, camera: dict[str, Any], aspect: float) -> np.ndarray:
    """Return the matrix from the world to the picture, shape (4, 4).

    Args:
        pos: Where the camera stands [m].
        look_at: What is in the middle [m].
        up: What is upwards in the picture.
        camera: `fov` [deg], `near` and `far` [m].
        aspect: Width of the picture over its height.
    """
    pos = np.asarray(pos, float)
    back = pos - np.asarray(look_at, float)
    back /= np.linalg.norm(back)
    right = np.cross(np.asarray(up, float), back)
    if np.linalg.norm(right) < 1e-9:  # straight up or down: any way will do
        right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    view = np.eye(4)
    view[:3, :3] = right, np.cross(back, right), back
    view[:3, 3] = -view[:3, :3] @ pos
    near, far = camera["near"], camera["far"]
    tall = 1.0 / np.tan(np.radians(camera["fov"]) / 2)
    lens = np.zeros((4, 4))
    lens[0, 0], lens[1, 1] = tall / aspect, tall
    lens[2, 2:] = (near + far) / (near - far), 2 * near * far / (near - far)
    lens[3, 2] = -1.0
    return lens @ view
