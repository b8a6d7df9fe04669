"""Rods that hold driven bodies, as those of a press, a crane or a drill; they are only drawn.

A body gets one if it is off the floor and nowhere next to something that could hold it. The rod moves with it and
reaches out of the picture: upwards if the body stays upright, or else along the axis about which it turns.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.compiler.shapes.rotation import quats_to_matrices
from text2sim.recording.film_record import FilmRecord
from text2sim.rendering.meshes import RenderMesh, joined
from text2sim.rendering.supports import CEILING, MOMENTS, StaticBody, crossing_heights, is_free, post, sights, solids
from text2sim.templates.cameras import View

Array = NDArray[np.floating]

AFLOAT = 0.1
"""Height over the floor that a body reaches if it floats, relative to its size."""
NEXT = 0.02
"""Largest gap to what could hold a body, relative to the size of the smaller of the two."""
STEADY = np.cos(np.radians(3.0))
"""Cosine of the largest angle by which a rod turns."""
THICK, THIN = 0.08, 0.008
"""Largest radius of a rod, relative to the size of its body, and smallest."""
BROAD = 0.15
"""Radius of a rod relative to the width of its body, within these bounds."""


@dataclass(frozen=True)
class Rods:
    """All rods of a film."""

    mesh: RenderMesh
    """In the frames of their links."""
    links: NDArray[np.integer]
    """The link that each vertex moves with, shape (n,)."""

    def placed(self, pos: Array, quat: Array) -> RenderMesh:
        """Return the rods for given poses of the links.

        Args:
            pos: Positions [m], shape (L, 3).
            quat: Unit quaternions (w, x, y, z), shape (L, 4).
        """
        turns = quats_to_matrices(quat)[self.links]
        vertices = np.einsum("nij,nj->ni", turns, self.mesh.vertices) + pos[self.links]
        return RenderMesh(vertices, self.mesh.faces, np.einsum("nij,nj->ni", turns, self.mesh.normals))


def hangers(recording: FilmRecord, driven: list[str], level: float, views: list[View]) -> Rods | None:
    """Return the rods of all driven bodies that need one; None if none does.

    Args:
        recording: The recording of the run.
        driven: Names of the copies with a prescribed motion.
        level: Height of the floor [m].
        views: Views of the cameras over the films, which stay free.
    """
    bodies = solids(recording, driven)
    if not bodies:
        return None
    states = recording.states
    picked = np.unique(np.linspace(0, len(states.time) - 1, MOMENTS).round().astype(int))
    times = [float(t) for t in states.time[picked]]
    links = {part.body: part.link for part in recording.parts}
    pos, quat = (np.array(rows) for rows in zip(*(states.poses(t) for t in times), strict=True))
    still = list(solids(recording, recording.bodies, fixed=True).values())
    in_sight = sights(views)
    boxes = states.boxes([name for name in recording.bodies if name not in recording.statics])
    placed = [states.placed(boxes, t) for t in times]
    rods: list[tuple[int, RenderMesh]] = []
    held: list[tuple[StaticBody, Array]] = []
    for body, thing in sorted(bodies.items(), key=lambda row: (-row[1].size, row[0])):
        at, turns = pos[:, links[body]], quats_to_matrices(quat[:, links[body]])
        ways = at - at[0]
        if body in recording.statics or not _floats(thing, ways, level):
            continue
        if all(_beside(thing, way, still) for way in ways) or any(_goes_along(thing, ways, *other) for other in held):
            held.append((thing, ways))
            continue
        others = np.array([name != body for name in boxes.names], bool)
        moving = [tuple(rows[others] for rows in moment) for moment in placed]
        for along in _steady_directions(turns):
            if (rod := _rod(along, thing, ways, still, moving, in_sight)) is not None:
                held.append((thing, ways))
                local = RenderMesh((rod.vertices - at[0]) @ turns[0], rod.faces, rod.normals @ turns[0])
                rods.append((links[body], local))
                break
    if not rods:
        return None
    return Rods(joined([mesh for _, mesh in rods]), np.repeat([k for k, _ in rods], [len(m.vertices) for _, m in rods]))


def _floats(thing: StaticBody, ways: Array, level: float) -> bool:
    """Return whether a body is above the floor at some time."""
    return bool(thing.low[2] + ways[:, 2].max() > level + AFLOAT * thing.size)


def _beside(thing: StaticBody, way: Array, others: list[StaticBody]) -> bool:
    """Return whether a body that has moved by `way` [m] is next to one of others, by their bounding boxes."""
    gaps = [(other, NEXT * min(thing.size, other.size)) for other in others]
    return any(
        bool(((thing.low + way <= other.high + gap) & (thing.high + way >= other.low - gap)).all())
        for other, gap in gaps
    )


def _goes_along(thing: StaticBody, ways: Array, other: StaticBody, others_ways: Array) -> bool:
    """Return whether a body is next to another one at the start, and moves with it."""
    return _beside(thing, ways[0], [other]) and np.abs(ways - others_ways).max() < NEXT * thing.size


def _steady_directions(turns: Array) -> list[Array]:
    """Return the directions of a body at the start that it keeps, shape (3,): up, or along the axis of its turning.

    Args:
        turns: Its orientations at each moment, shape (F, 3, 3).
    """
    relative = turns @ turns[0].T
    # The axis of a rotation R is where R + R^T stretches most.
    axis = np.linalg.eigh((relative + relative.swapaxes(1, 2)).mean(axis=0))[1][:, -1]
    up = np.array([0.0, 0.0, 1.0])
    candidates = [up] if relative[:, 2, 2].min() > STEADY else sorted((axis, -axis), key=lambda way: -float(way[2]))
    return [way for way in candidates if (relative @ way @ way).min() > STEADY]


def _rod(
    along: Array, thing: StaticBody, ways: Array, still: list[StaticBody], moving: list[Any], in_sight: list[Any]
) -> RenderMesh | None:
    """Return the rod of a body at the start; None if something is ever in its way.

    Args:
        along: Unit vector from the body along the rod, shape (3,).
        thing: The body at the start.
        ways: Displacements of the body at each moment [m], shape (F, 3).
        still: Bodies that never move.
        moving: Boxes around all other bodies that move, at each moment; see `supports.posts`.
        in_sight: Boxes in the views.
    """
    up = np.linalg.svd(along[None])[2]  # rows: an orthonormal basis whose first one is the rod, or its opposite
    frame = np.stack([up[1], np.cross(along, up[1]), along])
    thing, ways = StaticBody(thing.corners @ frame.T), ways @ frame.T
    still = [StaticBody(other.corners @ frame.T) for other in still]
    x, y = (thing.low[:2] + thing.high[:2]) / 2
    heights = crossing_heights(thing, x, y)
    if not len(heights):
        return None
    width = float((thing.high - thing.low)[:2].min())
    radius = float(np.clip(BROAD * width, THIN * thing.size, THICK * thing.size))
    start = np.array([x, y, float(heights.max())])
    end = start + (0.0, 0.0, CEILING * thing.size)
    for k, way in enumerate(ways):
        above = (crossing_heights(other, x + way[0], y + way[1]) for other in still)
        if any((z > start[2] + way[2]).any() for z in above):
            return None
        boxes = [(centers @ frame.T, frame @ axes, half) for centers, axes, half in (*moving[k : k + 1], *in_sight)]
        if not is_free(start + way, end + way, radius, boxes):
            return None
    rod = post(float(x), float(y), start[2], float(end[2]), radius, flared=False)
    return RenderMesh(rod.vertices @ frame, rod.faces, rod.normals @ frame)
