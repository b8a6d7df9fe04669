"""Supports of statics, and of bases of mechanisms, that hang in the air: thin posts, which are only drawn.

Touching ones form a group. A group needs posts if its centre is not above its footprint on the floor, no part of it
that stands by itself reaches up to that height, and no wall is close to it that may hold it. Posts stand under the
corners of its largest part, where nothing passes in the recording, and out of the near half of all views; if half of
them would be in the way, rods hold it from above.
"""

from collections.abc import Collection
from dataclasses import dataclass
from itertools import compress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.assets.surface import triangle_areas
from text2sim.compiler.shapes.rotation import quats_to_matrices
from text2sim.recording.film_record import FilmRecord
from text2sim.rendering.meshes import RenderMesh, joined, read_mesh, revolved
from text2sim.templates.cameras import View
from text2sim.templates.playback import Boxes

Array = NDArray[np.floating]

COLOR = (0.44, 0.46, 0.48)
MOMENTS = 60
"""Number of moments of the recording at which the positions of moving bodies are sampled."""
TOUCH = 0.01
"""Largest gap between statics of one group, relative to the size of the smaller."""
NEAR = 0.03
"""Largest height over the floor of points that stand on it, relative to the size of the group."""
STEADY = 0.15
"""Largest distance of the centre of a group beyond its footprint, relative to the size of the group."""
CLOSE, WIDE = 0.1, 0.8
"""Largest gap between a group and a wall that holds it, and width of that wall, relative to the group's width."""
LOW = 0.08
"""Length of the shortest post, relative to the size of what it carries."""
INSET, SLIM, SMALL = 0.12, 0.22, 0.3
"""Distance of posts from the edge, relative to the length; width over length below which they stand in one row; length
over height below which there is one post, with a foot."""
THICK = 0.014
"""Radius of a post relative to its height."""
LEAST, MOST = 0.03, 0.25
"""Smallest and largest radius of a post, relative to the width of what it carries."""
ROD = 0.004
"""Radius of a rod from above, relative to the size of what hangs from it."""
FREE = 2.5
"""Smallest distance of moving bodies from the axis of a post, in its radii."""
SIGHT = 0.1
"""Half the width of a view that is kept free, relative to the distance of what the camera looks at."""
CEILING = 6.0
"""Length of rods, relative to the size of what hangs from them."""
SIDES = 24
FLAT = 1e-5
"""Spread of corners across a plane, relative to that along it."""
CLEAR = 0.4
"""Opacity below which a body looks like nothing that needs a support."""


@dataclass(frozen=True)
class StaticBody:
    """A body where it stands."""

    corners: Array
    """Corners of its triangles, in the world [m], shape (n, 3, 3)."""

    @property
    def low(self) -> Array:
        """Lowest corner of its axis-aligned bounding box [m], shape (3,)."""
        return self.corners.min(axis=(0, 1))

    @property
    def high(self) -> Array:
        """Highest corner of that box [m], shape (3,)."""
        return self.corners.max(axis=(0, 1))

    @property
    def size(self) -> float:
        """Longest side of that box [m]."""
        return float(np.max(self.high - self.low))

    @property
    def is_ground(self) -> bool:
        """Whether it is flat: a plane, which may be tilted, is ground that things stand on."""
        points = self.corners.reshape(-1, 3)
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        return bool(spread[-1] < FLAT * spread[0])


def supports(recording: FilmRecord, level: float, planes: set[str], views: list[View]) -> RenderMesh | None:
    """Return the posts of all statics that need some; None if none does.

    Args:
        recording: The recording of the run.
        level: Height of the floor [m].
        planes: Names of the statics that are ground planes.
        views: Views of the cameras over the films.
    """
    still = solids(recording, set(recording.bodies) - planes, fixed=True)
    moving = [body for body in recording.bodies if body not in recording.statics]
    return posts(list(still.values()), level, [*(_boxes(recording, moving) if moving else []), *sights(views)])


def solids(recording: FilmRecord, bodies: Collection[str], *, fixed: bool = False) -> dict[str, StaticBody]:
    """Return what is visible and opaque of the given bodies at the start, by name of the copy.

    Args:
        recording: The recording of the run.
        bodies: Names of the copies.
        fixed: Whether to return only links that never move: statics, and bases of mechanisms.
    """
    links = recording.states.layout["links"]
    pos, quat = recording.states.poses(float(recording.states.time[0]))
    turns = quats_to_matrices(quat)
    found: dict[str, list[Array]] = {}
    for part in recording.parts:
        if part.body not in bodies or not part.look.visible or part.look.opacity < CLEAR:
            continue
        if fixed and (not links[part.link]["fixed"] or part.body in recording.states.removed):
            continue
        mesh = read_mesh(part.mesh)
        local = mesh.vertices @ quats_to_matrices(np.array([part.quat]))[0].T + part.pos
        placed = local @ turns[part.link].T + pos[part.link]
        found.setdefault(part.body, []).append(placed[mesh.faces])
    return {body: StaticBody(np.concatenate(corners)) for body, corners in found.items()}


def posts(things: list[StaticBody], level: float, moving: list[tuple[Array, Array, Array]]) -> RenderMesh | None:
    """Return the posts of all bodies that need some; None if none does.

    Args:
        things: All bodies that never move, except the floor.
        level: Height of the floor [m].
        moving: Boxes to keep free, around all moving bodies at each sampled moment and in the views: centres (n, 3)
            [m], axes (n, 3, 3) and half sizes (n, 3) [m].
    """
    supports = []
    for group in _groups(things):
        if any(thing.is_ground for thing in group) or _is_steady(group, level) or _is_held(group, level):
            continue
        if any(_is_wall_behind(thing, group, level) for thing in things if not any(thing is one for one in group)):
            continue
        largest = max(group, key=lambda thing: float(np.prod((thing.high - thing.low)[:2])))
        below, wanted = _posts_below(largest, level, things, moving)
        # A single post of two would look like a stray line.
        supports += below if 2 * len(below) > wanted else _rods_above(largest, things, moving) or below
    return joined(supports) if supports else None


def sights(views: list[View]) -> list[tuple[Array, Array, Array]]:
    """Return boxes along the near halves of views, as in `posts`: a post there would hide the scene, or the camera."""
    boxes = []
    for view in views:
        ahead = np.asarray(view.look_at, float) - view.pos
        distance = float(np.linalg.norm(ahead))
        if distance > 0:
            axes = np.linalg.svd(ahead[None])[2].T
            half = distance * np.array([[0.25, SIGHT, SIGHT]])
            boxes.append(((view.pos + 0.25 * ahead)[None], axes[None], half))
    return boxes


def _boxes(recording: FilmRecord, moving: list[str]) -> list[tuple[Array, Array, Array]]:
    states = recording.states
    boxes = states.boxes(moving)
    links = states.layout["links"]
    moves = np.array([link < 0 or not links[link]["fixed"] for link in boxes.link], bool)
    boxes = Boxes(list(compress(boxes.names, moves)), *(column[moves] for column in boxes[1:]))
    times = states.time[np.unique(np.linspace(0, len(states.time) - 1, MOMENTS).round().astype(int))]
    return [states.placed(boxes, float(t)) for t in times] if boxes.names else []


def _groups(things: list[StaticBody]) -> list[list[StaticBody]]:
    """Return the groups of touching bodies, by their bounding boxes."""
    group = list(range(len(things)))
    ends = [(thing.low, thing.high, thing.size) for thing in things]
    for i, (low, high, size) in enumerate(ends):
        for j, (first, last, other) in enumerate(ends[:i]):
            gap = TOUCH * min(size, other)
            if group[i] != group[j] and ((low <= last + gap) & (high >= first - gap)).all():
                old, new = group[i], group[j]
                group = [new if one == old else one for one in group]
    return [[thing for thing, one in zip(things, group, strict=True) if one == k] for k in dict.fromkeys(group)]


def _is_steady(group: list[StaticBody], level: float) -> bool:
    """Return whether the centre of a group is above its footprint on the floor, or nearly."""
    corners = np.concatenate([thing.corners for thing in group])
    size = float(np.max(np.ptp(corners.reshape(-1, 3), axis=0)))
    standing = corners.reshape(-1, 3)
    standing = standing[standing[:, 2] < level + NEAR * size][:, :2]
    if not len(standing):
        return False
    area = triangle_areas(corners)
    middle = (corners.mean(axis=1)[:, :2] * area[:, None]).sum(axis=0) / area.sum()
    turns = np.linspace(0, np.pi, 16, endpoint=False)
    directions = np.stack([np.cos(turns), np.sin(turns)])
    on, at = standing @ directions, middle @ directions
    return bool(((at >= on.min(axis=0) - STEADY * size) & (at <= on.max(axis=0) + STEADY * size)).all())


def _is_held(group: list[StaticBody], level: float) -> bool:
    """Return whether what stands by itself in a group reaches up to the middle of the largest of the rest."""
    standing, rest = [], []
    for thing in group:
        (standing if _is_steady([thing], level) else rest).append(thing)
    if not standing or not rest:
        return False
    largest = max(rest, key=lambda thing: thing.size)
    return max(float(thing.high[2]) for thing in standing) >= float(largest.low[2] + largest.high[2]) / 2


def _is_wall_behind(wall: StaticBody, group: list[StaticBody], level: float) -> bool:
    """Return whether a body is a wall, as wide as a group and as high as its middle, close to one of its sides."""
    corners = np.concatenate([thing.corners for thing in group]).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    along = int(np.argmax((high - low)[:2]))
    width = float((high - low)[along])
    gap = max(float(wall.low[1 - along] - high[1 - along]), float(low[1 - along] - wall.high[1 - along]))
    shared = float(min(wall.high[along], high[along]) - max(wall.low[along], low[along]))
    tall = float(wall.high[2]) >= float(low[2] + high[2]) / 2
    return gap <= CLOSE * width and shared >= WIDE * width and tall and _is_steady([wall], level)


def _posts_below(
    thing: StaticBody, level: float, things: list[StaticBody], moving: list[Any]
) -> tuple[list[RenderMesh], int]:
    """Return the posts of a body, and the number of posts that it would have if nothing were in the way."""
    spots, width = _spots(thing, float(thing.low[2]) - level)
    posts = []
    for x, y in spots:
        heights = crossing_heights(thing, x, y)
        if not len(heights):
            continue
        top = float(heights.min())
        below = [z for other in things if other is not thing for z in crossing_heights(other, x, y) if z < top]
        foot = max([level, *below])
        long = top - foot
        radius = float(np.clip(THICK * long, LEAST * width, MOST * width))
        if long > LOW * thing.size and is_free(np.array([x, y, foot]), np.array([x, y, top]), radius, moving):
            posts.append(post(x, y, foot, top, radius, flared=len(spots) == 1))
    return posts, len(spots)


def _rods_above(thing: StaticBody, things: list[StaticBody], moving: list[Any]) -> list[RenderMesh]:
    """Return the rods that hold a body from above."""
    spots, width = _spots(thing, 0.0)
    rods = []
    for x, y in spots:
        heights = crossing_heights(thing, x, y)
        if not len(heights):
            continue
        top = float(heights.max())
        end = top + CEILING * thing.size
        radius = float(np.clip(ROD * thing.size, LEAST * width, MOST * width))
        above = any((crossing_heights(other, x, y) > top).any() for other in things if other is not thing)
        if not above and is_free(np.array([x, y, top]), np.array([x, y, end]), radius, moving):
            rods.append(post(x, y, top, end, radius, flared=False))
    return rods


def _spots(thing: StaticBody, height: float) -> tuple[Array, float]:
    """Return positions for posts (n, 2) [m], and the width of what they carry [m]."""
    flat = thing.corners.reshape(-1, 3)[:, :2]
    middle = (flat.min(axis=0) + flat.max(axis=0)) / 2
    turns = np.radians(np.arange(0, 90, 3.0))
    frames = [np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) for a in turns]
    axes = min(frames, key=lambda frame: float(np.prod(np.ptp(flat @ frame.T, axis=0))))
    turned = flat @ axes.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    if high[0] - low[0] < high[1] - low[1]:
        axes, low, high = axes[::-1], low[::-1], high[::-1]
    middle, (length, width) = (low + high) / 2, high - low
    inset = INSET * length
    u = length / 2 - inset
    v = width / 2 - min(inset, 0.25 * width)
    if length < SMALL * height:
        local = np.zeros((1, 2))
    elif width < SLIM * length:
        local = np.array([(-u, 0.0), (u, 0.0)])
    else:
        local = np.array([(-u, -v), (-u, v), (u, -v), (u, v)])
    return (middle + local) @ axes, float(width)


def crossing_heights(thing: StaticBody, x: float, y: float) -> Array:
    """Return the heights [m] at which a vertical line crosses a body.

    Args:
        thing: The body.
        x: Where the line is [m].
        y: Where the line is [m].
    """
    if not ((thing.low[:2] <= (x, y)) & (thing.high[:2] >= (x, y))).all():
        return np.zeros(0)
    a, b, c = np.moveaxis(thing.corners, 1, 0)
    u, v, w = b[:, :2] - a[:, :2], c[:, :2] - a[:, :2], np.array([x, y]) - a[:, :2]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    flat = np.abs(area) < 1e-14
    area = np.where(flat, 1.0, area)
    s = (w[:, 0] * v[:, 1] - w[:, 1] * v[:, 0]) / area
    t = (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) / area
    met = ~flat & (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1 + 1e-9)
    return (a[:, 2] + s * (b[:, 2] - a[:, 2]) + t * (c[:, 2] - a[:, 2]))[met]


def is_free(start: Array, end: Array, radius: float, moving: list[Any]) -> bool:
    """Return whether no moving body ever comes near a line; what is only beyond its ends does not.

    Args:
        start: One end of the line [m], shape (3,).
        end: The other end [m], shape (3,).
        radius: Radius of what is to stand there [m].
        moving: Boxes, as in `posts`.
    """
    shift = min(FREE * radius / float(np.linalg.norm(end - start)), 0.5) * (end - start)
    start, end = start + shift, end - shift
    for centers, axes, half in moving:
        origin = np.einsum("ni,nij->nj", start - centers, axes)
        along = np.einsum("i,nij->nj", end - start, axes)
        along = np.where(np.abs(along) < 1e-12, 1e-12, along)
        room = half + FREE * radius
        a, b = (-room - origin) / along, (room - origin) / along
        first, last = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
        if (np.maximum(first, 0.0) < np.minimum(last, 1.0)).any():
            return False
    return True


def post(x: float, y: float, foot: float, top: float, radius: float, *, flared: bool) -> RenderMesh:
    """Return a vertical post.

    Args:
        x: Where its axis is [m].
        y: Where its axis is [m].
        foot: Height of its lower end [m].
        top: Height of its upper end [m].
        radius: Its radius [m].
        flared: Whether it has a foot.
    """
    profile, slopes = [(radius, foot), (radius, top)], [(1.0, 0.0), (1.0, 0.0)]
    mesh = revolved(np.array(profile), np.array(slopes), sides=SIDES)
    if flared:
        wide, thick = min(7 * radius, 0.4 * (top - foot)), 0.8 * radius
        rim = revolved(np.array([(wide, foot), (wide, foot + thick)]), np.array(slopes), sides=2 * SIDES)
        disc = np.array([(0.0, foot + thick), (wide, foot + thick)])
        mesh = joined([mesh, rim, revolved(disc, np.array([(0.0, 1.0), (0.0, 1.0)]), sides=2 * SIDES)])
    return RenderMesh(mesh.vertices + (x, y, 0.0), mesh.faces, mesh.normals)
