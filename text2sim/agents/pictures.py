"""The pictures of a run on one sheet, numbered, for the Critic: those of the preview, or traced where there is none."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.legibility.film import nearest_frame, spread

if TYPE_CHECKING:
    from text2sim.templates.cadence import Frame

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


def _read(path: Path) -> Any:
    """Return the picture of a file, None if it is none."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            return picture.convert("RGB")
    except (OSError, UnidentifiedImageError, Image.DecompressionBombError):
        return None


def _kept(run: Path) -> Iterator[Row]:
    """Pictures that the preview has left."""
    from text2sim.harness.visibility import read_samples

    samples = read_samples(run)
    share = FRAMES // max(1, len(samples)) or 1
    for camera, rows in samples.items():
        for k in spread(len(rows), share):
            picture = _read(run / "frames" / f"{camera}_{k}.png")
            if picture is not None:
                yield camera, rows[k][0], "", picture


def _at_events(run: Path) -> Iterator[Row]:
    """Pictures of the preview's main film at events."""
    import av.error

    from text2sim.templates.cadence import MAIN, frames, read_film, reels
    from text2sim.templates.directing import directed
    from text2sim.templates.playback import States

    try:
        film = read_film((run / "program" / "render.py").read_text("utf-8"))
        film = directed(film, States(run)) if film.get("auto") else film
        evidence = json.loads((run / "evidence.json").read_text("utf-8"))
        pictures = frames(film, reels(film)[MAIN], float(evidence["time"]["reached"]))
        wanted = _events(evidence, pictures)
        last = max((frame.k for frame in wanted), default=-1)
        with av.open(str(run / f"{MAIN}.mp4")) as video:
            for frame, picture in zip(pictures[: last + 1], video.decode(video=0), strict=False):
                if frame in wanted:
                    yield frame.camera, frame.t, wanted[frame], picture.to_image()
    except (OSError, ValueError, TypeError, KeyError, AttributeError, av.error.FFmpegError):
        return  # a run without a film, or of another version: what the preview has left will do


def _events(evidence: dict[str, Any], pictures: Sequence["Frame"]) -> "dict[Frame, str]":
    """Return the pictures that show the first events, and the names of those.

    Raises:
        TypeError, KeyError, AttributeError: if the evidence is not as this version writes it.
    """
    events = {name: row["first"] for name, row in evidence["events"].items() if row["first"] is not None}
    found: dict[Frame, str] = {}
    for name, first in sorted(events.items(), key=lambda row: row[1])[:EVENTS]:
        frame = nearest_frame(pictures, first)
        if frame is not None:
            found[frame] = f"{found[frame]}, {name}" if frame in found else f" {name}"
    return found


def _told(run: Path, pictures: Sequence["Frame"]) -> "dict[Frame, str]":
    """Return `_events`; nothing if the run was not judged."""
    try:
        return _events(json.loads((run / "evidence.json").read_text("utf-8")), pictures)
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return {}


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
        events = _told(run, reel.frames)
        evenly = (reel.frames[k] for k in spread(len(reel.frames), TRACED))
        chosen = list(dict.fromkeys([*evenly, *events]))
        paths = filming.render(Reel(reel.name, chosen), lambda progress: None)
    except (Text2SimError, ImportError, OSError):
        return
    for frame, path in zip(chosen, paths, strict=True):
        picture = _read(path)
        if picture is not None:
            yield frame.camera, frame.t, events.get(frame, ""), picture
