"""Cache of results about files in the user's cache folder, by content and by versions of the packages that gave them.

Loading MuJoCo or a URDF reader takes a second. An entry is JSON below a line with its digest: one that is damaged is
computed again. Without a writable folder, results are computed every time.
"""

import json
import re
import sys
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.spec_schema.whole_files import user_cache, write_atomically

if TYPE_CHECKING:
    import numpy as np

VERSIONED_PACKAGES = (
    "contourpy",
    "manifold3d",
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


def cached_answer(question: Iterable[bytes], ask: Callable[[], Any]) -> Any:
    """Return the answer to a question, from the cache if possible: always as it comes out of it, tuples as lists.

    Args:
        question: All that the answer depends on, except versions of packages and the source of the module that asks.
        ask: Computes the answer: plain data, bytes, and arrays, which become float64 or int64. Exceptions are not
            cached.
    """
    key = _key_of([*question, _source_of(ask.__module__)])
    text = _recall(key)
    if text is None:
        text = json.dumps(ask(), default=_encoded)
        _keep(key, text)
    return json.loads(text, object_hook=_decoded)


def _encoded(value: "bytes | np.ndarray") -> dict[str, Any]:
    if isinstance(value, bytes):
        return {"base64": b64encode(value).decode()}
    kind = "<f8" if value.dtype.kind == "f" else "<i8"
    return _encoded(value.astype(kind).tobytes()) | {"kind": kind, "shape": value.shape}


def _decoded(row: dict[str, Any]) -> Any:
    if not isinstance(row.get("base64"), str):  # a joint may have this name
        return row
    content = b64decode(row["base64"])
    if "kind" not in row:
        return content
    import numpy as np

    return np.frombuffer(content, row["kind"]).reshape(row["shape"])


def _key_of(question: Iterable[bytes]) -> str:
    digest = sha256()
    for content in (*question, *(_version(name).encode() for name in VERSIONED_PACKAGES), sys.version.encode()):
        # The length keeps different sequences of contents from giving the same bytes.
        digest.update(len(content).to_bytes(8, "big"))
        digest.update(content)
    return digest.hexdigest()


def _recall(key: str) -> str | None:
    """Return the text of an entry; None without one, or if it is damaged."""
    try:
        path = answers_folder() / f"{key}.answer"
        if path.stat().st_size > MAX_ENTRY_SIZE:
            return None
        digest, _, text = path.read_text("utf-8").partition("\n")
    except (OSError, ValueError, RuntimeError):
        return None
    return text if digest == _digest(text) else None


def _keep(key: str, text: str) -> None:
    entry = f"{_digest(text)}\n{text}"
    if len(entry) > MAX_ENTRY_SIZE:
        return
    with suppress(OSError, RuntimeError):
        where = answers_folder()
        where.mkdir(parents=True, exist_ok=True)
        write_atomically(where / f"{key}.answer", entry)
        _delete_old_entries(where)


def _digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()


def answers_folder() -> Path:
    """Return the folder of answers.

    Raises:
        RuntimeError: if the user has no home.
    """
    return user_cache() / "text2sim" / "models"


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
