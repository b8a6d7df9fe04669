"""Bundle of the files that a model refers to, under flat names."""

import re
from pathlib import Path

from text2sim.assets.engine_files import AssetFolder
from text2sim.assets.foreign_files import read_gltf
from text2sim.spec_schema.errors import AssetError

MAX_FILE = 64 * 1024 * 1024
MAX_TOTAL = 100 * 1024 * 1024
MAX_FILES = 500
PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tga")

_MTL_PICTURE = re.compile(r"^\s*(?:map_\w+|bump|disp|decal|refl|norm)\s", re.IGNORECASE)
_OBJ_MATERIAL = re.compile(rb"mtllib([^\r\n]*)(?:\r(?=\n))?", re.IGNORECASE)
"""Anywhere in a line: readers see it in a comment, too."""
_DAE_PICTURE = re.compile(rb"(<init_from[^>]*>)([^<]*)(</init_from>)")


def path_inside(source: AssetFolder, path: Path, text: str) -> Path:
    """Return a path with links resolved, which must be in a folder.

    Args:
        source: The folder.
        path: The path.
        text: The path as the author wrote it, for the message.

    Raises:
        AssetError: if it is outside of the folder.
    """
    resolved = path.resolve()
    if not resolved.is_relative_to(source.root):
        raise AssetError(f"`{text}` leads out of {source.name}{source.advice('copy it into the folder')}")
    return resolved


class Bundle:
    """Collects files from a case's folder, or from the engine's assets.

    Args:
        source: The folder that must contain all of them.
        here: Folder of the model that refers to the files, resolved.
    """

    def __init__(self, source: AssetFolder, here: Path) -> None:
        self.source, self.here = source, here
        self.files: dict[str, bytes] = {}
        self._names: dict[tuple[Path, bool], str] = {}
        self._read_files: list[Path] = []
        self._total = 0

    @property
    def sources(self) -> list[Path]:
        """Resolved paths of the files in that folder."""
        return list(dict.fromkeys(self._read_files))

    def add(
        self,
        reference: str,
        suffixes: tuple[str, ...],
        *,
        folders: tuple[Path, ...] = (),
        painted: bool = True,
    ) -> str:
        """Add a file and return its new name.

        Args:
            reference: Its name in the model.
            suffixes: Allowed suffixes.
            folders: Folders to search; that of the model if left out.
            painted: Whether materials and textures of a mesh are added, too.

        Raises:
            AssetError: if it does not exist, is outside of the folder, too large, or of a kind that is not supported.
        """
        path = self._find(reference, folders or (self.here,))
        if path.suffix.lower() not in suffixes:
            raise AssetError(f"`{reference}` must end in one of {', '.join(suffixes)}")
        key = (path, painted)
        if key not in self._names:
            content = self._read(path, reference)
            if path.suffix.lower() == ".obj":
                content = self._obj(content, path, painted=painted)
            elif path.suffix.lower() == ".dae":
                content = self._dae(content, path, reference)
            elif path.suffix.lower() == ".glb":
                try:
                    read_gltf(content, ".glb", beside=False)
                except AssetError as error:
                    raise AssetError(f"`{reference}` {error}") from None
            self._names[key] = self._add(path, content)
        return self._names[key]

    def _find(self, reference: str, folders: tuple[Path, ...]) -> Path:
        if not reference or "\\" in reference or "\0" in reference:
            raise AssetError(f"`{reference}` is not a path with forward slashes")
        if reference.startswith("package://"):
            # ROS finds packages on the author's machine; here they are folders of the case.
            rest = reference.removeprefix("package://")
            above = [self.here, *self.here.parents]
            above = above[: above.index(self.source.root) + 1]
            candidates = [folder / part for part in (rest, rest.partition("/")[2]) if part for folder in above]
            advice = self.source.advice("copy its package into the case's folder")
            message = f"`{reference}` is in no folder of {self.source.owner}{advice}"
        elif "://" in reference or reference.startswith("file:"):
            advice = self.source.advice("copy it into the folder and give its relative path")
            raise AssetError(f"`{reference}` is not a file of {self.source.owner}{advice}")
        elif reference.startswith(("/", "~")) or re.match(r"[A-Za-z]:", reference):
            advice = self.source.advice("copy it into the case's folder and give its path there")
            raise AssetError(f"`{reference}` is an absolute path{advice}")
        else:
            candidates = [folder / reference for folder in folders]
            message = f"`{reference}` does not exist in {self.source.name}"
        for candidate in candidates:
            path = path_inside(self.source, candidate, reference)
            if path.is_file():
                return path
        raise AssetError(message)

    def _read(self, path: Path, reference: str) -> bytes:
        size = path.stat().st_size
        self._total += size
        if size > MAX_FILE:
            raise AssetError(f"`{reference}` is too large ({size / 2**20:.0f} MiB; at most {MAX_FILE // 2**20} MiB)")
        if self._total > MAX_TOTAL:
            raise AssetError(f"its files are more than {MAX_TOTAL // 2**20} MiB in all")
        if len(self.files) >= MAX_FILES:
            raise AssetError(f"refers to more than {MAX_FILES} files")
        self._read_files.append(path)
        return path.read_bytes()

    def _add(self, path: Path, content: bytes) -> str:
        stem = re.sub(r"\W+", "_", path.stem)
        suffix = path.suffix.lower()
        name, number = stem + suffix, 1
        while self.files.get(name, content) != content:
            number += 1
            name = f"{stem}_{number}{suffix}"
        self.files[name] = content
        return name

    # --- files that meshes refer to ------------------------------------------------------------------------

    def _picture(self, name: str, *folders: Path) -> str | None:
        """Add a picture that a mesh names; None if the case does not have it."""
        try:
            return self.add(name, PICTURES, folders=folders)
        except AssetError:
            return None

    def _obj(self, content: bytes, path: Path, *, painted: bool) -> bytes:
        def replace(found: re.Match[bytes]) -> bytes:
            line = content.rfind(b"\n", 0, found.start()) + 1
            line = max(line, content.rfind(b"\r", line, found.start()) + 1)
            first = not content[line : found.start()].strip()
            name = self._material(found[1].decode("utf-8", "replace").strip(), path) if painted and first else None
            return b"" if name is None else b"mtllib " + name.encode()

        return _OBJ_MATERIAL.sub(replace, content)

    def _material(self, name: str, path: Path) -> str | None:
        try:
            material = self._find(name, (path.parent,))
        except AssetError:
            return None
        lines = self._read(material, name).decode("utf-8", "replace").splitlines()
        for index, line in enumerate(lines):
            if _MTL_PICTURE.match(line):
                # The name follows the options; it can contain blanks only if there are none.
                key, rest = (*line.split(None, 1), "")[:2]
                name = rest.split()[-1] if rest.startswith("-") else rest.strip()
                picture = self._picture(name, material.parent, path.parent)
                lines[index] = "" if picture is None else f"{key} {picture}"
        return self._add(material.with_suffix(".mtl"), "\n".join(lines).encode())

    def _dae(self, content: bytes, path: Path, reference: str) -> bytes:
        if b"\0" in content or b"<!DOCTYPE" in content or b"<!ENTITY" in content:
            raise AssetError(f"`{reference}` declares a document type; export it again as .obj or .glb")

        def replace(found: re.Match[bytes]) -> bytes:
            name = found[2].decode("utf-8", "replace").strip()
            if not name.lower().endswith(PICTURES):
                return found[0] if re.fullmatch(r"[\w.-]*", name) else found[1] + found[3]
            return found[1] + (self._picture(name, path.parent) or "").encode() + found[3]

        return _DAE_PICTURE.sub(replace, content)
