"""Recorded states, read while they are still being written."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.watching.painter.rotation import slerp


class LiveStates:
    """The states of a run folder as far as they have come.

    Attributes:
        time: Times of the frames [s], shape (F,).
        complete: Whether nothing more will come.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._layout: dict[str, Any] | None = None
        self._links: dict[tuple[str, str | None], int] = {}
        self._chunks = 0
        self._before = 0
        """Frames of the chunks before the one that is read."""
        self.time = np.zeros(0)
        self._pos = np.zeros((0, 0, 3))
        self._quat = np.zeros((0, 0, 4))
        self.complete = False

    def read(self) -> bool:
        """Take in what was written since the last time; return whether there was anything."""
        # In this order: what was written before the status is whole.
        complete = (self._folder / "status.json").is_file()
        if self._layout is None and not self._read_layout():
            self.complete = complete
            return False
        parts = []
        known = len(self.time) - self._before
        while (path := self._chunk(self._chunks)).is_file():
            last = not self._chunk(self._chunks + 1).is_file()  # it may still grow
            with np.load(path, allow_pickle=False) as chunk:
                frames = len(chunk["time"]) if "time" in chunk else 0
                if frames > known:
                    new = [chunk[name][known:].astype(float) for name in ("time", "links_pos", "links_quat")]
                    parts.append(new)
            if last:
                break
            self._chunks, self._before, known = self._chunks + 1, self._before + frames, 0
        if parts:
            before = [(self.time, self._pos, self._quat)] if len(self.time) else []
            columns = zip(*before, *parts, strict=True)
            self.time, self._pos, self._quat = (np.concatenate(column) for column in columns)
        self.complete = complete
        return bool(parts)

    def _chunk(self, number: int) -> Path:
        return self._folder / "states" / f"chunk_{number:05d}.npz"

    def poses(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m], shape (L, 3), and orientations, shape (L, 4), of all links at time `t`."""
        a, b, w = self._around(t)
        if w == 1.0:
            return self._pos[b], self._quat[b]
        return (1 - w) * self._pos[a] + w * self._pos[b], slerp(self._quat[a], self._quat[b], w)

    def position(self, body: str, t: float, link: str | None = None) -> np.ndarray:
        """Position of a link of a body (its first if none is named) at time `t` [m], shape (3,)."""
        a, b, w = self._around(t)
        pos = self._pos[:, self._links[body, link]]
        return (1 - w) * pos[a] + w * pos[b]

    def colors(self, copies: dict[str, list[float]]) -> dict[int, list[float]]:
        """Colours by link, for those of copies."""
        links = self._layout["links"] if self._layout is not None else []
        return {i: copies[link["body"]] for i, link in enumerate(links) if link["body"] in copies}

    def _around(self, t: float) -> tuple[int, int, float]:
        """Recorded frames before and after time `t`, and how far `t` is from the one to the other, 0 to 1."""
        last = len(self.time) - 1
        b = min(int(np.searchsorted(self.time, t)), last)
        a = max(b - 1, 0)
        return a, b, 1.0 if a == b else float(np.clip((t - self.time[a]) / (self.time[b] - self.time[a]), 0.0, 1.0))

    def _read_layout(self) -> bool:
        try:
            self._layout = json.loads((self._folder / "states" / "layout.json").read_text("utf-8"))
        except (OSError, ValueError):
            return False
        assert self._layout is not None
        links = [*enumerate(self._layout["links"])]
        self._links = {(link["body"], None): i for i, link in reversed(links) if link["link"] != "world"}
        self._links |= {(link["body"], link["link"]): i for i, link in links}
        return True
