"""Inventory of a run's files: whether they are as it wrote them, by names and digests in `run.json`."""

from collections.abc import Iterable, Mapping
from hashlib import file_digest
from pathlib import Path

RECORDED = ("states/*", "geometry/*")
"""Files that the simulation writes."""
JUDGED = ("evidence.json", "measures.csv", "events.jsonl")
"""Files that are made from these."""
Inventory = Mapping[str, str]
"""Path below the run folder → length [bytes] and SHA-256, as `1024 e3b0…`."""


def list_files(folder: Path, patterns: Iterable[str]) -> dict[str, str]:
    """List the files of a run folder that match one of the patterns."""
    paths = sorted(path for pattern in patterns for path in folder.glob(pattern) if path.is_file())
    return {path.relative_to(folder).as_posix(): _entry(path) for path in paths}


def first_fault(folder: Path, inventory: Inventory, *, content: bool = True) -> str:
    """Return what is wrong with the first file that is not as it was written; empty if all are.

    Args:
        folder: The run folder.
        inventory: What was written.
        content: Whether to read the files; otherwise only their lengths are compared.
    """
    for name, entry in inventory.items():
        path, length = folder / name, entry.partition(" ")[0]
        try:
            size = path.stat().st_size
            if str(size) != length:
                return f"{name} is damaged: it has {size} bytes, not {length}"
            if content and _entry(path) != entry:
                return f"{name} is not the file that the run wrote"
        except OSError:
            return f"{name} is missing"
    return ""


def _entry(path: Path) -> str:
    return f"{path.stat().st_size} {sha256_of(path)}"


def sha256_of(path: Path) -> str:
    """Return the digest of a file in hexadecimal."""
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()
