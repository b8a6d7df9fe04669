"""Lights of the render section as numbers, the named studios, and the exposure that fits them."""

from math import acos, dist, hypot, pi, radians, sin
from typing import Any, NamedTuple

from text2sim.compiler.default_colors import STATIC_COLOR
from text2sim.compiler.film_cameras import FilmedScene, StartPoses, extent, ground_planes, resolve_target
from text2sim.compiler.film_places import FilmPlace, adapted, floor_of, open_ground, place_of
from text2sim.compiler.looks import luminance, rounded_rgb
from text2sim.compiler.shapes.rotation import ORIGIN, Vec
from text2sim.spec_schema.models.lights import Environment, Lamp, Light, Sky, Softbox, Spot, Sun
from text2sim.spec_schema.models.render import Render
from text2sim.templates import viewpoints

SOFTBOX_DISTANCE = 4.0
"""Default distance of a softbox, in radii of the scene."""
SOFTBOX_SIDE = 0.24
"""Default side of a softbox, in units of its distance."""
NIGHT = 0.2
"""Luminance of a background below which there is no daylit sky behind a horizon."""
USUALLY_LIT = 0.6
"""How bright a white ball looks where the strongest light comes over the photographer's shoulder, as a part of its
brightness if the light came from the camera."""
MOST_GRAZING = 1.7
"""Largest factor by which own lights that graze what is seen make the film brighter."""
CYCLORAMA_RADIUS = 8.0
"""Radius of a cyclorama, in radii of the scene: lamps stand inside and light the wall too."""


class Studio(NamedTuple):
    """A named lighting. Directions are across, ahead and up, as the camera sees them."""

    lights: dict[str, Light]
    backdrop: str
    background: str
    ambient: float
    """For the preview, which has no indirect light."""
    stops: float = 0.0
    """How many stops brighter than the exposure that makes a white sheet white."""
    sky: str = ""
    """Colour of the sky overhead, out of doors."""
    softbox_side: float = SOFTBOX_SIDE
    """Side of its softboxes, in units of their distance: the smaller, the crisper are shadows."""


def _softbox(direction: Vec, strength: float, color: str) -> Softbox:
    return Softbox.model_construct(kind="softbox", direction=direction, strength=strength, color=color)


def _sun(direction: Vec, strength: float, angle_deg: float, color: str = "white") -> Sun:
    return Sun.model_construct(kind="sun", direction=direction, strength=strength, angle_deg=angle_deg, color=color)


def _fill(color: str, horizon: str, strength: float) -> Environment:
    return Environment.model_construct(kind="environment", color=color, horizon=horizon, strength=strength)


STUDIOS = {
    # One large key beside the camera, a cool edge from behind, a dim wall in front for flat metal to mirror, and
    # little else: much fill looks chalky.
    "studio": Studio(
        {
            "key": _softbox((0.75, 0.45, -1.0), 3.2, "#fff6ec"),
            "rim": _softbox((-0.6, -0.9, -1.4), 1.1, "#d6e4ff"),
            "front": _sun((-0.25, 1.0, -0.3), 0.3, 50.0),
            "fill": _fill("#eef3fa", "#dfe3e8", 0.12),
        },
        backdrop="cyclorama",
        background="#c9ced4",
        ambient=0.35,
        stops=0.25,
    ),
    # For places that have a wall: a window beside the camera, a light edge from behind, and so little else that
    # shadows give form.
    "daylight": Studio(
        {
            "key": _softbox((0.95, 0.2, -0.85), 3.8, "#fff4e6"),
            "rim": _softbox((-0.7, -0.7, -1.5), 1.2, "#dfe9ff"),
            "front": _sun((-0.25, 1.0, -0.3), 0.16, 35.0),
            "fill": _fill("#f0f4fb", "#e6e6e4", 0.03),
        },
        backdrop="wall",
        background="#e8e0d2",
        ambient=0.45,
        stops=0.5,
        softbox_side=0.12,
    ),
    "sunlight": Studio(
        {"sun": _sun((0.8, 0.4, -0.82), 2.9, 3.0, "#fff1dc"), "sky": _fill("#a9c6e8", "#e6edf2", 0.32)},
        backdrop="horizon",
        background="#dbe4ea",
        ambient=0.45,
        stops=0.2,
        sky="#86b1de",
    ),
    "overcast": Studio(
        {"cloud": _fill("#f2f5f8", "#cfd6dc", 0.9), "sun": _sun((0.3, 0.4, -1.0), 0.6, 40.0)},
        backdrop="ground",
        background="#d3d9de",
        ambient=0.6,
    ),
    "golden_hour": Studio(
        {"sun": _sun((0.85, 0.4, -0.42), 3.4, 2.0, "#ffc990"), "sky": _fill("#8fabd6", "#ffdfbd", 0.45)},
        backdrop="horizon",
        background="#e6cdb2",
        ambient=0.35,
        stops=0.5,
        sky="#8aa3c9",
    ),
    "dark_stage": Studio(
        {
            "key": _softbox((0.25, 0.5, -1.0), 3.0, "#fff1e0"),
            "rim": _softbox((-0.5, -0.8, -1.3), 1.2, "#dbe5f7"),
            "fill": _fill("#8090b0", "#404858", 0.02),
        },
        backdrop="cyclorama",
        background="#17181b",
        ambient=0.12,
        stops=-0.3,
    ),
}


def resolve_light(render: Render, scene: FilmedScene, camera: dict[str, Any]) -> dict[str, Any]:
    """Return lights, backdrop and brightness as plain data.

    Args:
        render: The section.
        scene: The scene at its start.
        camera: The first one, as numbers: studios are built around it.
    """
    place = place_of(render, scene)
    studio = STUDIOS[render.lighting if place is None or "lighting" in render.model_fields_set else place.lighting]
    center, radius = extent(scene)
    given: dict[str, Light] = dict(render.lights)
    if not given:
        ahead = _ahead(camera, scene)
        given = {name: _turn_light(light, ahead) for name, light in studio.lights.items()}
    elif not any(isinstance(light, Environment | Sky) for light in given.values()):
        strength = render.ambient if render.ambient is not None else 0.16
        given["ambient"] = Environment.model_construct(kind="environment", strength=strength)
    side = SOFTBOX_SIDE if render.lights else studio.softbox_side
    lights = {name: _light(light, scene, center, radius, side) for name, light in given.items()}
    if render.ambient is not None:
        for light in lights.values():
            if light["kind"] == "environment":
                light["strength"] = render.ambient
    # Lights of the case in a named place are exposed as those of the place: for its floor, and as bright.
    stops = render.exposure + (studio.stops if place or not render.lights else 0.0)
    floor = floor_of(place, scene, radius, named=render.setting is not None) if place else None
    if floor is not None:
        stops += adapted(floor)
    pos, look_at, _ = _placed(camera, scene)
    gain = _gain(lights, look_at, pos) if render.lights else _gain(lights, center, None)
    ground = ground_planes(scene)
    kind = render.backdrop or (place.backdrop if place else studio.backdrop)
    background, behind = _behind(render, place, studio, kind)
    if floor is None and "sky" in behind:
        floor = open_ground(scene, radius)
    return {
        "background": background,
        "ambient": studio.ambient if render.ambient is None else render.ambient,
        "lights": lights,
        "gain": round(2.0**stops * gain, 4),
        "backdrop": {
            "kind": kind,
            "level": max((plane.pos[2] for plane in ground), default=None),
            "center": center,
            "radius": round(CYCLORAMA_RADIUS * radius, 3),
            "planes": [plane.name for plane in ground if plane.model.look.color in (None, STATIC_COLOR)],
            **({"floor": floor} if floor else {}),
            **behind,
            "supports": render.supports == "posts",
            **({"own_lights": True} if render.lights else {}),
            **({"driven": driven} if (driven := scene.driven) else {}),
        },
    }


def _behind(render: Render, place: FilmPlace | None, studio: Studio, kind: str) -> tuple[Vec, dict[str, Any]]:
    """Return the background, and the wall or the sky behind the scene for a kind of backdrop."""
    sky, plain, own = studio.sky, studio.background, False
    if place:
        own = studio is STUDIOS[place.lighting]
        if own or kind != "horizon" or not sky:  # otherwise the light that the case names brings its own sky
            sky, plain = place.sky, place.behind
    found: dict[str, Any] = {}
    if place:
        found["wall"] = place.wall
        if place.wall != "plain" and own and not render.lights:
            found["window"] = True
    background = rounded_rgb(render.background or plain)
    if kind == "horizon" and luminance(background) > NIGHT:
        sky = sky or STUDIOS["sunlight"].sky
        found |= {"sky": rounded_rgb(sky), "skyline": (place.skyline if place else "") or "wood"}
    return background, found


def _light(light: Light, scene: FilmedScene, center: Vec, radius: float, side: float) -> dict[str, Any]:
    plain: dict[str, Any] = {"kind": light.kind, "strength": light.strength}
    if isinstance(light, Sky):
        return plain | {"direction": light.direction, "turbidity": light.turbidity}
    plain["color"] = rounded_rgb(light.color)
    if isinstance(light, Environment):
        return plain | {"horizon": plain["color"] if light.horizon is None else rounded_rgb(light.horizon)}
    if isinstance(light, Sun):
        return plain | {"direction": light.direction, "angle": round(radians(light.angle_deg), 5)}
    if isinstance(light, Softbox):
        distance = light.distance or round(SOFTBOX_DISTANCE * radius, 3)
        return plain | {
            "direction": light.direction,
            "at": center if light.at is None else resolve_target(light.at, scene),
            "distance": distance,
            "size": light.size or round(side * distance, 3),
        }
    if isinstance(light, Lamp):
        return plain | {"pos": light.pos, "radius": light.radius or round(0.05 * radius, 4)}
    assert isinstance(light, Spot)
    return plain | {
        "pos": light.pos,
        "look_at": resolve_target(light.look_at, scene),
        "angle": round(radians(light.angle_deg), 5),
        "blur": light.blur,
    }


def _turn_light(light: Light, ahead: tuple[float, float]) -> Light:
    """Return a studio's light, its direction turned from across, ahead and up to the axes of the world."""
    if isinstance(light, Environment):
        return light
    assert isinstance(light, Sun | Softbox)
    across, along, up = light.direction
    right = (ahead[1], -ahead[0])
    x, y = (across * r + along * a for r, a in zip(right, ahead, strict=True))
    return light.model_copy(update={"direction": (round(x, 4), round(y, 4), up)})


def _ahead(camera: dict[str, Any], scene: FilmedScene) -> tuple[float, float]:
    """Return the horizontal direction in which a camera looks at first; +y if it looks straight down."""
    pos, look_at, _ = _placed(camera, scene)
    x, y = look_at[0] - pos[0], look_at[1] - pos[1]
    away = hypot(x, y)
    return (x / away, y / away) if away > 1e-6 else (0.0, 1.0)


def _placed(camera: dict[str, Any], scene: FilmedScene) -> tuple[Vec, Vec, Vec]:
    """Return a camera's position, its target and the direction that is up in its picture, at the start."""
    return viewpoints.place(camera, 0.0, 0.0, StartPoses(scene.placed, scene.points.trees))


def _gain(lights: dict[str, Any], at: Vec, camera: Vec | None) -> float:
    """Return the factor at which a white sheet facing the strongest light is white, as a light meter would have it.

    Args:
        lights: As numbers.
        at: Where the light is measured.
        camera: Where the camera stands, if the lights are the case's own: where they only graze what it sees, the film
            is brighter, by up to `MOST_GRAZING`.
    """
    white, strongest, seen = 0.0, 0.0, 0.0
    for light in lights.values():
        power = light["strength"] * (max(light["color"]) if "color" in light else 1.0)
        if light["kind"] == "environment":
            white += power
        elif light["kind"] == "sky":
            white += power / pi
        else:
            if light["kind"] in ("lamp", "spot"):
                power /= max(dist(light["pos"], at), 1e-3) ** 2
            strongest = max(strongest, power / pi)
            if camera is not None:
                source = _between(at, light["pos"]) if "pos" in light else _between(light["direction"], ORIGIN)
                seen += power / pi * _lit_part(source, _between(at, camera)) / USUALLY_LIT
    sheet = max(white + strongest, 1e-3)
    return 1.0 / (min(sheet, max(white + seen, sheet / MOST_GRAZING)) if camera is not None else sheet)


def _lit_part(source: Vec, camera: Vec) -> float:
    """Return how bright a white ball looks, in units of its brightness if the light came from the camera.

    Lambert's phase function (J. H. Lambert, Photometria, 1760). Both directions are unit vectors.
    """
    cosine = max(-1.0, min(1.0, sum(s * c for s, c in zip(source, camera, strict=True))))
    angle = acos(cosine)
    return (sin(angle) + (pi - angle) * cosine) / pi


def _between(start: Vec, end: Vec) -> Vec:
    """Return the unit vector from one point towards another; the zero vector if they are one."""
    x, y, z = (e - s for s, e in zip(start, end, strict=True))
    away = max(hypot(x, y, z), 1e-9)
    return (x / away, y / away, z / away)
