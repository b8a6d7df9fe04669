"""Free surfaces of liquids and grains, and how much of a rigid body lies below them."""

from collections.abc import Iterator, Sequence

import numpy as np

from text2sim.evidence.recorded_case import RecordedCase, links_of
from text2sim.evidence.selection import RecordedTarget
from text2sim.evidence.solids import LinkSolid
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array
from text2sim.recording.vectors import rotate
from text2sim.spec_schema.models.shapes import Stream
from text2sim.spec_schema.models.space import Region
from text2sim.spec_schema.names.selectors import body_of
from text2sim.templates.streams import flowing

COLUMN = 2.0
"""Width of a column in distances of particles: a full one has four in each layer."""
BULK = 4
"""Particles in a cube of a column, which holds 8 if it is full, that are no spray."""
RING = 4
"""Width of the ring around a body in which its surroundings have their surface, in columns."""
SAMPLES = 4096
"""Points in the boxes around the solids of a link, which sample them."""
SPREAD = np.array([0.8191725134, 0.6710436067, 0.5497004779])
"""Steps of a sequence that fills a cube evenly: powers of 1/g with g^4 = g + 1 (Roberts, 2018)."""


def surface_level(recording: RecordedCase, bodies: Sequence[RecordedDeformable], region: Region | None) -> Array:
    """Return the height [m] of the free surface of bodies, shape (F,): the median over their columns.

    Args:
        recording: The recording.
        bodies: What flows.
        region: Where it is measured; None for everywhere. Frames without any bulk there give nan.
    """
    found = np.full(recording.states.frames, np.nan)
    for frame, points in enumerate(_particles(recording, bodies)):
        if region is not None:
            points = points[recording.depth_in(region, points, frame) >= 0]
        tops = columns(points, bodies[0].spacing)[2]
        found[frame] = np.median(tops) if len(tops) else np.nan
    return found


def submerged(
    recording: RecordedCase, targets: Sequence[RecordedTarget], bodies: Sequence[RecordedDeformable]
) -> Array | None:
    """Return the part (F,) of the volume of rigid bodies that is below the surface around each; None without shapes.

    Args:
        recording: The recording.
        targets: The bodies; those that have left the scene do not count.
        bodies: What flows.
    """
    clouds = [[(link, *inside_points(recording.shapes.of(link))) for link in links_of([one])] for one in targets]
    below, total = np.zeros((2, recording.states.frames))
    if not all(sum(weights.sum() for _, _, weights in cloud) for cloud in clouds):
        return None
    states, spacing = recording.states, bodies[0].spacing
    for frame, points in enumerate(_particles(recording, bodies)):
        for target, cloud in zip(targets, clouds, strict=True):
            if recording.gone(target.copy)[frame]:
                continue
            placed = [
                states.pos[frame, link] + rotate(states.quat[frame, link].astype(float), own) for link, own, _ in cloud
            ]
            spots, weights = np.concatenate(placed), np.concatenate([weights for _, _, weights in cloud])
            below[frame] += weights[spots[:, 2] < level_around(spots, points, spacing)].sum()
            total[frame] += weights.sum()
    return below / total


def columns(points: Array, spacing: float) -> tuple[Array, Array, Array]:
    """Return the middles (m, 2), lowest and highest heights (m,) [m] of the columns that particles fill.

    The top of a column is half a particle distance above its highest particle that has at least three more within a
    column's width below it: drops and spray have not.

    Args:
        points: Particles (n, 3) [m].
        spacing: Their distance [m].
    """
    width = COLUMN * spacing
    cells = np.floor(points[:, :2] / width).astype(np.int64)
    order = np.lexsort((points[:, 2], cells[:, 1], cells[:, 0]))
    cells, heights = cells[order], points[order, 2]
    upper, lower = slice(BULK - 1, None), slice(None, 1 - BULK)
    bulk = (cells[upper] == cells[lower]).all(axis=1) & (heights[upper] - heights[lower] <= width)
    cells, heights, lowest = cells[upper][bulk], heights[upper][bulk], heights[lower][bulk]
    found, first = np.unique(cells, axis=0, return_index=True)
    last = np.append(first[1:], len(cells))[: len(first)] - 1
    return (found + 0.5) * width, lowest[first], heights[last] + spacing / 2


def level_around(spots: Array, points: Array, spacing: float) -> float:
    """Return the height [m] of the surface around a body; -inf if nothing at its height is around it.

    It is the median over columns beside the body, and over those that reach above it: one that ends below the body
    ends at its underside, not at the surface. Columns that begin above it stand on something else.

    Args:
        spots: Points inside the body (k, 3) [m], world.
        points: Particles (n, 3) [m].
        spacing: Their distance [m].
    """
    from scipy.spatial import KDTree

    width, high = COLUMN * spacing, spots[:, 2].max()
    reach = (RING + 2) * width
    low, far = spots[:, :2].min(axis=0) - reach, spots[:, :2].max(axis=0) + reach
    near = points[((points[:, :2] > low) & (points[:, :2] < far)).all(axis=1)]
    middles, bottoms, tops = columns(near, spacing)
    away = KDTree(spots[:, :2]).query(middles)[0] if len(middles) else np.zeros(0)
    around = (away < (RING + 1) * width) & (bottoms < high) & ((away > width) | (tops > high))
    return float(np.median(tops[around])) if around.any() else -np.inf


def inside_points(solids: Sequence[LinkSolid]) -> tuple[Array, Array]:
    """Return points (n, 3) [m] that fill solids evenly, in the frame of their link, and the volume [m3] of each, (n,).

    What several solids have in common counts once.
    """
    count = max(64, SAMPLES // max(len(solids), 1))
    unit = (0.5 + np.arange(count)[:, None] * SPREAD) % 1
    points: list[Array] = [np.zeros((0, 3))]
    volumes: list[Array] = [np.zeros(0)]
    for solid in solids:
        low, high = solid.bounds
        own = low + unit * (high - low)
        spots = solid.pos + own[_is_inside(solid, own)] @ solid.turn.T
        shared = sum(_is_inside(other, (spots - other.pos) @ other.turn) for other in solids if other is not solid)
        points.append(spots)
        volumes.append(np.prod(high - low) / count / (np.ones(len(spots)) + shared))
    return np.concatenate(points), np.concatenate(volumes)


def _is_inside(solid: LinkSolid, own: Array) -> Array:
    return solid.least(own)[0] < 0


def _particles(recording: RecordedCase, bodies: Sequence[RecordedDeformable]) -> Iterator[Array]:
    """Yield the particles (n, 3) [m] of bodies in every frame, without those that wait in the mouth of a stream."""
    recorded = [body.points for body in bodies]
    is_stream = [isinstance(recording.case.bodies[body_of(body.body)].shape, Stream) for body in bodies]  # type: ignore[union-attr]
    for frame in range(recording.states.frames):
        found = []
        for body, rows, pours in zip(bodies, recorded, is_stream, strict=True):
            points = rows[frame].astype(float)
            kept = np.isfinite(points).all(axis=1)
            found.append(points[kept & flowing(points, body.rest, body.spacing) if pours else kept])
        yield np.concatenate(found)
