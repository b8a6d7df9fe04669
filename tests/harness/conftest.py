"""Recordings made by hand, in the format of `text2sim/templates/recorder.py`."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.harness.soft_shapes import SOFT
from text2sim.evidence.measures import Series, evaluate
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.spec_schema.models.case import Case

ORIGIN = (0.0, 0.0, 0.0)
IDENTITY = (1.0, 0.0, 0.0, 0.0)


class WrittenRun:
    """A run folder under construction: bodies move as functions of time say, and touch when told to."""

    def __init__(self, folder: Path, duration: float = 1.0, dt: float = 0.01, every: int = 1) -> None:
        self.folder, self.dt, self.every = folder, dt, every
        self.step = np.arange(0, round(duration / dt) + 1, every)
        self.time = self.step * dt
        self.duration = duration
        self.links: list[dict[str, Any]] = []
        self.joints: list[dict[str, Any]] = []
        self.columns: list[dict[str, Any]] = []
        self.dofs: list[tuple[Any, Any, Any]] = []
        self.contacts: list[tuple[Any, ...]] = []
        self.parts: list[tuple[int, str]] = []
        self.geometry: dict[str, list[dict[str, Any]]] = {}
        self.soft: list[dict[str, Any]] = []
        self.soft_arrays: list[tuple[np.ndarray, np.ndarray | None, dict[str, Any]]] = []

    def add_link(
        self, body: str, *, link: str | None = None, mass: float = 1.0, fixed: bool = False,
        pos: Any = ORIGIN, quat: Any = IDENTITY, vel: Any = ORIGIN, ang: Any = ORIGIN, com: Any = ORIGIN,
        inertia: Any = None,
    ) -> int:  # fmt: skip
        """Add a link; motions are arrays over all frames, or constant. Return its index."""
        index = len(self.links)
        tensor = np.eye(3) * 0.1 if inertia is None else np.asarray(inertia)
        self.links.append(
            {
                "body": body,
                "link": link or f"{body}_baselink",
                "mass": mass,
                "com": list(com),
                "inertia": tensor.tolist(),
                "fixed": fixed,
            }
        )
        self.columns.append({"links_pos": pos, "links_quat": quat, "links_vel": vel, "links_ang": ang})
        return index

    def add_joint(
        self,
        body: str,
        joint: str,
        kind: str,
        q: Any = 0.0,
        dq: Any = 0.0,
        force: Any = 0.0,
        limits: Any = (None, None),
        link: int = 0,
    ) -> None:
        """Add a hinge or slider that carries a link."""
        n = len(self.dofs)
        self.joints.append(
            {
                "body": body,
                "joint": joint,
                "kind": kind,
                "link": link,
                "q": [n, n + 1],
                "dofs": [n, n + 1],
                "limits": [list(limits)],
            }
        )
        self.dofs.append((q, dq, force))

    def add_ball(self, body: str, joint: str, quat: Any, link: int = 0) -> None:
        """Add a ball joint; its orientation is an array over all frames (F, 4). It has a row of `dofs` too many."""
        n = len(self.dofs)
        row = {"body": body, "joint": joint, "kind": "ball", "link": link, "q": [n, n + 4], "dofs": [n, n + 4]}
        self.joints.append(row | {"limits": [[None, None]] * 3})
        self.dofs += [(quat[:, k], 0.0, 0.0) for k in range(4)]

    def touch(
        self,
        a: int,
        b: int,
        steps: Any,
        force_on_b: Any,
        *,
        normal: float | None = None,
        depth: float = 0.001,
        pos: Any = (0, 0, 0),
        parts: tuple[str, str] = ("", ""),
    ) -> None:
        """Let two links (a < b), or named parts of them, touch during steps."""
        size = float(np.linalg.norm(force_on_b)) if normal is None else normal
        self.parts += [row for row in zip((a, b), parts, strict=True) if row[1] and row not in self.parts]
        part = tuple(self.parts.index(row) if row[1] else -1 for row in zip((a, b), parts, strict=True))
        self.contacts += [(int(step), (a, b), tuple(force_on_b), tuple(pos), depth, size, part) for step in steps]

    def add_box(self, link: int, half: Any, pos: Any = ORIGIN, quat: Any = IDENTITY) -> None:
        """Give a link a box."""
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.asarray(half)
        self.add_mesh(link, f"box{link}", corners, pos, quat)

    def add_mesh(self, link: int, name: str, vertices: Any, pos: Any = ORIGIN, quat: Any = IDENTITY) -> None:
        """Give a link a mesh."""
        (self.folder / "geometry").mkdir(parents=True, exist_ok=True)
        np.savez(
            self.folder / "geometry" / f"{name}.npz",
            vertices=np.asarray(vertices, np.float32),
            faces=np.zeros((0, 3), np.int32),
        )
        row = {"mesh": f"{name}.npz", "pos": list(pos), "quat": list(quat), "color": [1, 1, 1, 1]}
        self.geometry.setdefault(str(link), []).append(row)

    def add_soft(
        self, body: str, points: Any, *, kind: str = "soft", solver: str = "mpm", spacing: float = 0.1,
        mass: float = 1.0, surface: Any = None, pos: Any = ORIGIN, quat: Any = IDENTITY, domain: Any = None,
        vel: Any = ORIGIN, spin: Any = ORIGIN, kinetic: Any = 0.0, speed: Any = 0.0, **geometry: Any,
    ) -> None:  # fmt: skip
        """Add a body that deforms; `points` and `surface` are arrays over all frames (F, n, 3), or constant (n, 3)."""
        frames = len(self.time)
        points, seen = (
            None if x is None else np.broadcast_to(np.asarray(x, float), (frames, *np.shape(x)[-2:]))
            for x in (points, surface)
        )
        assert points is not None
        done = [0, 0]
        for before, drawn, _ in self.soft_arrays:
            done[0] += before.shape[1]
            done[1] += 0 if drawn is None else drawn.shape[1]
        row = {"body": body, "kind": kind, "solver": solver, "points": [done[0], done[0] + points.shape[1]]}
        row["surface"] = None if seen is None else [done[1], done[1] + seen.shape[1]]
        row |= {"spacing": spacing, "mass": mass, "pos": list(pos), "quat": list(quat)}
        self.soft.append(row | ({"domain": domain} if domain is not None else {}))
        arrays = {"rest": points[0], "masses": np.full(points.shape[1], mass / points.shape[1])} | geometry
        (self.folder / "geometry").mkdir(parents=True, exist_ok=True)
        np.savez(self.folder / "geometry" / f"soft_{len(self.soft) - 1}.npz", **arrays)
        motion = {"soft_velocity": np.broadcast_to(vel, (frames, 3))}
        motion["soft_spin"] = np.broadcast_to(spin, (frames, 3))
        motion |= {"soft_kinetic": np.broadcast_to(kinetic, frames), "soft_speed": np.broadcast_to(speed, frames)}
        self.soft_arrays.append((points, seen, motion))

    def write(self, state: str = "finished", chunk: int = 40, upto: int | None = None, **status: Any) -> Path:
        """Write it down; frames from `upto` on are left out."""
        states = self.folder / "states"
        states.mkdir(parents=True, exist_ok=True)
        layout = {"dt": self.dt, "every": self.every, "duration": self.duration, "gravity": [0.0, 0.0, -9.81]}
        if self.soft:
            layout["deformables"] = self.soft
        if self.parts:
            layout["parts"] = self.parts
        (states / "layout.json").write_text(json.dumps(layout | {"links": self.links, "joints": self.joints}))
        if self.geometry:
            (self.folder / "geometry" / "index.json").write_text(json.dumps(self.geometry))
        frames = len(self.time) if upto is None else upto
        arrays = {
            name: self._stack(name, width)
            for name, width in (("links_pos", 3), ("links_quat", 4), ("links_vel", 3), ("links_ang", 3))
        }
        for number, name in enumerate(("qpos", "dofs_velocity", "dofs_control_force")):
            rows = [np.broadcast_to(dof[number], len(self.time)) for dof in self.dofs]
            arrays[name] = np.stack(rows, 1) if rows else np.zeros((len(self.time), 0))
        if self.soft:
            arrays |= self._soft()
        arrays = {name: array.astype(np.float32) for name, array in arrays.items()} | {"time": self.time}
        done = -1
        for number, first in enumerate(range(0, frames, chunk)):
            last = min(first + chunk, frames)
            until = int(self.step[last - 1])
            part = {name: array[first:last] for name, array in arrays.items()}
            np.savez(states / f"chunk_{number:05d}.npz", **(part | self._contacts(done, until)))  # type: ignore[arg-type]
            done = until
        end = float(self.time[frames - 1]) if frames else 0.0
        (self.folder / "status.json").write_text(json.dumps({"state": state, "time": end, **status}))
        return self.folder

    def _stack(self, name: str, width: int) -> np.ndarray:
        columns = [np.broadcast_to(np.asarray(c[name], float), (len(self.time), width)) for c in self.columns]
        return np.stack(columns, axis=1) if columns else np.zeros((len(self.time), 0, width))

    def _soft(self) -> dict[str, np.ndarray]:
        points = [points for points, _, _ in self.soft_arrays]
        seen = [np.zeros((len(self.time), 0, 3)), *(seen for _, seen, _ in self.soft_arrays if seen is not None)]
        motions = [motion for _, _, motion in self.soft_arrays]
        return {
            "soft_points": np.concatenate(points, axis=1),
            "soft_surface": np.concatenate(seen, axis=1),
            **{name: np.stack([motion[name] for motion in motions], axis=1) for name in motions[0]},
        }

    def _contacts(self, after: int, until: int) -> dict[str, np.ndarray]:
        rows = sorted((row for row in self.contacts if after < row[0] <= until), key=lambda row: row[:2])
        shapes = {
            "step": (),
            "links": (2,),
            "force": (3,),
            "pos": (3,),
            "penetration": (),
            "normal_force": (),
            "parts": (2,),
        }
        if not self.parts:  # as recordings of older versions
            del shapes["parts"]
        types = {"step": np.int32, "links": np.int32, "parts": np.int32}
        return {
            f"contact_{name}": np.array([row[i] for row in rows], types.get(name, np.float32)).reshape(-1, *shape)
            for i, (name, shape) in enumerate(shapes.items())
        } | {"contact_count": np.ones(len(rows), np.int32)}


@pytest.fixture
def new_run(tmp_path: Path) -> Callable[..., WrittenRun]:
    """Return a function that begins a recording in a folder of its own."""

    def begin(**options: Any) -> WrittenRun:
        folder = tmp_path / f"run{len(list(tmp_path.glob('run*')))}"
        folder.mkdir()
        return WrittenRun(folder, **options)

    return begin


@pytest.fixture
def make_case() -> Callable[..., Case]:
    """Return a function that makes a case around actions; bodies are unit balls unless they are given."""

    def make(
        bodies: Any = ("ball",),
        duration: float = 1.0,
        scene: Any = None,
        statics: Any = ("floor",),
        **actions: Any,
    ) -> Case:
        ball = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}}
        plane = {"shape": {"kind": "plane"}}
        return Case.model_validate({
            "text2sim": 2, "name": "case", "prompt": "A ball falls.",
            "scene": {"duration": duration, "statics": dict.fromkeys(statics, plane), **(scene or {})},
            "bodies": bodies if isinstance(bodies, dict) else dict.fromkeys(bodies, ball),
            "actions": actions,
        })  # fmt: skip

    return make


@pytest.fixture
def measure(make_case):
    """Return a function that evaluates one measure of a written run."""

    def one(run: Any, bodies=("ball",), statics=("floor",), scene=None, **measure) -> Series:
        case = make_case(bodies=bodies, statics=statics, scene=scene, measures={"m": measure})
        folder = run.write() if hasattr(run, "write") else run
        return evaluate(RecordedCase.load(folder, case))["m"]

    return one


@pytest.fixture
def measure_soft(make_case):
    """Return a function that evaluates one measure of a written run."""

    def one(run, bodies=None, statics=("floor",), **measure) -> Series:
        case = make_case(bodies=bodies or {"jelly": SOFT}, statics=statics, measures={"m": measure})
        folder = run.write() if hasattr(run, "write") else run
        return evaluate(RecordedCase.load(folder, case))["m"]

    return one


@pytest.fixture
def soft_run(new_run):
    """A run of eleven frames with a floor."""
    run = new_run(duration=0.1)
    run.add_link("floor", fixed=True)
    return run
