"""Guards for reading untrusted files: declared sizes are checked, failures become messages about the file."""

import json
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from text2sim.spec_schema.errors import AssetError

MAX_COUNT = 20_000_000
"""Numbers of one kind that a glTF file may declare."""
MAX_EMPTY = 100_000
"""Declared numbers without data in the file, which would turn a few bytes into gigabytes."""
MAX_NODES = 2_000
MAX_GROUPS = 2_000
"""Parts of an .obj file: each takes a millisecond to read, and is then joined to the others."""
SIZES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


def printable_line(text: str, longest: int = 2000) -> str:
    """Return untrusted text as one printable line of at most `longest` characters."""
    return "".join(c if c.isprintable() else " " for c in text)[:longest].strip()


@contextmanager
def named_errors() -> Iterator[None]:
    """Turn every exception of a reader into a message about its file.

    Raises:
        AssetError: in place of every other exception.
    """
    import numpy as np

    try:
        with np.errstate(all="ignore"):
            yield
    except AssetError:
        raise
    except MemoryError:
        raise AssetError("cannot be read: it needs more memory than there is") from None
    except Exception as error:  # readers of untrusted files can raise anything
        raise AssetError(f"cannot be read ({type(error).__name__}: {str(error)[:120]})") from error


def read_gltf(content: bytes, suffix: str, *, beside: bool) -> dict[str, Any]:
    """Return the JSON document of a glTF file.

    Args:
        content: The file.
        suffix: `.glb` or `.gltf`.
        beside: Whether it may name other files; their reader has to check them.

    Raises:
        AssetError: if it is not a glTF file, or names other files although it must not.
    """
    try:
        if suffix == ".glb":
            magic, _, _, length, _ = struct.unpack_from("<4sIIII", content)
            content = content[20 : 20 + length] if magic == b"glTF" else b""
        document = json.loads(content)
        uris = [part.get("uri", "data:") for part in (*document.get("buffers", ()), *document.get("images", ()))]
    except (struct.error, ValueError, AttributeError, TypeError, RecursionError):
        raise AssetError(f"is not a {suffix} file") from None
    if not all(isinstance(uri, str) and (beside or uri.startswith("data:")) for uri in uris):
        raise AssetError("needs other files; export it as .glb with everything embedded")
    return document


def check_gltf(content: bytes, suffix: str, *, beside: bool) -> None:
    """Check that a glTF file declares neither more than it has nor more than is sensible.

    Args:
        content: The file.
        suffix: `.glb` or `.gltf`.
        beside: As for `read_gltf`.

    Raises:
        AssetError: if it does, or is not a glTF file.
    """
    document = read_gltf(content, suffix, beside=beside)
    try:
        accessors, views = list(document.get("accessors", ())), list(document.get("bufferViews", ()))
        nodes, needed = len(document.get("nodes", ())), document.get("extensionsRequired", ())
        counts = [accessor.get("count", 0) for accessor in accessors]
    except (AttributeError, TypeError):
        raise AssetError(f"is not a {suffix} file") from None
    if not all(isinstance(count, int) and 0 <= count <= MAX_COUNT for count in counts) or sum(counts) > MAX_COUNT:
        raise AssetError(f"declares more than {MAX_COUNT:,} numbers")
    try:
        drawn = _count_drawn_corners(document)
    except (AttributeError, TypeError, LookupError):
        raise AssetError("refers to meshes, parts or numbers that it does not have") from None
    if drawn > MAX_COUNT:
        raise AssetError(f"repeats its meshes until they have {drawn:,} corners; at most {MAX_COUNT:,} are possible")
    if nodes > MAX_NODES:
        raise AssetError(f"has {nodes:,} nodes; at most {MAX_NODES:,} are possible: join them")
    empty = sum(count for accessor, count in zip(accessors, counts, strict=True) if not _is_held(accessor, views))
    if empty > MAX_EMPTY:
        raise AssetError(f"declares {empty:,} numbers that it does not contain")
    if any("draco" in str(name).lower() or "meshopt" in str(name).lower() for name in needed):
        raise AssetError("is compressed (Draco or meshopt); export it without compression")


def check_disguise(content: bytes) -> None:
    """Check that a file is not what downloads and checkouts often leave in place of a mesh.

    Args:
        content: The file, or its first kilobyte.

    Raises:
        AssetError: if it is empty, an archive, a web page, or a pointer to a file in Git LFS.
    """
    if not content.strip():
        raise AssetError("is empty")
    if content.startswith((b"PK\x03\x04", b"\x1f\x8b", b"BZh", b"7z\xbc\xaf", b"\xfd7zXZ")):
        raise AssetError("is an archive; unpack it, and name the mesh in it")
    if content.startswith(b"version https://git-lfs.github.com/"):
        raise AssetError("is only a pointer to the mesh, which Git LFS holds; fetch it with `git lfs pull`")
    if content.lstrip()[:14].lower().startswith((b"<!doctype html", b"<html")):
        raise AssetError("is a web page, not a mesh; download the file itself")


def check_obj(content: bytes) -> None:
    """Check that an .obj file does not have so many parts that joining them takes minutes.

    Raises:
        AssetError: if it does.
    """
    groups = max(content.count(b"\n" + word) + content.count(b"\r" + word) for word in (b"usemtl", b"o ", b"g "))
    if groups > MAX_GROUPS:
        raise AssetError(f"has {groups:,} parts; at most {MAX_GROUPS:,} are possible: join them")


def _count_drawn_corners(document: dict[str, Any]) -> int:
    """Number of corners of all triangles, each mesh counted as often as nodes show it."""
    accessors = document.get("accessors", ())
    corners = []
    for mesh in document.get("meshes", ()):
        numbers = [part.get("indices", part.get("attributes", {}).get("POSITION")) for part in mesh["primitives"]]
        corners.append(sum(accessors[k].get("count", 0) for k in numbers if isinstance(k, int)))
    shown = [node.get("mesh") for node in document.get("nodes", ())]
    return sum(corners[k] for k in shown if isinstance(k, int))


def _is_held(accessor: dict[str, Any], views: list[Any]) -> bool:
    """Whether the file contains the numbers of an accessor."""
    view = accessor.get("bufferView")
    if not isinstance(view, int) or not 0 <= view < len(views) or not isinstance(views[view], dict):
        return False
    width = WIDTHS.get(str(accessor.get("type")), 1) * SIZES.get(accessor.get("componentType", 0), 1)
    length = views[view].get("byteLength", 0)
    return isinstance(length, int) and accessor.get("count", 0) * width <= max(length, 0)


class NamedFiles(Mapping[str, bytes]):
    """Files that another file names: read one by one, and never listed, as a folder may have any number of them."""

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __bool__(self) -> bool:
        return True
