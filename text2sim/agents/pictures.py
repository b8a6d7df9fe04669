"""Sheet of numbered frames of a run for the Critic, path-traced or from the preview."""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import inf
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from text2sim.agents.frame_choice import FrameMoment, Shown, after_strikes, choose_frames, moments, with_attached
from text2sim.agents.models.exchange import MAX_IMAGE
from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.legibility.film import spread_numbers
from text2sim.recording.run_files import read_events
from text2sim.runtime.internal_errors import keep_details
from text2sim.spec_schema.errors import Text2SimError
from text2sim.spec_schema.text.source import read_source

if TYPE_CHECKING:
    from text2sim.legibility.recorded import Recorded
    from text2sim.rendering.film import Filming, FilmProgress, Reel

SHEET_WIDTH = 500
"""Width of a frame on the sheet [pixels]; tall frames, four in a row, have three quarters of it."""
MAX_FRAMES = 12
"""Largest number of frames on the sheet."""
MAX_CLOSE_UPS = 4
"""Largest number of close-ups on the sheet."""
MAX_CAPTION_REASONS = 2
"""Largest number of reasons in a caption; more would hide the frame."""
SMALL_SUBJECT = 0.2
"""Fraction of the frame below which its subject is also shown in close-up."""
LOCATING_WIDTH = 160
"""Width of the pictures in which bodies are located [pixels]."""
MAX_TRACING_TIME = 90.0
"""Time for tracing the frames, at one or two seconds each [s]."""
FEWEST_TRACED = 6
"""Smallest number of traced frames that are shown; if there is no time for them, the preview is used."""
MORE_TRACING_TIME = 240.0
"""Further time for that number, if it is enough [s]: a preview takes longer, since it makes all frames of the film."""

TRACED_NOTE = (
    "The frames are path-traced, as the film will be, but small and coarse; they stand in the order of time, not of "
    "shots, and `replay` is what the film shows again."
)
PREVIEWED_FINISHES = (None, "rough", "painted", "plastic", "smooth")
"""Finishes that a preview shows approximately."""
MAX_NAMED_LOOKS = 8
"""Largest number of bodies whose missing looks are named."""

Row = tuple[str, str, Any, Any]
"""Camera, caption, frame, and its close-up or None."""


def frame_sheet(run: Path, preview: Callable[[], Any] = lambda: None) -> tuple[Any, int, str]:
    """Return a sheet of a run's frames with numbers and times, the number of frames, and a note.

    The frames are the first and last of the main film, moments that decide expectations, events with the moments before
    and after, extremes of measures, the deepest overlap, and others between which much moves. Small subjects are also
    shown in close-up. (None, 0, "") if there are no frames.

    Args:
        run: The run folder.
        preview: Makes the preview of the film if it is missing; called if no frames can be traced in time.
    """
    from text2sim.evidence.contact_sheet import contact_sheet

    rows, note = list(_traced(run, MAX_TRACING_TIME, MORE_TRACING_TIME)), TRACED_NOTE
    if not rows:
        preview()
        rows, note = list(_filmed(run)) or list(_preview_frames(run)), _left_out(run)
    if not rows:  # no preview without OpenGL
        rows, note = list(_traced(run, inf)), TRACED_NOTE
    tall = any(picture.width < 1.4 * picture.height for _, _, picture, _ in rows)
    columns, width = (4, SHEET_WIDTH * 3 // 4) if tall else (3, SHEET_WIDTH)
    thumbnails, close = [], 0
    for number, (camera, said, picture, near) in enumerate(rows, 1):
        picture.thumbnail((width, 2 * width))
        thumbnails.append(("", f"frame {number}: {said} ({camera})", picture))
        if near is not None and close < MAX_CLOSE_UPS:
            close += 1
            thumbnails.append(("", f"frame {number}, close", near.resize(picture.size)))
    if not rows:
        return None, 0, ""
    return contact_sheet(thumbnails, width=width, columns=columns), len(rows), note


def sheet_png(sheet: Any) -> bytes:
    """Return a sheet as PNG, reduced until it is small enough for a model."""
    while len(content := picture_bytes(sheet, "PNG", optimize=True)) > MAX_IMAGE:
        sheet = sheet.resize((sheet.width * 3 // 4, sheet.height * 3 // 4))
    return content


def _read(path: Path) -> Any:
    """Read a picture; None if the file is not one."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            return picture.convert("RGB")
    except (OSError, UnidentifiedImageError, Image.DecompressionBombError):
        return None


def _filmed(run: Path) -> Iterator[Row]:
    """Yield the frames of the main film."""
    import av.error

    from text2sim.legibility.visible_motion import visible_motion
    from text2sim.templates.cadence import MAIN, frames, read_film, reels
    from text2sim.templates.directing import directed
    from text2sim.templates.playback import States

    try:
        film = read_film((run / "program" / "render.py").read_text("utf-8"))
        film = directed(film, States(run)) if film.get("auto") else film
        evidence = json.loads((run / "evidence.json").read_text("utf-8"))
        pictures = frames(film, reels(film)[MAIN], float(evidence["time"]["reached"]))
        locator = _locator(run)
        motion = visible_motion(locator[0].recording, pictures).tolist() if locator is not None else []
        shown = {
            one.frame.k: one for one in choose_frames(_moments_to_show(run, evidence), pictures, MAX_FRAMES, motion)
        }
        with av.open(str(run / f"{MAIN}.mp4")) as video:
            for k, picture in zip(range(max(shown) + 1), video.decode(video=0), strict=False):
                if k in shown:
                    whole = picture.to_image()
                    yield shown[k].frame.camera, _caption(shown[k]), whole, _close_up(locator, shown[k], whole)
    except (OSError, ValueError, TypeError, KeyError, AttributeError, av.error.FFmpegError):
        return  # a run without a film, or of another version: use the preview


def _moments_to_show(run: Path, evidence: dict[str, Any]) -> list[FrameMoment]:
    """Moments worth showing; the case need not be readable."""
    from text2sim.spec_schema.text.document import parse_document

    try:
        case = parse_document(read_source(run / "expanded.yaml")).data
        actions, statics = case.get("actions") or {}, (case.get("scene") or {}).get("statics") or {}
        strikes = after_strikes(read_events(run), statics)
    except Exception:  # noqa: BLE001 - names of bodies are only for close views
        actions, strikes = {}, []
    return [replace(one, bodies=with_attached(one.bodies, actions)) for one in moments(evidence, actions, strikes)]


def _caption(one: Shown) -> str:
    reasons = [*dict.fromkeys(one.reasons)]
    return ", ".join(
        [f"{one.frame.t:.2f} s", *reasons[:MAX_CAPTION_REASONS], *(["…"] if reasons[MAX_CAPTION_REASONS:] else [])]
    )


def _locator(run: Path) -> "tuple[Recorded, Any] | None":
    """Recording and views for locating bodies in frames; None if that is impossible."""
    try:
        from text2sim.legibility.recorded import Recorded
        from text2sim.recording.film_record import read_recording
        from text2sim.templates.cameras import Cameras

        recording = read_recording(run)
        return Recorded(recording), Cameras(recording.film, recording.states)
    except (Text2SimError, ImportError, OSError, ValueError, KeyError, TypeError):
        return None


def _close_up(locator: "tuple[Recorded, Any] | None", one: Shown, picture: Any) -> Any:
    """A close-up of a moment's bodies; None if they are large, out of sight, or unknown."""
    import numpy as np

    if locator is None or not one.bodies:
        return None
    recorded, cameras = locator
    wide, tall = picture.size
    view = cameras.view(one.frame.camera, one.frame.t, one.frame.part)
    sight = recorded.sight(one.frame.t, view, (LOCATING_WIDTH, max(2, round(LOCATING_WIDTH * tall / wide))))
    about = [k for k, name in enumerate(recorded.names) if name in one.bodies and name not in recorded.statics]
    if not about:
        return None
    rows, columns = np.nonzero(np.logical_or.reduce([sight.mask(k) for k in about]))
    if not len(rows):
        return None
    scale = wide / LOCATING_WIDTH
    # Half the width of the crop: that of the bodies with a margin of 30 %, at the aspect ratio of the picture.
    half = max((np.ptp(columns) + 1) * scale, (np.ptp(rows) + 1) * scale * wide / tall, wide / 4) * 0.65
    if half > SMALL_SUBJECT**0.5 * wide / 2 * 1.3:
        return None
    x = float(np.clip((columns.min() + columns.max() + 1) / 2 * scale, half, wide - half))
    high = half * tall / wide
    y = float(np.clip((rows.min() + rows.max() + 1) / 2 * scale, high, tall - high))
    return picture.crop((round(x - half), round(y - high), round(x + half), round(y + high)))


def _preview_frames(run: Path) -> Iterator[Row]:
    """Yield the frames stored by the preview."""
    from text2sim.evidence.visibility import read_samples

    samples = read_samples(run)
    share = MAX_FRAMES // max(1, len(samples)) or 1
    for camera, rows in samples.items():
        for k in spread_numbers(len(rows), share):
            picture = _read(run / "frames" / f"{camera}_{k}.png")
            if picture is not None:
                yield camera, f"{rows[k][0]:.2f} s", picture, None


def _traced(run: Path, seconds: float, more: float = 0.0) -> Iterator[Row]:
    """Yield the path-traced frames of the main film that are finished in time; none if these are too few.

    Args:
        run: The run folder.
        seconds: Time for all frames [s].
        more: Further time for `FEWEST_TRACED` of them [s].
    """
    try:
        from PIL import Image

        from text2sim.legibility.visible_motion import visible_motion
        from text2sim.recording.film_record import read_recording
        from text2sim.rendering.film import Filming, Reel

        recording = read_recording(run)
        width, height = recording.film["resolution"]
        filming = Filming(recording, "draft", size=(SHEET_WIDTH, max(2, round(SHEET_WIDTH * height / width / 2) * 2)))
        reel = filming.reels()[0]
        motion = visible_motion(recording, reel.frames).tolist()
        shown = choose_frames(moments_of(run), reel.frames, MAX_FRAMES, motion)
        fewest = min(FEWEST_TRACED, len(shown))
        _trace(filming, filming.excerpt(reel, [one.frame for one in shown]), fewest, seconds, more)
        traced = [one for one in shown if filming.finished(one.frame).is_file()]
        if len(traced) < fewest:
            return
        few = Reel(reel.name, [one.frame for one in traced])
        pictures = [Image.fromarray(picture) for picture in filming.pictures(few, filming.rendered(few))]
    except (Text2SimError, ImportError, OSError):
        return
    except Exception as error:  # noqa: BLE001 - an internal error must not end the loop; the preview is used
        keep_details(error)
        return
    locator = _locator(run)
    for one, picture in zip(traced, pictures, strict=True):
        yield one.frame.camera, _caption(one), picture, _close_up(locator, one, picture)


def _trace(filming: "Filming", reel: "Reel", fewest: int, seconds: float, more: float) -> None:
    """Trace frames for a time [s], and for `more` seconds if `fewest` of them will be finished by then."""
    took: list[float] = []
    done = 0

    def tell(progress: "FilmProgress") -> None:
        nonlocal done
        done = progress.done
        if progress.seconds:  # the background of a camera is shared by the frames after the first one
            took.append(sum(time for step, time in progress.seconds.items() if step != "background"))

    filming.render(reel, tell, until=monotonic() + seconds)
    if done == 1 < fewest:  # a second one tells how long they take: the first also compiles the tracer's kernels
        filming.render(reel, tell, until=monotonic() + 1.0)
    if done < fewest and (fewest - done) * min(took, default=inf) <= more:
        filming.render(reel, tell, until=monotonic() + more)


def _left_out(run: Path) -> str:
    """Describe the looks that a preview does not show."""
    try:
        looks = json.loads((run / "program" / "looks.json").read_text("utf-8"))
        unshown = {name: _unshown(look) for name, look in looks.items() if "looks" not in look}
    except (OSError, ValueError, TypeError, AttributeError):
        unshown = {}
    rows = [f"{words} of `{name}`" for name, words in unshown.items() if words][:MAX_NAMED_LOOKS]
    some = f", so also {'; '.join(rows)}" if rows else ""
    return (
        "The frames are of the preview, which leaves out shadows, the place around, finishes, patterns, labels and how "
        f"clear a liquid is{some}: judge such looks by the case."
    )


def _unshown(look: dict[str, Any]) -> str:
    """The parts of a look that only the path tracer shows."""
    words = [f"the {key}" for key in ("pattern", "label") if look.get(key)]
    return " and ".join([*([look["finish"]] if look.get("finish") not in PREVIEWED_FINISHES else []), *words])


def moments_of(run: Path) -> list[FrameMoment]:
    """Return the moments of a run that are worth showing; empty without evidence."""
    try:
        return _moments_to_show(run, json.loads((run / "evidence.json").read_text("utf-8")))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return []
