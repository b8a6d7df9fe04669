"""Contact sheet: frames sampled from the film, side by side, each with its time."""

import re
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

from text2sim.evidence.visibility import read_samples
from text2sim.spec_schema.whole_files import naming

if TYPE_CHECKING:
    from PIL.Image import Image

LETTER_WIDTH = 8
"""Width of a letter in a label [pixels]; most are narrower."""
PICTURE_WIDTH = 320
"""Width of a picture [pixels]."""
COLUMNS = 4
GAP = 4
"""Space between pictures [pixels]."""
LINE_HEIGHT = 19
"""Height of a line above a picture [pixels]."""
MAX_PICTURES = 96
"""Most pictures."""
_FRAME = re.compile(r"(?P<camera>\w+)_(?P<number>\d{1,5})\.png\Z")


def write_contact_sheet(run_dir: Path) -> Path | None:
    """Write `contact_sheet.png` from `frames/`; return its path, or None if there are no frames."""
    from PIL import Image, UnidentifiedImageError

    target = run_dir / "contact_sheet.png"
    target.unlink(missing_ok=True)
    samples = read_samples(run_dir)
    thumbnails = []
    for camera, number, path in _frames(run_dir / "frames")[:MAX_PICTURES]:
        try:
            with Image.open(path) as picture:
                small = picture.convert("RGB")
        except (OSError, UnidentifiedImageError, Image.DecompressionBombError):
            continue  # truncated file: show the others
        small.thumbnail((PICTURE_WIDTH, 2 * PICTURE_WIDTH))
        known = samples.get(camera, [])
        time = f"{known[number][0]:.2f} s" if number < len(known) else f"no. {number}"
        thumbnails.append((camera, time, small))
    if not thumbnails:
        return None
    with naming(target):
        contact_sheet(thumbnails).save(target, optimize=True)
    return target


def contact_sheet(
    thumbnails: "list[tuple[str, str, Image]]", *, width: int = PICTURE_WIDTH, columns: int = COLUMNS
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
    labels = [["\n".join(wrap(time if len(cameras) == 1 else f"{camera}  {time}", width // LETTER_WIDTH))
               for camera, time, _ in row] for row in rows]  # fmt: skip
    # Labels stand above pictures, so that they hide nothing.
    above = [LINE_HEIGHT * max(label.count("\n") + 1 for label in row) + GAP for row in labels]
    size = (max(map(len, rows)) * (width + GAP) + GAP, sum(above) + len(rows) * (height + GAP) + GAP)
    sheet = Image.new("RGB", size, "#202428")
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default(size=15)
    top = GAP
    for row, said, strip in zip(rows, labels, above, strict=True):
        for x, ((_, _, small), label) in enumerate(zip(row, said, strict=True)):
            left = GAP + x * (width + GAP)
            draw.text((left, top), label, font=font, fill="white", spacing=LINE_HEIGHT - 15)
            sheet.paste(small, (left, top + strip))
        top += strip + height + GAP
    return sheet


def _frames(folder: Path) -> list[tuple[str, int, Path]]:
    found = ((_FRAME.match(path.name), path) for path in folder.glob("*.png"))
    return sorted((match["camera"], int(match["number"]), path) for match, path in found if match is not None)
