"""Compiles tiny cases with our compiler, runs the programs that it writes, and reads the states that they record."""

import json
import re
import select
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.compiler.build import compile_case
from text2sim.spec_schema.load import load_case

PATIENCE = 1800.0
"""Longest wait [s] for one case: a bare machine compiles the engine's kernels on the way."""
Array = np.ndarray[Any, np.dtype[np.float64]]


class RunFailed(RuntimeError):
    """A program died, or raised; the text is what it said."""


@dataclass(frozen=True)
class Run:
    """What one run recorded. Arrays over frames are float64."""

    folder: Path
    cpu: float = 0.0
    """Processor seconds of the simulation, without building the scene."""

    @cached_property
    def layout(self) -> dict[str, Any]:
        """What the columns of the states mean."""
        return json.loads((self.folder / "states" / "layout.json").read_text())

    @cached_property
    def arrays(self) -> dict[str, Array]:
        """All chunks, frame after frame; contacts are left out."""
        chunks = [np.load(path) for path in sorted((self.folder / "states").glob("chunk_*.npz"))]
        chunks = [chunk for chunk in chunks if "time" in chunk]
        names = [name for name in chunks[0] if not name.startswith("contact_")]
        return {name: np.concatenate([chunk[name] for chunk in chunks]).astype(float) for name in names}

    @property
    def time(self) -> Array:
        """Times of the frames [s], shape (F,)."""
        return self.arrays["time"]

    def row(self, body: str) -> tuple[int, dict[str, Any]] | None:
        """Index and entry of a body that deforms; None for one of links."""
        rows = self.layout.get("deformables", [])
        return next(((k, row) for k, row in enumerate(rows) if row["body"] == body), None)

    def points(self, body: str) -> Array:
        """Points [m] of a body that deforms, shape (F, n, 3)."""
        found = self.row(body)
        assert found is not None, f"{body} does not deform"
        start, end = found[1]["points"]
        return self.arrays["soft_points"][:, start:end]

    def rest(self, body: str) -> dict[str, Array]:
        """Arrays of a body that deforms which do not change: `rest`, `masses`, `tets`, `faces`."""
        found = self.row(body)
        assert found is not None, f"{body} does not deform"
        with np.load(self.folder / "geometry" / f"soft_{found[0]}.npz") as file:
            return {name: file[name] for name in file.files}

    def links(self, body: str) -> list[int]:
        """Columns of the links of a body."""
        return [k for k, link in enumerate(self.layout["links"]) if link["body"] == body]

    def mass(self, body: str) -> float:
        """Mass [kg]."""
        found = self.row(body)
        if found is not None:
            return float(found[1]["mass"])
        return sum(self.layout["links"][k]["mass"] for k in self.links(body) if not self.layout["links"][k]["fixed"])

    def velocity(self, body: str) -> Array:
        """Velocity of the centre of mass [m/s], shape (F, 3)."""
        found = self.row(body)
        if found is not None:
            return self.arrays["soft_velocity"][:, found[0]]
        links = self.links(body)
        masses = np.array([self.layout["links"][k]["mass"] for k in links])
        return np.einsum("l,flk->fk", masses / masses.sum(), self.arrays["links_vel"][:, links])

    def center(self, body: str) -> Array:
        """Centre of mass of a body that deforms, mean origin of the links of another [m], shape (F, 3)."""
        if self.row(body) is not None:
            masses = self.rest(body)["masses"]
            return np.einsum("p,fpk->fk", masses / masses.sum(), self.points(body))
        return self.arrays["links_pos"][:, self.links(body)].mean(axis=1)

    def momentum(self, body: str) -> Array:
        """Momentum [kg m/s], shape (F, 3)."""
        return self.mass(body) * self.velocity(body)

    def joint(self, body: str) -> tuple[Array, Array]:
        """Position and actuator force of the hinge or slider of a body, each (F,)."""
        joint = next(j for j in self.layout["joints"] if j["body"] == body and j["kind"] in ("hinge", "slider"))
        return self.arrays["qpos"][:, joint["q"][0]], self.arrays["dofs_control_force"][:, joint["dofs"][0]]


class Lab:
    """Runs cases, in a process of its own for each precision; a crash costs one case."""

    def __init__(self, keep: Path | None = None) -> None:
        self._folder = keep or Path(tempfile.mkdtemp(prefix="softlab_"))
        self._keep, self._count = keep is not None, 0
        self._workers: dict[str, subprocess.Popen[str]] = {}

    def __enter__(self) -> "Lab":
        return self

    def __exit__(self, *problem: object) -> None:
        for worker in list(self._workers):
            self._end(worker)
        if not self._keep:
            shutil.rmtree(self._folder, ignore_errors=True)

    def run(self, text: str, name: str = "trial", files: Mapping[str, str] | None = None, **params: Any) -> Run:
        """Simulate a case.

        Args:
            text: The case below `name`.
            name: For the folder.
            files: Contents of files that the case names.
            params: Values for the names that the text uses in `${...}`.

        Raises:
            RunFailed: if the program does not get to its end.
        """
        self._count += 1
        folder = self._folder / f"{self._count:03d}_{name}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        head = {"text2sim": 1, "name": "trial", "params": params}
        lines = [f"{key}: {json.dumps(value)}" for key, value in head.items()]
        for file, content in (files or {}).items():
            (folder / file).write_text(content)
        (folder / "case.yaml").write_text("\n".join(lines) + "\n" + text)
        compile_case(load_case(folder), folder / "program")
        found = re.search(r'precision="(\d+)"', (folder / "program" / "scene.py").read_text())
        order = {"program": str(folder / "program"), "out": str(folder)}
        return Run(folder, self._serve(found.group(1) if found else "32", order))

    def _serve(self, precision: str, order: dict[str, str]) -> float:
        if precision not in self._workers:
            self._workers[precision] = subprocess.Popen(
                [sys.executable, str(Path(__file__).with_name("worker.py"))],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                stderr=(self._folder / f"worker_{precision}.log").open("a"),
            )  # fmt: skip
        worker = self._workers[precision]
        assert worker.stdin is not None
        assert worker.stdout is not None
        worker.stdin.write(json.dumps(order) + "\n")
        worker.stdin.flush()
        ready, _, _ = select.select([worker.stdout], [], [], PATIENCE)
        answer = worker.stdout.readline() if ready else ""
        if not answer:
            worker.kill()
            self._end(precision)
            said = (self._folder / f"worker_{precision}.log").read_text()[-2000:]
            raise RunFailed(f"the engine {'died' if ready else 'did not answer'}:\n{said}")
        result = json.loads(answer)
        if result["error"]:
            raise RunFailed(result["error"])
        return result["cpu"]

    def _end(self, precision: str) -> None:
        worker = self._workers.pop(precision)
        if worker.stdin is not None:
            worker.stdin.close()
        try:
            worker.wait(60)
        except subprocess.TimeoutExpired:
            worker.kill()
            worker.wait()
