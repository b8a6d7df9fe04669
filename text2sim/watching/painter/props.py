"""The shapes of a recorded scene on the graphics device, drawn where their links are."""

import ctypes
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.watching.painter.creases import corners
from text2sim.watching.painter.rotation import multiply, rotate
from text2sim.watching.painter.shaders import Shader

_FILE = re.compile(r"\w{1,128}\.(npz|png)\Z")
ROW = 20
"""Numbers of a copy: a matrix, column by column, and a colour."""


@dataclass
class Batch:
    """All copies of one mesh with one texture: one call draws them."""

    array: int
    """The device's name for the arrangement of the buffers."""
    buffer: int
    """Where the rows of the copies go."""
    corners: int
    """To draw."""
    texture: int | None
    links: np.ndarray
    """Links that wear it, shape (n,)."""
    pos: np.ndarray
    """Where, in the link's frame [m], shape (n, 3)."""
    quat: np.ndarray
    """How turned, shape (n, 4)."""
    rows: np.ndarray
    """What the device gets, shape (n, ROW), float32; the colours stand in it."""
    clear: bool
    """Whether one sees through it."""


class Props:
    """What stands on the stage."""

    def __init__(self, gl: Any, shader: Shader, folder: Path, colors: dict[int, list[float]]) -> None:
        """Load the shapes of a recording.

        Args:
            gl: OpenGL.
            shader: What colours them.
            folder: Where they were recorded.
            colors: By link, where they are not those that were recorded.
        """
        self._gl, self._shader = gl, shader
        self._names: list[tuple[Any, int]] = []
        self._batches = [self._batch(folder, key, rows) for key, rows in _groups(folder, colors).items()]
        self._batches.sort(key=lambda batch: batch.clear)

    def draw(self, pos: np.ndarray, quat: np.ndarray, eye: np.ndarray) -> None:
        """Draw them with their links at `pos` (L, 3) [m], turned by `quat` (L, 4), for a camera at `eye` [m]."""
        gl = self._gl
        gl.glEnable(gl.GL_DEPTH_TEST)
        gl.glEnable(gl.GL_CULL_FACE)
        gl.glDisable(gl.GL_BLEND)
        seen_through = []
        for batch in self._batches:
            turns = multiply(quat[batch.links], batch.quat)
            batch.rows[:, 12:15] = places = pos[batch.links] + rotate(quat[batch.links], batch.pos)
            for k, axis in enumerate(np.eye(3)):
                batch.rows[:, 4 * k : 4 * k + 3] = rotate(turns, axis)
            if batch.clear:
                seen_through += [(float(((place - eye) ** 2).sum()), batch, i) for i, place in enumerate(places)]
            else:
                self._send(batch, batch.rows)
        if seen_through:
            # From behind to the front: the one order in which colours mix as they should.
            gl.glEnable(gl.GL_BLEND)
            gl.glBlendFunc(gl.GL_SRC_ALPHA, gl.GL_ONE_MINUS_SRC_ALPHA)
            for _, batch, i in sorted(seen_through, key=lambda entry: -entry[0]):
                self._send(batch, batch.rows[i : i + 1])

    def delete(self) -> None:
        """Free what they hold."""
        for free, name in self._names:
            free(1, [name])

    def _send(self, batch: Batch, rows: np.ndarray) -> None:
        gl = self._gl
        self._shader.surface(textured=batch.texture is not None)
        if batch.texture is not None:
            gl.glBindTexture(gl.GL_TEXTURE_2D, batch.texture)
        gl.glBindVertexArray(batch.array)
        gl.glBindBuffer(gl.GL_ARRAY_BUFFER, batch.buffer)
        gl.glBufferSubData(gl.GL_ARRAY_BUFFER, 0, rows.nbytes, rows)
        gl.glDrawArraysInstanced(gl.GL_TRIANGLES, 0, batch.corners, len(rows))

    def _batch(self, folder: Path, key: tuple[str, str | None, bool], rows: list[tuple[int, dict[str, Any]]]) -> Batch:
        gl, (mesh, texture, clear) = self._gl, key
        array = self._own(gl.glGenVertexArrays, gl.glDeleteVertexArrays)
        gl.glBindVertexArray(array)
        with np.load(folder / mesh, allow_pickle=False) as data:
            vertices, faces = np.asarray(data["vertices"], np.float32), np.asarray(data["faces"], np.int64)
            normals = np.asarray(data["normals"] if "normals" in data else np.zeros((0, 3)), np.float32)
            uvs = np.asarray(data["uvs"], np.float32) if "uvs" in data else None
        vertex, outward = corners(vertices, faces, normals)
        self._attribute(0, vertices[vertex])
        self._attribute(1, outward)
        if uvs is not None and len(uvs) == len(vertices):
            self._attribute(2, uvs[vertex])
        else:
            texture = None
        cells = np.zeros((len(rows), ROW), np.float32)
        cells[:, 15] = 1.0
        cells[:, 16:] = [row["color"] for _, row in rows]
        buffer = self._own(gl.glGenBuffers, gl.glDeleteBuffers)
        gl.glBindBuffer(gl.GL_ARRAY_BUFFER, buffer)
        gl.glBufferData(gl.GL_ARRAY_BUFFER, cells.nbytes, cells, gl.GL_STREAM_DRAW)
        for k in range(ROW // 4):
            gl.glVertexAttribPointer(3 + k, 4, gl.GL_FLOAT, False, 4 * ROW, ctypes.c_void_p(16 * k))
            gl.glEnableVertexAttribArray(3 + k)
            gl.glVertexAttribDivisor(3 + k, 1)
        return Batch(
            array=array,
            buffer=buffer,
            corners=len(vertex),
            texture=None if texture is None else self._texture(folder / texture),
            links=np.array([link for link, _ in rows]),
            pos=np.array([row["pos"] for _, row in rows], float),
            quat=np.array([row["quat"] for _, row in rows], float),
            rows=cells,
            clear=clear,
        )

    def _attribute(self, place: int, values: np.ndarray) -> None:
        gl, values = self._gl, np.ascontiguousarray(values, np.float32)
        buffer = self._own(gl.glGenBuffers, gl.glDeleteBuffers)
        gl.glBindBuffer(gl.GL_ARRAY_BUFFER, buffer)
        gl.glBufferData(gl.GL_ARRAY_BUFFER, values.nbytes, values, gl.GL_STATIC_DRAW)
        gl.glVertexAttribPointer(place, values.shape[1], gl.GL_FLOAT, False, 0, None)
        gl.glEnableVertexAttribArray(place)

    def _texture(self, path: Path) -> int:
        from PIL import Image

        gl = self._gl
        with Image.open(path) as image:
            pixels = np.asarray(image.convert("RGBA").transpose(Image.Transpose.FLIP_TOP_BOTTOM))
        texture = self._own(gl.glGenTextures, gl.glDeleteTextures)
        gl.glBindTexture(gl.GL_TEXTURE_2D, texture)
        gl.glTexImage2D(
            gl.GL_TEXTURE_2D, 0, gl.GL_RGBA, *pixels.shape[1::-1], 0, gl.GL_RGBA, gl.GL_UNSIGNED_BYTE, pixels.tobytes()
        )
        gl.glGenerateMipmap(gl.GL_TEXTURE_2D)
        return texture

    def _own(self, make: Any, free: Any) -> int:
        name = int(make(1))
        self._names.append((free, name))
        return name


def _groups(
    folder: Path, colors: dict[int, list[float]]
) -> dict[tuple[str, str | None, bool], list[tuple[int, dict[str, Any]]]]:
    """Rows of the recorded geometry by (mesh, texture, whether one sees through it)."""
    groups: dict[tuple[str, str | None, bool], list[tuple[int, dict[str, Any]]]] = {}
    index = json.loads((folder / "index.json").read_text("utf-8"))
    for link, rows in index.items():
        for row in rows:
            mesh, texture = row["mesh"], row.get("texture")
            if texture is None:
                row["color"] = colors.get(int(link), row["color"])
            if not all(_FILE.match(name) for name in (mesh, texture) if name is not None):
                continue  # a name becomes a path
            groups.setdefault((mesh, texture, row["color"][3] < 1.0), []).append((int(link), row))
    return groups
