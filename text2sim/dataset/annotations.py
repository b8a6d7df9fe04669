"""Annotations of each picture of a film, rasterised from recorded states and the film's cameras.

Cameras are pinholes. Pixels count from the upper left corner; the centre of the first is (0.5, 0.5). Camera frames
follow OpenCV: x to the right, y down, z ahead. Anything outside the recording, such as a backdrop, is background.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from text2sim.assets.surface import scaled_normals
from text2sim.compiler.shapes.rotation import quats_to_matrices
from text2sim.drawing.raster import Raster
from text2sim.drawing.view import PictureView
from text2sim.legibility.recorded import Array, Recorded, raster_view
from text2sim.legibility.sight import MIN_PIXELS, Things, look
from text2sim.recording.film_record import FilmRecord
from text2sim.recording.states import RunStates
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras

MAX_TRIANGLES = 400_000
"""Triangles of rigid things, about: larger meshes are coarsened."""
MAX_PARTICLES = 5_000
"""Particles that are drawn."""
KEY_POINT_DIRECTIONS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
"""Key points of a thing are the eight vertices of its surface that are farthest in these directions at the start."""
DEPTH_TOLERANCE = 0.01
"""A point is seen if it is at most this part of its depth behind the surface at its pixel."""
FLIP = np.array([1.0, -1.0, -1.0])
"""Converts (right, up, back) to (right, down, ahead)."""
LIGHT = np.array([0.35, -0.45, 0.82])
"""Direction to the light of a preview."""

ARRAYS = {
    "depth": "float32 (T, H, W): distance along the camera's z axis [m]; inf for background",
    "normals": "float16 (T, H, W, 3): unit normals towards the camera, in the world; 0 for background",
    "instances": "uint16 (T, H, W): number of the thing, from 1; 0 for background",
    "parts": "uint16 (T, H, W): number of the mesh or deforming body, from 1; 0 for background",
    "flow": "float32 (T, H, W, 2): motion of a surface point to the next picture [pixels]; nan where that is unknown: "
    "background, the last picture, a cut",
    "seen_next": "bool (T, H, W): whether that point is seen in the next picture",
    "contacts": "float16 (T, H, W): sum of the normal forces of the contacts at a pixel [N]",
}


@dataclass(frozen=True)
class Seen:
    """Geometry of a picture."""

    frame: Frame
    view: PictureView
    corners: Array
    """Triangles [m], shape (n, 3, 3)."""
    there: Array
    """Whether each triangle exists at this time, shape (n,)."""
    ids: Array
    """Triangle at each pixel, -1 for background, shape (h, w)."""
    depth: Array
    """Depth [m], shape (h, w); inf for background."""


class Annotator:
    """Annotates pictures of a film.

    Args:
        recording: The recorded run; its `film` has size and cameras.
    """

    def __init__(self, recording: FilmRecord):
        self.recording = recording
        self.recorded = Recorded(recording, MAX_TRIANGLES, MAX_PARTICLES, copies=True)
        self.size: tuple[int, int] = tuple(recording.film["resolution"])
        self._cameras = Cameras(recording.film, recording.states)
        corners, self.piece, _ = self.recorded.surfaces(float(recording.states.time[0]))
        self.owner = self.recorded.thing_of_piece[self.piece]
        self._keys = [_outermost(corners, np.flatnonzero(self.owner == k)) for k in range(len(self.names))]

    @property
    def names(self) -> list[str]:
        """Names of the things; the first is instance 1."""
        return self.recorded.names

    @cached_property
    def things(self) -> list[dict[str, Any]]:
        """Number, name and body of each thing, and whether it is static."""
        statics = self.recorded.statics
        return [
            {"instance": k + 1, "name": name, "body": name.partition("[")[0], "static": name in statics}
            for k, name in enumerate(self.names)
        ]

    @cached_property
    def parts(self) -> list[dict[str, Any]]:
        """Number, thing and link of each part; a deformable body is one part without a link."""
        rows, found = self.recording.states.layout["links"], []
        for k, piece in enumerate(self.recorded.pieces):
            link = getattr(piece, "link", None)
            name = "" if link is None else str(rows[link]["link"])
            found.append({"part": k + 1, "thing": piece.body, "link": name})
        return found

    def seen(self, frame: Frame) -> Seen:
        """Return the geometry of a picture."""
        view = raster_view(self._cameras.view(frame.camera, frame.t, frame.part), self.size)
        corners, _, there = self.recorded.surfaces(frame.t)
        raster = Raster(np.where(there[:, None, None], corners, 0.0), view)
        raster.draw(np.flatnonzero(there))
        with np.errstate(divide="ignore"):
            depth = np.where(raster.ids >= 0, 1.0 / raster.nearness, np.inf).astype(np.float32)
        return Seen(frame, view, corners, there, raster.ids, depth)

    def arrays(
        self, now: Seen, after: Seen | None, wanted: Sequence[str], touches: "PictureContacts | None"
    ) -> dict[str, Any]:
        """Return the arrays of a picture, see `ARRAYS`.

        Args:
            now: The picture.
            after: The next picture; None after the last.
            wanted: Names of annotations.
            touches: Recorded contacts; None if the run has no record of them.
        """
        hit, found = now.ids >= 0, {}
        if "depth" in wanted:
            found["depth"] = now.depth
        if "normals" in wanted:
            found["normals"] = self.normals(now).astype(np.float16)
        if "instances" in wanted:
            found["instances"] = np.where(hit, self.owner[now.ids] + 1, 0).astype(np.uint16)
        if "parts" in wanted:
            found["parts"] = np.where(hit, self.piece[now.ids] + 1, 0).astype(np.uint16)
        if "flow" in wanted:
            found["flow"], found["seen_next"] = self.flow(now, after)
        if "contacts" in wanted and touches is not None:
            found["contacts"] = touches.map(now)
        return found

    def normals(self, now: Seen) -> Array:
        """Return unit normals towards the camera, in the world, shape (h, w, 3); 0 for background."""
        hit = now.ids >= 0
        corners = now.corners[now.ids[hit]]
        normal = scaled_normals(corners)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
        towards = np.einsum("nk,nk->n", normal, now.view.origin - corners[:, 0]) >= 0
        found = np.zeros((*now.ids.shape, 3))
        found[hit] = np.where(towards[:, None], normal, -normal)
        return found

    def flow(self, now: Seen, after: Seen | None) -> tuple[Array, Array]:
        """Return the flow to the next picture, and whether each point is seen there; see `ARRAYS`."""
        flow = np.full((*now.ids.shape, 2), np.nan, np.float32)
        shown = np.zeros(now.ids.shape, bool)
        if after is None or after.frame.camera != now.frame.camera or after.frame.t < now.frame.t:
            return flow, shown
        row, column = np.nonzero(now.ids >= 0)
        triangle = now.ids[row, column]
        here = np.stack([column + 0.5, row + 0.5], axis=1)
        points = np.einsum("nk,nkc->nc", _shares(now, here, triangle), after.corners[triangle])
        later = after.view.pixels(points)
        later[~after.there[triangle]] = np.nan
        flow[row, column] = later - here
        shown[row, column] = _is_seen(after, points)
        return flow, shown

    def preview(self, now: Seen) -> Array:
        """Return an image with flat colours and one light, without shadows, uint8, shape (h, w, 3)."""
        shade = 0.45 + 0.55 * np.clip(self.normals(now) @ LIGHT, 0, 1)
        background = np.asarray(self.recording.film["background"], float)
        colors = self.recorded.colors[self.owner[now.ids]] * shade[..., None]
        return (np.where((now.ids >= 0)[..., None], colors, background) * 255).round().astype(np.uint8)

    def row(self, now: Seen, wanted: Sequence[str], touches: "PictureContacts | None") -> dict[str, Any]:
        """Return the row of a picture in the table of frames.

        Args:
            now: The picture.
            wanted: Names of annotations.
            touches: Recorded contacts; None if the run has no record of them.
        """
        frame, view = now.frame, now.view
        found: dict[str, Any] = {"frame": frame.k, "camera": frame.camera, "time": frame.t, "speed": frame.speed}
        if "cameras" in wanted:
            turn = view.axes * FLIP[:, None]
            found["intrinsics"] = [view.focal, view.focal, view.width / 2, view.height / 2]
            found["rotation"] = turn.ravel().tolist()
            found["translation"] = (-turn @ view.origin).tolist()
        if {"boxes", "keypoints", "visibility"} & {*wanted}:
            found["objects"] = self._objects(now, wanted)
        if "contacts" in wanted and touches is not None:
            found["contacts"] = touches.rows(now)
        return found

    def _objects(self, now: Seen, wanted: Sequence[str]) -> list[dict[str, Any]]:
        owner, count = self.owner, len(self.names)
        solid = self.recorded.hiding[self.piece][now.there]
        sight = look(Things(now.corners[now.there], owner[now.there], solid, count), now.view)
        ids = np.where(now.ids >= 0, owner[now.ids], -1)
        rows = []
        for k, thing in enumerate(self.things):
            chosen = (owner == k) & now.there
            if not chosen.any():
                continue
            points = now.corners[chosen].reshape(-1, 3)
            row: dict[str, Any] = {"instance": k + 1, "name": thing["name"]}
            if "visibility" in wanted:
                row["share"] = float(sight.seen[k] / sight.size)
                row["hidden"] = float(sight.hidden[k]) if sight.alone[k] >= MIN_PIXELS else None
                row["inside"] = float(sight.inside[k])
            if "boxes" in wanted:
                row["box"], row["whole_box"] = _box(ids == k), _bounding_box(points, now.view)
                row |= self._box3d(thing["name"], points, now.frame.t)
            if "keypoints" in wanted:
                triangle, corner = self._keys[k]
                keys = now.corners[triangle, corner]
                row["keypoints"] = keys.ravel().tolist()
                row["keypoint_pixels"] = [None if np.isnan(v) else float(v) for v in now.view.pixels(keys).ravel()]
                row["keypoint_seen"] = _is_seen(now, keys).tolist()
            rows.append(row)
        return rows

    def _box3d(self, name: str, points: Array, t: float) -> dict[str, Any]:
        """A box in the frame of the first link of a thing that has meshes; in the world frame if the thing deforms."""
        piece = next(piece for piece in self.recorded.pieces if piece.body == name)
        link = getattr(piece, "link", None)
        quat, turn = np.array([1.0, 0, 0, 0]), np.eye(3)
        if link is not None:
            quat = self.recording.states.poses(t)[1][link].astype(float)
            turn = quats_to_matrices(quat[None])[0]
        local = points @ turn
        low, high = local.min(axis=0), local.max(axis=0)
        return {"center": (turn @ ((low + high) / 2)).tolist(), "size": (high - low).tolist(), "quat": quat.tolist()}


class PictureContacts:
    """Recorded contacts between links at the time step of a picture."""

    def __init__(self, states: RunStates):
        self._states = states
        self._bodies = [link.body for link in states.links]
        self._steps = states.contact("step").astype(np.int64)
        order = np.argsort(self._steps, kind="stable")
        self._order, self._sorted = order, self._steps[order]
        self._arrays = {key: states.contact(key) for key in ("links", "force", "pos", "penetration", "normal_force")}

    def rows(self, now: Seen) -> list[dict[str, Any]]:
        """Return the contacts of a picture, one row each."""
        pixels = self._pixels(now)
        return [
            {
                "between": [self._bodies[int(link)] for link in self._arrays["links"][k]],
                "pos": self._arrays["pos"][k].tolist(),
                "force": self._arrays["force"][k].tolist(),
                "penetration": float(self._arrays["penetration"][k]),
                "pixel": pixels[n].tolist() if np.isfinite(pixels[n]).all() else None,
            }
            for n, k in enumerate(self._points_at(now.frame.t))
        ]

    def map(self, now: Seen) -> Array:
        """Return the sum of normal forces at each pixel [N], float16, shape (h, w)."""
        wide, tall = now.view.width, now.view.height
        pixels, force = self._pixels(now), self._arrays["normal_force"][self._points_at(now.frame.t)]
        inside = np.isfinite(pixels).all(axis=1) & (pixels >= 0).all(axis=1) & (pixels < (wide, tall)).all(axis=1)
        column, row = pixels[inside].astype(int).T
        sums = np.bincount(row * wide + column, np.abs(force[inside]).astype(float), wide * tall)
        return np.minimum(sums, np.finfo(np.float16).max).reshape(tall, wide).astype(np.float16)

    def _points_at(self, t: float) -> Array:
        step = round(t / self._states.dt)
        first, last = np.searchsorted(self._sorted, [step, step + 1])
        return self._order[first:last]

    def _pixels(self, now: Seen) -> Array:
        return now.view.pixels(self._arrays["pos"][self._points_at(now.frame.t)].reshape(-1, 3))


def _shares(now: Seen, pixels: Array, triangle: Array) -> Array:
    """Barycentric coordinates of the points that are seen at pixels, shape (n, 3).

    The ray through a pixel is a sum of the triangle's corners, relative to the eye, with positive weights. This is
    exact in perspective, and independent of the rasteriser.
    """
    view = now.view
    slope = np.stack([pixels[:, 0] - view.width / 2, view.height / 2 - pixels[:, 1]], axis=1) / view.focal
    ray = slope @ view.axes[:2] - view.axes[2]
    corners = now.corners[triangle] - view.origin
    weights = np.stack(
        [np.einsum("nk,nk->n", ray, np.cross(corners[:, (k + 1) % 3], corners[:, (k + 2) % 3])) for k in range(3)], 1
    )
    return weights / weights.sum(axis=1, keepdims=True)


def _is_seen(now: Seen, points: Array) -> Array:
    """Whether nothing hides points [m], shape (n, 3), at their pixels.

    Depth is known at the centre of a pixel. The plane of the triangle that is seen there is extrapolated to the point:
    at a grazing angle, depth changes a lot within a pixel.
    """
    pixels, depth = now.view.pixels(points), -now.view.local(points)[:, 2]
    inside = np.isfinite(pixels).all(axis=1) & (pixels >= 0).all(axis=1) & (depth > now.view.near)
    inside &= (np.nan_to_num(pixels, nan=-1) < (now.view.width, now.view.height)).all(axis=1)
    found = inside.copy()
    column, row = pixels[inside].astype(int).T
    shown = now.ids[row, column]
    hit = shown >= 0
    which = np.flatnonzero(inside)[hit]
    corners = now.corners[shown[hit]]
    normal = scaled_normals(corners)
    over = np.einsum("nk,nk->n", normal, corners[:, 0] - now.view.origin)
    under = np.einsum("nk,nk->n", normal, points[which] - now.view.origin)
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = depth[which] * over / under
    # The plane extends beyond the triangle.
    ends = -now.view.local(corners.reshape(-1, 3))[:, 2].reshape(-1, 3)
    ahead = np.where(ahead > 0, np.clip(ahead, ends.min(axis=1), ends.max(axis=1)), now.depth[row, column][hit])
    found[which] = depth[which] <= ahead * (1 + DEPTH_TOLERANCE)
    return found


def _outermost(corners: Array, triangles: Array) -> tuple[Array, Array]:
    """Triangle and corner of the points that are farthest along `KEY_POINT_DIRECTIONS`, both of shape (8,)."""
    best = np.argmax(corners[triangles].reshape(-1, 3) @ KEY_POINT_DIRECTIONS.T, axis=0)
    return triangles[best // 3], best % 3


def _box(mask: Array) -> list[int] | None:
    """Left, top, right, bottom of a mask [pixels], the last two exclusive; None if it is empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return None
    return [int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1]


def _bounding_box(points: Array, view: PictureView) -> list[float] | None:
    """Left, top, right, bottom [pixels] of a whole thing, with what is hidden or outside of the picture.

    None if some of it is behind the camera.
    """
    pixels = view.pixels(points)
    if not np.isfinite(pixels).all():
        return None
    return [*pixels.min(axis=0).tolist(), *pixels.max(axis=0).tolist()]
