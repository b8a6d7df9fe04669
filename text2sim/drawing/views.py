"""The cameras of a case at its start, and what they see."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.trees.tree import tree_links
from text2sim.drawing.prop import Stage
from text2sim.drawing.raster import Raster
from text2sim.drawing.stage import stage
from text2sim.drawing.view import View, perspective
from text2sim.templates.viewpoints import clip, place

if TYPE_CHECKING:
    from text2sim.compiler.build import Resolution

Vec = tuple[float, float, float]

COARSE = 30_000
"""Triangles of a stage that is only asked what is seen of it."""
SOLID = 0.5
"""What is at least this opaque hides what is behind it."""


class CameraPose(NamedTuple):
    """Where a camera stands, what it looks at, and which way is up."""

    pos: Vec
    target: Vec
    up: Vec


def cameras(resolution: "Resolution") -> dict[str, dict[str, Any]]:
    """Return the cameras of a case by name, as the plan has them; one is derived if the case has none."""
    return resolution.plan.render["cameras"]


def camera_pose(resolution: "Resolution", name: str, t: float = 0.0) -> CameraPose:
    """Return the pose of a camera at a time [s] of the simulation, all bodies where they start.

    Raises:
        KeyError: if there is no such camera.
    """
    render = resolution.plan.render
    camera = cameras(resolution)[name]
    span = render["end"] - render["start"]
    part = min(max((t - render["start"]) / span, 0.0), 1.0) if span > 0 else 0.0
    pos, target = place(camera, t, part, _Start(resolution))
    return CameraPose(pos, target, camera["up"])


def field_of_view(camera: Mapping[str, Any]) -> float:
    """Return the vertical field of view [deg] of a camera of the plan."""
    return camera["fov"]


def film_view(resolution: "Resolution", name: str, size: tuple[int, int], t: float = 0.0) -> View:
    """Return a camera of the case as a view of the film's proportions, as large as fits into `size` [pixels]."""
    camera, pose = cameras(resolution)[name], camera_pose(resolution, name, t)
    wide, tall = resolution.plan.render["resolution"]
    shrink = min(size[0] / wide, size[1] / tall)
    fitting = max(round(wide * shrink), 1), max(round(tall * shrink), 1)
    return perspective(*pose, field_of_view(camera), fitting, near=clip(camera)[0])


def visible(resolution: "Resolution", camera: str, size: tuple[int, int] = (160, 90)) -> dict[str, float]:
    """Return the share of the picture that each copy fills at the start, by its name; only of those that are seen.

    What is hidden behind something else is not seen, what stands behind glass is. What is smaller than a pixel
    counts as a quarter of one.

    Args:
        resolution: The case, worked out.
        camera: Name of the camera.
        size: Largest width and height [pixels] of the picture that is looked at.
    """
    return shares(stage(resolution, COARSE), film_view(resolution, camera, size))


def shares(props: Stage, view: View) -> dict[str, float]:
    """Return the share of the picture that each copy fills, by its name; see `visible`."""
    solid = np.array([prop.opacity >= SOLID for prop in props], bool)[props.owner]
    raster = Raster(props.triangles, view, props.culled)
    raster.draw(np.flatnonzero(solid))
    total = view.width * view.height
    seen = np.bincount(props.owner[raster.ids[raster.ids >= 0]], minlength=len(props)).astype(float)
    for part in raster.fragments(np.flatnonzero(~solid)):
        ahead = part.nearness > raster.nearness.ravel()[part.pixel]
        seen += np.bincount(props.owner[part.triangle[ahead]], minlength=len(props))
    seen[(seen == 0) & _peeping(props, raster, seen == 0)] = 0.25
    found: dict[str, float] = {}
    for prop, pixels in zip(props, seen.tolist(), strict=True):
        if pixels and prop.opacity > 0.0:
            found[prop.name] = found.get(prop.name, 0.0) + min(pixels / total, 1.0)
    return found


def _peeping(props: Stage, raster: Raster, wanted: np.ndarray) -> np.ndarray:
    """Return which of the props that are wanted are seen with a corner, though it lies between pixels."""
    view = raster.view
    chosen = np.flatnonzero(wanted[props.owner])
    points = props.triangles[chosen].reshape(-1, 3)
    pixels = view.pixels(points)
    depth = -view.local(points)[:, 2]
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 0) & (pixels < (view.width, view.height))).all(axis=1) & (depth > view.near)
    column, row = np.floor(pixels[inside]).astype(int).T
    ahead = 1.0 / depth[inside] >= raster.nearness[row, column] * (1 - 1e-3)
    found = np.zeros(len(props), bool)
    found[np.repeat(props.owner[chosen], 3)[inside][ahead]] = True
    return found


class _Start:
    """A scene at its start, as cameras ask for it."""

    def __init__(self, resolution: "Resolution") -> None:
        self._resolution = resolution

    def position(self, name: str, t: float, link: str | None) -> Vec:
        """Position [m] of a copy's link; of its first if none is named."""
        groups = self._resolution.placed.values()
        copy: Copy = next(copy for group in groups for copy in group if copy.name == name)
        tree = self._resolution.lowering.trees.get(name)
        if tree is None:
            return copy.pos
        standing = {one.link.name: one.pos for one in tree_links(tree, copy.pos, copy.quat)}
        return standing[link if link is not None else tree.roots[0].name]
