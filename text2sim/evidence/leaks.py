"""Leaks: the fraction of grains, liquids and snow that penetrated walls and floors."""

import numpy as np

from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.rigid_shapes import world_frames
from text2sim.evidence.solids import LinkSolid
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array
from text2sim.spec_schema.models.bodies import Driven, Rigid
from text2sim.spec_schema.models.shapes import Plane
from text2sim.spec_schema.names.selectors import body_of

PASSING_DEPTH = 2.5
"""Depth, in distances of points, beyond which a point is passing through: sound runs press points in to 2."""
PASSING_SHARE = 0.8
"""The same for thin walls, as a part of half their thickness."""
PLACES_BETWEEN_FRAMES = 4
"""Places checked between two recorded frames, so that fast points are not missed."""


def leaks(recording: RecordedCase, body: RecordedDeformable) -> tuple[Array, list[str]]:
    """Return the fraction (F,) of a body's mass that has leaked into or through containers, and where most of it did.

    Containers are grounds, statics, driven and mounted bodies. A point counts from the moment at which it is deeper in
    one of them than contact explains. All points of a body have the same mass.
    """
    frames, count = len(body.points), body.points.shape[1]
    first, through = np.full(count, frames), np.full(count, -1)
    walls = [*_walls(recording)]
    for number, (link, solid) in enumerate(walls):
        pos, turn = world_frames(recording.states, link, solid, body.step)
        size = half_size(recording, link) if solid.kind == "plane" else np.inf
        deep = depth_on_the_way(solid, body.spacing)
        before = None
        for frame in range(frames):
            own = (body.points[frame].astype(float) - pos[frame]) @ turn[frame]
            hit = _points_below(own, deep, size) if solid.kind == "plane" else _inside(solid, own, before, deep)
            new = hit[first[hit] > frame]
            first[new], through[new] = frame, number
            before = own
    share = np.cumsum(np.bincount(first, minlength=frames + 1)[:frames]) / max(count, 1)
    where = ""
    if (through >= 0).any():
        most = int(np.bincount(through[through >= 0]).argmax())
        where = recording.names.label_of_link(walls[most][0])
    return share, [where] * frames


def _walls(recording: RecordedCase) -> list[tuple[int, LinkSolid]]:
    """Return solids that can contain a body, with their links."""
    names, found = recording.names, []
    for name, target in names.copies.items():
        model = recording.case.bodies.get(body_of(name))
        held = names.is_static(name) or isinstance(model, Driven)
        held = held or (isinstance(model, Rigid) and model.mount.kind != "free")
        if held and target.soft is None and (felt := names.felt_links(target)):
            found += recording.shapes.of_links(np.array(felt))
    return found


def half_size(recording: RecordedCase, link: int) -> float:
    """Return half the side [m] of a ground; points that fall beside it have not leaked."""
    shape = recording.case.scene.statics[body_of(recording.states.links[link].body)].shape
    return shape.size / 2 if isinstance(shape, Plane) else np.inf


def depth_on_the_way(solid: LinkSolid, spacing: float) -> float:
    """Return the depth [m] in a solid beyond which a point is passing through, for a point spacing [m]."""
    # The box centre of a non-convex mesh may lie outside of it, and then says nothing about its thickness.
    least = spacing if solid.kind == "surface" else 0.0
    return min(PASSING_DEPTH * spacing, max(PASSING_SHARE * _half_thickness(solid), least))


def _half_thickness(solid: LinkSolid) -> float:
    """Return the largest possible depth [m] in a solid."""
    if solid.kind == "plane":
        return np.inf
    low, high = solid.bounds
    return max(0.0, -float(solid.distance(((low + high) / 2)[None])[0]))


def _points_below(own: Array, deep: float, size: float) -> Array:
    """Return the indices of points below a ground."""
    return np.flatnonzero((own[:, 2] < -deep) & (np.abs(own[:, :2]) < size).all(axis=1))


def _inside(solid: LinkSolid, own: Array, before: Array | None, deep: float) -> Array:
    """Return the indices of points that are deep in a solid now, or were since the previous frame."""
    before = own if before is None else before
    low, high = solid.bounds
    with np.errstate(invalid="ignore"):
        near = (np.minimum(own, before) < high).all(axis=1) & (np.maximum(own, before) > low).all(axis=1)
    near = np.flatnonzero(near & np.isfinite(own).all(axis=1) & np.isfinite(before).all(axis=1))
    if not len(near):
        return near
    a, b = before[near], own[near]
    depth = [solid.distance(a + (b - a) * k / PLACES_BETWEEN_FRAMES) for k in range(1, PLACES_BETWEEN_FRAMES + 1)]
    return near[np.min(depth, axis=0) < -deep]
