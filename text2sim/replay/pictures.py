"""Textures of bodies, scaled for a page."""

import tempfile
from functools import cache
from pathlib import Path

from text2sim.evidence.page import data_uri
from text2sim.exchange.files import save_picture
from text2sim.spec_schema.errors import RunError

MAX_SIDE = 512
"""Largest side of a picture [pixels]."""
MAX_TOTAL_SIZE = 2_000_000
"""Largest size of all pictures [characters]."""


class Pictures:
    """Collects pictures as data URIs.

    Attributes:
        uris: The URIs.
    """

    def __init__(self, notes: list[str]) -> None:
        self.uris: list[str] = []
        self.add = cache(self._take)
        """The index of a picture, by its path; None if it is too large or cannot be read."""
        self._notes = notes

    def _take(self, path: Path) -> int | None:
        with tempfile.TemporaryDirectory() as folder:
            small = Path(folder) / "picture.png"
            try:
                save_picture(path, small, MAX_SIDE)
            except RunError:
                self._notes.append(f"the picture {path.name} cannot be read")
                return None
            uri = data_uri(small, "image/png") or ""
        if len(uri) + sum(map(len, self.uris)) > MAX_TOTAL_SIZE:
            self._notes.append(f"the picture {path.name} is too large")
            return None
        self.uris.append(uri)
        return len(self.uris) - 1
