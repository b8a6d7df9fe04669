"""Backdrops: a floor and a wall, a seamless studio wall, or endless ground.

As in a studio, the wall stands only where a camera looks. Light escapes through the open sides, which makes frames
cheaper: in a closed room every light path reaches its maximum length.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from text2sim.rendering.meshes import RenderMesh, joined, revolved
from text2sim.rendering.skyline import blurred, skyline
from text2sim.templates.cameras import basis

Array = NDArray[np.floating]

WALL = 0.9
"""Height of a cyclorama's wall above its curve, in radii."""
NEAR = 0.5
"""Distance at which the curve of the wall begins, in radii; the floor continues on its open side, under lamps and
cameras."""
CLEARANCE = 1.15
"""Distance at which the curve begins behind a camera that stands in front of it, in distances of that camera."""
FILLET = 0.35
"""Radius of the curve between floor and wall, in radii."""
STEPS = 40
SIDES = 192
BEHIND = np.radians(75.0)
"""Angle [rad] that the wall extends to both sides of a camera's viewing direction."""
BEYOND_EDGE = np.radians(6.0)
"""Angle [rad] that the wall extends beyond the field of view of cameras."""
HAZY = {"ground": 0.8, "horizon": 1.2}
"""Distance from the camera at which endless ground fades into haze, in radii of the stage."""
OPEN, NEAREST_WOOD = 4.0, 30.0
"""That distance before a skyline, in radii of the stage, and its least [m]: it meets the ground at a thin line."""
CLEAR, MAX_CLEARING = 2.5, 6.0
"""That distance is at least this many distances of the farthest body, and grows by this factor at most."""
FADING, EDGE = 4, 14
"""Exponents of the fall in transmittance with distance: into haze, and at a skyline, whose foot it has to meet."""
LOST = 1.5
"""Radius of endless ground, in distances of haze: less than a hundredth of it would be visible there."""
OVERHEAD = 0.5
"""Sine of the elevation at which a sky has its full colour."""
WHOLE = 0.999
"""Alpha of a completely covered pixel."""
SUNK = 1e-4
"""Depth of the floor below the level on which bodies stand [m], so that the two surfaces do not coincide."""


SPREAD = np.radians(40.0)
"""Largest angle [rad] between the directions of cameras and that of most of them for which the wall is straight."""
DEEP, SHALLOW = 5.0, 2.2
"""Largest and smallest distance of a straight wall, in radii of the subject."""
BEYOND, PERCENTILE = 0.7, 99.0
"""Distance of a straight wall behind this percentile [%] of all visible points, in radii of the subject."""
WIDE, TALL = 9.0, 3.2
"""Smallest width and height of a straight wall, in its distances. It meets the floor at an edge: a curve would catch
the light as a pale band."""
WIDEST, TALLEST, MARGIN = 30.0, 12.0, 1.05
"""Largest width and height of a straight wall, in its distances; beyond them the wall is round. Its extent relative to
the visible part."""


class Wall(NamedTuple):
    """A wall behind the scene."""

    mesh: RenderMesh
    uvs: Array | None = None
    """Texture coordinates from 0 to 1 along and up, shape (n, 2); None for a round wall."""
    size: tuple[float, float] = (0.0, 0.0)
    """Width and height of a straight wall [m]."""
    away: float = 0.0
    """Distance of a straight wall behind the middle of the scene [m]."""


def edge_rays(view: Any, aspect: float) -> Array:
    """Return ray directions: the image centre, then the left and right edges from bottom to top, shape (n, 3).

    Args:
        view: View of the film's camera.
        aspect: Width of the picture divided by its height.
    """
    right, up, ahead = (np.array(axis) for axis in basis(view.pos, view.look_at, view.up))
    tall = np.tan(np.radians(view.fov) / 2)
    sides = [x * aspect * right + y * up for x in (-1, 1) for y in np.linspace(-1, 1, 9)]
    return np.stack([ahead, *(ahead + tall * side for side in sides)])


def upper_edge(view: Any) -> float:
    """Return the elevation [rad] of the middle of a picture's upper edge."""
    _, up, ahead = (np.array(axis) for axis in basis(view.pos, view.look_at, view.up))
    ray = ahead + np.tan(np.radians(view.fov) / 2) * up
    return float(np.arcsin(ray[2] / np.linalg.norm(ray)))


def wall_mesh(
    backdrop: dict[str, Any], eyes: Iterable[Array], things: Array, stage: float, rays: Sequence[Array] = ()
) -> Wall:
    """Return a wall behind the scene.

    The wall is straight, or round if cameras look along it or in too many directions for a straight one. No camera sees
    its ends.

    Args:
        backdrop: The resolved backdrop of the film section, with a level.
        eyes: Sampled positions of the cameras [m].
        things: Positions of everything visible, over the whole film [m], shape (n, 3).
        stage: Radius of the stage [m].
        rays: `edge_rays` of each camera.
    """
    eyes = list(eyes)
    # A camera that follows something looks past the centre.
    looks = [rays_of[0] for rays_of in rays] or [np.subtract(backdrop["center"], eye) for eye in eyes]
    headings = np.array([look[:2] for look in looks], float).reshape(-1, 2)
    headings = headings[np.hypot(*headings.T) > 1e-6]
    headings /= np.hypot(*headings.T)[:, None]
    ahead = _usual(headings)
    extent, away = None, 0.0
    if len(headings) and (headings @ ahead).min() >= np.cos(SPREAD):
        depths = (things[:, :2] - backdrop["center"][:2]) @ ahead
        # Outliers may pass through the wall: it is placed behind most things.
        reach = float(np.percentile(depths, PERCENTILE)) if len(depths) else 0.0
        away = float(np.clip(reach + BEYOND * stage, SHALLOW * stage, DEEP * stage))
        extent = _extent(backdrop, eyes, rays, ahead, away)
    if extent is None:
        radius = max(float(backdrop["radius"]), _farthest(backdrop, eyes, rays) * CLEARANCE / NEAR)
        mesh = _round_wall(backdrop, eyes, radius, rays)
        x, y = backdrop["center"][:2]
        placed = mesh.vertices + (x, y, backdrop["level"] - SUNK)
        return Wall(RenderMesh(placed, mesh.faces, mesh.normals))
    width, height = extent
    side, rise = np.linspace(-width / 2, width / 2, 49), np.linspace(0, height, 25)
    foot = away * ahead + side[:, None] * np.array([ahead[1], -ahead[0]])
    vertices = np.concatenate(
        [np.repeat(foot[:, None], len(rise), axis=1), np.broadcast_to(rise[:, None], (len(side), len(rise), 1))], axis=2
    )
    normals = np.broadcast_to([*-ahead, 0.0], vertices.shape)
    k = np.arange(len(side) * len(rise)).reshape(len(side), len(rise))
    corners = [k[:-1, :-1].ravel(), k[1:, :-1].ravel(), k[1:, 1:].ravel(), k[:-1, 1:].ravel()]
    faces = np.concatenate([np.stack([corners[i] for i in row], axis=1) for row in ((0, 2, 1), (0, 3, 2))])
    uvs = np.stack(np.meshgrid(side / width + 0.5, rise / height, indexing="ij"), axis=-1).reshape(-1, 2)
    x, y = backdrop["center"][:2]
    placed = vertices.reshape(-1, 3) + (x, y, backdrop["level"] - SUNK)
    return Wall(RenderMesh(placed, faces, normals.reshape(-1, 3)), uvs, (width, height), away)


def blocks_light(wall: RenderMesh, center: Array, stage: float, lights: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether a wall keeps the strongest light that has a direction from the scene.

    Args:
        wall: The wall.
        center: Middle of the scene [m], shape (3,).
        stage: Radius of the stage [m].
        lights: Resolved lights of the film section.
    """
    directed = [light for light in lights if "direction" in light]
    if not directed:
        return False
    key = max(directed, key=lambda light: float(light["strength"]))
    back = -np.asarray(key["direction"], float) / np.linalg.norm(key["direction"])
    spots = center + stage / 2 * np.array([(0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
    a, b, c = (wall.vertices[wall.faces[:, k]] for k in range(3))
    across = np.cross(back, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1 / ((b - a) * across).sum(axis=1)
        for spot in spots:  # Moeller and Trumbore, 1997
            u = ((spot - a) * across).sum(axis=1) * scale
            normal = np.cross(spot - a, b - a)
            v, away = (normal @ back) * scale, ((c - a) * normal).sum(axis=1) * scale
            if ((u >= 0) & (v >= 0) & (u + v <= 1) & (away > 0) & (away < key.get("distance", np.inf))).any():
                return True
    return False


def _usual(headings: Sequence[Array]) -> Array:
    """Return the horizontal direction (2,) of most cameras: they see the foot of a wall across it as level."""
    flat = np.array([direction for direction in headings if np.hypot(*direction) > 1e-6]).reshape(-1, 2)
    if not len(flat):
        return np.zeros(2)
    flat /= np.hypot(*flat.T)[:, None]
    apart = np.arccos(np.clip(flat @ flat.T, -1.0, 1.0))
    return flat[apart.sum(axis=1).argmin()]


def _extent(
    backdrop: dict[str, Any], eyes: Sequence[Array], rays: Sequence[Array], ahead: Array, away: float
) -> tuple[float, float] | None:
    """Return the width and height [m] of a straight wall whose ends no camera sees; None if it would be too large."""
    width, height = WIDE * away, TALL * away
    across, onto = np.array([ahead[1], -ahead[0], 0.0]), np.append(ahead, 0.0)
    for eye, directions in zip(eyes, rays, strict=False):
        place = np.subtract(eye, [*backdrop["center"][:2], backdrop["level"]])
        with np.errstate(divide="ignore", invalid="ignore"):
            if place @ onto >= away:  # it stands behind the wall
                return None
            far = (away - place @ onto) / np.maximum(directions @ onto, 0.0)
            floor = np.where(directions[:, 2] < 0, -place[2] / directions[:, 2], np.inf)
        directions, far = directions[far <= floor], far[far <= floor]
        if not np.isfinite(far).all():
            return None
        met = place + far[:, None] * directions
        width = max(width, 2 * MARGIN * float(np.abs(met @ across).max(initial=0.0)))
        height = max(height, MARGIN * float(met[:, 2].max(initial=0.0)))
    return (width, height) if width < WIDEST * away and height < TALLEST * away else None


def backdrop_mesh(
    backdrop: dict[str, Any], eyes: Iterable[Array], rays: Sequence[Array] = (), reach: float = 0.0, haze: float = 0.0
) -> RenderMesh | None:
    """Return the mesh of a backdrop without its wall (see `wall_mesh`); None if there is none.

    Args:
        backdrop: The resolved backdrop of the film section.
        eyes: Sampled positions of the cameras [m].
        rays: `edge_rays` of each camera.
        reach: Smallest radius of a floor with a wall [m].
        haze: Largest distance at which endless ground fades, see `haze_distance` [m].
    """
    kind, eyes = backdrop["kind"], list(eyes)
    if kind == "none" or backdrop["level"] is None:
        return None
    if kind in ("cyclorama", "wall"):
        radius = max(float(backdrop["radius"]), _farthest(backdrop, eyes, rays) * CLEARANCE / NEAR, reach)
    else:
        off = [np.hypot(*np.subtract(eye, backdrop["center"])[:2]) for eye in eyes]
        radius = LOST * haze + max(off, default=0.0)
    rings = radius * np.geomspace(0.05, 1.0, STEPS)
    ground = _turned(np.column_stack([np.append(0.0, rings), np.zeros(STEPS + 1)]), np.tile([0.0, 1.0], (STEPS + 1, 1)))
    if kind == "cyclorama":
        ground = joined([ground, _round_wall(backdrop, eyes, radius, rays)])
    x, y = backdrop["center"][:2]
    return RenderMesh(ground.vertices + (x, y, backdrop["level"] - SUNK), ground.faces, ground.normals)


def haze_distance(backdrop: dict[str, Any], eye: Array, places: Array) -> float:
    """Return the distance from the camera [m] at which endless ground fades into haze; 0 without any.

    Args:
        backdrop: The resolved backdrop of the film section.
        eye: Position of the camera [m].
        places: Extreme points of everything visible [m], shape (n, 3).
    """
    usual = HAZY.get(backdrop["kind"], 0.0) * float(backdrop["radius"])
    if usual and "skyline" in backdrop:
        usual = max(OPEN * float(backdrop["radius"]), NEAREST_WOOD)
    away = np.percentile(np.linalg.norm(places - eye, axis=1), PERCENTILE) if usual and len(places) else 0.0
    return min(max(usual, CLEAR * float(away)), MAX_CLEARING * usual)


def clearness(haze: float, depth: Array, alpha: Array, *, edge: bool = False) -> Array:
    """Return the transmittance of the haze, 0 to 1: the ground fades out before its hard edge.

    Args:
        haze: Distance from the camera at which endless ground fades [m]; 0 without haze.
        depth: Distance from the camera [m], 0 for empty pixels, shape (h, w).
        alpha: Coverage of each pixel, 0 to 1, shape (h, w).
        edge: Whether the ground ends there, at a skyline, instead of fading.
    """
    if not haze:
        return np.ones_like(depth)
    # Only some samples of a pixel at the ground's edge hit it: take the depth of its neighbours.
    away = np.where(alpha < WHOLE, maximum_filter(depth, size=3), depth)
    return np.exp(-((away / haze) ** (EDGE if edge else FADING)))


def sky(backdrop: dict[str, Any], background: Array, view: Any, size: tuple[int, int], far: int = 1) -> Array:
    """Return the background in sRGB: one colour, shape (3,), or a sky, shape (h, 1 or w, 3).

    Args:
        backdrop: The resolved backdrop of the film section; `sky` is the colour at the zenith.
        background: Colour at the horizon.
        view: View of the film's camera.
        size: Width and height of the picture [pixels].
        far: How many times as far away as usual the skyline is.
    """
    if "sky" not in backdrop:
        return np.asarray(background, float)
    right, up, ahead = (np.array(axis) for axis in basis(view.pos, view.look_at, view.up))
    width, height = size
    tall = np.tan(np.radians(view.fov) / 2)
    y = tall * (1 - 2 * (np.arange(height) + 0.5) / height)[:, None, None]
    x = tall * width / height * (2 * (np.arange(width) + 0.5) / width - 1)[None, :, None]
    rays = ahead + x * right + y * up
    rays = (rays / np.linalg.norm(rays, axis=-1, keepdims=True)).astype(np.float32)
    overhead = np.clip(rays[..., 2:] / OVERHEAD, 0.0, 1.0) ** 0.7
    sky = background + (np.asarray(backdrop["sky"]) - background) * overhead
    if "skyline" not in backdrop:
        return sky
    pixel = 2 * tall / height
    sky = skyline(backdrop["skyline"], rays, np.asarray(background, float), pixel, sky, far)
    return blurred(sky, view.aperture / max(view.focus, 1e-6) / pixel)


def _round_wall(backdrop: dict[str, Any], eyes: Sequence[Array], radius: float, rays: Sequence[Array]) -> RenderMesh:
    bend, near = FILLET * radius, NEAR * radius
    turn = np.linspace(0, np.pi / 2, STEPS)
    curve = np.stack([near + bend * np.sin(turn), bend - bend * np.cos(turn)], axis=1)
    slopes = np.stack([-np.sin(turn), np.cos(turn)], axis=1)
    top = [(near + bend, WALL * radius + bend)]
    wall = _turned(np.concatenate([curve, top]), np.concatenate([slopes, slopes[-1:]]))
    return _open(wall, backdrop, eyes, near + bend, rays)


def _turned(profile: Array, slopes: Array) -> RenderMesh:
    mesh = revolved(profile, slopes, sides=SIDES)
    # The room is seen from inside, so its faces are flipped.
    return RenderMesh(mesh.vertices, mesh.faces[:, ::-1], mesh.normals)


def _farthest(backdrop: dict[str, Any], eyes: Sequence[Array], rays: Sequence[Array]) -> float:
    """Return the distance [m] of the farthest camera that the wall must not hide.

    Such a camera has a wall behind it, because another camera looks towards it, it looks past the centre, or its
    picture is wider than a wall behind a small scene.
    """
    away = np.array([np.asarray(eye, float)[:2] for eye in eyes]).reshape(-1, 2) - backdrop["center"][:2]
    angle = np.arctan2(away[:, 1], away[:, 0])
    inside = (_between(angle[:, None], angle[None] + np.pi) < BEHIND).any(axis=1)
    if len(rays):
        looks = np.array([rays_of[0][:2] for rays_of in rays])
        past = _between(angle + np.pi, np.arctan2(looks[:, 1], looks[:, 0])) > SPREAD
        inside |= past & (np.hypot(*looks.T) > 1e-6)
        corners = [np.arctan2(rays_of[:, 1], rays_of[:, 0]) for rays_of in map(np.asarray, rays)]
        widest = [_between(angle[k] + np.pi, of).max() for k, of in enumerate(corners)]
        distance = np.hypot(*away.T)
        wide = distance * np.sin(np.minimum(widest, np.pi / 2)) > NEAR * backdrop["radius"]
        inside |= wide & (distance > NEAR * backdrop["radius"])
    return float(np.hypot(*away[inside].T).max(initial=0.0))


def _between(a: Array, b: Array) -> Array:
    """Return the angle [rad] between two directions, 0 to pi."""
    return np.abs((a - b + np.pi) % (2 * np.pi) - np.pi)


def _open(
    wall: RenderMesh, backdrop: dict[str, Any], eyes: Sequence[Array], radius: float, rays: Sequence[Array]
) -> RenderMesh:
    """Return the part of a round wall that cameras see behind the scene."""
    middle = wall.vertices[wall.faces].mean(axis=1)
    angle = np.arctan2(middle[:, 1], middle[:, 0])
    kept = np.zeros(len(angle), bool)
    for eye, directions in zip_longest(eyes, rays):
        x, y = np.subtract(backdrop["center"][:2], np.asarray(eye)[:2])
        if np.hypot(x, y) < 1e-6:  # looks straight down
            kept[:] = True
            continue
        kept |= _between(angle, np.arctan2(y, x)) < BEHIND
        if directions is not None:
            bearings = _met_at(np.array([-x, -y]), directions[:, :2], radius)
            widest = _between(bearings, bearings[0]).max() + BEYOND_EDGE
            kept |= _between(angle, bearings[0]) < widest
    return RenderMesh(wall.vertices, wall.faces[kept], wall.normals)


def _met_at(place: Array, directions: Array, radius: float) -> Array:
    """Return the angles [rad] about the centre where rays from a point (2,) in directions (n, 2) hit a round wall."""
    directions = directions / np.maximum(np.hypot(*directions.T), 1e-9)[:, None]
    along = directions @ place
    far = np.sqrt(np.maximum(along**2 - place @ place + radius**2, 0.0)) - along
    met = place + far[:, None] * directions
    return np.arctan2(met[:, 1], met[:, 0])
