"""The pictures of a run on one sheet, numbered, for the Critic: those of the preview, or traced where there is none."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SHEET_WIDTH = 400
"""Of a picture on the sheet [pixels]."""
FRAMES = 12
"""Pictures on it at most, besides those of events."""
EVENTS = 4
"""Events that are shown at most, each when it happens first: between evenly spread pictures they would be missed."""
TRACED = 8
"""Pictures that are traced where OpenGL is missing: a second or two each."""


def frame_sheet(run: Path) -> tuple[Any, int]:
    """Return the pictures of a run as one, each with its number and time, and how many they are.

    Of several cameras each has its share, spread over the whole film; the main film is also shown at its first events.
    (None, 0) if there are no pictures.
    """
    from text2sim.harness.contact_sheet import contact_sheet

    rows = [*_kept(run), *_at_events(run)] or list(_traced(run))
    order = list(dict.fromkeys(camera for camera, *_ in rows))
    rows.sort(key=lambda row: (order.index(row[0]), row[1]))
    thumbnails = []
    for camera, time, said, picture in rows:
        picture.thumbnail((SHEET_WIDTH, 2 * SHEET_WIDTH))
        thumbnails.append((camera, f"frame {len(thumbnails) + 1}: {time:.2f} s{said}", picture))
    return (contact_sheet(thumbnails, width=SHEET_WIDTH) if thumbnails else None), len(thumbnails)


Row = tuple[str, float, str, Any]
"""Camera, time [s], what else is to be said, and the picture."""


def _read(path: Path) -> Iterator[Any]:
    """Yield the picture of a file, unless it is none."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            yield picture.convert("RGB")
    except (OSError, UnidentifiedImageError, Image.DecompressionBombError):
        return


def _kept(run: Path) -> Iterator[Row]:
    """Pictures that the preview has left."""
    from text2sim.harness.visibility import read_samples

    samples = read_samples(run)
    share = FRAMES // max(1, len(samples)) or 1
    for camera, rows in samples.items():
        for k in _spread(len(rows), share):
            for picture in _read(run / "frames" / f"{camera}_{k}.png"):
                yield camera, rows[k][0], "", picture


def _at_events(run: Path) -> Iterator[Row]:
    """Pictures of the preview's main film, each the first that shows an event."""
    import av.error

    from text2sim.templates.cadence import MAIN, frames, read_film, reels

    try:
        evidence = json.loads((run / "evidence.json").read_text("utf-8"))
        film = read_film((run / "program" / "render.py").read_text("utf-8"))
        pictures = frames(film, reels(film)[MAIN], float(evidence["time"]["reached"]))
        events = {name: row["first"] for name, row in evidence["events"].items() if row["first"] is not None}
        wanted: dict[int, list[str]] = {}
        for name, first in sorted(events.items(), key=lambda row: row[1])[:EVENTS]:
            shown = min((f.k for f in pictures if first <= f.t < first + 2 * f.speed / film["fps"]), default=None)
            if shown is not None:
                wanted.setdefault(shown, []).append(name)
        with av.open(str(run / f"{MAIN}.mp4")) as video:
            for k, picture in enumerate(video.decode(video=0)):
                if k in wanted:
                    frame = pictures[k]
                    yield frame.camera, frame.t, f" {', '.join(wanted.pop(k))}", picture.to_image()
                if not wanted:
                    return
    except (OSError, ValueError, TypeError, KeyError, AttributeError, av.error.FFmpegError):
        return  # a run without a film, or of another version: what the preview has left will do


def _traced(run: Path) -> Iterator[Row]:
    """Pictures of the main film from the path tracer; nothing where that cannot be done."""
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
    for frame, path in zip(chosen, paths, strict=True):
        for picture in _read(path):
            yield frame.camera, frame.t, "", picture


def _spread(count: int, share: int) -> list[int]:
    """At most `share` numbers below `count`, from the first to the last."""
    if count <= share:
        return list(range(count))
    return list(dict.fromkeys(round(k * (count - 1) / max(1, share - 1)) for k in range(share)))
