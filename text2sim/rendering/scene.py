"""Scene of the path tracer at one time of a recording.

It is rebuilt for every time, with cached meshes of static bodies. That takes a hundredth of a frame's time, and works
for deformable, liquid and rigid bodies alike.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import floor, log10
from typing import Any, NamedTuple

import numpy as np

from text2sim.compiler.film_lights import CYCLORAMA_RADIUS
from text2sim.compiler.shapes.rotation import quats_to_matrices
from text2sim.recording.film_record import FilmRecord, SurfaceLook, WornMesh
from text2sim.rendering.backdrop import backdrop_mesh, blocks_light, edge_rays, haze_distance, wall_mesh
from text2sim.rendering.finishes import material, needs_uvs
from text2sim.rendering.floors import floor_material
from text2sim.rendering.hangers import hangers
from text2sim.rendering.lights import dome, dome_radiance, emitters, gradient
from text2sim.rendering.meshes import RenderMesh
from text2sim.rendering.offstage import EYES, offstage, views_of
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.rigid import batches
from text2sim.rendering.shapes import mesh_shape, shaded
from text2sim.rendering.soft import SoftBodies
from text2sim.rendering.springs import Springs
from text2sim.rendering.supports import COLOR as POSTS
from text2sim.rendering.supports import supports
from text2sim.rendering.tone import linear
from text2sim.rendering.walls import wall_material
from text2sim.rendering.wetting import Wall
from text2sim.templates.cameras import View, basis

BACKDROP_FINISH = "rough"
ROOM_BRIGHTNESS = 0.8
"""Brightness of the room that glass reflects, as a fraction of the background's."""
CEILING, WALLS = 1.1, 0.58
"""Radiance of the room that metals reflect, overhead and at eye level, relative to a white sheet: what a film does not
show is empty, and polished steel would reflect black."""
ROOM_RADIUS = 2.0
"""Radius of what a film shows [m] from which textures have their full size."""
SMALLEST_TEXTURE_SCALE = 0.2
LENS = ("aperture_radius", "focus_distance")
"""Parameters of a sensor that the renderer would compile as constants; it treats the others as variable by itself."""
MAX_HAZE_POINTS = 5000
"""Largest number of extreme points that decide where haze begins."""


def texture_scale(radius: float) -> float:
    """Return the factor on the lengths that textures cover, so that a small scene shows their details, too.

    Args:
        radius: Radius of what a film shows [m].
    """
    return round(min(1.0, max(SMALLEST_TEXTURE_SCALE, radius / ROOM_RADIUS)), 2)


@dataclass(frozen=True)
class FilmMoment:
    """The scene at one time."""

    solid: Any
    """All bodies except clear ones."""
    gloss: Any = None
    """Reflections of clear bodies only: everything else is black. None if nothing is clear."""
    filters: Any = None
    """Coloured transparent bodies; None if there are none."""
    liquids: Any = None
    """All surfaces of `solid`, and clear liquids; None if there are none."""
    room: Any = None
    """What clear bodies reflect where nothing is."""
    metals: Any = None
    """What metals reflect where nothing is, besides the lamps and the light of `solid`: everything else is black. None
    without metals, or if they lack nothing."""


class _Placed(NamedTuple):
    """What moves, at one time."""

    t: float
    """Simulated time [s]."""
    pos: Any
    """Positions of links [m], shape (L, 3)."""
    quat: Any
    """Their orientations (w, x, y, z), shape (L, 4)."""
    around: Any
    """Where the time lies among the recorded ones."""
    flowing: list[Any]
    """Liquids, and what makes a shape of each with a material."""
    rods: RenderMesh | None
    """Rods that hold driven bodies."""


class FilmStage:
    """Everything that a film shows."""

    def __init__(self, recording: FilmRecord):
        self.recording, film = recording, recording.film
        self.backdrop = film["backdrop"] | {"level": self._level()}
        self._stage = float(self.backdrop["radius"]) / CYCLORAMA_RADIUS
        """Radius of what the film shows [m]."""
        self._fixed: dict[str, Any] = {"type": "scene"}
        self._kept: tuple[_Placed, FilmMoment] | None = None
        self._views = views_of(recording)
        self._floor, replaced = self._floor_look()
        hidden = replaced | offstage(recording, self._views)
        self._backdrop = self._make_backdrop()
        center, radius = np.asarray(self.backdrop["center"], float), float(self.backdrop["radius"])
        self._fixed |= emitters(film["lights"], center, radius)
        posts, self._rods = None, None
        if self.backdrop.get("supports") and self.backdrop["level"] is not None:
            level, ground = float(self.backdrop["level"]), hidden | set(self.backdrop["planes"])
            posts = supports(recording, level, ground, self._views)
            self._rods = hangers(recording, self.backdrop.get("driven", []), level, self._views)
        if posts is not None:
            self._backdrop["supports"] = _painted("supports", posts, _post_colors(posts)), self._post
        self._fixed |= {name: make(bsdf) for name, (make, bsdf) in self._backdrop.items()}
        scale = texture_scale(self._stage)
        self._level_square = [_square(self.backdrop)] if replaced else []
        shown = [part for part in recording.parts if part.body not in hidden]
        self._rigid = batches(shown, recording.statics, scale)
        self._springs = Springs(recording) if recording.film.get("springs") else None
        states = recording.states.soft
        self._soft = None if states is None else SoftBodies(recording.soft, states, scale)

    def _floor_look(self) -> tuple[SurfaceLook, set[str]]:
        """Return the look of the backdrop, and the planes of the scene that it replaces.

        A plane of the scene has visible edges. So the backdrop replaces it and takes over its look.
        """
        recording, level = self.recording, self.backdrop["level"]
        look = SurfaceLook(recording.film["background"], finish=BACKDROP_FINISH)
        if self.backdrop["kind"] == "none" or level is None:
            return look, set()
        flat = [
            part for part in recording.parts if part.body in recording.statics and _is_plane(part, recording, level)
        ]
        planes = set(self.backdrop["planes"])
        plain = [part for part in flat if part.body not in planes and part.look.visible and not _patterned(part.look)]
        if plain:
            look = plain[0].look
            if needs_uvs(look.finish):  # wood grain does not suit a wall or endless ground
                look = replace(look, finish=BACKDROP_FINISH)
        return look, planes | {part.body for part in plain}

    def _level(self) -> float | None:
        """Return the height of the floor [m]; without one, the lowest point of everything visible."""
        level = self.recording.film["backdrop"]["level"]
        if level is not None:
            return level
        states = self.recording.states
        times = states.time[:: max(1, len(states.time) // EYES)]
        bodies = self.recording.bodies
        lowest = [states.bounds(bodies, float(t))[:, 2].min() for t in times] if bodies else []
        # Bodies that fall out of the picture do not lower the floor.
        return float(max(min(lowest), lowest[0] - np.ptp(states.bounds(bodies, 0.0)[:, 2]))) if lowest else None

    def at(self, t: float, *, gloss: bool = True, metals: bool = True) -> FilmMoment:
        """Return the scene at a time.

        Args:
            t: Simulated time [s].
            gloss: Whether the reflections of clear bodies are needed.
            metals: Whether those of the room in metals are needed.
        """
        now, moment = self._plain(t)
        gloss, metals = gloss and self._is_glossy, metals and self._metal_room is not None
        if not (gloss or metals):
            return moment
        mi, dark = mitsuba(), self._darkened(now)
        if metals:
            bright = {batch.name: batch.shape(now.pos, now.quat, t) for batch in self._rigid if batch.is_metal}
            if self._springs is not None:
                bright |= self._springs.shapes(t, metal_only=True)
            mirrored = {"type": "scene", "dome": self._metal_room} | dark | bright
            moment = replace(moment, metals=mi.load_dict(mirrored, optimize=False))
        return self._glossed(moment, now, dark) if gloss else moment

    def _plain(self, t: float) -> tuple["_Placed", FilmMoment]:
        """Return what moves at a time [s], and the scene without gloss and metals; the last one is kept.

        It goes before the next is made: kernels depend on the numbers of its shapes, which the next then takes over.
        """
        if self._kept is not None and self._kept[0].t == t:
            return self._kept
        self._kept = None
        now, solid = self._placed(t), [batch for batch in self._rigid if not batch.is_clear]
        shapes: dict[str, Any] = {batch.name: batch.shape(now.pos, now.quat, t) for batch in solid}
        if now.rods is not None:
            shapes["rods"] = _painted("rods", now.rods, _post_colors(now.rods))(self._post)
        if self._soft is not None:
            shapes |= self._soft.shapes(now.around)
        if self._springs is not None:
            shapes |= self._springs.shapes(t)
        shapes |= {liquid.name: make(liquid.bsdf) for liquid, make in now.flowing if not liquid.is_clear}
        mi, liquids = mitsuba(), None
        scene = mi.load_dict(self._fixed | shapes, optimize=False)
        if water := {liquid.name: make(liquid.bsdf) for liquid, make in now.flowing if liquid.is_clear}:
            backdrop = {name: self._fixed[name] for name in self._backdrop}
            liquids = mi.load_dict({"type": "scene"} | backdrop | shapes | water, optimize=False)
        self._kept = now, FilmMoment(scene, liquids=liquids, room=None if liquids is None else self._room)
        return self._kept

    def _placed(self, t: float) -> "_Placed":
        """Return what moves at simulated time `t` [s]."""
        pos, quat = self.recording.states.poses(t)
        around, flowing = self.recording.states.around(t), []
        if self._soft is not None and self._soft.has_liquids:
            surfaces = [wall for batch in self._rigid for wall in batch.walls(pos, quat)]
            flowing = self._soft.liquids(around, [*self._level_square, *surfaces])
        return _Placed(t, pos, quat, around, flowing, None if self._rods is None else self._rods.placed(pos, quat))

    @property
    def _is_glossy(self) -> bool:
        return any(batch.is_clear for batch in self._rigid) or (self._soft is not None and self._soft.has_skins)

    def _darkened(self, now: "_Placed") -> dict[str, Any]:
        """Return all that is not clear, in black, by name."""
        # A black mirror instead of black paint: a mirror sends no rays to the lamps.
        black = mitsuba().load_dict({"type": "conductor", "specular_reflectance": {"type": "rgb", "value": 0.0}})
        solid = [batch for batch in self._rigid if not batch.is_clear]
        dark = {batch.name: batch.shape(now.pos, now.quat, now.t, black) for batch in solid}
        dark |= {liquid.name: make(black) for liquid, make in now.flowing}
        if now.rods is not None:
            dark["rods"] = _painted("rods", now.rods, _post_colors(now.rods))(black)
        if self._springs is not None:
            dark |= self._springs.shapes(now.t, black)
        if self._soft is not None:
            dark |= self._soft.shapes(now.around, black)
        return dark | {name: make(black) for name, (make, _) in self._backdrop.items()}

    def _glossed(self, moment: FilmMoment, now: "_Placed", dark: dict[str, Any]) -> FilmMoment:
        """Return a moment with the reflections of clear bodies, and their colours."""
        mi, clear = mitsuba(), [batch for batch in self._rigid if batch.is_clear]
        colored = {batch.name: batch.shape(now.pos, now.quat, now.t) for batch in clear if batch.filters}
        shapes = dark | {batch.name: batch.shape(now.pos, now.quat, now.t) for batch in clear}
        if self._soft is not None and self._soft.has_skins:
            skins = self._soft.shapes(now.around, clear=True)
            colored, shapes = colored | skins, shapes | skins
        filters = mi.load_dict({"type": "scene"} | colored, optimize=False) if colored else None
        gleaming = mi.load_dict(self._fixed | shapes | {"dome": self._room}, optimize=False)
        return replace(moment, gloss=gleaming, filters=filters, room=self._room)

    @cached_property
    def _post(self) -> Any:
        """Material of posts and rods."""
        return material("painted", two_sided=True)

    @cached_property
    def _room(self) -> Any:
        """What glass and water reflect besides lamps: a dome in place of the lit room.

        It is bright above and fades towards the floor: otherwise a flat pane would reflect a hard line between the two.
        """
        film = self.recording.film
        return dome(gradient(linear(np.asarray(film["background"])) * ROOM_BRIGHTNESS / film["gain"], np.zeros(3)))

    @cached_property
    def _metal_room(self) -> Any:
        """What metals reflect of a room beyond the light of the film's own domes; None if that is nothing."""
        sprung = self._springs is not None and self._springs.has_metal
        if not (sprung or any(batch.is_metal for batch in self._rigid)):
            return None
        film = self.recording.film
        missing = gradient(np.full(3, CEILING), np.full(3, WALLS)) / film["gain"] - dome_radiance(film["lights"])
        return dome(np.maximum(missing, 0.0)) if (missing > 0).any() else None

    def _make_backdrop(self) -> dict[str, tuple[Callable[[Any], Any], Any]]:
        """Return for the floor and the wall a factory that takes a material, and the default material."""
        views, backdrop, (wide, tall) = self._views, self.backdrop, self.recording.film["resolution"]
        eyes, rays, reach = [view.pos for view in views], [edge_rays(view, wide / tall) for view in views], 0.0
        wall = None
        if backdrop["kind"] == "wall" and backdrop["level"] is not None:
            wall = wall_mesh(backdrop, eyes, self._places, self._stage, rays)
            reach = float(np.hypot(*(wall.mesh.vertices[:, :2] - backdrop["center"][:2]).T).max())
            if blocks_light(
                wall.mesh, np.array(backdrop["center"]), self._stage, self.recording.film["lights"].values()
            ):
                wall, reach = None, 0.0  # it would shade the scene; the background has its colour
        mesh = backdrop_mesh(backdrop, eyes, rays, reach, max(map(self.haze, eyes), default=0.0))
        if mesh is None:
            return {}
        floor = backdrop.get("floor")
        bare = material(self._floor.finish, two_sided=True)
        laid = bare if floor is None else floor_material(floor["pattern"], floor["color"], floor["tile"])
        color, _ = shaded(self._floor.color, self._floor.finish)
        shapes = {"backdrop": (_painted("backdrop", mesh, np.broadcast_to(color, mesh.vertices.shape)), laid)}
        if wall is not None:
            painted = self.recording.film["background"]
            color = np.broadcast_to(linear(np.asarray(painted)), wall.mesh.vertices.shape)
            bsdf = (
                material(BACKDROP_FINISH, two_sided=True)
                if wall.uvs is None
                else wall_material(
                    backdrop.get("wall", "plain"), painted, wall, self._stage, window=backdrop.get("window", False)
                )
            )
            shapes["wall"] = _painted("wall", wall.mesh, color, wall.uvs), bsdf
        return shapes

    def haze(self, eye: Any) -> float:
        """Return the distance [m] at which endless ground fades for a camera at a position [m]."""
        # A frame's haze depends on its own camera alone, as its digest does.
        return haze_distance(self.backdrop, eye, self._places[:: 1 + len(self._places) // MAX_HAZE_POINTS])

    @cached_property
    def _places(self) -> Any:
        """Return the extreme points of everything visible, over the whole time [m], shape (n, 3)."""
        states, planes = self.recording.states, self.backdrop["planes"]
        bodies = [body for body in self.recording.bodies if body not in planes]
        times = states.time[:: max(1, len(states.time) // EYES)]
        clouds = [states.bounds(bodies, float(t)) for t in times] if bodies else []
        points = np.concatenate([np.zeros((0, 3)), *clouds])
        return points[np.isfinite(points).all(axis=1)]


def _square(backdrop: dict[str, Any]) -> Wall:
    """Return the floor that stands for planes of the scene."""
    x, y = backdrop["center"][:2]
    side = 2 * float(backdrop["radius"])
    corners = np.array([(x - side, y - side), (x + side, y - side), (x + side, y + side), (x - side, y + side)])
    return Wall(np.column_stack([corners, np.full(4, backdrop["level"])]), np.array([(0, 1, 2), (0, 2, 3)]))


def _painted(name: str, mesh: RenderMesh, colors: Any, uvs: Any = None) -> Callable[[Any], Any]:
    uvs = mesh.vertices[:, :2] if uvs is None else uvs
    return lambda bsdf: mesh_shape(name, bsdf, mesh.vertices, mesh.faces, mesh.normals, colors=colors, uvs=uvs)


def _post_colors(mesh: RenderMesh) -> Any:
    return np.broadcast_to(linear(np.array(POSTS)), mesh.vertices.shape)


def _patterned(look: SurfaceLook) -> bool:
    return look.picture is not None or look.decoration is not None


def _is_plane(part: WornMesh, recording: FilmRecord, level: float) -> bool:
    """Return whether a part is a floor plane at this height [m]."""
    pos, quat = recording.states.poses(0.0)
    with np.load(part.mesh) as mesh:
        corners = mesh["vertices"].astype(float)
    if len(corners) != 4:
        return False
    own, turned = quats_to_matrices(np.array([part.quat, quat[part.link]]))
    corners = (corners @ own.T + part.pos) @ turned.T
    return bool(np.abs(corners[:, 2] + pos[part.link, 2] - level).max() < 1e-3)


def sensor(view: View, size: tuple[int, int]) -> Any:
    """Return a Mitsuba sensor for a view of the film, of a width and height [pixels]."""
    mi = mitsuba()
    right, up, ahead = basis(view.pos, view.look_at, view.up)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, up, ahead], axis=1) * (-1.0, 1.0, 1.0)
    matrix[:3, 3] = view.pos
    away = float(np.linalg.norm(np.subtract(view.look_at, view.pos)))
    sensor: dict[str, Any] = {
        "type": "perspective",
        "fov": float(view.fov),
        "fov_axis": "y",
        "near_clip": max(_decade(away) * 1e-3, 1e-4),
        "far_clip": max(_decade(away) * 1e5, 1e4),
        "to_world": mi.ScalarTransform4f(matrix),
        "film": {
            "type": "hdrfilm", "width": size[0], "height": size[1], "pixel_format": "rgba", "rfilter": {"type": "box"},
            "component_format": "float32",
        },
        "sampler": {"type": "multijitter"},
    }  # fmt: skip
    if view.aperture > 0:
        sensor |= {"type": "thinlens", "aperture_radius": float(view.aperture), "focus_distance": float(view.focus)}
    return _unfrozen(mi.load_dict(sensor))


def _decade(length: float) -> float:
    """Return the power of ten below a length: values compiled into kernels must not change with every camera step."""
    return 10.0 ** floor(log10(max(length, 1e-6)))


def _unfrozen(sensor: Any) -> Any:
    """Return a sensor whose numbers are data of its kernels instead of compiled constants.

    Otherwise all kernels are recompiled whenever a camera moves, which takes ten times as long as tracing.
    """
    if mitsuba().variant().startswith("scalar"):
        return sensor
    import drjit

    parameters = mitsuba().traverse(sensor)
    for name in LENS:
        if name in parameters:
            value = parameters[name]
            drjit.make_opaque(value)
            parameters[name] = value
    parameters.update()
    return sensor
