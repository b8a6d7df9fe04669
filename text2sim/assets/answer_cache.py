"""Cache of results about files in the user's cache folder, by content and by versions of the packages that gave them.

Loading MuJoCo or a URDF reader takes a second. Entries are plain JSON, and are validated when they are read. Without a
writable folder, results are computed every time.
"""

import json
import os
import re
import sys
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.spec_schema.whole_files import write_atomically

if TYPE_CHECKING:
    import numpy as np

VERSIONED_PACKAGES = (
    "contourpy",
    "mujoco",
    "numpy",
    "opencv-python",
    "pymeshlab",
    "scipy",
    "shapely",
    "trimesh",
    "yourdfpy",
)
"""Packages whose versions are part of the key."""
MAX_ANSWERS = 1000
"""Entries of the cache; the oldest are deleted first."""
MAX_ENTRY_SIZE = 16 * 1024**2
"""Size [bytes] above which an entry is neither written nor read."""


def cached_answer(
    question: Iterable[bytes], members: Mapping[str, type], ask: Callable[[], dict[str, Any]]
) -> dict[str, Any]:
    """Return the answer to a question, from the cache if possible.

    Args:
        question: All that the answer depends on, except versions of packages and the source of the module that asks.
        members: Names and types of the members of an answer.
        ask: Computes the answer. Exceptions are not cached.
    """
    return _cached(question, members, ask, _source_of(ask.__module__))


def _cached(
    question: Iterable[bytes], members: Mapping[str, type], ask: Callable[[], dict[str, Any]], source: bytes
) -> dict[str, Any]:
    key = _key_of([*question, source])
    found = _recall(key, members)
    if found is None:
        found = ask()
        if found.keys() == members.keys():
            _keep(key, found)
    return found


def cached_net(
    question: Iterable[bytes], make: "Callable[[], tuple[np.ndarray, np.ndarray]]"
) -> "tuple[np.ndarray, np.ndarray]":
    """Return vertices (n, 3) float64 and triangles (m, 3) int64, from the cache if possible.

    Args:
        question: All that they depend on, except versions of packages and the source of the module that asks.
        make: Computes them. Exceptions are not cached.
    """
    import numpy as np

    made: list[tuple[np.ndarray, np.ndarray]] = []

    def ask() -> dict[str, str]:
        made.append(make())
        return dict(zip(("vertices", "faces"), map(packed, made[0]), strict=True))

    found = _cached(question, {"vertices": str, "faces": str}, ask, _source_of(make.__module__))
    vertices, faces = unpacked(found["vertices"], "f8", 3), unpacked(found["faces"], "i8", 3)
    if vertices is None or faces is None or not are_valid_rows(faces, vertices):  # the entry is damaged
        vertices, faces = made[0] if made else make()
    return vertices, faces


def packed(array: "np.ndarray") -> str:
    """Return an array as text; see `unpacked`."""
    return b64encode(array.astype("<f8" if array.dtype.kind == "f" else "<i8").tobytes()).decode()


def unpacked(text: str, kind: str, columns: int) -> "np.ndarray | None":
    """Return an array (n, columns) of kind `f8` or `i8`, or None if the text is not one.

    Args:
        text: The array in base64.
        kind: Type of its numbers, `f8` or `i8`.
        columns: Its columns.
    """
    import numpy as np

    try:
        return np.frombuffer(b64decode(text, validate=True), f"<{kind}").reshape(-1, columns)
    except ValueError:
        return None


def are_valid_rows(index: "np.ndarray | None", table: "np.ndarray") -> bool:
    """Whether there are indices, and all are valid rows of a table."""
    return index is not None and len(index) > 0 and bool(index.min() >= 0) and bool(index.max() < len(table))


def _key_of(question: Iterable[bytes]) -> str:
    digest = sha256()
    for content in (*question, *(_version(name).encode() for name in VERSIONED_PACKAGES), sys.version.encode()):
        # The length keeps different sequences of contents from giving the same bytes.
        digest.update(len(content).to_bytes(8, "big"))
        digest.update(content)
    return digest.hexdigest()


def _recall(key: str, members: Mapping[str, type]) -> dict[str, Any] | None:
    try:
        path = answers_folder() / f"{key}.json"
        if path.stat().st_size > MAX_ENTRY_SIZE:
            return None
        found = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RuntimeError, RecursionError):
        return None
    fits = isinstance(found, dict) and found.keys() == members.keys()
    return found if fits and all(isinstance(found[name], kind) for name, kind in members.items()) else None


def _keep(key: str, answer: dict[str, Any]) -> None:
    text = json.dumps(answer)
    if len(text) > MAX_ENTRY_SIZE:
        return
    with suppress(OSError, RuntimeError):
        where = answers_folder()
        where.mkdir(parents=True, exist_ok=True)
        write_atomically(where / f"{key}.json", text)
        _delete_old_entries(where)


def answers_folder() -> Path:
    """Return the folder of answers.

    Raises:
        RuntimeError: if the user has no home.
    """
    cache = os.environ.get("XDG_CACHE_HOME")
    return (Path(cache) if cache else Path.home() / ".cache") / "text2sim" / "models"


def _delete_old_entries(where: Path) -> None:
    rows = list(where.iterdir())
    if len(rows) > MAX_ANSWERS:
        for path in sorted(rows, key=lambda path: path.stat().st_mtime)[: len(rows) - MAX_ANSWERS]:
            path.unlink(missing_ok=True)


@lru_cache
def _source_of(module: str) -> bytes:
    """Return the source of a module: another program may give another answer."""
    file = getattr(sys.modules.get(module), "__file__", None)
    return Path(file).read_bytes() if file else b""


@lru_cache
def _version(name: str) -> str:
    """Version of a package; empty without it."""
    # `importlib.metadata.version` is slow: it parses all of the metadata.
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        found = re.search(r"^Version: (\S+)", distribution(name).read_text("METADATA") or "", re.MULTILINE)
    except PackageNotFoundError:
        return ""
    return found[1] if found else ""
