"""Views of a case's cameras at its start."""

from typing import Any, NamedTuple

from text2sim.compiler.build import Resolution
from text2sim.compiler.film_cameras import StartPoses
from text2sim.compiler.shapes.rotation import Vec
from text2sim.drawing.view import PictureView, perspective
from text2sim.templates.viewpoints import clip, place


class CameraPose(NamedTuple):
    """Position [m], target [m] and up direction of a camera."""

    pos: Vec
    target: Vec
    up: Vec


def cameras(resolution: Resolution) -> dict[str, dict[str, Any]]:
    """Return the cameras of the plan by name; one is derived if the case has none."""
    return resolution.plan.render["cameras"]


def camera_pose(resolution: Resolution, name: str, t: float = 0.0) -> CameraPose:
    """Return the pose of a camera at a time [s] of the simulation, with all bodies at their start.

    Args:
        resolution: The resolved case.
        name: Name of the camera.
        t: Time of the simulation [s].

    Raises:
        KeyError: if there is no such camera.
    """
    render = resolution.plan.render
    camera = cameras(resolution)[name]
    span = render["end"] - render["start"]
    part = min(max((t - render["start"]) / span, 0.0), 1.0) if span > 0 else 0.0
    poses = StartPoses(resolution.placed, resolution.lowering.trees)
    return CameraPose(*place(camera, t, part, poses))


def film_view(resolution: Resolution, name: str, size: tuple[int, int], t: float = 0.0) -> PictureView:
    """Return a view of a camera of the case, with the film's aspect ratio, that fits into `size` [pixels].

    Args:
        resolution: The resolved case.
        name: Name of the camera.
        size: Largest width and height [pixels].
        t: Time of the simulation [s].

    Raises:
        KeyError: if there is no such camera.
    """
    camera, pose = cameras(resolution)[name], camera_pose(resolution, name, t)
    wide, tall = resolution.plan.render["resolution"]
    shrink = min(size[0] / wide, size[1] / tall)
    fitting = max(round(wide * shrink), 1), max(round(tall * shrink), 1)
    return perspective(*pose, camera["fov"], fitting, near=clip(camera)[0])
