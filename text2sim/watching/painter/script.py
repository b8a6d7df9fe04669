"""What a program says about its film: its `render.py`, read without running it."""

from typing import Any

import numpy as np

from text2sim.templates.cadence import Frame, frames, read_film, reels
from text2sim.templates.cameras import Cameras, View
from text2sim.templates.viewpoints import basis, clip


class Script:
    """Cameras, lights and cadence of a program.

    Cameras that frame what happens stand where they show all as it is at the start: while a film is made, nobody
    knows yet what will happen.
    """

    def __init__(self, text: str) -> None:
        self._film = read_film(text)
        self.resolution: tuple[int, int] = self._film["resolution"]
        self.fps = float(self._film["fps"])
        self.background, self.ambient = self._film["background"], (self._film["ambient"],) * 3
        self.lights = [_light(light) for light in self._film["lights"].values() if light["kind"] != "environment"]
        self.films = {name: str(reel[0]["camera"]) for name, reel in reels(self._film).items()}
        """The first camera of each film, by the name of its file."""

    def pictures(self, film: str, last: float) -> list[Frame]:
        """The pictures of a film if the recording ends at `last` [s]."""
        return frames(self._film, reels(self._film)[film], last)

    @property
    def end(self) -> float:
        """Simulated time [s] at which nothing more is shown."""
        return max(float(shot["to"]) for reel in reels(self._film).values() for shot in reel)

    def view(self, frame: Frame, states: Any) -> View:
        """The camera of a picture; `states` has `position`."""
        return Cameras(self._film, states).view(frame.camera, frame.t, frame.part)

    def clip(self, camera: str) -> tuple[float, float]:
        """Nearest and farthest distance [m] that is drawn."""
        return clip(self._film["cameras"][camera])


def _light(light: dict[str, Any]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    color = tuple(light["strength"] * part for part in light.get("color", (1.0, 1.0, 1.0)))
    if "pos" in light:
        return (*light["pos"], 1.0), color
    way = np.array(light["direction"], float)
    return (*(way / np.linalg.norm(way)).tolist(), 0.0), color


def projection(view: View, clip: tuple[float, float], aspect: float) -> np.ndarray:
    """Return the matrix from the world to the picture, shape (4, 4).

    Args:
        view: The camera.
        clip: Nearest and farthest distance [m] that is drawn.
        aspect: Width of the picture over its height.
    """
    right, up, ahead = (np.array(axis) for axis in basis(view.pos, view.look_at, view.up))
    matrix = np.eye(4)
    matrix[:3, :3] = right, up, -ahead
    matrix[:3, 3] = -matrix[:3, :3] @ view.pos
    near, far = clip
    tall = 1.0 / np.tan(np.radians(view.fov) / 2)
    lens = np.zeros((4, 4))
    lens[0, 0], lens[1, 1] = tall / aspect, tall
    lens[2, 2:] = (near + far) / (near - far), 2 * near * far / (near - far)
    lens[3, 2] = -1.0
    return lens @ matrix
