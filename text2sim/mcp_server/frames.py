"""Tool that shows pictures of a film side by side, each with its simulated time."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.mcp_server.answers import ToolAnswer, jpeg
from text2sim.mcp_server.workspace import Workspace, is_file, read_file
from text2sim.recording.record import RunRecord
from text2sim.spec_schema.errors import RunError
from text2sim.templates.cadence import MAIN, Frame, frames, read_film, reels
from text2sim.templates.directing import directed
from text2sim.templates.playback import States

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_SHEET_PICTURES = 16
"""Largest number of pictures on a sheet."""
WIDTH_OF_FEW, WIDTH_OF_MANY = 640, 320
"""Width of a picture [pixels] if there are up to `MAX_FEW`, and if there are more."""
MAX_FEW = 4
MAX_FILM = 2_000_000_000
"""Size of a film [bytes]."""
MAX_PICTURES = 100_000
"""Largest number of pictures of a film, whose description is untrusted."""
MAX_SIDE = 8192
"""Side of a film [pixels]."""


def frames_of(workspace: Workspace, run: str, times: list[float], count: int, camera: str) -> ToolAnswer:
    """Show pictures of a run's film.

    Args:
        workspace: The workspace.
        run: The run, or a case, for its newest run.
        times: Simulated times [s], for each of which the nearest picture is shown.
        count: Number of pictures, spread over the film, if there are no times.
        camera: Name of a camera; the main film if empty.

    Raises:
        RunError: if there is no film, or no such camera.
    """
    folder = workspace.run_folder(run)
    reel, pictures = _pictures(folder, camera)
    wanted = _chosen(pictures, times[:MAX_SHEET_PICTURES], min(max(count, 1), MAX_SHEET_PICTURES))
    film = _film(folder, reel)
    found = _decoded(film, wanted, WIDTH_OF_FEW if len(wanted) <= MAX_FEW else WIDTH_OF_MANY)
    if not found:
        raise RunError(f"{film} has no readable pictures; run the case again")
    thumbnails = [(frame.camera, f"{frame.t:.3g} s", image) for frame, image in found]
    document: dict[str, Any] = {
        "run": folder.name,
        "film": str(film),
        "shown": [{"t": round(frame.t, 4), "camera": frame.camera} for frame, _ in found],
        "film_covers": [round(min(p.t for p in pictures), 4), round(max(p.t for p in pictures), 4)],
        "pictures": len(pictures),
    }
    return ToolAnswer(document, picture=jpeg(_sheet(thumbnails)), media="image/jpeg")


def _sheet(thumbnails: "list[tuple[str, str, Image]]") -> "Image":
    from text2sim.evidence.contact_sheet import contact_sheet

    width = max(image.width for _, _, image in thumbnails)
    return contact_sheet(thumbnails, width=width, columns=2 if len(thumbnails) <= MAX_FEW else 4)


def _pictures(folder: Path, camera: str) -> tuple[str, list[Frame]]:
    """The film that shows a camera, and its pictures of that camera."""
    text = (read_file(folder / "program" / "render.py", 2_000_000) or b"").decode("utf-8", "replace")
    record = RunRecord.read(folder)
    if not text or record is None:
        raise RunError(f"{folder} is not the folder of a run with a film")
    try:
        film = read_film(text)
        film = directed(film, States(folder)) if film.get("auto") else film
        films = reels(film)
        if camera and camera not in film["cameras"]:
            raise RunError(f"there is no camera `{camera[:80]}`; there are {', '.join(film['cameras'])}")
        reel = f"{MAIN}_{camera}" if f"{MAIN}_{camera}" in films else MAIN
        if sum(_length(film, shot) for shot in films[reel]) > MAX_PICTURES:
            raise RunError(f"the film of {folder} is too long to show")
        last = record.time or float(film["end"])
        pictures = [picture for picture in frames(film, films[reel], last) if not camera or picture.camera == camera]
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError, OSError) as error:
        raise RunError(f"{folder / 'program' / 'render.py'} describes no film: {error!r}") from None
    if not pictures:
        raise RunError(f"the film has no pictures of `{camera}`")
    return reel, pictures


def _length(film: dict[str, Any], shot: dict[str, Any]) -> float:
    return abs(shot["to"] - shot["from"]) * film["fps"] / shot["speed"] + shot["hold"] * film["fps"] + 1


def _chosen(pictures: list[Frame], times: list[float], count: int) -> list[Frame]:
    """The pictures nearest to some times, or a number of evenly spread ones, in the order of the film."""
    if times:
        # Limited to the end of the film: for huge numbers, rounding would make all pictures equally near.
        last = max(picture.t for picture in pictures)
        near = [min(pictures, key=lambda picture: abs(picture.t - min(time, last))) for time in times]
    else:
        steps = max(count - 1, 1)
        near = [pictures[round(i * (len(pictures) - 1) / steps)] for i in range(count)]
    return sorted({frame.k: frame for frame in near}.values())


def _film(folder: Path, reel: str) -> Path:
    suffix = reel.removeprefix(MAIN)
    # The preview comes first, because it always shows the current case.
    for place in (reel, f"render/final{suffix}", f"render/draft{suffix}"):
        path = folder / f"{place}.mp4"
        if is_file(path, MAX_FILM):
            return path
    raise RunError(
        f"{folder} has no film: run the case with film: true, which films the recording, or, on a machine "
        f"without OpenGL, use `text2sim render {folder}`"
    )


def _decoded(film: Path, wanted: list[Frame], width: int) -> "list[tuple[Frame, Image]]":
    """Scaled pictures of a film, without those beyond its end."""
    import av
    from av.error import FFmpegError

    by_number = {frame.k: frame for frame in wanted}
    found = []
    try:
        with av.open(str(film)) as container:
            stream = container.streams.video[0]
            if not 0 < stream.width <= MAX_SIDE or not 0 < stream.height <= MAX_SIDE:
                raise RunError(f"{film} is not a film of ours: {stream.width} x {stream.height} pixels")
            size = min(width, stream.width)
            tall = max(2, min(round(stream.height * size / stream.width), 2 * width))
            stream.thread_type = "AUTO"
            for number, picture in enumerate(container.decode(stream)):
                if number in by_number:
                    found.append((by_number[number], picture.to_image(width=size, height=tall)))
                if len(found) == len(by_number):
                    break
    except (FFmpegError, IndexError) as error:
        raise RunError(f"{film} cannot be read: {error}") from None
    return found
