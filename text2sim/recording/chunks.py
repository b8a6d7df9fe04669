"""Array files of a recording: whether they are complete, and their contents, read only as far as needed."""

import struct
import tokenize
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.spec_schema.errors import RunError

Array = NDArray[Any]
Rows = Mapping[str, tuple[int | str, ...]]
"""Shape of one row of each array; words stand for sizes."""

DAMAGED = (
    OSError, ValueError, KeyError, IndexError, TypeError, OverflowError, EOFError, RuntimeError, SyntaxError,
    tokenize.TokenError, struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""Errors of reading a broken array file; numpy reads headers as Python literals."""
_LOCAL_HEADER = 30
"""Bytes of the header of a zip member before its name."""


@dataclass(frozen=True, eq=False)
class Chunks:
    """Chunks in their order, as if they were one file."""

    paths: tuple[Path, ...]
    _views: dict[tuple[Path, str], Array] = field(default_factory=dict, repr=False)

    def gather(self, name: str, row: tuple[int, ...]) -> Array:
        """Return one array over all frames, shape (F, *row).

        Raises:
            RunError: if a chunk was damaged since it was checked.
        """
        parts = []
        for path in self.paths:
            try:
                with np.load(path, allow_pickle=False) as chunk:
                    if name in chunk.files:  # the last chunk may have only contacts
                        parts.append(chunk[name])
            except DAMAGED as error:
                raise RunError(f"{path}: damaged ({error})") from error
        return np.concatenate(parts) if parts else np.zeros((0, *row))

    def columns(self, name: str, first: int, last: int) -> Array:
        """Return the columns `first` to `last` of an array (F, n, ...), copying no others into memory.

        Args:
            name: Name of the array.
            first: First column.
            last: Column after the last.

        Raises:
            RunError: if a chunk was damaged since it was checked.
        """
        parts = []
        for path in self.paths:
            try:
                view = self._view(path, name)
            except DAMAGED as error:
                raise RunError(f"{path}: damaged ({error})") from error
            if view is not None:
                parts.append(view[:, first:last])
        return np.concatenate(parts) if parts else np.zeros((0, last - first, 3), np.float32)

    def _view(self, path: Path, name: str) -> Array | None:
        if (path, name) in self._views:
            return self._views[path, name]
        with zipfile.ZipFile(path) as archive:
            if f"{name}.npy" not in archive.namelist():
                return None
            info = archive.getinfo(f"{name}.npy")
        if info.compress_type != zipfile.ZIP_STORED:
            with np.load(path, allow_pickle=False) as chunk:
                view = chunk[name]
        else:
            view = _mapped(path, info)
        self._views[path, name] = view
        return view


def _mapped(path: Path, info: zipfile.ZipInfo) -> Array:
    """Map an uncompressed array from its place in the file, after a check of its checksum."""
    with path.open("rb") as file:
        file.seek(info.header_offset)
        lengths = struct.unpack("<HH", file.read(_LOCAL_HEADER)[26:])
        begin = info.header_offset + _LOCAL_HEADER + sum(lengths)
        file.seek(begin)
        checksum = 0
        left = info.file_size
        while left > 0 and (block := file.read(min(left, 1 << 24))):
            checksum, left = zlib.crc32(block, checksum), left - len(block)
        if left or checksum != info.CRC:
            raise ValueError(f"bad checksum of {info.filename}")
        file.seek(begin)
        shape, dtype, fortran = _header(file)
        offset = file.tell()
    if not np.prod(shape):
        return np.zeros(shape, dtype)  # nothing to map
    return np.memmap(path, dtype, "r", offset, shape, "F" if fortran else "C")


def readable_chunks(
    folder: Path, framed: Rows, always: Rows, sizes: Mapping[str, int]
) -> tuple[tuple[Path, ...], list[str]]:
    """Return the chunks up to the first that is missing or damaged, and a message about what is left out.

    Args:
        folder: Their folder.
        framed: Arrays of a chunk that has frames, with equal numbers of rows.
        always: Arrays of every chunk, with equal numbers of rows.
        sizes: Sizes that words in the shapes of rows stand for.
    """
    good: list[Path] = []
    paths = sorted(folder.glob("chunk_*.npz"))
    for number, path in enumerate(paths):
        wrong = "an earlier one is missing" if path.name != f"chunk_{number:05d}.npz" else ""
        reason = wrong or _fault(path, framed, always, sizes)
        if reason:
            # Chunks after a gap do not continue the frames before it.
            rest = len(paths) - number
            return tuple(good), [f"states/{path.name}: {reason}; {rest} of {len(paths)} chunks left out"]
        good.append(path)
    return tuple(good), []


def _fault(path: Path, framed: Rows, always: Rows, sizes: Mapping[str, int]) -> str:
    """Return what is wrong with a chunk, from its headers alone; empty if it is whole."""
    try:
        with zipfile.ZipFile(path) as archive:
            rows: dict[str, int] = {}
            groups = (framed, always) if "time.npy" in archive.namelist() else (always,)
            for name, wanted in (item for group in groups for item in group.items()):
                shape = array_shape(archive, name)
                row = tuple(sizes[n] if isinstance(n, str) else n for n in wanted)
                if not shape or shape[1:] != row:
                    return f"{name} has shape {shape}, not (n, {', '.join(map(str, row))})"
                rows[name] = shape[0]
    except DAMAGED as error:
        return f"damaged ({error})"
    for group in groups:
        if len({rows[name] for name in group}) > 1:
            return "its arrays have different lengths"
    return ""


def array_shape(archive: zipfile.ZipFile, name: str) -> tuple[int, ...]:
    """Return the shape of an array of numbers, from its header.

    Raises:
        ValueError: or another of `DAMAGED`, if it is missing, or not as long as its header says.
    """
    member = archive.getinfo(f"{name}.npy")
    with archive.open(member) as stream:
        shape, dtype, _ = _header(stream)
        size = int(np.prod(shape, dtype=np.int64)) * dtype.itemsize
        if dtype.kind not in "fiub" or member.file_size != stream.tell() + size:
            raise ValueError(f"{name} is not {size} bytes of numbers")
    return shape


def _header(stream: Any) -> tuple[tuple[int, ...], np.dtype, bool]:
    version = np.lib.format.read_magic(stream)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, fortran, dtype = read(stream)
    return tuple(shape), dtype, bool(fortran)


def read_arrays(path: Path, names: Sequence[str]) -> dict[str, Array]:
    """Return those of the arrays that a file has.

    Raises:
        One of `DAMAGED`: if it is missing, or an array in it is not numeric.
    """
    with zipfile.ZipFile(path) as archive:
        stored = [name for name in names if f"{name}.npy" in archive.namelist()]
        for name in stored:
            array_shape(archive, name)
    with np.load(path, allow_pickle=False) as data:
        return {name: data[name] for name in stored}
