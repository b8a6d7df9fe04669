"""Legibility of each body in rendered films.

    RUN/render/legibility.json     film -> sampled pictures -> bodies

Visibility is measured by `text2sim/legibility`; colours are those of the finished frames.
"""

import json
from typing import Any

from text2sim.legibility.film import Row, Watcher, read_picture
from text2sim.rendering.film import Filming, Reel
from text2sim.rendering.frames import save
from text2sim.templates.cadence import Frame


def write_legibility(filming: Filming, reels: list[Reel]) -> dict[str, list[Row]]:
    """Measure films, write the result beside them, and return it."""

    def finished(frame: Frame, size: tuple[int, int]) -> Any:
        path = filming.finished(frame)
        return read_picture(path, size) if path.is_file() else None

    watcher = Watcher(filming.recording, finished)
    found = {reel.name: watcher.rows(reel.frames) for reel in reels}
    text = json.dumps(found, indent=1, allow_nan=False) + "\n"
    save(filming.folder / "legibility.json", lambda part: part.write_text(text, "utf-8"))
    return found
