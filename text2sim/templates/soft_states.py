"""Reads the recording of `soft.py`."""

import numpy as np

CHUNKS_IN_HAND = 2


class SoftStates:
    """Recorded points and surfaces of deformable bodies.

    Chunks are read on demand, because those of a large body do not fit into memory together.

    Args:
        rows: Rows of the layout, one for each body.
        chunks: Chunks of the recording that contain frames, in order.
    """

    def __init__(self, rows: list[dict], chunks: list):
        self.rows, self._chunks = rows, chunks
        self._ends = np.cumsum([len(chunk["time"]) for chunk in chunks])
        self._in_hand: dict[tuple[str, int], np.ndarray] = {}
        self._centres = None

    def at(self, name: str, around: tuple[int, int, float]) -> np.ndarray:
        """Return positions [m], interpolated linearly between two frames, shape (n, 3).

        Args:
            name: Name of the array, `soft_points` or `soft_surface`.
            around: Frames before and after, and the fraction of the way from one to the other.
        """
        a, b, w = around
        return (1 - w) * self._frame(name, a) + w * self._frame(name, b)

    def centre(self, body: str, around: tuple[int, int, float]) -> np.ndarray | None:
        """Return the mean of the points of a body between two frames [m], shape (3,); None if no such body deforms."""
        names = [row["body"] for row in self.rows]
        if body not in names:
            return None
        if self._centres is None:
            frames = (self._frame("soft_points", i).astype(float) for i in range(self._ends[-1]))
            starts = [row["points"][0] for row in self.rows]
            sizes = np.diff([*starts, self.rows[-1]["points"][1]])
            self._centres = np.array([np.add.reduceat(points, starts) / sizes[:, None] for points in frames])
        a, b, w = around
        k = names.index(body)
        return (1 - w) * self._centres[a, k] + w * self._centres[b, k]

    def _frame(self, name: str, i: int) -> np.ndarray:
        k = int(np.searchsorted(self._ends, i, side="right"))
        if (name, k) not in self._in_hand:
            held = [key for key in self._in_hand if key[0] == name]
            if len(held) == CHUNKS_IN_HAND:
                del self._in_hand[held[0]]
            self._in_hand[name, k] = self._chunks[k][name]
        array = self._in_hand[name, k]
        return array[i - self._ends[k]]  # counted from the end of the chunk
