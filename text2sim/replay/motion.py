"""Motion of a run for the page, in limited numbers of frames."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.exchange.scenery import Figure, Scenery
from text2sim.exchange.viewing import camera_tracks
from text2sim.recording.states import RunStates
from text2sim.replay.packing import Blob
from text2sim.replay.pictures import Pictures
from text2sim.replay.shapes import pack_faces, surface_of

Array = NDArray[Any]

MAX_RIGID_SIZE = 5_000_000
"""Largest size of all poses [bytes]."""
POSE_SIZE = 14
"""Size of a pose [bytes]."""
MAX_SOFT_SIZE = 6_000_000
"""Largest size of the points of deformable bodies [bytes]."""
POINT_SIZE = 6
"""Size of a point in a frame [bytes]."""
MIN_SOFT_FRAMES, SMOOTH_SOFT_FRAMES = 12, 50
"""Smallest number of frames of deformable bodies, and the number that takes precedence over showing all particles."""
MAX_CONTACTS = 100_000
"""Largest number of contacts in all frames."""


def evenly_spaced(count: int, max_frames: int) -> Array:
    """Return the indices of at most `max_frames` of `count` frames, evenly spread, with the first and the last."""
    if count <= max_frames:
        return np.arange(count)
    stride = math.ceil((count - 1) / max(max_frames - 2, 1))
    return np.unique([*range(0, count, stride), count - 1])


def pack_links(scenery: Scenery, blob: Blob, notes: list[str]) -> tuple[dict[str, Any], dict[int, int], Array]:
    """Pack the poses of visible moving links.

    Args:
        scenery: The run.
        blob: Collects the arrays.
        notes: Collects notes about omissions.

    Returns:
        Data for the page; the track number of each such link; the indices of the frames.
    """
    pos, quat = scenery.poses
    moves = ((pos != pos[0]).any(axis=2) | (quat != quat[0]).any(axis=2)).any(axis=0)
    moving = [link.row for link in scenery.links if link.pieces and moves[link.row]]
    frames = evenly_spaced(len(pos), max(MAX_RIGID_SIZE // (POSE_SIZE * max(len(moving), 1)), 2))
    _note_thinning(notes, "rigid bodies", len(pos), frames)
    row: dict[str, Any] = {"times": blob.add(scenery.times[frames].astype(np.float32)), "count": len(moving)}
    row["pos"] = blob.add_points(pos[frames][:, moving])
    row["quat"] = blob.add(np.rint(np.clip(quat[frames][:, moving], -1, 1) * 32767).astype(np.int16))
    return row, {link: k for k, link in enumerate(moving)}, frames


def pack_figures(scenery: Scenery, blob: Blob, pictures: Pictures, notes: list[str]) -> list[dict[str, Any]]:
    """Pack deformable bodies: complete surfaces, and particles as far as there is room.

    Args:
        scenery: The run.
        blob: Collects the arrays.
        pictures: Collects the pictures of surfaces.
        notes: Collects notes about omissions.
    """
    figures = list(scenery.figures)
    surfaces = sorted((f for f in figures if f.faces is not None), key=lambda f: f.size)
    while sum(f.size for f in surfaces) * POINT_SIZE * MIN_SOFT_FRAMES > MAX_SOFT_SIZE:
        figures.remove(large := surfaces.pop())
        notes.append(f"{large.body} is left out: its surface has {large.size} points")
    room = MAX_SOFT_SIZE / POINT_SIZE / min(SMOOTH_SOFT_FRAMES, len(scenery.frames)) - sum(f.size for f in surfaces)
    particles = sum(f.size for f in figures if f.faces is None)
    stride = max(1, math.ceil(particles / max(room, MAX_SOFT_SIZE / POINT_SIZE / SMOOTH_SOFT_FRAMES / 10)))
    if stride > 1:
        notes.append(f"one of {stride} particles is shown, enlarged")
    total = sum(f.size if f.faces is not None else math.ceil(f.size / stride) for f in figures)
    frames = evenly_spaced(len(scenery.frames), max(MAX_SOFT_SIZE // (POINT_SIZE * max(total, 1)), 2))
    if figures:
        _note_thinning(notes, "deformable bodies", len(scenery.frames), frames)
    # Frame by frame, because the chunks of a long recording do not fit into memory together.
    tracks: list[list[Array]] = [[] for _ in figures]
    for frame in scenery.frames[frames]:
        for track, figure in zip(tracks, figures, strict=True):
            points = figure.points(int(frame))
            track.append(points if figure.faces is not None else points[::stride])
    times = blob.add(scenery.times[frames].astype(np.float32))
    return [
        _pack_figure(figure, np.array(track), stride, blob, pictures) | {"times": times}
        for figure, track in zip(figures, tracks, strict=True)
    ]


def _pack_figure(figure: Figure, points: Array, stride: int, blob: Blob, pictures: Pictures) -> dict[str, Any]:
    count = points.shape[1]
    # One box for the whole body: all frames as one list of points.
    row: dict[str, Any] = {"body": figure.body, "kind": figure.kind, "count": count, "frames": len(points)}
    row["points"] = blob.add_points(points.reshape(-1, 3))
    if figure.faces is None:
        row["radius"] = 0.5 * figure.spacing * stride ** (1 / 3)
    else:
        row["faces"] = pack_faces(figure.faces, blob)
        if figure.uvs is not None and figure.material.picture is not None:
            row["uvs"] = blob.add(figure.uvs.astype(np.float32))
    return row | surface_of(figure.material, pictures)


def pack_contacts(folder: Path, scenery: Scenery, frames: Array, blob: Blob, notes: list[str]) -> dict[str, Any] | None:
    """Pack the contacts between links: for each pair, the strongest since the previous frame.

    Args:
        folder: The run folder.
        scenery: The run.
        frames: Indices of the frames, shape (n,).
        blob: Collects the arrays.
        notes: Collects notes about omissions.
    """
    states = RunStates.load(folder)
    pos, force, pairs = (states.contact(name) for name in ("pos", "normal_force", "links"))
    steps = np.rint(scenery.times[frames] / states.dt).astype(np.int64)
    frame = np.searchsorted(steps, states.contact("step"))
    sound = (frame < len(steps)) & np.isfinite(pos).all(axis=1) & np.isfinite(force)
    pos, force, pairs, frame = pos[sound], force[sound], np.sort(pairs[sound], axis=1), frame[sound]
    if not len(pos):
        return None
    order = np.lexsort((-force, pairs[:, 1], pairs[:, 0], frame))
    rows = np.column_stack([frame, pairs])[order]
    order = order[np.concatenate([[True], (rows[1:] != rows[:-1]).any(axis=1)])]
    if len(order) > MAX_CONTACTS:
        notes.append(f"of {len(order)} contacts the {MAX_CONTACTS} strongest are shown")
        order = order[np.sort(np.argsort(-force[order], kind="stable")[:MAX_CONTACTS])]
    names, number = [], {}
    for link in scenery.links:
        number.setdefault(link.body, len(number))
        names.append(number[link.body])
    return {
        "starts": blob.add(np.searchsorted(frame[order], np.arange(len(steps) + 1)).astype(np.uint32)),
        "pos": blob.add_points(pos[order]),
        "force": blob.add(force[order].astype(np.float32)),
        "pairs": blob.add(np.array(names)[pairs[order]].astype(np.uint16)),
        "names": list(number),
        "strongest": float(force.max()),
    }


def pack_cameras(scenery: Scenery, blob: Blob) -> list[dict[str, Any]]:
    """Pack the cameras of the film."""
    rows = []
    for name, track in camera_tracks(scenery.recording).items():
        rows.append(
            {
                "name": name, "times": blob.add(track.times.astype(np.float32)),
                "pos": blob.add(np.array([view.pos for view in track.views], np.float32)),
                "look": blob.add(np.array([view.look_at for view in track.views], np.float32)),
                "up": blob.add(np.array([view.up for view in track.views], np.float32)), "fov": track.views[0].fov,
            }
        )  # fmt: skip
    return rows


def _note_thinning(notes: list[str], what: str, count: int, frames: Array) -> None:
    if len(frames) < count:
        notes.append(f"{what} are shown in {len(frames)} of {count} recorded frames")
