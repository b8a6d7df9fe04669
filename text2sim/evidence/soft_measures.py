"""Measures of deformable bodies. Each function states its formula."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from text2sim.compiler.shapes.regions import RegionError, check_border, end_region
from text2sim.compiler.soft.regions import SIDE_LAYER
from text2sim.evidence import bonds, curvature, deformation, fold_lines, folds, free_surface, tearing
from text2sim.evidence.gaps import Nearest, nearest_cloud, nearest_solid
from text2sim.evidence.leaks import leaks
from text2sim.evidence.recorded_case import RecordedCase, links_of
from text2sim.evidence.selection import RecordedTarget
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array
from text2sim.spec_schema.models import measures
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.regions import SIDES, BodyRegion
from text2sim.spec_schema.names.selectors import body_of

_FLAT = 1e-6


class SoftMeasureError(ValueError):
    """Error: a measure is undefined for what was recorded."""


def deformables(recording: RecordedCase, selectors: str | list[str]) -> list[RecordedDeformable]:
    """Return the deformable bodies that a selector, or any of several, matches, each once.

    Raises:
        SelectionError: if one of them matches nothing that was recorded.
        SoftMeasureError: if one of them is not deformable.
    """
    found = []
    for target in recording.names.select(selectors):
        body = recording.deformable(target)
        if body is None:
            raise SoftMeasureError(f"{target.label} does not deform")
        found.append(body)
    return found


def region_path(recording: RecordedCase, target: RecordedTarget, region: BodyRegion) -> Array:
    """Return the mean position [m] of the points of a region, world, shape (F, 3).

    The points are those inside the region at the start, in the body's own frame; a side contains a layer
    below the outermost point, as for attachments.

    Args:
        recording: The recording.
        target: The body.
        region: The region.

    Raises:
        SoftMeasureError: if the body is not deformable, or has no points in the region.
    """
    body = recording.deformable(target)
    if body is None:
        raise SoftMeasureError(f"{target.label} does not deform: `region` is for deformable bodies")
    rows = region_rows(recording, body, region)
    return body.points[:, rows].mean(axis=1, dtype=float)


def region_rows(recording: RecordedCase, body: RecordedDeformable, region: BodyRegion) -> Array:
    """Return the indices of a body's points in a region at the start; see `region_path`.

    Args:
        recording: The recording.
        body: The deformable body.
        region: The region.

    Raises:
        SoftMeasureError: if no point lies in the region, or the body has no such side or border.
    """
    points, within = body.own, SIDE_LAYER.get(body.solver, 0.5) * body.spacing
    shape = getattr(recording.case.bodies.get(body_of(body.body)), "shape", None)
    region = end_region(shape, region, within)
    try:
        check_border(shape, region)
    except RegionError as error:
        raise SoftMeasureError(f"{body.body}: {error}") from error
    if region.nearest is not None:
        return np.array([np.linalg.norm(points - region.nearest, axis=1).argmin()])
    inside = np.ones(len(points), bool)
    if region.sphere is not None:
        inside = np.linalg.norm(points - region.sphere.center, axis=1) <= region.sphere.radius
    elif region.box is not None:
        inside = ((points >= region.box.min) & (points <= region.box.max)).all(axis=1)
    size = np.ptp(points, axis=0)
    for side in region.sides:
        axis, sign = SIDES[side]
        if region.face is None and size[axis] <= _FLAT * size.max():
            raise SoftMeasureError(f"{body.body} is flat, and has no {side}")
        along = sign * points[:, axis]
        inside &= along >= along.max() - within
    if not inside.any():
        raise SoftMeasureError(f"none of the {len(points)} points of {body.body} lies in this region")
    return np.flatnonzero(inside)


# --- measures ------------------------------------------------------------------------


def _volume(recording: RecordedCase, measure: measures.Volume) -> Array:
    """Sum of the volumes inside the surfaces, by the divergence theorem; optionally relative to the start."""
    total = np.sum([deformation.volumes(body) for body in deformables(recording, measure.of)], axis=0)
    return total / total[:1] if measure.relative else total


def _stretch(recording: RecordedCase, measure: measures.Stretch) -> Array:
    """Length of edges over their length in the first frame: largest, smallest, mean, or 99th percentile of all."""
    return reduce_to_frames([deformation.stretches(body) for body in deformables(recording, measure.of)], measure.stat)


def _strain(recording: RecordedCase, measure: measures.Strain) -> Array:
    """sqrt(2/3 E':E') of the Green-Lagrange strain E: largest, smallest, mean, or 99th percentile of all elements."""
    return reduce_to_frames([deformation.strains(body) for body in deformables(recording, measure.of)], measure.stat)


def reduce_to_frames(values: Sequence[Array], stat: str) -> Array:
    """Reduce values (F, n) to one per frame, shape (F,)."""
    if stat in ("max", "min"):
        each = [getattr(rows, stat)(axis=1) for rows in values]
        return getattr(np.stack(each), stat)(axis=0).astype(float)
    if stat == "mean":
        total = np.sum([rows.sum(axis=1, dtype=float) for rows in values], axis=0)
        return total / sum(rows.shape[1] for rows in values)
    rows = np.concatenate(values, axis=1) if len(values) > 1 else values[0]
    # The smallest value that 99 of 100 do not exceed; a percentile between two values would need a full sort.
    at = max(0, int(np.ceil(0.99 * rows.shape[1])) - 1)
    return np.partition(rows, at, axis=1)[:, at].astype(float) if rows.size else np.zeros(len(rows))


def _wrinkling(recording: RecordedCase, measure: measures.Wrinkling) -> Array:
    """Mean of |k1| + |k2| over the area of all cloths."""
    found = [curvature.curvatures(body) for body in deformables(recording, measure.of)]
    return np.sum([total for total, _ in found], axis=0) / np.sum([area for _, area in found], axis=0)


def _folded_area(recording: RecordedCase, measure: measures.FoldedArea) -> Array:
    """Sum over cloths of the area of all layers seen along the axis, minus that of the silhouette."""
    bodies = deformables(recording, measure.of)
    return np.sum([folds.folded_area(body, "xyz".index(measure.axis)) for body in bodies], axis=0)


def _folds(recording: RecordedCase, measure: measures.Folds) -> Array:
    """Median of the folds of all lines of all cloths; of an even number, the larger one in the middle."""
    bodies = deformables(recording, measure.of)
    counts = np.sort(np.hstack([fold_lines.folds_of_lines(body, "xyz".index(measure.across)) for body in bodies]))
    return counts[:, counts.shape[1] // 2]


def _self_penetration(recording: RecordedCase, measure: measures.SelfPenetration) -> Array:
    """Largest over cloths of the thickness minus the distance of the nearest non-adjacent points."""
    bodies = deformables(recording, measure.of)
    return np.max([folds.self_penetration(body, recording.thickness(body)) for body in bodies], axis=0)


def _share_in(recording: RecordedCase, measure: measures.ShareIn) -> Array:
    """Sum of m_i over points in the region or on its surface, over the sum of m_i over all points."""
    inside, mass = np.zeros(recording.states.frames), 0.0
    for body in deformables(recording, measure.of):
        for k, points in enumerate(body.points):
            there = recording.depth_in(measure.region, points.astype(float), k) >= 0
            inside[k] += float(body.masses[there].sum())
        mass += float(body.masses.sum())
    return inside / mass


def _gap(recording: RecordedCase, measure: measures.Gap) -> Array:
    """Smallest signed distance between the points of one body and the solids of another, or the points of another."""
    first, second = recording.names.select(measure.of), recording.names.select(measure.to)
    of, to = (", ".join(listed(side)) for side in (measure.of, measure.to))
    if any(target.soft is None for target in first):
        first, second = second, first
    bodies = [body for target in first if (body := recording.deformable(target)) is not None]
    if len(bodies) < len(first):
        raise SoftMeasureError(f"neither {of} nor {to} deforms: measure their `distance`")
    best = np.full(recording.states.frames, np.inf)
    for body, target in zip(bodies, first, strict=True):
        others = [other for other in second if other != target]
        best = np.minimum(best, gap(recording, body, others).value)
    if np.isinf(best).all() and len(best):
        raise SoftMeasureError(f"{of} and {to} have no shapes between which there is a gap")
    return best


def depth(recording: RecordedCase, targets: Sequence[RecordedTarget], others: Sequence[RecordedTarget] | None) -> Array:
    """Return the largest depth [m] of points of deformable bodies in rigid solids, shape (F,); 0 if none is inside.

    Args:
        recording: The recording.
        targets: Deformable or rigid bodies.
        others: The bodies on the other side; None for all that they can touch.
    """
    everything = list(recording.names.copies.values())
    deepest = np.zeros(recording.states.frames)
    for one, two in ((targets, others), (others, targets)):
        bodies = [t for t in (everything if one is None else one) if t.soft is not None]
        rigid = [t for t in (everything if two is None else two) if t.soft is None]
        if one is None or two is None:
            felt = [(t, recording.names.felt_links(t)) for t in rigid]
            rigid = [replace(t, links=links) for t, links in felt if links]
        for target in bodies if rigid else ():
            body = recording.deformable(target)
            assert body is not None
            deepest = np.maximum(deepest, 0.0 - gap(recording, body, rigid, 0.0).value)
    return deepest


def gap(
    recording: RecordedCase, body: RecordedDeformable, others: Sequence[RecordedTarget], limit: float = np.inf
) -> Nearest:
    """Return the signed distance [m] of a body to the nearest of others in each frame; negative inside.

    Args:
        recording: The recording.
        body: The body.
        others: Bodies, links or statics.
        limit: Distance [m] beyond which the exact value does not matter.
    """
    cloud = recording.cloud(body)
    found = nearest_solid(cloud, recording.states, recording.shapes.of_links(links_of(others)), limit)
    for other in others:
        other_body = recording.deformable(other)
        if other_body is None or other_body is body:
            continue
        one = nearest_cloud(cloud, recording.cloud(other_body), found.value)
        nearer = one.value < found.value
        found.value[nearer], found.pos[nearer], found.of[nearer] = one.value[nearer], one.pos[nearer], -1
    return found


def _pieces(recording: RecordedCase, measure: measures.Pieces) -> Array:
    bonded, soft = _apart(recording, measure.of)
    return np.sum([*(tearing.pieces(body)[0] for body in soft), *bonded[:1]], axis=0)


def _largest_piece(recording: RecordedCase, measure: measures.LargestPiece) -> Array:
    bonded, soft = _apart(recording, measure.of)
    return np.min([*(tearing.pieces(body)[1] for body in soft), *bonded[1:]], axis=0)


def _apart(
    recording: RecordedCase, selectors: str | list[str]
) -> tuple[tuple[Array, Array] | tuple[()], list[RecordedDeformable]]:
    """Return the pieces of the selected bodies that are rigid, if there are any, and the deformable ones."""
    targets = recording.names.select(selectors)
    rigid = [target for target in targets if target.soft is None]
    soft = [body for target in targets if (body := recording.deformable(target)) is not None]
    return bonds.pieces(recording, rigid) if rigid else (), soft


def _leaked(recording: RecordedCase, measure: measures.Leaked) -> Array:
    """Sum over bodies of m_b s_b over the sum of m_b, with s_b the leaked fraction of a body."""
    bodies = deformables(recording, measure.of)
    masses = [float(body.masses.sum()) for body in bodies]
    return np.average([leaks(recording, body)[0] for body in bodies], axis=0, weights=masses)


def _surface_level(recording: RecordedCase, measure: measures.SurfaceLevel) -> Array:
    """Median over columns of two particle distances of their tops; see `free_surface.columns`."""
    return free_surface.surface_level(recording, deformables(recording, measure.of), measure.region)


def _submerged(recording: RecordedCase, measure: measures.Submerged) -> Array:
    """Sum of the volumes of sample points below the level around their body, over the sum of all their volumes."""
    targets = recording.names.select(measure.of)
    share = free_surface.submerged(recording, targets, deformables(recording, measure.by))
    if share is None:
        raise SoftMeasureError(f"{', '.join(listed(measure.of))} has no recorded solid")
    return share


MEASURES: dict[str, Callable[[RecordedCase, Any], Array]] = {
    "volume": _volume,
    "stretch": _stretch,
    "strain": _strain,
    "wrinkling": _wrinkling,
    "folded_area": _folded_area,
    "folds": _folds,
    "gap": _gap,
    "self_penetration": _self_penetration,
    "share_in": _share_in,
    "pieces": _pieces,
    "largest_piece": _largest_piece,
    "leaked": _leaked,
    "surface_level": _surface_level,
    "submerged": _submerged,
}
"""Measures by kind; values are over frames, (F,)."""
