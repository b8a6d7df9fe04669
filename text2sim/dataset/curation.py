"""Filters of items: reasons to refuse them, doubts that a person should look at, and duplicates."""

import io
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from text2sim.dataset.item import Item
from text2sim.dataset.recipe import ItemLimits
from text2sim.recording.vectors import rotate

COMPARED_TIMES = 12
"""Number of times at which two runs are compared."""
THUMBNAIL_SIDE, THUMBNAILS = 12, 4
"""Fields along each side of a picture, and pictures of a film, whose mean colours are compared."""
MAX_SAME_DIFFERENCE = 1.5
"""Mean difference of these colours, of 255, below which two films of one simulation are the same."""
MAX_COMPARED_LINKS = 16
"""Links, and points of deformable bodies, whose motion is compared, at most."""
POINT_OFFSET = 0.1
"""Distance [m] from a link's origin of further points that are compared: an arm may turn about its origin."""
DOUBTFUL_SHARE = 0.5
"""Part of a limit above which an item is doubtful."""


def refusals(item: Item, limits: ItemLimits) -> list[str]:
    """Return the reasons to refuse an item."""
    row, found = item.row, []
    if row["state"] != "finished":
        found.append(f"state: the run ended as {row['state']}")
    with np.load(item.folder / "states.npz") as arrays:
        found += [f"finite: {name} is not" for name in arrays if not np.isfinite(arrays[name]).all()]
    if (gain := row["energy_gain"]) is not None and gain > limits.energy:
        found.append(f"energy: {100 * gain:.2g} % without a source, more than {100 * limits.energy:g} %")
    if (depth := row["penetration"]) is not None and depth > limits.penetration:
        found.append(f"penetration: {1e3 * depth:.3g} mm, more than {1e3 * limits.penetration:g} mm")
    if (seen := _median_filled_share(item)) < limits.seen:
        found.append(f"legibility: no moving body fills {limits.seen:g} of the picture in half of them ({seen:.2g})")
    pictures = thumbnail_colors(item.folder / "film.mp4", (row["width"], row["height"]))
    if len(pictures) != row["frames"]:
        found.append(f"film: {len(pictures)} of {row['frames']} pictures can be decoded")
    item.glance = pictures[:: max(1, len(pictures) // THUMBNAILS)]
    found += annotation_faults(item.folder / "annotations.npz", row, item.frames)
    return found


def is_doubtful(row: dict[str, Any], limits: ItemLimits) -> bool:
    """Whether a person should look at an accepted item."""
    close = [(row["energy_gain"], limits.energy), (row["penetration"], limits.penetration)]
    return bool(row["suspicions"]) or any(
        value is not None and value > DOUBTFUL_SHARE * limit for value, limit in close
    )


def _median_filled_share(item: Item) -> float:
    """Median over the pictures of the share that the largest moving body fills."""
    still = {thing["instance"] for thing in item.row["things"] if thing["static"]}
    shares = [
        max((thing["share"] for thing in frame.get("objects", []) if thing["instance"] not in still), default=0.0)
        for frame in item.frames
    ]
    return median(shares) if shares else 0.0


def thumbnail_colors(path: "Path | io.BytesIO", size: tuple[int, int]) -> list[list[int]]:
    """Return mean colours of fields of each picture, 0 to 255, as far as a film is readable and has this size."""
    import av
    import av.error

    found: list[list[int]] = []
    try:
        with av.open(path, "r") as film:
            for picture in film.decode(video=0):
                if (picture.width, picture.height) != size:
                    return found
                image = picture.reformat(
                    width=THUMBNAIL_SIDE, height=THUMBNAIL_SIDE, format="rgb24", interpolation="AREA"
                )
                found.append([int(value) for value in image.to_ndarray().ravel()])
    except (av.error.FFmpegError, OSError, IndexError):
        pass
    return found


def annotation_faults(path: "Path | io.BytesIO", row: dict[str, Any], frames: list[dict[str, Any]]) -> list[str]:
    """Return contradictions in the annotations of an item.

    Args:
        path: The file of the annotations, or its content.
        row: Row of the item.
        frames: Rows of its frames; boxes are not checked without them.
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
            inside = mask[box[1] : box[3], box[0] : box[2]].sum()
            if not inside or inside != mask.sum():
                return [f"annotation: the box of {thing['name']} in picture {k} is not around its pixels"]
    return []


class Likeness:
    """Finds runs that nearly repeat earlier ones; keeps a few numbers of each.

    Args:
        limit: As in `is_alike`, for two runs of a case; for runs in two splits it is that of `dataset check`.
    """

    def __init__(self, limit: float):
        self._limit = limit
        self._known: dict[int, list[tuple[str, str, str, Any]]] = {}

    def twin(self, key: str, name: str, split: str, states: Path, base: str | None = None) -> str | None:
        """Return the item of its case, or of another split, that moves like this one; remember it if there is none.

        Args:
            key: The item.
            name: Name of its case.
            split: Its split.
            states: Its `states.npz`.
            base: The item that it may move like, as a counterfactual without an effect does.
        """
        motion = fingerprint(states)
        others = self._known.setdefault(motion.size, [])
        for other, its_name, its_split, its_motion in others:
            limit = self._limit if its_split == split else ItemLimits().alike
            if (its_name == name or its_split != split) and is_alike(motion, its_motion, limit):
                if other == base:
                    break
                return other
        others.append((key, name, split, motion))
        return None


def is_alike(one: Any, other: Any, limit: float) -> bool:
    """Whether two runs are nearly the same.

    Args:
        one: Its `fingerprint`.
        other: That of the other run.
        limit: Mean distance below which they are, as a part of the larger space that their bodies take up.
    """
    if one.shape != other.shape or not one.size:
        return False
    space = max(float(np.ptp(motion.reshape(-1, 3), axis=0).max()) for motion in (one, other))
    return bool(np.linalg.norm(one - other, axis=-1).mean() < limit * max(space, 1e-9))


def same_film(item: Item, others: Sequence[Item]) -> str | None:
    """Return the key of the first of some films of the same simulation that looks the same, if any."""
    for other in others:
        one, two = np.array(item.glance, float), np.array(other.glance, float)
        if one.shape == two.shape and np.abs(one - two).mean() < MAX_SAME_DIFFERENCE:
            return other.key
    return None


def fingerprint(states: "Path | io.BytesIO") -> Any:
    """Return positions of points of links and deformable bodies at some times of a run [m], shape (M, L, 3)."""
    with np.load(states) as arrays:
        pos = arrays["pos"]
        chosen = np.linspace(0, len(pos) - 1, COMPARED_TIMES).round().astype(int) if len(pos) else []
        pos, quat = (
            a[chosen][:, :: max(1, a.shape[1] // MAX_COMPARED_LINKS)].astype(float) for a in (pos, arrays["quat"])
        )
        found = [pos, *(pos + rotate(quat, np.broadcast_to(axis, pos.shape)) for axis in POINT_OFFSET * np.eye(3)[:2])]
        if "soft_points" in arrays:
            soft = arrays["soft_points"]
            rows = np.linspace(0, len(soft) - 1, COMPARED_TIMES).round().astype(int)
            found.append(soft[rows][:, :: max(1, soft.shape[1] // MAX_COMPARED_LINKS)].astype(float))
    return np.concatenate(found, axis=1) if len(found[0]) else np.zeros((0, 0, 3))
