"""The files of a program by their paths in its folder; slow ones are made when they are first read."""

from collections.abc import Callable, Iterator, MutableMapping


class Files(MutableMapping[str, bytes]):
    """Contents by path. A check only needs the names, a digest and the program need everything."""

    def __init__(self) -> None:
        self._contents: dict[str, bytes | Callable[[], str | bytes]] = {}

    def later(self, path: str, make: Callable[[], str | bytes]) -> None:
        """Add a file, unless there is one at that path; its content is made when it is first read."""
        self._contents.setdefault(path, make)

    def __getitem__(self, path: str) -> bytes:
        content = self._contents[path]
        if not isinstance(content, bytes):
            made = content()
            content = self._contents[path] = made.encode() if isinstance(made, str) else made
        return content

    def __setitem__(self, path: str, content: bytes) -> None:
        self._contents[path] = content

    def __delitem__(self, path: str) -> None:
        del self._contents[path]

    def __contains__(self, path: object) -> bool:
        return path in self._contents

    def __iter__(self) -> Iterator[str]:
        return iter(self._contents)

    def __len__(self) -> int:
        return len(self._contents)
