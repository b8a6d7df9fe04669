"""Turning that no picture shows: of plain bodies of revolution about their axes."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from text2sim.recording.film_record import FilmRecord, WornMesh
from text2sim.spec_schema.names.selectors import body_of
from text2sim.templates.cadence import Frame

Array = NDArray[np.floating]

LEAST_TURNS = 0.5
"""Number of turns about its axis below which a body's turning is not missed."""
PLAIN_FINISHES = frozenset(
    "rough painted plastic smooth rubber metal brushed_metal polished_metal ceramic silicone jelly".split()
)
"""Finishes without a texture that would show the turning."""
TRIALS = (0.5, 0.83)
"""Angles by which a shape is turned to see whether it looks the same [rad]; no multiples of those of small polygons."""
FACETING = 0.15
"""Distance between a shape and the turned one, relative to its radius, within which they look the same.

Vertices of a prism of n sides are at most sin(pi / n) from those of the turned one: 0.2 for 16 sides, and 0.1 at the
angles of `TRIALS`; for 12 sides, whose edges show that it turns, 0.22.
"""
TOGETHER = 0.05
"""Largest angle [rad] by which links that turn together turn against each other."""
MAX_VERTICES = 4_000


def unseen_turns(recording: FilmRecord, pictures: Sequence[Frame]) -> dict[str, float]:
    """Return how often bodies turn about their axes without a picture showing it, by name of the body.

    Args:
        recording: The recorded run.
        pictures: Pictures of a film, in order.
    """
    worn: dict[int, list[WornMesh]] = defaultdict(list)
    for part in recording.parts:
        if part.look.drawn and part.body not in recording.statics:
            worn[part.link].append(part)
    if not worn or len(pictures) < 2:
        return {}
    times = dict.fromkeys(frame.t for frame in pictures if not frame.again)
    poses = [recording.states.poses(t) for t in times]
    places, quats = poses[0][0], np.array([quats for _, quats in poses], float)
    orientations = {link: Rotation.from_quat(quats[:, link], scalar_first=True) for link in worn}
    found: dict[str, float] = {}
    for link, own in orientations.items():
        axis, turns = _turned(own)
        if turns < LEAST_TURNS:
            continue
        drawn = []
        for other, parts in worn.items():
            if parts[0].body != worn[link][0].body:
                continue
            relative = own.inv() * orientations[other]
            if (relative[0].inv() * relative).magnitude().max() > TOGETHER:
                continue  # it does not turn along
            offset = own[0].inv().apply(places[other] - places[link])
            drawn += [(part, relative[0], offset) for part in parts]
        if _same_all_round(drawn, axis):
            name = body_of(worn[link][0].body)
            found[name] = max(found.get(name, 0.0), turns)
    return found


def _turned(turns: Rotation) -> tuple[Array, float]:
    """Return the axis about which something turns most, in its own frame, and how far apart its turns about it reach.

    Args:
        turns: Its orientations, F of them.
    """
    steps = (turns[:-1].inv() * turns[1:]).as_rotvec()
    axis = np.linalg.eigh(steps.T @ steps)[1][:, -1]
    return axis, float(np.ptp(np.cumsum([0.0, *(steps @ axis)])) / (2 * np.pi))


def _same_all_round(parts: Sequence[tuple[WornMesh, Rotation, Array]], axis: Array) -> bool:
    """Return whether parts look the same however they are turned together about an axis through their middle.

    Args:
        parts: Each with the orientation and position [m] of its link's frame.
        axis: In the same frame.
    """
    corners: dict[object, list[Array]] = defaultdict(list)
    for part, orientation, place in parts:
        look = part.look
        if look.picture or look.decoration or look.finish not in PLAIN_FINISHES:
            return False
        with np.load(part.mesh) as arrays:
            vertices = arrays["vertices"].astype(float)
        vertices = vertices[:: -(-len(vertices) // MAX_VERTICES)]
        turn = Rotation.from_quat(part.quat, scalar_first=True)
        corners[look.color].append(orientation.apply(turn.apply(vertices) + part.pos) + place)
    of_color = [np.concatenate(rows) for rows in corners.values()]
    middle = np.concatenate(of_color).mean(axis=0)
    for points in of_color:
        points = points - middle
        radius = np.linalg.norm(np.cross(points, axis), axis=1).max()
        tree = KDTree(points)
        for angle in TRIALS:
            away, _ = tree.query(Rotation.from_rotvec(angle * axis).apply(points))
            if away.max() > FACETING * radius:
                return False
    return True
