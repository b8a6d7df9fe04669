"""What is behind all surfaces, in the pictures of each camera."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.rendering.backdrop import sky, upper_edge
from text2sim.rendering.skyline import distance_of
from text2sim.templates.cameras import Cameras, View

Array = NDArray[np.floating]

SKYLINE_MOMENTS = 9
"""Pictures of a camera that decide how far away its skyline is."""
MAX_SKIES = 8
"""Largest number of painted skies that are kept."""


@dataclass
class Skies:
    """Painted skies of a film."""

    film: dict[str, Any]
    """Constants of `render.py`."""
    cameras: Cameras
    times: Array
    """Recorded times [s]."""
    size: tuple[int, int]
    """Width and height of the pictures [pixels]."""
    _painted: dict[tuple[str, bytes], Any] = field(default_factory=dict, init=False)
    _distances: dict[str, int] = field(default_factory=dict, init=False)

    def behind(self, view: View, camera: str) -> Any:
        """Return what is behind all surfaces in a view of a camera; it is painted once for one that stands still."""
        key = camera, np.hstack(view).tobytes()  # another camera may have the same view, and another distance
        if key not in self._painted:
            if len(self._painted) >= MAX_SKIES:
                self._painted.clear()
            far = self._distance(camera)
            self._painted[key] = sky(self.film["backdrop"], self.film["background"], view, self.size, far)
        return self._painted[key]

    def _distance(self, camera: str) -> int:
        """Return the distance of the skyline for a camera, see `distance_of`; it is the same in all of its pictures."""
        kind = self.film["backdrop"].get("skyline")
        if kind is None:
            return 1
        if camera not in self._distances:
            parts = np.linspace(0.0, 1.0, SKYLINE_MOMENTS)
            moments = self.times[0] + parts * (self.times[-1] - self.times[0])
            views = (self.cameras.view(camera, float(t), float(part)) for t, part in zip(moments, parts, strict=True))
            self._distances[camera] = distance_of(kind, [upper_edge(view) for view in views])
        return self._distances[camera]
