"""Playback of the recorded states of a run: poses at any time between the first frame and the last."""

import json
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import numpy as np

QUATERNION_AT = {"free": 3, "ball": 0}  # offset of the quaternion in the joint's slice of qpos
# 26 directions; the outermost points of a body along them stand for its extent.
DIRECTIONS = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z], float)
AWAY = np.array([0.0, 0.0, -1e5])
"""Position of removed bodies [m], out of sight of any camera."""
TRACKED = 48
"""Largest number of points of a deformable body that `States.tracks` returns."""


class Boxes(NamedTuple):
    """Bounding boxes, one for each visual mesh of a link and for each deformable body."""

    names: list[str]
    """Names of the copies."""
    link: np.ndarray
    """Index of the link; for a deformable body -1 minus its index, shape (n,)."""
    center: np.ndarray
    """Centre in the link's frame [m], shape (n, 3)."""
    half: np.ndarray
    """Half sizes [m], shape (n, 3)."""
    quat: np.ndarray
    """Orientation in the link's frame, shape (n, 4)."""
    color: np.ndarray
    """Colour, sRGB, 0 to 1, shape (n, 3)."""
    solid: np.ndarray
    """Whether it hides bodies behind it, shape (n,)."""


class States:
    """The recorded states of a run.

    Attributes:
        layout: Content of `layout.json`.
        time: Times of the recorded frames [s], shape (F,).
        soft: States of deformable bodies; None if there are none.
        removed: Time of removal [s] by copy.
    """

    def __init__(self, out: Path):
        self._out = Path(out)
        folder = self._out / "states"
        self.layout = json.loads((folder / "layout.json").read_text())
        chunks = [np.load(path) for path in sorted(folder.glob("chunk_*.npz"))]
        chunks = [chunk for chunk in chunks if "time" in chunk]
        self.time, self._qpos, self._pos, self._quat = (
            np.concatenate([chunk[name] for chunk in chunks]) for name in ("time", "qpos", "links_pos", "links_quat")
        )
        turning = [joint for joint in self.layout["joints"] if joint["kind"] in QUATERNION_AT]
        starts = [joint["q"][0] + QUATERNION_AT[joint["kind"]] for joint in turning]
        self._quaternions = np.array(starts, int)[:, None] + np.arange(4)
        links = [*enumerate(self.layout["links"])]
        self.soft = None
        if self.layout.get("deformables"):
            self.soft = _soft_states(self.layout["deformables"], chunks)
        self.removed = read_removed(folder)
        self._links = {(link["body"], None): i for i, link in reversed(links) if link["link"] != "world"}
        self._links |= {(link["body"], link["link"]): i for i, link in links}
        self._chosen: dict[tuple[str, ...], tuple] = {}

    def position(self, body: str, t: float, link: str | None = None) -> np.ndarray:
        """Position of a link of a body at a time [m], shape (3,).

        Args:
            body: Copy name; a deformable body is represented by the mean of its points.
            t: Time [s].
            link: Name of the link; the first one if None.
        """
        a, b, w = self.around(t)
        if self.soft is not None and (centre := self.soft.centre(body, (a, b, w))) is not None:
            return centre
        pos = self._pos[:, self._links[body, link]].astype(float)
        return (1 - w) * pos[a] + w * pos[b]

    def pose(self, body: str, t: float, link: str | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Position [m], shape (3,), and orientation (w, x, y, z) of a link's authored frame at a time.

        Args:
            body: Copy name, of a body that does not deform.
            t: Time [s].
            link: Name of the link; the first one if None.
        """
        (a, b, w), k = self.around(t), self._links[body, link]
        return self.position(body, t, link), slerp(self._quat[a, k].astype(float), self._quat[b, k].astype(float), w)

    def qpos(self, t: float) -> np.ndarray:
        """Generalized positions at time `t` [s], shape (Q,): interpolated linearly, quaternions by `slerp`."""
        i, j, w = self.around(t)
        a, b = self._qpos[i].astype(float), self._qpos[j].astype(float)
        qpos = (1 - w) * a + w * b
        qpos[self._quaternions] = slerp(a[self._quaternions], b[self._quaternions], w)
        return qpos.astype(np.float32)

    def gone(self, t: float) -> np.ndarray:
        """Whether the body of each link has been removed by time `t` [s], shape (L,)."""
        left = {body for body, when in self.removed.items() if t > when + 1e-9}
        return np.array([link["body"] in left for link in self.layout["links"]], bool)

    def poses(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m], shape (L, 3), and orientations, shape (L, 4), of all links' authored frames at time `t` [s].

        Removed bodies are at `AWAY`.
        """
        pos, quat = self._recorded(t)
        if self.removed:
            pos[self.gone(t)] = AWAY
        return pos, quat

    def _recorded(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        i, j, w = self.around(t)
        pos = (1 - w) * self._pos[i].astype(float) + w * self._pos[j]
        return pos, slerp(self._quat[i].astype(float), self._quat[j].astype(float), w)

    def spring_ends(self, t: float) -> np.ndarray:
        """Ends of all springs at a time [m], shape (n, 2, 3), as in the layout; nan once a body is removed."""
        rows = self.layout.get("springs", [])
        if not rows:
            return np.zeros((0, 2, 3))
        pos, quat = (np.asarray(values, dtype=float) for values in self.poses(t))
        links, points = np.array([row["links"] for row in rows]), np.array([row["points"] for row in rows], dtype=float)
        ends = pos[links] + _turned(quat[links], points)
        ends[self.gone(t)[links].any(axis=1)] = np.nan
        return ends

    def bounds(self, bodies: list[str], t: float) -> np.ndarray:
        """Outermost points of the visible surfaces of bodies [m], shape (n, 3).

        Args:
            bodies: Names such as `ball`, `brick` for all its copies, `brick[3]`, `arm.hand` for a link, `net.x5_*` for
                several, or `cart.hook` for a part of a compound that others touch.
            t: Simulated time [s].
        """
        links, local, soft = self._named(bodies)
        pos, quat = self._recorded(t)
        found = [pos[links] + _turned(quat[links], local)]
        found += [outermost(self._soft_points(row, t)) for row in soft]
        return np.concatenate(found)

    def extremes(self, bodies: list[str], times: np.ndarray) -> np.ndarray:
        """Those of the recorded times [s], shape (n,), at which links of bodies (see `bounds`) are outermost."""
        links, local, _ = self._named(bodies)
        own, row = np.unique(links, return_inverse=True)
        if not len(own):
            return times[:0]
        middle = np.stack([np.bincount(row, local[:, k]) for k in range(3)], axis=1) / np.bincount(row)[:, None]
        frames = np.searchsorted(self.time, times)
        way = self._pos[frames][:, own] + _turned(self._quat[frames][:, own], middle)
        far = [np.nan_to_num(way @ direction, nan=-np.inf).max(axis=1).argmax() for direction in DIRECTIONS]
        return times[np.unique(far)]

    def tracks(self, bodies: list[str], t: float) -> np.ndarray:
        """Points that are fixed to bodies, at time `t` [s], shape (n, 3) [m]; differences over time give the motion."""
        links, local, soft = self._named(bodies)
        pos, quat = self._recorded(t)
        some = (self._soft_points(row, t) for row in soft)
        return np.concatenate([pos[links] + _turned(quat[links], local), *(p[:: -(-len(p) // TRACKED)] for p in some)])

    def boxes(self, bodies: list[str]) -> Boxes:
        """Bounding boxes of bodies, named as in `bounds`."""
        geometry = self._out / "geometry"
        pieces = _listed(geometry / "index.json")
        names, rows, ends = [], [], {}
        for i, link in enumerate(self.layout["links"]):
            if any(_means(name, link["body"], link["link"]) for name in bodies):
                for row in pieces.get(str(i), ()):
                    if row["mesh"] not in ends:
                        with np.load(geometry / row["mesh"]) as mesh:
                            ends[row["mesh"]] = mesh["vertices"].min(axis=0), mesh["vertices"].max(axis=0)
                    low, high = ends[row["mesh"]]
                    quat = np.asarray(row["quat"], float)
                    center = np.asarray(row["pos"]) + _turned(quat, (low + high) / 2)
                    names.append(link["body"])
                    rows.append([i, *center, *(high - low) / 2, *quat, *row["color"][:3], row["color"][3] >= 0.5])
        path = geometry / "soft_index.json"
        painted = {row["body"]: row["color"] for row in json.loads(path.read_text())} if path.is_file() else {}
        for k, row in enumerate(self.layout.get("deformables") or ()):
            if any(_means(name, row["body"]) for name in bodies):
                names.append(row["body"])
                color = painted.get(row["body"], (0.5, 0.5, 0.5))[:3]
                rows.append([-1 - k, *(0.0,) * 6, 1.0, 0.0, 0.0, 0.0, *color, row["kind"] != "cloth"])
        found = np.array(rows, float).reshape(-1, 15)
        columns = np.split(found, (1, 4, 7, 11, 14), axis=1)
        return Boxes(names, columns[0][:, 0].astype(int), *columns[1:5], columns[5][:, 0] > 0)

    def placed(self, boxes: Boxes, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Centres [m], (n, 3), axes as columns, (n, 3, 3), and half sizes [m], (n, 3), of boxes at time `t` [s]."""
        pos, quat = self._recorded(t)
        link, unit = np.maximum(boxes.link, 0), np.eye(3)
        centers = pos[link] + _turned(quat[link], boxes.center) if len(pos) else np.zeros((len(link), 3))
        axes = np.stack([_turned(boxes.quat, np.broadcast_to(axis, boxes.center.shape)) for axis in unit], axis=2)
        if len(pos):
            axes = np.stack([_turned(quat[link], axes[:, :, k]) for k in range(3)], axis=2)
        half = boxes.half.copy()
        for k in np.flatnonzero(boxes.link < 0):
            points = self._soft_points(self.layout["deformables"][-1 - boxes.link[k]], t)
            low, high = points.min(axis=0), points.max(axis=0)
            centers[k], axes[k], half[k] = (low + high) / 2, unit, (high - low) / 2
        return centers, axes, half

    def around(self, t: float) -> tuple[int, int, float]:
        """Recorded frames before and after time `t` [s], and the fraction of the way from one to the other."""
        last = len(self.time) - 1
        b = min(int(np.searchsorted(self.time, t)), last)
        a = max(b - 1, 0)
        return a, b, 1.0 if a == b else float(np.clip((t - self.time[a]) / (self.time[b] - self.time[a]), 0.0, 1.0))

    def _named(self, bodies: list[str]) -> tuple[np.ndarray, np.ndarray, list[dict]]:
        key = tuple(bodies)
        if key not in self._chosen:
            self._chosen[key] = self._choose(bodies)
        return self._chosen[key]

    def _choose(self, bodies: list[str]) -> tuple[np.ndarray, np.ndarray, list[dict]]:
        """Link index and position in the link's frame of each outermost point, and rows of deformable bodies."""
        geometry = self._out / "geometry"
        pieces, solids = (_listed(geometry / name) for name in ("index.json", "solids.json"))
        links, points, outer = [np.zeros(0, int)], [np.zeros((0, 3))], {}
        for i, link in enumerate(self.layout["links"]):
            named = [name for name in bodies if _means(name, link["body"], link["link"])]
            parts = [row for row in solids.get(str(i), ()) if row.get("part")]
            dotted = [name for name in bodies if "." in name]
            rows = [row for row in parts if any(_means(name, link["body"], row["part"]) for name in dotted)]
            if {*named} - {*dotted} or (named and not rows):
                rows = pieces.get(str(i), ())
            for row in rows:
                if "mesh" not in row:
                    local = _primitive(row["kind"], row["size"])
                else:
                    if row["mesh"] not in outer:
                        with np.load(geometry / row["mesh"]) as mesh:
                            outer[row["mesh"]] = outermost(mesh["vertices"].astype(float))
                    local = outer[row["mesh"]]
                points.append(np.asarray(row["pos"]) + _turned(np.asarray(row["quat"], float), local))
                links.append(np.full(len(points[-1]), i))
        soft = [row for row in self.layout.get("deformables") or () if any(_means(n, row["body"]) for n in bodies)]
        return np.concatenate(links), np.concatenate(points), soft

    def _soft_points(self, row: dict, t: float) -> np.ndarray:
        name = "soft_points" if row["surface"] is None else "soft_surface"
        first, last = row["points"] if row["surface"] is None else row["surface"]
        return self.soft.at(name, self.around(t))[first:last].astype(float)


def read_removed(states: Path) -> dict[str, float]:
    """Time of removal [s] by copy; `states` is the folder of the recorded states."""
    try:
        rows = json.loads((states / "removed.json").read_text("utf-8"))
        return {str(body): float(when) for body, when in rows.items()}
    except (OSError, ValueError, TypeError, AttributeError, RecursionError):
        return {}


def outermost(points: np.ndarray) -> np.ndarray:
    """Return the points that are outermost along 26 directions, shape (n, 3)."""
    return points[np.unique((points @ DIRECTIONS.T).argmax(axis=0))] if len(points) else points


def slerp(a: np.ndarray, b: np.ndarray, w: float) -> np.ndarray:
    """Spherical linear interpolation between orientations along the shorter arc, shape (..., 4).

    Args:
        a: Unit quaternions (w, x, y, z), shape (..., 4).
        b: The same.
        w: Fraction of the way from `a` to `b`.
    """
    cosine = (a * b).sum(axis=-1, keepdims=True)
    angle = np.arccos(np.abs(cosine).clip(0.0, 1.0))
    near = angle < 1e-4
    sine = np.where(near, 1.0, np.sin(angle))
    wa = np.where(near, 1 - w, np.sin((1 - w) * angle) / sine)
    wb = np.where(near, w, np.sin(w * angle) / sine)
    quat = wa * a + np.where(cosine < 0, -wb, wb) * b
    return quat / np.linalg.norm(quat, axis=-1, keepdims=True)


def _listed(path: Path) -> dict:
    return json.loads(path.read_text()) if path.is_file() else {}


def _primitive(kind: str, size: list[float]) -> np.ndarray:
    """Points on a solid as in `solids.json`, in its frame [m], shape (n, 3)."""
    if kind == "box":
        return DIRECTIONS * size / 2
    if kind == "cylinder":
        around = DIRECTIONS[np.abs(DIRECTIONS[:, :2]).any(axis=1)]
        around[:, :2] *= size[0] / np.linalg.norm(around[:, :2], axis=1, keepdims=True)
        return around * (1, 1, size[1] / 2)
    ball = size[0] * DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
    return ball + np.sign(DIRECTIONS) * (0, 0, size[1] / 2) if kind == "capsule" else ball


def _means(name: str, body: str, link: str | None = None) -> bool:
    """Whether a name, as in `States.bounds`, stands for this copy, or for this link or part of it."""
    wanted, dot, part = name.partition(".")
    if body != wanted and not body.startswith(f"{wanted}["):
        return False
    return not dot or part == link or ("*" in part and link not in (None, "world") and fnmatchcase(link, part))


def _turned(quat: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Vectors, shape (..., 3), rotated by unit quaternions, shape (..., 4)."""
    twist = 2.0 * np.cross(quat[..., 1:], vector)
    return vector + quat[..., :1] * twist + np.cross(quat[..., 1:], twist)


def _soft_states(rows: list[dict], chunks: list):
    if __package__:
        from .soft_states import SoftStates  # noqa: TID252
    else:
        from soft_states import SoftStates
    return SoftStates(rows, chunks)
