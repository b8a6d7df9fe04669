"""Contact sheet: frames sampled from the film, side by side, each with its time."""

import re
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

from text2sim.evidence.visibility import read_samples
from text2sim.spec_schema.whole_files import naming

if TYPE_CHECKING:
    from PIL.Image import Image

LETTER = 8
"""Width of a letter in what stands on a picture [pixels]; most are narrower."""
THUMBNAIL = 320
"""Width of a picture [pixels]."""
COLUMNS = 4
MOST = 96
"""Pictures at most."""
_FRAME = re.compile(r"(?P<camera>\w+)_(?P<number>\d{1,5})\.png\Z")


def write_contact_sheet(run_dir: Path) -> Path | None:
    """Write `contact_sheet.png` from `frames/`; return its path, or None if there are no frames."""
    from PIL import Image, UnidentifiedImageError

    target = run_dir / "contact_sheet.png"
    target.unlink(missing_ok=True)
    samples = read_samples(run_dir)
    thumbnails = []
    for camera, number, path in _frames(run_dir / "frames")[:MOST]:
        try:
            with Image.open(path) as picture:
                small = picture.convert("RGB")
        except (OSError, UnidentifiedImageError, Image.DecompressionBombError):
            continue  # truncated file: show the others
        small.thumbnail((THUMBNAIL, 2 * THUMBNAIL))
        known = samples.get(camera, [])
        time = f"{known[number][0]:.2f} s" if number < len(known) else f"no. {number}"
        thumbnails.append((camera, time, small))
    if not thumbnails:
        return None
    with naming(target):
        contact_sheet(thumbnails).save(target, optimize=True)
    return target


def contact_sheet(
    thumbnails: "list[tuple[str, str, Image]]", *, width: int = THUMBNAIL, columns: int = COLUMNS
) -> "Image":
    """Return pictures side by side, grouped by camera.

    Args:
        thumbnails: Camera, label of the time, and picture, none wider than `width`.
        width: Width of a picture [pixels].
        columns: Largest number of pictures in a row.
    """
    from PIL import Image, ImageDraw, ImageFont

    cameras = list(dict.fromkeys(camera for camera, _, _ in thumbnails))
    height = max(small.height for _, _, small in thumbnails)
    rows = [
        part[first : first + columns]
        for part in ([row for row in thumbnails if row[0] == camera] for camera in cameras)
        for first in range(0, len(part), columns)
    ]
    across = max(map(len, rows))
    gap = 4
    sheet = Image.new("RGB", (across * (width + gap) + gap, len(rows) * (height + gap) + gap), "#202428")
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(size=15)
    for y, row in enumerate(rows):
        for x, (camera, time, small) in enumerate(row):
            corner = (gap + x * (width + gap), gap + y * (height + gap))
            sheet.paste(small, corner)
            label = "\n".join(wrap(time if len(cameras) == 1 else f"{camera}  {time}", width // LETTER))
            box = draw.textbbox((corner[0] + 6, corner[1] + 4), label, font=font)
            draw.rectangle((box[0] - 4, box[1] - 3, box[2] + 4, box[3] + 3), fill="#202428")
            draw.text((corner[0] + 6, corner[1] + 4), label, font=font, fill="white")
    return sheet


def _frames(folder: Path) -> list[tuple[str, int, Path]]:
    found = []
    for path in folder.glob("*.png"):
        match = _FRAME.match(path.name)
        if match is not None:
            found.append((match["camera"], int(match["number"]), path))
    return sorted(found)
