"""Writer of binary glTF: a JSON document, and one buffer for its accessors."""

import json
import struct
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim import __version__
from text2sim.spec_schema.errors import RunError

Array = NDArray[Any]

FLOAT, SHORT, INT = 5126, 5123, 5125
VERTICES, INDICES = 34962, 34963
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
MAX_FILE_SIZE = 2**32 - 1
"""Largest size of a file [bytes], which its header limits."""


class Glb:
    """Builds a file.

    Attributes:
        document: Its JSON document.
    """

    def __init__(self) -> None:
        self.document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"text2sim {__version__}"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
        }
        self._parts: list[bytes] = []
        self._size = 0
        self._seen: dict[tuple[Any, ...], int] = {}

    def add(self, kind: str, row: dict[str, Any]) -> int:
        """Add a row to a list of the document; return its index."""
        rows = self.document.setdefault(kind, [])
        rows.append(row)
        return len(rows) - 1

    def use(self, extension: str) -> None:
        """Declare an extension."""
        used = self.document.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)

    def floats(self, values: Array, *, bounds: bool = False, vertices: bool = False) -> int:
        """Return the accessor of rows of floats, (n,) or (n, k); equal data is stored once.

        Args:
            values: The rows.
            bounds: Whether glTF requires their minimum and maximum.
            vertices: Whether they are attributes of vertices.
        """
        rows = np.ascontiguousarray(values, np.float32)
        wide = rows.reshape(len(rows), -1)
        data = rows.tobytes()
        key = blake2b(data, digest_size=16).digest(), wide.shape[1], vertices, bounds
        if key not in self._seen:
            accessor: dict[str, Any] = {"componentType": FLOAT, "count": len(rows), "type": KINDS[wide.shape[1]]}
            if bounds:
                accessor |= {"min": wide.min(axis=0).tolist(), "max": wide.max(axis=0).tolist()}
            accessor["bufferView"] = self.view(data, VERTICES if vertices else None)
            self._seen[key] = self.add("accessors", accessor)
        return self._seen[key]

    def indices(self, values: Array) -> int:
        """Return the accessor of vertex indices of triangles."""
        flat = np.ascontiguousarray(values).ravel()
        small = not len(flat) or flat.max() < 65535
        rows = flat.astype(np.uint16 if small else np.uint32)
        view = self.view(rows.tobytes(), INDICES)
        row = {"componentType": SHORT if small else INT, "count": len(rows), "type": "SCALAR", "bufferView": view}
        return self.add("accessors", row)

    def view(self, data: bytes, target: int | None = None) -> int:
        """Add bytes to the buffer; return their view."""
        row: dict[str, Any] = {"buffer": 0, "byteOffset": self._size, "byteLength": len(data)}
        if target is not None:
            row["target"] = target
        padding = -len(data) % 4
        self._parts += [data, bytes(padding)]
        self._size += len(data) + padding
        return self.add("bufferViews", row)

    def write(self, path: Path) -> None:
        """Write the file.

        Raises:
            RunError: if it is larger than the format allows.
        """
        text = json.dumps(
            self.document | {"buffers": [{"byteLength": self._size}]}, separators=(",", ":"), allow_nan=False
        ).encode()
        text += b" " * (-len(text) % 4)
        total = 12 + 8 + len(text) + 8 + self._size
        if total > MAX_FILE_SIZE:
            raise RunError(f"{path}: {total / 1e9:.1f} GB, more than glTF allows; write USD, or fewer frames (--every)")
        with path.open("wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, total))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", self._size, b"BIN\0"))
            file.writelines(self._parts)
