"""Cache of finished frames on disk, named by digests of their inputs, so that unchanged ones are not traced again."""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from time import time
from typing import Any

import numpy as np

from text2sim.recording.film_record import FilmRecord, SurfaceLook
from text2sim.rendering.offstage import offstage, views_of
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.trace import Quality
from text2sim.spec_schema.whole_files import replacing
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras

DRAWING_VERSION = 63
"""Version of this package's output; incremented whenever it draws the same scene differently."""
ABANDONED = 3600.0
"""Age [s] from which an incomplete file counts as abandoned."""
SHOWN = ("lights", "background", "backdrop", "gain", "tone", "springs")
"""Keys of the film section that every picture depends on."""


class Digests:
    """Digests of everything that a frame's pixels depend on.

    Args:
        recording: The recording of the run.
        quality: Quality of the frames.
        size: Width and height [pixels].
    """

    def __init__(self, recording: FilmRecord, quality: Quality, size: tuple[int, int]):
        self._recording, self._quality = recording, quality
        self._cameras = Cameras(recording.film, recording.states)
        # The name of a mesh is a digest of its content, see `templates/files.py`.
        parts = [(p.body, p.link, p.mesh.name, p.pos, p.quat, *_look_key(p.look)) for p in recording.parts]
        parts += [(p.body, p.surface_velocity) for p in recording.parts if p.surface_velocity]
        springs = recording.states.layout.get("springs", []) if recording.film.get("springs") else []
        self._timed = bool(springs) or any(p.surface_velocity for p in recording.parts)
        soft = [
            (p.body, p.row, _content(p.geometry), *_look_key(p.look), _content(p.regions), *map(_look_key, p.parts))
            for p in recording.soft
        ]
        film = {name: recording.film.get(name) for name in SHOWN}
        statics = sorted(recording.statics), sorted(offstage(recording, views_of(recording)))
        self._common = hashlib.sha256(
            json.dumps(
                [DRAWING_VERSION, film, size, vars(quality), parts, soft, springs, *statics], default=str
            ).encode()
        )

    def __call__(self, frame: Frame, samples: int, reference: Frame | None = None) -> str:
        """Return the digest of a frame.

        Args:
            frame: The frame.
            samples: Its samples per pixel.
            reference: The frame whose background it shows; None without one.
        """
        states, digest = self._recording.states, self._common.copy()
        digest.update(str(samples).encode())
        behind = [] if reference is None else [(reference.t, reference.part)]
        for t, part in [*frame.moments(self._quality.blur), *behind]:
            view = self._cameras.view(frame.camera, t, part)
            arrays: list[Any] = [*states.poses(t), *view, *([np.array(t)] if self._timed else [])]
            if states.soft is not None:
                arrays += [states.soft.at(name, states.around(t)) for name in ("soft_points", "soft_surface")]
            for array in arrays:
                digest.update(np.ascontiguousarray(array, np.float32).tobytes())
        return digest.hexdigest()[:20]


def remove_abandoned(folder: Path) -> None:
    """Remove incomplete files of killed processes."""
    for part in folder.glob(".*-*"):
        try:
            if time() - part.stat().st_mtime > ABANDONED:
                part.unlink()
        except OSError:
            continue  # removed by another process


def save(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file atomically; `write` writes its content to a given path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as part:
        write(part)


def write_radiance(path: Path, layers: np.ndarray) -> None:
    """Write layers (height, width, 4) of 32-bit floats as an EXR file.

    Raises:
        OSError: If it cannot be written; Mitsuba itself would raise another exception.
    """
    mi = mitsuba()
    stream = mi.MemoryStream()
    mi.Bitmap(layers).write(stream, mi.Bitmap.FileFormat.OpenEXR)
    path.write_bytes(stream.raw_buffer())


def _look_key(look: SurfaceLook | None) -> tuple[Any, ...]:
    if look is None:
        return ()
    picture = _content(look.picture)
    return look.color, look.opacity, look.finish, look.visible, picture, look.decoration, look.alike, look.cut


def _content(path: Path | None) -> str:
    return "" if path is None or not path.is_file() else hashlib.sha256(path.read_bytes()).hexdigest()[:16]
