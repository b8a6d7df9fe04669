"""The render section with everything resolved: cameras as numbers, lights in the engine's terms, a camera if none."""

from math import dist, radians, sqrt, tan
from typing import Any

from text2sim.compiler.placing.body_points import BodyPoints
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.selection import select
from text2sim.compiler.shapes.regions import RegionError
from text2sim.compiler.shapes.rotation import Vec, vector_cross, vector_unit
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.load import LoadedCase
from text2sim.spec_schema.models.colors import rgb
from text2sim.spec_schema.models.regions import BodyPoint
from text2sim.spec_schema.models.render import Camera, Dolly, Follow, Lamp, Light, Orbit, Render, Softbox, Sun

Ball = tuple[tuple[float, float, float], float]

# For a scene that names no light, in front of a camera that looks along +y. One, with light from everywhere, is
# enough without shadows; on software OpenGL every further light costs as much as the whole picture.
DEFAULT_LIGHTS: tuple[Light, ...] = (Sun(kind="sun", direction=(-0.5, 0.8, -1.0), strength=3.6),)
DEFAULT_VIEW = (0.55, -1.0, 0.5)
"""Direction from the scene to a camera that nobody placed."""
ROOM = 1.5
"""How much farther away it stands than it has to: what moves needs room."""


def resolve_render(
    render: Render,
    placed: dict[str, list[Copy]],
    moving: tuple[str, ...],
    duration: float,
    balls: dict[str, list[Ball]],
    points: BodyPoints,
) -> dict[str, Any]:
    """Return plain data for the template.

    Args:
        render: The section.
        placed: Copies by body, statics included.
        moving: Names of the bodies.
        duration: Simulated time [s].
        balls: Balls around the pieces of each copy at the start, in the world.
        points: Finds links and regions of bodies.
    """
    start, end = render.during or (0.0, duration)
    lights = render.lights.values() or DEFAULT_LIGHTS
    cameras = [_camera(name, camera, placed, points) for name, camera in render.cameras.items()]
    cameras = cameras or [
        _derived(
            [ball for name in moving for copy in placed[name] for ball in balls.get(copy.name, [])],
            render.resolution[0] / render.resolution[1],
        )
    ]
    for camera in cameras:
        camera |= _clip(camera)
    return {
        "resolution": tuple(render.resolution),
        "fps": render.fps,
        "speed": render.speed,
        "start": start,
        "end": min(end, duration),
        "background": _color(render.background),
        "ambient": (render.ambient,) * 3,
        "lights": [_light(light) for light in lights],
        "cameras": cameras,
    }


def _camera(name: str, camera: Camera, placed: dict[str, list[Copy]], points: BodyPoints) -> dict[str, Any]:
    common: dict[str, Any] = {"name": name, "kind": camera.kind, "fov": camera.fov, "up": camera.up}
    if isinstance(camera, Follow):
        copies, link = select(camera.body, placed)
        common |= {"body": copies[0].name, "link": link, "smooth": camera.smooth}
        place = {"pos": camera.from_} if camera.from_ is not None else {"offset": camera.offset}
        return common | place
    target = _target(camera.look_at, placed, points)
    if isinstance(camera, Orbit):
        return common | {
            "look_at": target,
            "radius": camera.radius,
            "height": camera.height,
            "start": radians(camera.start_deg),
            "turn": radians(camera.turn_deg),
        }
    if isinstance(camera, Dolly):
        return common | {"look_at": target, "pos": camera.from_, "to": camera.to}
    return common | {"look_at": target, "pos": camera.from_}


def check_targets(loaded: LoadedCase, placed: dict[str, list[Copy]], points: BodyPoints) -> list[Problem]:
    """Return what is wrong with the regions that cameras look at."""
    problems = []
    for name, camera in loaded.case.render.cameras.items():
        if isinstance(camera, Follow) or not isinstance(camera.look_at, BodyPoint):
            continue
        try:
            _target(camera.look_at, placed, points)
        except RegionError as error:
            where = ("render", "cameras", name, "look_at", "region")
            problems.append(loaded.problem(where, f"{camera.look_at.body}: {error}", rule="empty-region"))
    return problems


def _target(target: Any, placed: dict[str, list[Copy]], points: BodyPoints) -> Vec:
    """Where a camera looks at the start: the middle of all copies, links or regions that are meant."""
    region = None
    if isinstance(target, BodyPoint):
        target, region = target.body, target.region
    if not isinstance(target, str):
        return target
    copies, link = select(target, placed)
    found = [points.in_world(copy, link, region) for copy in copies]
    x, y, z = (round(sum(axis) / len(found), 6) for axis in zip(*found, strict=True))
    return (x, y, z)


def _derived(balls: list[Ball], aspect: float) -> dict[str, Any]:
    """A still camera that just sees everything that moves, where it starts and down to the ground below it.

    Args:
        balls: What is to be seen.
        aspect: Width of the picture over its height.
    """
    balls = balls or [((0.0, 0.0, 0.0), 1.0)]
    # Where something falls to, if there is ground at zero, and not too far below.
    balls = balls + [((x, y, 0.0), r) for (x, y, z), r in balls if r < z < 3.0]
    fov, view = 40.0, vector_unit(DEFAULT_VIEW)
    right = vector_unit((-view[1], view[0], 0.0))
    up = vector_cross(view, right)
    center = tuple((min(c[k] - r for c, r in balls) + max(c[k] + r for c, r in balls)) / 2 for k in range(3))
    tall = tan(radians(fov / 2))
    distance = 0.1
    for position, radius in balls:
        offset = tuple(p - c for p, c in zip(position, center, strict=True))
        for axis, slope in ((right, tall * aspect), (up, tall)):
            # The ball touches the plane through the camera and an edge of the picture.
            reach = abs(_dot(offset, axis)) / slope + radius * sqrt(1.0 + 1.0 / slope**2)
            distance = max(distance, ROOM * reach + _dot(offset, view))
    look_at = tuple(round(c, 4) for c in center)
    pos = tuple(round(c + distance * v, 4) for c, v in zip(center, view, strict=True))
    return {"name": "main", "kind": "still", "fov": fov, "up": (0.0, 0.0, 1.0), "look_at": look_at, "pos": pos}


def _dot(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def _clip(camera: dict[str, Any]) -> dict[str, float]:
    """Nearest and farthest distance [m] that are drawn, from the distance to what the camera looks at."""
    if "offset" in camera:
        distance = dist(camera["offset"], (0.0, 0.0, 0.0))
    elif "radius" in camera:
        distance = camera["radius"]
    elif "look_at" in camera:
        distance = dist(camera["pos"], camera["look_at"])
    else:
        distance = 3.0
    return {"near": round(max(distance / 50, 0.005), 4), "far": round(max(distance * 20, 60.0), 1)}


def _color(color: Any) -> tuple[float, float, float]:
    red, green, blue = rgb(color)
    return (round(red, 4), round(green, 4), round(blue, 4))


def _light(light: Light) -> dict[str, Any]:
    if isinstance(light, Lamp):
        return {"pos": light.pos, "color": _color(light.color), "intensity": light.strength}
    assert isinstance(light, Sun | Softbox)
    return {"dir": light.direction, "color": _color(light.color), "intensity": light.strength}
