"""Writes the files of a run: JSON, arrays, meshes and pictures. No file is ever seen half written."""

import hashlib
import json
import os
from pathlib import Path

import genesis as gs
import numpy as np


def write_json(path: Path, value) -> None:
    """Writes a value as strict JSON, atomically."""
    _replace(path, lambda file: file.write((json.dumps(value, indent=1, allow_nan=False) + "\n").encode()))


def write_npz(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """Writes arrays uncompressed. Equal arrays give equal bytes, since numpy dates every member 1980."""
    _replace(path, lambda file: np.savez(file, **arrays))


def write_mesh(folder: Path, mesh) -> str:
    """Writes a mesh of the engine, unless its file exists, and returns the name of the file."""
    arrays = {"vertices": mesh.verts, "faces": mesh.faces, "normals": mesh.normals, "uvs": mesh.uvs}
    arrays = {
        name: np.asarray(array, np.int32 if name == "faces" else np.float32)
        for name, array in arrays.items()
        if array is not None
    }
    name = _digest(*(array for pair in arrays.items() for array in (pair[0].encode(), pair[1].tobytes()))) + ".npz"
    if not (folder / name).exists():
        write_npz(folder / name, arrays)
    return name


def write_paint(folder: Path, paint) -> dict:
    """Returns the color of a surface, and the name of its texture if it has one, which is written to `folder`."""
    if not isinstance(paint, gs.textures.ImageTexture):
        return {"color": [float(x) for x in (*paint.color, 1.0)[:4]]}
    from PIL import Image

    name = _digest(paint.image_array.tobytes()) + ".png"
    Image.fromarray(paint.image_array).save(folder / name)
    return {"color": [1.0, 1.0, 1.0, 1.0], "texture": name}


def _digest(*parts: bytes) -> str:
    return hashlib.sha256(b"".join(parts)).hexdigest()[:16]


def _replace(path: Path, write) -> None:
    """Replaces a file atomically: after a crash there is the old file or the new one, never a part."""
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except OSError as error:  # the error of a full disk names no file
        part.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from error
