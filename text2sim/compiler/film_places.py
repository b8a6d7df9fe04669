"""Settings of a film: a floor, what is behind it, and the light that belongs there.

Where a case names neither light nor background, a place is chosen for it. Nothing here touches physics.
"""

from collections.abc import Collection
from math import dist, floor, log2, log10
from typing import Any, NamedTuple

from text2sim.compiler.default_colors import STATIC_COLOR
from text2sim.compiler.film_cameras import FilmedScene, extent, ground_planes
from text2sim.compiler.looks import all_colors, has_glass, looks_of, luminance, oklab, rounded_rgb
from text2sim.compiler.shapes.rotation import Vec
from text2sim.spec_schema.models.colors import rgb
from text2sim.spec_schema.models.render import Render


class FilmPlace(NamedTuple):
    """A named place."""

    lighting: str
    """Its light, a row of `film_lights.STUDIOS`."""
    backdrop: str
    pattern: str
    """Pattern of its floor, a row of `rendering/floors.py`."""
    floor: str
    behind: str
    """Colour of its wall, or of the sky at the horizon."""
    wall: str = "plain"
    """What its wall is made of, one of `rendering/walls.py`."""
    sky: str = ""
    """Colour of the sky overhead."""
    skyline: str = ""
    """What stands at the horizon, one of `rendering/skyline.py`."""


PLACES = {
    "studio": FilmPlace("daylight", "wall", "polished", "#b4b7ba", "#b3c2d1"),
    "workshop": FilmPlace("daylight", "wall", "slabs", "#8a857f", "#a87f6b", "bricks"),
    "warehouse": FilmPlace("daylight", "wall", "slabs", "#767d83", "#b4bfc7", "concrete"),
    "room": FilmPlace("daylight", "wall", "boards", "#a07a54", "#b3c3c6", "plaster"),
    "kitchen": FilmPlace("daylight", "wall", "tiles", "#a89f93", "#c4d6d2", "tiles"),
    "tabletop": FilmPlace("daylight", "wall", "boards", "#a97c50", "#c9d2d6"),
    "street": FilmPlace("sunlight", "horizon", "asphalt", "#8b8d90", "#dbe4ea", sky="#8fb4d9", skyline="town"),
    "yard": FilmPlace("sunlight", "horizon", "earth", "#8f7a5c", "#dde8ec", sky="#86b1de", skyline="wood"),
    "meadow": FilmPlace("sunlight", "horizon", "grass", "#5f6d3d", "#dde8ec", sky="#86b1de", skyline="wood"),
}
PLACE_AND_LIGHT_FIELDS = {"lighting", "lights", "backdrop", "background", "ambient", "exposure", "tone", "setting"}
"""Fields of `render` that decide about light or background."""
FLOORS_AND_WALLS = (
    ("slabs", "#8d8379", "#a9c8df"),
    ("slabs", "#7f8b94", "#e6cda8"),
    ("slabs", "#9a8a78", "#a3c4b4"),
    ("slabs", "#59636d", "#8298ad"),
    ("slabs", "#6b6058", "#c79a7c"),
)
"""Pattern and colour of the floor, and colour of the wall, of a place that nobody chose; the most usual first."""
MIN_CONTRAST_GAIN = 0.03
"""What each step down that list has to gain in contrast."""
MAX_TABLE_RADIUS = 0.3
"""Radius [m] of a scene small enough for a table, on whose floor joints would look huge: it has none."""
OF_FINISH = {
    "concrete": "slabs",
    "wood": "boards",
    "ceramic": "tiles",
    "brick": "tiles",
    "sand": "sand",
    "smooth": "polished",
}
"""Pattern of a floor by the finish that the case gives the ground."""
JOINT_DISTANCES = {
    "slabs": (0.5, 2.0),
    "boards": (0.02, 0.2),
    "tiles": (0.05, 0.5),
    "asphalt": (0.5, 2.0),
    "earth": (0.5, 2.0),
    "grass": (0.5, 2.0),
}
"""Least and greatest distance [m] of the joints of a pattern, or size of what it repeats."""
JOINT_SHARE = 0.45
"""That distance within these limits, in radii of the scene."""
GREENERY = "foliage"
"""Finish of hedges and trees."""
GREENERY_SHARE = 0.3
"""Least radius of a part of a hedge or tree that puts a scene out of doors, in radii of the scene: no potted plant."""
LIT_BRIGHTNESS, ADAPTED_SHARE, MAX_ADAPTED_STOPS = 0.33, 0.5, 0.7
"""Brightness of the floor that lights are made for, the part of another floor's difference in stops that exposure makes
up for, and the most stops of that."""


def is_chosen(render: Render) -> bool:
    """Return whether a place is chosen for a case: it decides about neither light nor background."""
    return not render.model_fields_set & PLACE_AND_LIGHT_FIELDS


def place_of(render: Render, scene: FilmedScene) -> FilmPlace | None:
    """Return where a film takes place; None if the case has its own light or backdrop and names no place."""
    if render.setting is not None:
        return PLACES[render.setting]
    if not is_chosen(render):
        return None
    if any(_is_green(copy.model.look.color) for copy in ground_planes(scene)):
        return PLACES["meadow"]
    radius = extent(scene)[1]
    if _has_greenery(scene, GREENERY_SHARE * radius):
        return PLACES["street"]._replace(pattern="slabs", skyline="wood")
    colors = _colors(scene)
    pattern, color, behind = FLOORS_AND_WALLS[max(range(len(FLOORS_AND_WALLS)), key=lambda k: _contrast(k, colors))]
    if radius < MAX_TABLE_RADIUS:
        pattern = "polished"
    return PLACES["workshop"]._replace(pattern=pattern, floor=color, behind=behind, wall="plaster")


def adapted(floor: dict[str, Any]) -> float:
    """Return the stops that brighten a picture with a dark floor and darken one with a pale floor, as eyes adapt."""
    stops = ADAPTED_SHARE * log2(LIT_BRIGHTNESS / max(luminance(floor["color"]), 1e-3))
    return round(min(max(stops, -MAX_ADAPTED_STOPS), MAX_ADAPTED_STOPS), 4)


def floor_of(place: FilmPlace, scene: FilmedScene, radius: float, *, named: bool) -> dict[str, Any]:
    """Return the floor of a place, as plain data.

    A place that nobody named keeps the ground of the scene where that was given a colour or a finish.

    Args:
        place: The place.
        scene: The scene at its start.
        radius: Of the scene [m].
        named: Whether the case names the place.
    """
    pattern, color = place.pattern, place.floor
    for copy in () if named else ground_planes(scene):
        look = copy.model.look
        pattern = OF_FINISH.get(look.finish, pattern)
        if look.color not in (None, STATIC_COLOR):
            color = all_colors(copy)[0][:3]
    low, high = JOINT_DISTANCES.get(pattern, (0.1, 2.0))
    return {
        "pattern": pattern,
        "color": rounded_rgb(color),
        "tile": _pleasant(min(max(JOINT_SHARE * radius, low), high)),
    }


def open_ground(scene: FilmedScene, radius: float) -> dict[str, Any] | None:
    """Return the floor below a sky without a place: grass, earth or asphalt by the colour of the ground.

    None if no plane has one colour of its own.
    """
    for copy in ground_planes(scene):
        color = copy.model.look.color
        if isinstance(color, str) and color != STATIC_COLOR and copy.model.look.pattern is None:
            usual = PLACES["meadow" if _is_green(color) else "yard" if _is_brown(color) else "street"]
            return floor_of(usual, scene, radius, named=False)
    return None


def _has_greenery(scene: FilmedScene, least: float) -> bool:
    """Return whether a hedge or a tree with a part of at least this radius [m] stands in the scene."""
    return any(
        GREENERY in {look.finish for copy in copies for look in looks_of(copy.model)}
        and max(radius for _, radius in scene.around([name])) >= least
        for name, copies in scene.placed.items()
        if name not in scene.moving and not all(copy in ground_planes(scene) for copy in copies)
    )


def _is_green(color: Any) -> bool:
    if not isinstance(color, str):
        return False
    red, green, blue = rgb(color)
    return green > 1.1 * red and green > 1.2 * blue


def _is_brown(color: str) -> bool:
    red, green, blue = rgb(color)
    return red > 1.05 * green > 1.1 * blue


def _colors(scene: FilmedScene) -> dict[Vec, None]:
    """Return the distinct colours, in Oklab, of all that moves; glass counts as white."""
    moving = (copy for name in scene.moving for copy in scene.placed[name])
    colors = dict.fromkeys(rgba[:3] for copy in moving for rgba in all_colors(copy))
    if any(has_glass(copy) for copies in scene.placed.values() for copy in copies):
        colors[1.0, 1.0, 1.0] = None
    return dict.fromkeys(map(oklab, colors))


def _contrast(k: int, colors: Collection[Vec]) -> float:
    """Return a score of how well colours stand out against a floor and its wall."""
    if not colors:
        return -k
    behind = [oklab(rgb(color)) for color in FLOORS_AND_WALLS[k][1:]]
    away = sorted(min(dist(other, color) for other in behind) for color in colors)
    return 0.6 * away[0] + 0.4 * sum(away) / len(away) - MIN_CONTRAST_GAIN * k


def _pleasant(length: float) -> float:
    """Return the largest of 1, 2, 5, 10, … (times a power of ten) that is not longer."""
    decade = 10.0 ** floor(log10(length))
    return round(next(step for step in (5, 2, 1) if step * decade <= length * 1.0001) * decade, 6)
