"""Annotations of a dataset worked out anew from its states and cameras, without any code of text2sim.

    python benchmarks/dataset/recompute.py DATASET

Rays are cast at boxes, balls and cylinders, of which the case says the size, where the states say they are. Their
depth, their flow to the next picture and the boxes around them are compared with those in the dataset, at the pixels
that are wholly inside of the thing's mask.
"""

import io
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import webdataset
import yaml
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation, Slerp

FAR = 1e9
SIZES = {"box": ("size",), "sphere": ("radius",), "cylinder": ("radius", "height")}


def main() -> None:
    """Go through all items, and print how far both are apart."""
    folder = Path(sys.argv[1])
    frames: dict[str, list[dict[str, Any]]] = {}
    for row in pq.read_table(folder / "frames").to_pylist():
        frames.setdefault(row["key"], []).append(row)
    items = {row["key"]: row for row in pq.read_table(folder / "items").to_pylist()}
    found: dict[str, list[np.ndarray]] = {}
    keys = set()
    for path in sorted((folder / "shards").glob("*.tar")):
        for sample in webdataset.WebDataset(str(path), shardshuffle=False):
            key = sample["__key__"]
            rows = sorted(frames[key], key=lambda row: row["frame"])
            for name, errors in compared(sample, items[key], rows):
                keys.add(key)
                found.setdefault(name, []).append(errors)
    table = Table("what", "compared", "median", "99 of 100 below", "largest")
    for name, parts in found.items():
        errors = np.concatenate(parts)
        table.add_row(name, f"{len(errors)}", *(f"{np.quantile(errors, q):.3g}" for q in (0.5, 0.99, 1.0)))
    console = Console()
    console.print(table)
    console.print(f"{len(keys)} of {len(items)} items have such things")


def compared(
    sample: Mapping[str, Any], item: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the name of what is compared, and how far both are apart.

    Args:
        sample: Files of the item, as bytes.
        item: Its row.
        rows: Those of its pictures.
    """
    case = yaml.safe_load(sample["case.yaml"])
    links = yaml.safe_load(sample["layout.json"])["links"]
    with np.load(io.BytesIO(sample["annotations.npz"])) as arrays:
        depth, masks, flow = (arrays[name] for name in ("depth", "instances", "flow"))
    with np.load(io.BytesIO(sample["states.npz"])) as arrays:
        time, pos, quat = (arrays[name].astype(float) for name in ("time", "pos", "quat"))
    shapes = {name: shape for name, shape in shapes_of(case).items() if shape is not None}
    for thing in item["things"]:
        shape, of = shapes.get(thing["body"]), [k for k, row in enumerate(links) if row["body"] == thing["name"]]
        if thing["static"] or shape is None or len(of) != 1:
            continue
        turn = Slerp(time, Rotation.from_quat(quat[:, of[0]], scalar_first=True))

        def pose(t: float, link: int = of[0], turn: Slerp = turn) -> tuple[np.ndarray, Rotation]:
            t = float(np.clip(t, time[0], time[-1]))
            return np.array([np.interp(t, time, axis) for axis in pos[:, link].T]), turn(t)

        for k, row in enumerate(rows):
            mask = masks[k] == thing["instance"]
            seen = next(one for one in row["objects"] if one["instance"] == thing["instance"])
            if mask.any():
                yield "box around the mask [pixels]", np.abs(np.subtract(_around(mask), seen["box"]))
            place, turned = pose(row["time"])
            if shape["kind"] == "box" and seen["whole_box"] is not None:
                corners = np.array(list(np.ndindex(2, 2, 2))) - 0.5
                at, ahead = _pixels(place + turned.apply(corners * np.array(shape["size"])), row)
                if (ahead > 0).all():
                    yield (
                        "box around all of it [pixels]",
                        np.abs(np.array([*at.min(axis=0), *at.max(axis=0)]) - seen["whole_box"]),
                    )
            down, right = np.nonzero(_inner(mask))
            if not len(down):
                continue
            ray, eye, ahead = _rays(np.stack([right, down], 1) + 0.5, row)
            way = _hit(shape, turned.inv().apply(eye - place), turned.inv().apply(ray))
            yield "depth [m]", np.abs(way * ahead - depth[k, down, right])
            known = np.isfinite(flow[k, down, right]).all(axis=1) & (way < FAR)
            if known.any() and k + 1 < len(rows):
                local = turned.inv().apply(eye + way[:, None] * ray - place)
                after, turned_after = pose(rows[k + 1]["time"])
                there, _ = _pixels(after + turned_after.apply(local), rows[k + 1])
                moved = there - np.stack([right, down], 1) - 0.5
                yield "flow [pixels]", np.linalg.norm(moved - flow[k, down, right], axis=1)[known]


def shapes_of(case: Mapping[str, Any]) -> dict[str, dict[str, Any] | None]:
    """Boxes, balls and cylinders of which the size stands there in numbers, or as a parameter alone."""
    found: dict[str, dict[str, Any] | None] = {}
    for name, body in case["bodies"].items():
        params, shape = case.get("params") or {}, body.get("shape") or {}
        sizes = {key: number_of(shape.get(key), params) for key in SIZES.get(str(shape.get("kind")), ())}
        alike = (body.get("repeat") or {}).get("kind") != "running_bond"  # which has half bricks
        plain = body.get("kind") == "rigid" and alike and sizes and all(size is not None for size in sizes.values())
        found[name] = {"kind": shape["kind"], **sizes} if plain else None
    return found


def number_of(value: Any, params: Mapping[str, Any]) -> Any:
    """Return a number, or a list of some, that stands there or in a parameter; None for anything else."""
    if isinstance(value, str):
        value = params.get(value.removeprefix("${").removesuffix("}"))
    if isinstance(value, list):
        found = [number_of(one, params) for one in value]
        return None if None in found else found
    return value if isinstance(value, int | float) else None


def _rays(pixels: np.ndarray, row: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Directions (n, 3) of rays in the world, where they begin, and their shares along the camera's axis."""
    fx, fy, cx, cy = row["intrinsics"]
    turn = np.array(row["rotation"]).reshape(3, 3)
    ray = np.stack([(pixels[:, 0] - cx) / fx, (pixels[:, 1] - cy) / fy, np.ones(len(pixels))], 1)
    length = np.linalg.norm(ray, axis=1)
    return ray / length[:, None] @ turn, -turn.T @ np.array(row["translation"]), 1 / length


def _pixels(points: np.ndarray, row: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (n, 2) of points [m], and how far they are ahead [m]."""
    fx, fy, cx, cy = row["intrinsics"]
    x, y, z = (points @ np.array(row["rotation"]).reshape(3, 3).T + row["translation"]).T
    return np.stack([fx * x / z + cx, fy * y / z + cy], 1), z


def _hit(shape: Mapping[str, Any], eye: np.ndarray, ray: np.ndarray) -> np.ndarray:
    """Distance [m] to a shape at the origin, along rays (n, 3) from an eye in its frame; `FAR` if they pass it."""
    if shape["kind"] == "sphere":
        half, rest = ray @ eye, eye @ eye - shape["radius"] ** 2
        under = half**2 - rest
        return np.where(under > 0, -half - np.sqrt(np.maximum(under, 0)), FAR)
    with np.errstate(divide="ignore", invalid="ignore"):
        if shape["kind"] == "box":
            sides = (np.array([[-0.5], [0.5]]) * shape["size"] - eye)[:, None] / ray
            first, last = sides.min(axis=0).max(axis=1), sides.max(axis=0).min(axis=1)
        else:
            a, b = (ray[:, :2] ** 2).sum(axis=1), ray[:, :2] @ eye[:2]
            root = np.sqrt(b**2 - a * (eye[:2] @ eye[:2] - shape["radius"] ** 2))
            ends = (np.array([[-0.5], [0.5]]) * shape["height"] - eye[2]) / ray[:, 2]
            first = np.maximum((-b - root) / a, ends.min(axis=0))
            last = np.minimum((-b + root) / a, ends.max(axis=0))
    return np.where(first < last, first, FAR)


def _inner(mask: np.ndarray) -> np.ndarray:
    """Pixels of a mask of which all eight neighbours belong to it."""
    wide = np.pad(mask, 1)
    tall, broad = mask.shape
    return np.logical_and.reduce([wide[i : i + tall, j : j + broad] for i in range(3) for j in range(3)])


def _around(mask: np.ndarray) -> list[int]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return [columns[0], rows[0], columns[-1] + 1, rows[-1] + 1]


if __name__ == "__main__":
    main()
