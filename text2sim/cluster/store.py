"""Shared store of files by the digest of their content, and of results of tasks.

blobs/<sha256>      a file
trees/<key>.json    a task's result and its files by path; written last
"""

import json
import os
import re
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from hashlib import sha256
from itertools import islice
from pathlib import Path
from typing import Any

from text2sim.recording.inventory import sha256_of
from text2sim.spec_schema.errors import RunError

SKIPPED = frozenset({"runs", "program", "__pycache__"})
"""Folders of an input that are not stored, nor are hidden ones."""
OBJECT_STORES = frozenset({"s3", "s3a", "gs", "gcs", "abfs", "az"})
"""Protocols of object stores, whose top level are buckets."""
MAX_FILES = 10_000
MAX_TRANSFERS = 16
"""Number of transfers at a time: latency dominates."""
_DIGEST = re.compile(r"[0-9a-f]{64}\Z")
Tree = dict[str, str]
"""Path below a folder → digest of the file."""


@dataclass
class Store:
    """A store in a folder, or in any file system of fsspec.

    Args:
        url: `folder`, `s3://bucket/path`, …
    """

    url: str
    _known: set[str] = field(default_factory=set)
    """Blobs that are known to exist."""

    def __post_init__(self) -> None:
        import fsspec

        with self._using():
            self._fs, root = fsspec.core.url_to_fs(self.url)
            self._root = str(root).rstrip("/")
            protocol = self._fs.protocol
            protocols = {protocol} if isinstance(protocol, str) else {*protocol}
            self._is_folder = "file" in protocols
            if protocols & OBJECT_STORES:
                # Object stores need no folders, and `makedirs` would create a bucket if its name is misspelt.
                if not self._fs.exists(bucket := self._root.partition("/")[0]):
                    raise RunError(f"the store {self.url} cannot be used: there is no bucket {bucket}")
            else:
                for name in ("blobs", "trees"):
                    self._fs.makedirs(f"{self._root}/{name}", exist_ok=True)

    def put_tree(self, folder: Path, *, skip: frozenset[str] = frozenset()) -> Tree:
        """Store the files of a folder, or one file, without links; return their digests.

        Raises:
            RunError: if there are too many, or the store cannot be reached.
        """
        files = list(islice(_files(folder, skip), MAX_FILES + 1))
        if len(files) > MAX_FILES:
            raise RunError(f"{folder} has more than {MAX_FILES:,} files, the limit for a task")
        with ThreadPoolExecutor(MAX_TRANSFERS) as pool:
            return dict(
                zip((name for name, _ in files), pool.map(self._upload, (path for _, path in files)), strict=True)
            )

    def get_tree(self, tree: Tree, folder: Path) -> None:
        """Fetch files that a folder does not have yet, each atomically.

        Raises:
            RunError: if a path leads out of the folder, or a file is missing or damaged.
        """
        with ThreadPoolExecutor(MAX_TRANSFERS) as pool:
            list(pool.map(lambda name: self._get(name, tree[name], folder), tree))

    def keep(self, key: str, result: dict[str, Any], tree: Tree) -> None:
        """Store the result of a task.

        Args:
            key: Key of the task.
            result: Its result, as JSON.
            tree: Digests of its files.

        Raises:
            RunError: if the store cannot be reached.
        """
        text = json.dumps({"result": result, "files": tree})
        with self._using():
            self._write(f"{self._root}/trees/{key}.json", lambda path: self._fs.pipe_file(path, text.encode()))

    def kept(self, key: str) -> tuple[dict[str, Any], Tree] | None:
        """Return the result of a task, if it is known.

        Raises:
            RunError: if the store cannot be reached.
        """
        try:
            with self._using():
                text = self._fs.cat_file(f"{self._root}/trees/{key}.json")
            data = json.loads(text)
            return data["result"], data["files"]
        except (FileNotFoundError, ValueError, KeyError, TypeError):
            return None

    def _get(self, name: str, digest: str, folder: Path) -> None:
        target = folder / name
        if os.path.isabs(name) or ".." in Path(name).parts or not _DIGEST.match(digest):
            raise RunError(f"the store {self.url} has an invalid path or digest: {name[:80]!r}")
        if target.is_file() and sha256_of(target) == digest:
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(f".{os.getpid()}-{target.name}.part")
        try:
            with self._using():
                self._fs.get_file(self._blob(digest), str(part))
            if sha256_of(part) != digest:
                raise RunError(f"{name} is damaged in the store {self.url}")
            os.replace(part, target)
        except FileNotFoundError as error:
            raise RunError(f"{name} is missing in the store {self.url}") from error
        finally:
            part.unlink(missing_ok=True)

    def _upload(self, path: Path) -> str:
        digest = sha256_of(path)
        target = self._blob(digest)
        with self._using():
            if digest not in self._known and not self._fs.exists(target):
                self._write(target, lambda place: self._fs.put_file(str(path), place))
        self._known.add(digest)
        return digest

    @contextmanager
    def _using(self) -> Iterator[None]:
        """Turn errors, which each kind of store defines itself, into messages about this store.

        Raises:
            RunError: in place of any error except a missing file.
        """
        try:
            yield
        except (RunError, FileNotFoundError):
            raise
        except Exception as error:
            raise RunError(f"the store {self.url} cannot be used: {error}") from error

    def _blob(self, digest: str) -> str:
        """Path of a file. Object stores distribute load by prefixes of names."""
        return f"{self._root}/blobs/{digest[:2]}/{digest}"

    def _write(self, path: str, write: Callable[[str], Any]) -> None:
        """Write a file atomically, as object stores always do."""
        if not self._is_folder:
            write(path)
            return
        self._fs.makedirs(path.rpartition("/")[0], exist_ok=True)
        part = f"{path}.{os.getpid()}.{threading.get_ident()}"
        write(part)
        self._fs.mv(part, path)


def digest_of(tree: Tree) -> str:
    """Return the digest of a folder's content."""
    return sha256(json.dumps(tree, sort_keys=True).encode()).hexdigest()


def _files(folder: Path, skip: frozenset[str]) -> Iterator[tuple[str, Path]]:
    if folder.is_file():
        yield folder.name, folder
        return
    for root, folders, files in os.walk(folder):
        top = Path(root) == folder
        folders[:] = sorted(
            n
            for n in folders
            if not n.startswith(".") and not (top and n in skip) and not (Path(root) / n).is_symlink()
        )
        for name in sorted(files):
            path = Path(root) / name
            if not name.startswith(".") and not path.is_symlink():
                yield path.relative_to(folder).as_posix(), path
