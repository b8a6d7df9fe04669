"""Collision shapes of the links of a recording, as solids.

`geometry/solids.json` holds the engine's collision shapes: for each link a list of {kind, pos, quat, size | mesh}.
For recordings without it, the visual shapes are used.
"""

import json
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.evidence.solids import LinkSolid, solid_of_mesh
from text2sim.recording.chunks import DAMAGED, read_arrays
from text2sim.recording.geometry import MESH_FILE
from text2sim.recording.states import Array, RunStates
from text2sim.recording.vectors import rotate
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.names.selectors import body_of

_SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2, "plane": 0}
"""How many numbers give the size of a solid, by kind."""


class RigidShapes:
    """Solids by link."""

    def __init__(self, run_dir: Path, states: RunStates, case: Case) -> None:
        self._folder, self._states, self._case = run_dir / "geometry", states, case
        index = _index(self._folder / "solids.json")
        self._index = _index(self._folder / "index.json") or {} if index is None else index
        self.of = cache(self._solids)
        """The solids of a link, in its frame."""
        self._mesh = cache(self._read_mesh)

    def of_links(self, links: Iterable[int]) -> list[tuple[int, LinkSolid]]:
        """Return the solids of links, each with its link."""
        return [(int(link), solid) for link in links for solid in self.of(int(link))]

    def _solids(self, link: int) -> list[LinkSolid]:
        static = self._case.scene.statics.get(body_of(self._states.links[link].body))
        if static is not None and static.shape.kind == "plane":
            return [LinkSolid("plane", np.zeros(3), np.eye(3))]
        found = [self._solid(row) for row in self._index.get(str(link), ()) if isinstance(row, dict)]
        return [solid for solid in found if solid is not None]

    def _solid(self, row: dict[str, Any]) -> LinkSolid | None:
        try:
            pos = np.array([float(x) for x in row.get("pos", (0, 0, 0))])
            quat = np.array([float(x) for x in row.get("quat", (1, 0, 0, 0))])
            size = tuple(float(x) for x in row.get("size", ()))
            kind, part = str(row.get("kind", "hull")), str(row.get("part", ""))
        except (TypeError, ValueError):
            return None
        turn = rotate(quat, np.eye(3)).T if quat.shape == (4,) else np.zeros(0)
        if pos.shape != (3,) or turn.shape != (3, 3) or not np.isfinite([*pos, *turn.ravel(), *size]).all():
            return None
        if kind in _SIZES:
            fits = len(size) == _SIZES[kind] and all(x > 0 for x in size)
            return LinkSolid(kind, pos, turn, size, part=part) if fits else None
        solid = self._mesh(str(row.get("mesh")))
        return None if solid is None else replace(solid, pos=pos, turn=turn, part=part)

    def _read_mesh(self, name: str) -> LinkSolid | None:
        if not MESH_FILE.match(name):  # the name becomes a path
            return None
        try:
            arrays = read_arrays(self._folder / name, ("vertices", "faces"))
            vertices = np.asarray(arrays["vertices"], float).reshape(-1, 3)
            faces = np.asarray(arrays.get("faces", np.zeros((0, 3))), np.int64).reshape(-1, 3)
        except DAMAGED:
            return None
        return solid_of_mesh(vertices, faces)


def _index(path: Path) -> dict[str, list[Any]] | None:
    try:
        data = json.loads(path.read_text("utf-8"))
        return {str(link): list(rows) for link, rows in data.items()}
    except (OSError, ValueError, TypeError, AttributeError, RecursionError):
        return None


def world_frames(states: RunStates, link: int, solid: LinkSolid, step: int = 1) -> tuple[Array, Array]:
    """Return positions [m] (F, 3) and rotation matrices (F, 3, 3) of a solid's frame in the world, every `step` frames.

    Positions are nan after its body has left the scene.

    Args:
        states: The recorded states.
        link: Number of the link.
        solid: A solid of the link.
        step: Frames from one that is taken to the next.
    """
    quat = states.quat[::step, link].astype(float)
    turn = rotate(quat[:, None], np.eye(3)[None]).swapaxes(1, 2)
    pos = states.pos[::step, link] + turn @ solid.pos
    return np.where(states.gone(states.links[link].body)[::step, None], np.nan, pos), turn @ solid.turn
