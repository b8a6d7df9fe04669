"""Why an item gets into a dataset, or does not, and which items somebody should look at."""

import io
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from text2sim.dataset.item import Item
from text2sim.dataset.recipe import ItemLimits
from text2sim.recording.vectors import rotate

MOMENTS = 12
"""At which two runs are compared."""
GLANCE, GLANCES = 12, 4
"""Fields along each side of a picture, and pictures of a film, whose mean colours are compared."""
SAME = 1.5
"""Mean difference of these colours, of 255, below which two films of one simulation are the same."""
LINKS = 16
"""Of a run, at most, and as many points that deform, whose ways are compared."""
REACH = 0.1
"""How far from a link's origin [m] points of its axes lie that are compared, too: an arm turns about its origin."""
NEAR = 0.5
"""Part of a limit from which on an item is doubtful."""


def refusals(item: Item, limits: ItemLimits) -> list[str]:
    """Return why an item is refused; nothing if it is not."""
    row, found = item.row, []
    if row["state"] != "finished":
        found.append(f"state: the run ended as {row['state']}")
    found += [f"finite: {name} is not" for name in _not_finite(item.folder)]
    if (gain := row["energy_gain"]) is not None and gain > limits.energy:
        found.append(f"energy: {100 * gain:.2g} % from nowhere, more than {100 * limits.energy:g} %")
    if (depth := row["penetration"]) is not None and depth > limits.penetration:
        found.append(f"penetration: {1e3 * depth:.3g} mm, more than {1e3 * limits.penetration:g} mm")
    if (seen := _seen(item)) < limits.seen:
        found.append(f"legibility: no moving body fills {limits.seen:g} of the picture in half of them ({seen:.2g})")
    pictures = decoded(item.folder / "film.mp4", (row["width"], row["height"]))
    if len(pictures) != row["frames"]:
        found.append(f"film: {len(pictures)} of {row['frames']} pictures can be decoded")
    item.glance = pictures[:: max(1, len(pictures) // GLANCES)]
    found += annotation_faults(item.folder / "annotations.npz", row, item.frames)
    return found


def is_doubtful(row: dict[str, Any], limits: ItemLimits) -> bool:
    """Whether somebody should look at an item that is not refused."""
    close = [(row["energy_gain"], limits.energy), (row["penetration"], limits.penetration)]
    return bool(row["suspicions"]) or any(value is not None and value > NEAR * limit for value, limit in close)


def _not_finite(folder: Path) -> list[str]:
    with np.load(folder / "states.npz") as arrays:
        return [name for name in arrays if not np.isfinite(arrays[name]).all()]


def _seen(item: Item) -> float:
    still = {thing["instance"] for thing in item.row["things"] if thing["static"]}
    shares = [
        max((one["share"] for one in frame.get("objects", []) if one["instance"] not in still), default=0.0)
        for frame in item.frames
    ]
    return median(shares) if shares else 0.0


def decoded(path: "Path | io.BytesIO", size: tuple[int, int]) -> list[list[int]]:
    """Return mean colours of fields of each picture, 0 to 255, as far as a film can be read and has this size."""
    import av
    import av.error

    found: list[list[int]] = []
    try:
        with av.open(path, "r") as film:
            for picture in film.decode(video=0):
                if (picture.width, picture.height) != size:
                    return found
                image = picture.reformat(width=GLANCE, height=GLANCE, format="rgb24", interpolation="AREA")
                found.append([int(value) for value in image.to_ndarray().ravel()])
    except (av.error.FFmpegError, OSError, IndexError):
        pass
    return found


def annotation_faults(path: "Path | io.BytesIO", row: dict[str, Any], frames: list[dict[str, Any]]) -> list[str]:
    """Return what contradicts itself in the annotations of an item.

    Args:
        path: The file of the annotations, or its content.
        row: Row of the item.
        frames: Rows of its frames.
    """
    if isinstance(path, Path) and not path.is_file():
        return []
    found = []
    with np.load(path) as arrays:
        shape = (row["frames"], row["height"], row["width"])
        found += [f"annotation: {n} has the shape {arrays[n].shape}" for n in arrays if arrays[n].shape[:3] != shape]
        if found:
            return found
        ids = arrays["instances"] if "instances" in arrays else None
        if ids is not None and ids.max() > len(row["things"]):
            found.append(f"annotation: instance {ids.max()} is not in the list of things")
        if ids is not None and "depth" in arrays and (np.isfinite(arrays["depth"]) != (ids > 0)).any():
            found.append("annotation: depth and instances disagree about the background")
        if ids is not None and len(frames) == len(ids):
            found += _box_faults(ids, frames)
    return found


def _box_faults(ids: Any, frames: list[dict[str, Any]]) -> list[str]:
    for k, frame in enumerate(frames):
        for thing in frame.get("objects") or []:
            box = thing.get("box")
            if box is None:
                continue
            mask = ids[k] == thing["instance"]
            if (
                not mask[box[1] : box[3], box[0] : box[2]].any()
                or mask.sum() != mask[box[1] : box[3], box[0] : box[2]].sum()
            ):
                return [f"annotation: the box of {thing['name']} in picture {k} is not around its pixels"]
    return []


class Likeness:
    """Finds runs that are nearly those that are there already; keeps a few numbers of each.

    Args:
        limit: Mean distance, as a part of the room that the bodies take, below which two runs are the same.
    """

    def __init__(self, limit: float):
        self._limit = limit
        self._known: dict[tuple[str, int], list[tuple[str, Any]]] = {}

    def twin(self, key: str, name: str, states: Path) -> str | None:
        """Return the item of the same case that is nearly this one; take note of this one if there is none.

        Args:
            key: The item.
            name: Of its case.
            states: Its `states.npz`.
        """
        places = fingerprint(states)
        room = float(np.ptp(places.reshape(-1, 3), axis=0).max()) if places.size else 0.0
        others = self._known.setdefault((name, places.size), [])
        for other, there in others:
            if places.size and np.linalg.norm(places - there, axis=-1).mean() < self._limit * max(room, 1e-9):
                return other
        others.append((key, places))
        return None


def same_film(item: Item, others: Sequence[Item]) -> str | None:
    """Return which of some films of the same simulation looks the same; None if none does."""
    for other in others:
        one, two = np.array(item.glance, float), np.array(other.glance, float)
        if one.shape == two.shape and np.abs(one - two).mean() < SAME:
            return other.key
    return None


def fingerprint(states: "Path | io.BytesIO") -> Any:
    """Return where links with their axes, and points that deform, are at some moments of a run [m], shape (M, L, 3)."""
    with np.load(states) as arrays:
        pos = arrays["pos"]
        chosen = np.linspace(0, len(pos) - 1, MOMENTS).round().astype(int) if len(pos) else []
        pos, quat = (a[chosen][:, :: max(1, a.shape[1] // LINKS)].astype(float) for a in (pos, arrays["quat"]))
        found = [pos, *(pos + rotate(quat, np.broadcast_to(axis, pos.shape)) for axis in REACH * np.eye(3)[:2])]
        if "soft_points" in arrays:
            soft = arrays["soft_points"]
            rows = np.linspace(0, len(soft) - 1, MOMENTS).round().astype(int)
            found.append(soft[rows][:, :: max(1, soft.shape[1] // LINKS)].astype(float))
    return np.concatenate(found, axis=1) if len(found[0]) else np.zeros((0, 0, 3))
