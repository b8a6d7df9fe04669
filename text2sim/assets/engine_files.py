"""Asset files that come with the engine: `genesis:PATH` is a path in the assets of the installed package."""

from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

from text2sim.spec_schema.errors import AssetError, nearest

PREFIX = "genesis:"
SUFFIXES = (".xml", ".urdf", ".obj", ".stl", ".ply", ".glb", ".gltf")
"""Suffixes of the files that messages suggest; which are readable depends on the reader."""


@dataclass(frozen=True)
class AssetFolder:
    """The folder that must contain a file that a case names."""

    root: Path
    """Path of the folder, resolved."""
    file: str
    """Path inside it, as the case has it."""
    own: bool
    """Whether it is the case's folder, to which an author can copy files."""

    @property
    def name(self) -> str:
        """The folder, in words."""
        return "the case's folder" if self.own else "the engine's assets"

    @property
    def owner(self) -> str:
        """Owner of the folder, in words."""
        return "the case" if self.own else self.name

    def advice(self, text: str) -> str:
        """Return advice about a missing file; empty for the engine's folder, which authors cannot change."""
        return f"; {text}" if self.own else ""


def asset_folder(folder: Path, file: str) -> AssetFolder:
    """Return the folder that must contain a file that a case names, without importing the engine.

    Args:
        folder: The case's folder.
        file: Path inside it, or `genesis:` and a path inside the engine's assets.

    Raises:
        AssetError: if the engine does not have the file, or is not installed.
    """
    if not file.startswith(PREFIX):
        return AssetFolder(folder.resolve(), file, own=True)
    path = file.removeprefix(PREFIX)
    root = engine_assets()
    if root is None:
        raise AssetError("comes with the engine, which is not installed: pip install genesis-world")
    if not path or path.startswith("/") or "\\" in path or "\0" in path or ".." in path.split("/"):
        raise AssetError("must be `genesis:` and a path inside the engine's assets, with forward slashes")
    try:
        exists = (root / path).is_file()
    except (OSError, ValueError):
        exists = False
    if not exists:
        near = nearest(path, _list_files(root))
        raise AssetError(f"is not among the engine's assets{f'; did you mean `{PREFIX}{near}`?' if near else ''}")
    return AssetFolder(root, path, own=False)


def locate_in_root(file: Path, root: Path | None) -> tuple[Path, str]:
    """Return the folder of a file that the user named, and its path inside the folder as in a case.

    Args:
        file: The file, or `genesis:PATH`.
        root: The folder with all of its files; that of the file if None.

    Raises:
        AssetError: if it is a link, or outside of the folder.
    """
    if file.as_posix().startswith(PREFIX):
        return root or Path("."), file.as_posix()
    if file.is_symlink():
        raise AssetError(f"`{file}` is a symbolic link; name the file itself")
    folder = root or file.parent
    try:
        return folder, file.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError:
        raise AssetError(f"`{file}` is not in {folder}") from None


@lru_cache(maxsize=1)
def engine_assets() -> Path | None:
    """Return the resolved folder of assets of the installed engine; None if it is not installed."""
    try:
        spec = find_spec("genesis")
    except (ImportError, ValueError):
        return None
    for place in (spec and spec.submodule_search_locations) or ():
        folder = Path(place) / "assets"
        if folder.is_dir():
            return folder.resolve()
    return None


@lru_cache(maxsize=1)
def _list_files(root: Path) -> tuple[str, ...]:
    found = (path for path in root.rglob("*") if path.suffix.lower() in SUFFIXES)
    return tuple(sorted(path.relative_to(root).as_posix() for path in found))
