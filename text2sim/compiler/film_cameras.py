"""Cameras of the render section as numbers, and one that shows everything, for a case without cameras."""

from collections.abc import Collection
from math import dist, inf, radians
from statistics import median
from typing import Any, NamedTuple

from text2sim.compiler.film_views import free_direction
from text2sim.compiler.looks import has_glass
from text2sim.compiler.placing.body_points import BodyPoints
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.selection import select
from text2sim.compiler.shapes.boxes import Bounds, apart, around_balls, grown, middle, sides
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.piece import Ball
from text2sim.compiler.shapes.regions import RegionError
from text2sim.compiler.shapes.rotation import IDENTITY, Quaternion, Vec, quat_from_euler_deg, quat_rotate, vector_plus
from text2sim.compiler.trees.tree import Tree, link_frame
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.bodies import Driven
from text2sim.spec_schema.models.cameras import Camera, Dolly, Follow, Keyframed, Mounted, Orbit, Still
from text2sim.spec_schema.models.regions import BodyPoint
from text2sim.spec_schema.names.name_table import touching_parts
from text2sim.spec_schema.names.selectors import body_of, parse_selector
from text2sim.templates.viewpoints import basis

DEFAULT_FOV = 32.0
"""Vertical field of view [deg] of that camera: a lens of 42 mm, which draws things as eyes see them."""
DEFAULT_MARGIN = 0.08
"""Part of the picture that a frame keeps free at each edge, if nothing is said."""
ORBIT_HEIGHT = 0.45
"""Height over radius of a circle that follows from what it frames."""
MAX_GROUND_DISTANCE = 3.0
"""How far [m] down to the ground a body may be at the start, for the place below it to be in a picture."""
MAX_STRAY_SCENE_SIZES, MAX_STRAY_BODY_SIZES = 2.5, 20.0
"""That camera follows a body until it strays this many sizes of the whole scene, or this many of its own, from where
all began: any farther, and nothing would be large enough to recognise."""
MAX_STATIC_DISTANCE, MAX_STATIC_SIZE = 2.0, 3.0
"""A static nearer than this many sizes of what moves is shown too, if it is not larger than this many."""

MAX_DECOR_SIZE = 3.0
"""That camera frames a body without its decor if that makes it more than this many times as large."""


class FilmedScene(NamedTuple):
    """What cameras need to know of the scene at the start."""

    placed: dict[str, list[Copy]]
    """Copies by body, statics included."""
    moving: Collection[str]
    """Names of the bodies, as a set or dictionary."""
    balls: dict[str, list[Ball]]
    """Balls around the pieces of each copy, in the world."""
    points: BodyPoints
    """Finds links and regions of bodies."""
    aspect: float
    """Width of the picture over its height."""

    @property
    def driven(self) -> list[str]:
        """Copies with prescribed motion, in order."""
        return [copy.name for copies in self.placed.values() for copy in copies if isinstance(copy.model, Driven)]

    def around(self, names: Any) -> list[Ball]:
        """Return balls around the copies of bodies and statics, planes left out."""
        chosen = [copy for name in names for copy in self.placed[name] if not _is_plane(copy)]
        return [ball for copy in chosen for ball in self.balls.get(copy.name, [(copy.pos, 0.05)])]


class StartPoses:
    """Poses of copies and links at the start, whatever the time, for `viewpoints.place`.

    Args:
        placed: Copies by body, statics included.
        trees: Trees of links by name of the copy.
    """

    def __init__(self, placed: dict[str, list[Copy]], trees: dict[str, Tree]) -> None:
        self._copies = {copy.name: copy for copies in placed.values() for copy in copies}
        self._trees = trees

    def position(self, body: str, t: float, link: str | None) -> Vec:
        """Return the position [m] of a link of a copy, see `pose`.

        Args:
            body: Name of the copy.
            t: Any time.
            link: Name of the link; the first one if None.
        """
        return self.pose(body, t, link)[0]

    def pose(self, body: str, t: float, link: str | None) -> tuple[Vec, Quaternion]:
        """Return the position [m] and orientation (w, x, y, z) of a link of a copy, or of a copy without links.

        Args:
            body: Name of the copy.
            t: Any time.
            link: Name of the link; the first one if None.
        """
        copy = self._copies[body]
        return link_frame(self._trees.get(body), link, copy.pos, copy.quat)


def resolve_camera(camera: Camera, scene: FilmedScene) -> dict[str, Any]:
    """Return a camera as plain numbers; one with a frame stands where it shows all of it at the start."""
    plain: dict[str, Any] = {"kind": camera.kind, "up": camera.up, "fov": round(camera.field, 4)}
    if camera.f_stop is not None:
        plain["f_stop"] = camera.f_stop
        if camera.focus is not None:
            plain["focus"] = _focus(camera.focus, scene)
    if isinstance(camera, Mounted):
        copies, link = select(camera.on, scene.placed)
        return plain | {"body": copies[0].name, "link": link} | _line_of_sight(camera)
    if isinstance(camera, Follow):
        copies, link = select(camera.body, scene.placed)
        plain |= {"body": copies[0].name, "link": link, "smooth": camera.smooth}
        if camera.frame is None:
            return plain | ({"pos": camera.from_} if camera.from_ is not None else {"offset": camera.offset})
        frame = _frame(camera, scene) | {"direction": camera.direction}
        x, y, z = scene.points.in_world(copies[0], link, None)
        balls = _subject_balls(_names(camera.frame), scene)
        beside = [((a - x, b - y, c - z), radius) for (a, b, c), radius in balls]
        return _framed(plain | {"frame": frame}, beside, scene)
    if isinstance(camera, Keyframed):
        listed = isinstance(camera.look_at, list)
        look_at = camera.look_at if listed else resolve_target(camera.look_at, scene)
        return plain | {"times": camera.times, "positions": camera.positions, "look_at": look_at}
    if isinstance(camera, Dolly):
        return plain | {"pos": camera.from_, "to": camera.to, "look_at": resolve_target(camera.look_at, scene)}
    if isinstance(camera, Orbit):
        plain |= {"start": radians(camera.start_deg), "turn": radians(camera.turn_deg)}
        if camera.radius is not None:
            plain |= {"radius": camera.radius, "height": camera.height}
        else:
            plain |= {"radius": 1.0, "height": ORBIT_HEIGHT}
        if camera.frame is None:
            return plain | {"look_at": resolve_target(camera.look_at, scene)}
        frame = _frame(camera, scene) | {"fit": camera.radius is None}
        return _framed(plain | {"frame": frame}, _subject_balls(_names(camera.frame), scene), scene)
    assert isinstance(camera, Still)
    if camera.frame is None:
        return plain | {"pos": camera.from_, "look_at": resolve_target(camera.look_at, scene)}
    frame = _frame(camera, scene)
    if camera.from_ is not None:
        plain |= {"pos": camera.from_}
    else:
        frame |= {"direction": camera.direction or _free_direction(_names(camera.frame), scene)}
    return _framed(plain | {"frame": frame}, _subject_balls(_names(camera.frame), scene), scene)


def _line_of_sight(camera: Mounted) -> dict[str, Any]:
    """Return position, target and up direction of a camera in the frame of its carrier.

    Up is at right angles to the line of sight there, so that the picture cannot turn about it while the carrier turns.
    """
    if camera.euler_deg is None:
        look_at, up = camera.look_at, basis(camera.pos, camera.look_at, camera.up or (0.0, 0.0, 1.0))[1]
    else:
        quat = quat_from_euler_deg(camera.euler_deg)
        look_at = vector_plus(camera.pos, quat_rotate(quat, (0.0, 0.0, 1.0)))
        up = quat_rotate(quat, (0.0, -1.0, 0.0))
    return {"pos": camera.pos, "look_at": _rounded(look_at, 6), "up": _rounded(up, 6)}


def derived_camera(scene: FilmedScene) -> dict[str, Any]:
    """Return a still camera that shows everything that moves, over all of the film."""
    moving = _to_the_ground(scene.around(scene.moving), scene)
    statics = _near_statics(moving, scene)
    balls = moving + scene.around(statics)
    low, high = box = _box(balls)
    size = max(sides(box))
    own = 2 * median(radius for _, radius in moving) if moving else size
    room = max(MAX_STRAY_SCENE_SIZES * size, MAX_STRAY_BODY_SIZES * own)
    levels = [copy.pos[2] for copy in _planes(scene)]
    lowest = min(levels) - 0.1 * size if levels else low[2] - size
    within = _rounded((low[0] - room, low[1] - room, lowest)), _rounded(c + room for c in high)
    frame = {"bodies": [*scene.moving, *statics], "margin": DEFAULT_MARGIN, "within": within}
    frame |= {"direction": _free_direction(scene.moving, scene)}
    return _framed({"kind": "still", "up": (0.0, 0.0, 1.0), "fov": DEFAULT_FOV, "frame": frame}, balls, scene)


def derived_decisions(scene: FilmedScene, *, paced: bool, lit: bool) -> dict[str, Any]:
    """Return what `templates/directing.py` decides, which knows what was recorded.

    Args:
        scene: The scene at the start.
        paced: Whether somebody has said which part of the run is shown, or how quickly.
        lit: Whether somebody has placed lights.
    """
    statics = [name for name in scene.placed if name not in scene.moving]
    clear = [name for name, copies in scene.placed.items() if any(has_glass(copy) for copy in copies)]
    near = _near_statics(_to_the_ground(scene.around(scene.moving), scene), scene)
    standing = [name for name in statics if not all(_is_plane(copy) for copy in scene.placed[name])]
    bare = _bare(scene)
    return {
        "times": not paced, "camera": True, "turn_lights": not lit, "moving": [*scene.moving], "statics": near,
        "standing": standing, "clear": clear, **({"bare": bare} if bare else {}),
    }  # fmt: skip


def _bare(scene: FilmedScene) -> dict[str, list[str]]:
    """Return the parts that touch, by name of the body, of bodies whose decor is far larger."""
    found = {}
    for name, copies in scene.placed.items():
        parts = touching_parts(copies[0].model) if copies else []
        if not parts:
            continue
        whole = copies[0].model.shape
        drawn = {key: part.model_copy(update={"decor": False}) for key, part in whole.parts.items()}
        size, drawn_size = (
            max(sides(extents(shape, IDENTITY, scene.points.folder)))
            for shape in (whole, whole.model_copy(update={"parts": drawn}))
        )
        if parts == [*whole.solids] and drawn_size > MAX_DECOR_SIZE * size:
            found[name] = [f"{name}.{part}" for part in parts]
    return found


def resolve_target(target: Any, scene: FilmedScene) -> Vec:
    """Return where a target is at the start: the middle of all copies, links or regions that it names."""
    region = None
    if isinstance(target, BodyPoint):
        target, region = target.body, target.region
    if not isinstance(target, str):
        return target
    copies, link = select(target, scene.placed)
    found = [scene.points.in_world(copy, link, region) for copy in copies]
    x, y, z = (round(sum(axis) / len(found), 6) for axis in zip(*found, strict=True))
    return (x, y, z)


def check_targets(loaded: LoadedCase, placed: dict[str, list[Copy]], points: BodyPoints) -> list[Problem]:
    """Return what is wrong with the regions that cameras and lights look at.

    Args:
        loaded: The case.
        placed: Copies by static and body.
        points: Finds points of regions.
    """
    problems = []
    scene = FilmedScene(placed, (), {}, points, 1.0)
    render = loaded.case.render
    for section, things in (("cameras", render.cameras), ("lights", render.lights)):
        for name, thing in things.items():
            for key in ("look_at", "focus", "at"):
                target = getattr(thing, key, None)
                if not isinstance(target, BodyPoint):
                    continue
                try:
                    resolve_target(target, scene)
                except RegionError as error:
                    where = ("render", section, name, key, "region")
                    problems.append(loaded.problem(where, f"{target.body}: {error}", rule="empty-region"))
    return problems


def extent(scene: FilmedScene) -> tuple[Vec, float]:
    """Return the middle [m] of what the film shows at the start, and the radius [m] of a ball around it."""
    moving = scene.around(scene.moving)
    balls = moving + scene.around(_near_statics(moving, scene)) if moving else scene.around(scene.placed)
    box = _box(_to_the_ground(balls, scene))
    return _rounded(middle(box)), round(dist(*box) / 2, 4)


def ground_planes(scene: FilmedScene) -> list[Copy]:
    """Return the level planes of the scene."""
    return [copy for copy in _planes(scene) if abs(copy.quat[1]) + abs(copy.quat[2]) < 1e-9]


def _focus(focus: Any, scene: FilmedScene) -> Any:
    if not isinstance(focus, str):
        return resolve_target(focus, scene)
    copies, link = select(focus, scene.placed)
    if len(copies) > 1 or body_of(focus) not in scene.moving:
        return resolve_target(focus, scene)
    return {"body": copies[0].name, "link": link}


def _frame(camera: Still | Orbit | Follow, scene: FilmedScene) -> dict[str, Any]:
    assert camera.frame is not None
    margin = DEFAULT_MARGIN if camera.margin is None else camera.margin
    within = None if camera.within is None else (camera.within.min, camera.within.max)
    return {"bodies": _plain_names(camera.frame, scene), "margin": margin, "within": within}


def _plain_names(selectors: list[str], scene: FilmedScene) -> list[str]:
    """Return selectors as recorded states know them: a body for all its copies, or a copy, and links of either."""
    found = []
    for selector in selectors:
        chosen = parse_selector(selector)
        copies, part = select(selector, scene.placed)
        names = [chosen.body] if chosen.first is None else [copy.name for copy in copies]
        found += [name if part is None else f"{name}.{part}" for name in names]
    return found


def _names(selectors: list[str]) -> list[str]:
    return list(dict.fromkeys(map(body_of, selectors)))


def _framed(camera: dict[str, Any], balls: list[Ball], scene: FilmedScene) -> dict[str, Any]:
    """Return a camera with its place if nothing moves, in short numbers."""
    from text2sim.templates.cameras import framed_balls  # here, since importing numpy takes a tenth of a second

    found = framed_balls(camera, balls or [((0.0, 0.0, 0.0), 1.0)], scene.aspect)
    numbers = {key: round(float(found[key]), 4) for key in ("fov", "radius", "height") if key in found}
    found |= numbers | {key: _rounded(found[key]) for key in ("pos", "look_at", "offset", "aside") if key in found}
    return {key: found[key] for key in [*(key for key in found if key != "frame"), "frame"]}


def _subject_balls(names: list[str], scene: FilmedScene) -> list[Ball]:
    """Return balls around what a frame is to show, as known at the start, and around where it will fall."""
    moving = scene.around([name for name in names if name in scene.moving])
    return _to_the_ground(moving, scene) + scene.around([name for name in names if name not in scene.moving])


def _free_direction(names: Any, scene: FilmedScene) -> Vec:
    """Return the direction to a camera whose view of the bodies is free."""
    balls = _to_the_ground(scene.around(names), scene)
    own = {*scene.moving, *names}
    statics = [copy for name, copies in scene.placed.items() if name not in own for copy in copies]
    size = sides(_box(balls))
    return free_direction([center for center, _ in balls], statics, scene.points, 3 * max(size), size)


def _to_the_ground(balls: list[Ball], scene: FilmedScene) -> list[Ball]:
    """Return the balls, and where they will land if there is ground not too far below."""
    level = max((copy.pos[2] for copy in ground_planes(scene)), default=-inf)
    return balls + [((x, y, level + r), r) for (x, y, z), r in balls if r < z - level < MAX_GROUND_DISTANCE]


def _near_statics(moving: list[Ball], scene: FilmedScene) -> list[str]:
    """Return the statics that stand near what moves, and are not too large to be shown with it."""
    if not moving:
        return [name for name in scene.placed if scene.around([name])]
    box = _box(moving)
    size = max(sides(box))
    found = []
    for name in scene.placed:
        if name in scene.moving or not (balls := scene.around([name])):
            continue
        own = _box(balls)
        if not apart(own, grown(box, MAX_STATIC_DISTANCE * size)) and max(sides(own)) <= MAX_STATIC_SIZE * size:
            found.append(name)
    return found


def _planes(scene: FilmedScene) -> list[Copy]:
    return [copy for copies in scene.placed.values() for copy in copies if _is_plane(copy)]


def _is_plane(copy: Copy) -> bool:
    return getattr(getattr(copy.model, "shape", None), "kind", None) == "plane"


def _box(balls: list[Ball]) -> Bounds:
    return around_balls(balls or [((0.0, 0.0, 0.0), 1.0)])


def _rounded(point: Any, digits: int = 4) -> Vec:
    x, y, z = (round(float(c), digits) for c in point)
    return (x, y, z)
