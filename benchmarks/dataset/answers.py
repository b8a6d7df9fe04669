"""Answers to a dataset's questions worked out anew from its states, without any code of text2sim.

    python benchmarks/dataset/answers.py DATASET

Balls, boxes and planes of which the case says the size are put where the states say they are. They touch where there is
no gap between them. Masses are densities times volumes. Nothing of the recorded contacts, and nothing of the evidence
of a question, is used. Questions about other shapes, and about gaps that may have closed between two recorded frames,
are left out and counted.
"""

import io
import json
import re
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import webdataset
import yaml
from recompute import number_of, shapes_of
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation

CLOSE = 0.0005
"""Gap [m] at which things touch."""
EARLY = 0.05
"""What touches up to this time [s] touches from the start."""
SIGNS = np.array(list(np.ndindex(2, 2, 2))) - 0.5
UNKNOWN = None


class Scene:
    """Where the bodies of an item are.

    Args:
        sample: Files of the item, as bytes.
        rows: Those of its pictures.
    """

    def __init__(self, sample: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> None:
        self.case = yaml.safe_load(sample["case.yaml"])
        self.pictures = np.array([row["time"] for row in sorted(rows, key=lambda row: row["frame"])])
        with np.load(io.BytesIO(sample["states.npz"])) as arrays:
            self.time, self._pos, self._quat = (arrays[name].astype(float) for name in ("time", "pos", "quat"))
        links = json.loads(sample["layout.json"])["links"]
        self._links: dict[str, list[int]] = {}
        for k, link in enumerate(links):
            if link["link"] != "world":
                self._links.setdefault(link["body"], []).append(k)
        bodies = self.case["bodies"] | self.case["scene"].get("statics", {})
        self._shapes = shapes_of(
            {**self.case, "bodies": {name: {"kind": "rigid", **body} for name, body in bodies.items()}}
        )
        self._shapes |= {
            n: {"kind": "plane"} for n, body in bodies.items() if (body.get("shape") or {}).get("kind") == "plane"
        }
        self.names = {name.replace("_", " "): name for name in bodies}

    def copies(self, body: str) -> list[str]:
        """Names of a body's copies."""
        return [name for name in self._links if name.partition("[")[0] == body]

    def gap(self, one: str, other: str) -> np.ndarray | None:
        """Gap (frames,) [m] between two copies, or less than it between boxes; None for shapes that are not known."""
        a, b = (self._shapes.get(name.partition("[")[0]) for name in (one, other))
        if a is None or b is None or any(len(self._links[name]) != 1 for name in (one, other)):
            return None
        i, j = (self._links[name][0] for name in (one, other))
        if (b["kind"], a["kind"]) < (a["kind"], b["kind"]):  # box, plane, sphere
            a, b, i, j = b, a, j, i
        there, near = self._pos[:, j] - self._pos[:, i], Rotation.from_quat(self._quat[:, i], scalar_first=True)
        kinds = a["kind"], b["kind"]
        if kinds == ("sphere", "sphere"):
            return np.linalg.norm(there, axis=1) - a["radius"] - b["radius"]
        if kinds == ("plane", "sphere"):
            return near.inv().apply(there)[:, 2] - b["radius"]
        if kinds == ("box", "sphere"):
            local, half = near.inv().apply(there), np.array(a["size"]) / 2
            return np.linalg.norm(local - local.clip(-half, half), axis=1) - b["radius"]
        if kinds == ("box", "plane"):
            plane = Rotation.from_quat(self._quat[:, j], scalar_first=True).inv()
            corners = [plane.apply(near.apply(sign * a["size"]) - there)[:, 2] for sign in SIGNS]
            return np.min(corners, axis=0)
        if kinds == ("box", "box"):
            return _between_boxes(there, near, Rotation.from_quat(self._quat[:, j], scalar_first=True), a, b)
        return None

    def first_touch(self, one: str, other: str) -> float | None:
        """Time [s] at which two bodies first touch: infinite if never; None if that is not known."""
        found = [np.inf]
        for a in self.copies(one):
            for b in self.copies(other):
                gap = self.gap(a, b)
                if gap is None:
                    return UNKNOWN
                touching = np.flatnonzero(gap < CLOSE)
                if not len(touching) and (gap + np.diff(gap, prepend=gap[0]) < CLOSE).any():
                    return UNKNOWN  # it may have touched and bounced before the next frame
                found += [float(self.time[touching[0]])] if len(touching) else []
        return min(found)

    def way(self, name: str) -> np.ndarray:
        """How far (frames,) a copy is from where it began [m]."""
        path = self._pos[:, self._links[name][0]]
        return np.linalg.norm(path - path[0], axis=1)

    def tilt(self, name: str) -> float:
        """Angle [deg] between the axis that pointed upwards, at the last picture, and the vertical."""
        turns = Rotation.from_quat(self._quat[:, self._links[name][0]], scalar_first=True)
        up = turns[self.last].apply(turns[0].inv().apply([0, 0, 1]))
        return float(np.degrees(np.arccos(np.clip(up[2], -1, 1))))

    def size(self) -> float:
        """Extent of what is loose at the start, or the longest way if that is more [m]."""
        loose = [n for n in self._links if n.partition("[")[0] in self.case["bodies"] and self.way(n).max() > 0]
        starts = np.array([self._pos[0, self._links[name][0]] for name in loose])
        return max(float(np.ptp(starts, axis=0).max()), *(float(self.way(name).max()) for name in loose))

    @property
    def last(self) -> int:
        """Recorded frame of the last picture."""
        return min(int(np.searchsorted(self.time, self.pictures.max() - 1e-9)), len(self.time) - 1)

    def mass(self, body: str) -> float | None:
        """Density times volume [kg]."""
        shape = self._shapes.get(body)
        density = number_of(
            (self.case["bodies"][body].get("material") or {}).get("density"), self.case.get("params") or {}
        )
        if shape is None or density is None or shape["kind"] not in ("box", "sphere"):
            return None
        return density * (np.prod(shape["size"]) if shape["kind"] == "box" else 4 / 3 * np.pi * shape["radius"] ** 3)


def main() -> None:
    """Go through all questions, and print how many answers come out the same."""
    folder = Path(sys.argv[1])
    asked: dict[str, list[dict[str, Any]]] = {}
    for row in pq.read_table(folder / "questions").to_pylist():
        asked.setdefault(row["key"], []).append(row)
    # The items whose runs answer what would happen.
    pairs = {row["counterfactual_of"]: row["key"] for row in pq.read_table(folder / "items").to_pylist()}
    frames: dict[str, list[dict[str, Any]]] = {}
    for row in pq.read_table(folder / "frames", columns=["key", "frame", "time"]).to_pylist():
        frames.setdefault(row["key"], []).append(row)
    scenes = {}
    for path in sorted((folder / "shards").glob("*.tar")):
        for sample in webdataset.WebDataset(str(path), shardshuffle=False):
            key = sample["__key__"]
            if key in asked or key in pairs.values():
                scenes[key] = Scene(sample, frames[key])
    counts: dict[str, Counter[str]] = {}
    wrong = []
    for key, rows in asked.items():
        for row in rows:
            base = key.removesuffix(match[0]) if (match := re.search(r"-film\d+$", key)) else key
            answer = answered(row, scenes[key], scenes.get(pairs.get(base, "")))
            given = row["choices"][row["answer"]]
            what = "not known" if answer is UNKNOWN else "same" if answer == given else "other"
            counts.setdefault(row["kind"], Counter())[what] += 1
            if what == "other":
                wrong.append(f"{key}: {row['question']} {given}, and not {answer}? {row['evidence']}")
    table = Table("kind", "same", "other", "not known")
    for kind, found in sorted(counts.items()):
        table.add_row(kind, *(str(found[what]) for what in ("same", "other", "not known")))
    console = Console()
    console.print(table)
    for words in wrong:
        console.print(words, markup=False)


def answered(row: Mapping[str, Any], scene: Scene, other: Scene | None) -> str | None:
    """Return the answer to a question.

    Args:
        row: The question.
        scene: What it is about.
        other: The run with another cause.
    """
    kind, question = row["kind"], row["question"]
    bodies = [scene.names[name] for name in re.findall("“(.*?)”", question) if name in scene.names]
    numbers = [int(number) for number in re.findall(r"\d+", re.sub("“.*?”", "", question))]
    if kind in ("touch_by", "will_touch"):
        first = scene.first_touch(*bodies)
        if first is UNKNOWN:
            return UNKNOWN
        until = scene.pictures[numbers[0]] if kind == "touch_by" else scene.time[-1]
        return "yes" if first <= until else "no"
    if kind == "touches_first":
        found = {name: scene.first_touch(bodies[0], name) for name in scene.names.values() if name != bodies[0]}
        if UNKNOWN in found.values():
            return UNKNOWN
        later = {name: t for name, t in found.items() if t is not None and t > EARLY}
        return f"“{min(later, key=lambda name: later[name]).replace('_', ' ')}”"
    if kind == "moves_first":
        starts = {}
        for body in bodies:
            way = np.max([scene.way(copy) for copy in scene.copies(body)], axis=0)
            starts[body] = int(np.argmax(way > 0.05 * scene.size()))
        return f"“{min(starts, key=lambda body: starts[body]).replace('_', ' ')}”"
    if kind == "how_many":
        copies = scene.copies(bodies[0])
        if "fallen" in question:
            return str(sum(scene.tilt(name) > 45 for name in copies))
        return str(sum(scene.way(name)[scene.last] > 0.05 * scene.size() for name in copies))
    if kind == "heavier":
        masses = {body: scene.mass(body) for body in bodies}
        if UNKNOWN in masses.values():
            return UNKNOWN
        return f"“{max(masses, key=lambda body: masses[body] or 0.0).replace('_', ' ')}”"
    if kind == "what_if" and other is not None and "touch" in question:
        first = other.first_touch(*bodies[-2:])
        return UNKNOWN if first is UNKNOWN else "yes" if first < np.inf else "no"
    return UNKNOWN


def _between_boxes(
    there: np.ndarray, near: Rotation, far: Rotation, a: Mapping[str, Any], b: Mapping[str, Any]
) -> np.ndarray:
    """Widest gap (frames,) [m] along the 15 axes that can separate two boxes; negative where none does."""
    sides = [turn.as_matrix().transpose(0, 2, 1) for turn in (near, far)]
    axes = [*sides[0].transpose(1, 0, 2), *sides[1].transpose(1, 0, 2)]
    axes += [np.cross(sides[0][:, i], sides[1][:, j]) for i in range(3) for j in range(3)]
    gaps = []
    for axis in axes:
        length = np.linalg.norm(axis, axis=1)
        reach = sum(
            (np.abs(np.einsum("fij,fj->fi", side, axis)) * np.array(box["size"]) / 2).sum(axis=1)
            for side, box in zip(sides, (a, b), strict=True)
        )
        gap = np.abs(np.einsum("fi,fi->f", there, axis)) - reach
        gaps.append(np.where(length > 1e-6, gap / np.maximum(length, 1e-6), -np.inf))
    return np.max(gaps, axis=0)


if __name__ == "__main__":
    main()
