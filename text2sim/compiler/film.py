"""The render section with everything resolved, as plain data for the program's `render.py`."""

from typing import Any

from text2sim.compiler.film_cameras import FilmedScene, derived_camera, derived_decisions, resolve_camera
from text2sim.compiler.film_lights import resolve_light
from text2sim.compiler.placing.body_points import BodyPoints
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.piece import Ball
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.colors import rgb
from text2sim.spec_schema.models.controls import Spring
from text2sim.spec_schema.models.render import Render

STEEL, RUBBER = (0.62, 0.64, 0.67), (0.55, 0.13, 0.11)
"""Colours of coils and cords (sRGB), unless the case gives another."""


def spring_looks(controls: dict[str, Any]) -> dict[str, Any]:
    """Return form, radius and colour of the springs as the constant `springs` of `render.py`; nothing without springs.

    Args:
        controls: Controls of the case.
    """
    looks = {
        name: {
            "form": control.form,
            "radius": control.radius,
            "color": rgb(control.color) if control.color is not None else STEEL if control.form == "coil" else RUBBER,
        }
        for name, control in controls.items()
        if isinstance(control, Spring)
    }
    return {"springs": looks} if looks else {}


def resolve_render(
    render: Render,
    placed: dict[str, list[Copy]],
    moving: tuple[str, ...],
    duration: float,
    balls: dict[str, list[Ball]],
    points: BodyPoints,
) -> dict[str, Any]:
    """Return plain data: the constants of `render.py`, by lower-case name.

    Args:
        render: The section.
        placed: Copies by body, statics included.
        moving: Names of the bodies.
        duration: Simulated time [s].
        balls: Balls around the pieces of each copy at the start, in the world.
        points: Finds links and regions of bodies.
    """
    start, end = span_of(render.during, duration)
    end = min(end, duration)
    width, height = render.resolution
    scene = FilmedScene(placed, dict.fromkeys(moving), balls, points, width / height)
    cameras = {name: resolve_camera(camera, scene) for name, camera in render.cameras.items()}
    given = render.model_fields_set
    paced, lit = bool(given & {"during", "speed", "shots"}), bool(render.lights)
    auto = None if cameras else derived_decisions(scene, paced=paced, lit=lit)
    cameras = cameras or {"main": derived_camera(scene)}
    shots = [
        {
            "name": name,
            "camera": shot.camera,
            "from": start if shot.from_ is None else shot.from_,
            "to": min(end if shot.to is None else shot.to, duration),
            "speed": shot.speed or render.speed,
            "hold": shot.hold,
        }
        for name, shot in render.shots.items()
    ]
    first = cameras[shots[0]["camera"]] if shots else next(iter(cameras.values()))
    return {
        "resolution": (width, height),
        "fps": render.fps,
        "speed": render.speed,
        "start": start,
        "end": end,
        "motion_blur": render.motion_blur,
        "cameras": cameras,
        "auto": auto,
        "shots": shots,
        **resolve_light(render, scene, first),
        "tone": render.tone,
        "overlay": dict(render.overlay),
    }
