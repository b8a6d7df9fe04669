"""Detection of saves of a case, independent of how its editor saves."""

import os
import stat
from hashlib import file_digest
from pathlib import Path
from time import monotonic, sleep, time
from typing import Literal

SUFFIXES = frozenset(
    ".yaml .yml .json .obj .mtl .stl .ply .off .glb .gltf .bin .dae .3mf .xml .mjcf .urdf .png .jpg .jpeg .tga".split()
)
"""Suffixes of files that a case may use; editors create others beside it."""
SKIPPED = frozenset({"runs", "program", "__pycache__", "node_modules"})
MAX_FILES = 2_000
"""Largest number of watched files, because a case file may be in any folder."""
MAX_DEPTH = 4
SETTLE_TIME = 0.01
"""Time [s] without a change after which a save is complete."""
MISSING_FILE_PATIENCE = 0.5
"""Time [s] for which a file may be missing, or empty, while it is being saved."""

Stamp = tuple[int, int, int]


class CaseFiles:
    """The file of a case, and the files of its folder that it may refer to."""

    def __init__(self, case_file: Path) -> None:
        self._case = case_file
        self.age = 0.0
        """Time [s] between the last save and its detection."""
        self._stamps = self._look()
        self._digests = {path: _digest(path) for path in self._stamps}

    def saved(self) -> Literal["changed", "touched", ""]:
        """Return what happened since the last call: new content, a save of the same content, or nothing."""
        if self._look() == self._stamps:
            return ""
        self._settle()
        stamps = self._look()
        touched = {path for path in {*stamps, *self._stamps} if stamps.get(path) != self._stamps.get(path)}
        newest = max((stamps[path][0] / 1e9 for path in touched & stamps.keys()), default=time())
        self.age = min(max(0.0, time() - newest), MISSING_FILE_PATIENCE)
        digests = {path: _digest(path) if path in stamps else "" for path in touched}
        changed = any(digest != self._digests.get(path, "") for path, digest in digests.items())
        self._stamps = stamps
        self._digests = {path: digests.get(path, self._digests.get(path, "")) for path in stamps}
        return "changed" if changed else "touched" if self._case in touched else ""

    def _settle(self) -> None:
        """Wait for the end of a save: some editors truncate a file first, others replace it."""
        begun, before = monotonic(), None
        while monotonic() - begun < MISSING_FILE_PATIENCE:
            stamps = self._look()
            complete = (stamp := stamps.get(self._case)) is not None and stamp[1] > 0
            if complete and stamps == before:
                return
            before = stamps
            sleep(SETTLE_TIME)

    def _look(self) -> dict[Path, Stamp]:
        stamps: dict[Path, Stamp] = {}
        self._look_into(self._case.parent, MAX_DEPTH, stamps)
        if self._case not in stamps and (stamp := _stamp(self._case)) is not None:
            stamps[self._case] = stamp
        return stamps

    def _look_into(self, folder: Path, depth: int, stamps: dict[Path, Stamp]) -> None:
        try:
            entries = list(os.scandir(folder))
        except OSError:
            return
        for entry in entries:
            if len(stamps) >= MAX_FILES or entry.name.startswith("."):
                continue
            try:
                if entry.is_dir(follow_symlinks=False):
                    if depth and entry.name not in SKIPPED:
                        self._look_into(Path(entry.path), depth - 1, stamps)
                elif os.path.splitext(entry.name)[1].lower() in SUFFIXES:
                    if (stamp := _stamp(Path(entry.path))) is not None:
                        stamps[Path(entry.path)] = stamp
            except OSError:
                continue


def _stamp(path: Path) -> Stamp | None:
    try:
        found = path.stat()
    except OSError:
        return None
    if not stat.S_ISREG(found.st_mode):
        return None  # reading a pipe or a device may never end
    return found.st_mtime_ns, found.st_size, found.st_ino


def _digest(path: Path) -> str:
    try:
        with open(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as stream:
            if not stat.S_ISREG(os.fstat(stream.fileno()).st_mode):
                return ""
            return file_digest(stream, "blake2b").hexdigest()
    except OSError:
        return ""
