"""Views of a case's cameras at its start."""

from typing import NamedTuple

import numpy as np

from text2sim.compiler.build import Resolution
from text2sim.compiler.looks import hides
from text2sim.drawing.prop import Stage
from text2sim.drawing.stage import stage
from text2sim.drawing.view import PictureView
from text2sim.drawing.views import film_view
from text2sim.legibility.sight import Sight, Things, look

COARSE_TRIANGLES = 30_000
"""Triangles of a stage that only serves to find what is visible."""


class Layout(NamedTuple):
    """Copies of bodies and statics, and their visibility to a camera."""

    names: list[str]
    sight: Sight

    @property
    def shares(self) -> dict[str, float]:
        """Part of the picture that each visible copy fills."""
        rows = zip(self.names, self.sight.seen.tolist(), strict=True)
        return {name: min(pixels / self.sight.size, 1.0) for name, pixels in rows if pixels}

    def hider(self, copies: set[str]) -> str:
        """Return the copy that hides the largest part of some copies; empty if none does."""
        hidden: dict[str, float] = {}
        for k, name in enumerate(self.names):
            for other, part in self.sight.hiders(k) if name in copies else ():
                hider = self.names[other]
                hidden[hider] = hidden.get(hider, 0.0) + part * float(self.sight.alone[k])
        return max(hidden.keys() - copies, key=lambda name: (hidden[name], name), default="")


def at_start(resolution: Resolution, camera: str, size: tuple[int, int] = (160, 90)) -> Layout:
    """Return what a camera sees at the start of a case.

    Things behind glass are visible. Visible things that are smaller than a pixel count as a quarter of one.

    Args:
        resolution: The resolved case.
        camera: Name of the camera.
        size: Largest width and height of the picture [pixels].
    """
    return of_stage(stage(resolution, COARSE_TRIANGLES), film_view(resolution, camera, size))


def of_stage(props: Stage, view: PictureView) -> Layout:
    """Return what a view shows of the props of a stage."""
    names = list(dict.fromkeys(prop.name for prop in props if prop.opacity > 0.0))
    index = {name: k for k, name in enumerate(names)}
    thing = np.array([index.get(prop.name, -1) for prop in props], np.int64)
    opaque = np.array([hides(prop.opacity, prop.finish) for prop in props], bool)
    owners = props.owner if len(props) else np.zeros(0, np.int64)
    owner, solid = thing[owners], opaque[owners]
    kept = owner >= 0
    things = Things(props.triangles[kept], owner[kept], solid[kept], len(names), props.culled[kept])
    return Layout(names, look(things, view))
