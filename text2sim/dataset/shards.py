"""WebDataset shards: tar files with the files of each item in sequence, named by its key."""

import tarfile
from collections.abc import Iterator
from io import BytesIO
from itertools import groupby
from pathlib import Path


class ShardWriter:
    """Writes items to the shards of a split, with modification times of zero, so that equal items give equal files.

    Args:
        folder: Folder of the shards.
        split: Prefix of their names.
        max_bytes: Size above which the next shard begins [bytes].
    """

    def __init__(self, folder: Path, split: str, max_bytes: float):
        self._folder, self._split, self._max_bytes = folder, split, max_bytes
        self._tar: tarfile.TarFile | None = None
        self._count = 0
        folder.mkdir(parents=True, exist_ok=True)

    def add(self, key: str, folder: Path, extra: dict[str, bytes]) -> str:
        """Append the files of an item; return the name of the shard.

        Args:
            key: Key of the item.
            folder: Its files.
            extra: Further files by name.
        """
        if self._tar is None or self._tar.offset >= self._max_bytes:
            self.close()
            self._tar = tarfile.open(self._folder / f"{self._split}-{self._count:05d}.tar", "w")  # noqa: SIM115
            self._count += 1
        for path in sorted(path for path in folder.iterdir() if path.is_file()):
            info = tarfile.TarInfo(f"{key}.{path.name}")
            info.size = path.stat().st_size
            with path.open("rb") as file:
                self._tar.addfile(info, file)
        for name, content in sorted(extra.items()):
            info = tarfile.TarInfo(f"{key}.{name}")
            info.size = len(content)
            self._tar.addfile(info, BytesIO(content))
        return Path(str(self._tar.name)).name

    def close(self) -> None:
        """Complete the last shard."""
        if self._tar is not None:
            self._tar.close()
            self._tar = None


def read_shard(path: Path) -> Iterator[tuple[str, dict[str, bytes]]]:
    """Yield the items of a shard, one in memory at a time: key, and contents of files by name.

    Raises:
        tarfile.TarError: if it is not a shard.
    """
    with tarfile.open(path) as tar:
        for key, members in groupby(tar, lambda info: info.name.partition(".")[0]):
            files = {}
            for info in members:
                member = tar.extractfile(info)
                files[info.name.partition(".")[2]] = b"" if member is None else member.read()
            yield key, files
