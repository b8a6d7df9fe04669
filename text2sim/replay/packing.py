"""Packing of arrays into text for a page: quantised, compressed, in base64."""

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

TYPES = {"float32": "Float32Array", "uint32": "Uint32Array", "uint16": "Uint16Array", "int16": "Int16Array",
         "int8": "Int8Array"}  # fmt: skip
STEPS = 65535
"""Quantisation steps over the extent of points."""


class Blob:
    """Concatenated arrays, which the page finds by their offsets."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self.size = 0
        """Size [bytes]."""

    def add(self, values: Array) -> dict[str, Any]:
        """Add an array; return its description for the page."""
        data = np.ascontiguousarray(values).tobytes()
        row = {"type": TYPES[values.dtype.name], "at": self.size, "count": int(values.size)}
        padding = -len(data) % 4
        self._parts += [data, bytes(padding)]
        self.size += len(data) + padding
        return row

    def add_points(self, points: Array) -> dict[str, Any]:
        """Add points, quantised in their bounding box: that of all, shape (n, 3), or of each track, shape (F, n, 3).

        The page gets `low` and `step` of the boxes: a coordinate is low + step * number.
        """
        low, high = (points.min(axis=0), points.max(axis=0)) if points.size else (np.zeros(3), np.zeros(3))
        step = np.maximum(high - low, 1e-12) / STEPS
        numbers = np.rint((points - low) / step).astype(np.uint16)
        return self.add(numbers) | {"low": _plain(low), "step": _plain(step)}

    def text(self) -> str:
        """Return all arrays, deflated, in base64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 6)).decode()


def _plain(values: Array) -> list[float]:
    return [float(f"{x:.9g}") for x in np.ravel(values)]
