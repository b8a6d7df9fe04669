"""The pictures of a run on one sheet, numbered, for the Critic: those of the preview, or traced where there is none."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

SHEET_WIDTH = 400
"""Of a picture on the sheet [pixels]."""
FRAMES = 12
"""Pictures on it at most."""
TRACED = 8
"""Pictures that are traced where OpenGL is missing: a second or two each."""


def frame_sheet(run: Path) -> tuple[Any, int]:
    """Return the pictures of a run as one, each with its number and time, and how many they are.

    Of several cameras each has its share, spread over the whole film. (None, 0) if there are no pictures.
    """
    from PIL import Image, UnidentifiedImageError

    from text2sim.harness.contact_sheet import contact_sheet

    thumbnails = []
    for camera, time, path in list(_kept(run)) or list(_traced(run)):
        try:
            with Image.open(path) as picture:
                small = picture.convert("RGB")
        except (OSError, UnidentifiedImageError, Image.DecompressionBombError):
            continue
        small.thumbnail((SHEET_WIDTH, 2 * SHEET_WIDTH))
        thumbnails.append((camera, f"frame {len(thumbnails) + 1}: {time:.2f} s", small))
    return (contact_sheet(thumbnails, width=SHEET_WIDTH) if thumbnails else None), len(thumbnails)


def _kept(run: Path) -> Iterator[tuple[str, float, Path]]:
    """Pictures that the preview has left: camera, time [s], file."""
    from text2sim.harness.visibility import read_samples

    samples = read_samples(run)
    share = FRAMES // max(1, len(samples)) or 1
    for camera, rows in samples.items():
        for k in _spread(len(rows), share):
            path = run / "frames" / f"{camera}_{k}.png"
            if path.is_file():
                yield camera, rows[k][0], path


def _traced(run: Path) -> Iterator[tuple[str, float, Path]]:
    """The same from the path tracer; nothing where that cannot be done."""
    from text2sim.spec_schema.errors import Text2SimError

    try:
        from text2sim.rendering.film import Filming, Reel
        from text2sim.rendering.recording import read_recording

        recording = read_recording(run)
        width, height = recording.film["resolution"]
        filming = Filming(recording, "draft", size=(SHEET_WIDTH, max(2, round(SHEET_WIDTH * height / width))))
        reel = filming.reels()[0]
        chosen = [reel.frames[k] for k in _spread(len(reel.frames), TRACED)]
        paths = filming.render(Reel(reel.name, chosen), lambda progress: None)
    except (Text2SimError, ImportError, OSError):
        return
    yield from ((frame.camera, frame.t, path) for frame, path in zip(chosen, paths, strict=True))


def _spread(count: int, share: int) -> list[int]:
    """At most `share` numbers below `count`, from the first to the last."""
    if count <= share:
        return list(range(count))
    return list(dict.fromkeys(round(k * (count - 1) / max(1, share - 1)) for k in range(share)))
