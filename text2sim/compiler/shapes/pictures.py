"""Pictures of a case: found, checked and limited, since they may come from anybody."""

import warnings
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.compiler.shapes.meshfile import case_path, errors_about
from text2sim.spec_schema.errors import AssetError

if TYPE_CHECKING:
    from PIL.Image import Image

SUFFIXES = (".png", ".jpg", ".jpeg")
MAX_BYTES = 16 * 1024 * 1024
MAX_PIXELS, MAX_SIDE = 25_000_000, 20_000
MAX_USEFUL_SIDE = 2400
"""Pixels of the longer side beyond which more make no visible difference."""

PREVIEW_SIDE = 512
"""Pixels of the longer side of a picture as `show` draws it."""


def picture_path(file: str, folder: Path) -> Path:
    """Return where a picture of a case is.

    Raises:
        AssetError: if it is not in the case's folder, is too large, or is not a .png or .jpg.
    """
    return case_path(file, folder, "picture", SUFFIXES, MAX_BYTES)[0]


def open_picture(path: Path) -> "Image":
    """Read a picture, turned upright by its EXIF data.

    Raises:
        AssetError: if it cannot be read, or has too many pixels; a file of a few kilobytes can have billions.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError

    advice = f"at most {MAX_PIXELS:,}: make it smaller, {MAX_USEFUL_SIDE} along its longer side are enough"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path, formats=("PNG", "JPEG")) as image:
                wide, tall = image.size
                if wide * tall > MAX_PIXELS:
                    raise AssetError(f"has too many pixels ({wide} x {tall}), {advice}")
                if max(wide, tall) > MAX_SIDE:
                    raise AssetError(f"is {wide} x {tall} pixels; at most {MAX_SIDE:,} along a side are possible")
                image.load()
                return ImageOps.exif_transpose(image)
    except AssetError:
        raise
    except Image.DecompressionBombError:
        raise AssetError(f"has too many pixels, {advice}") from None
    except UnidentifiedImageError:
        raise AssetError("cannot be read: it is not a picture, despite its name; a .png or .jpg is needed") from None
    except Exception as error:  # readers of foreign files fail in every way there is
        raise AssetError(f"cannot be read ({type(error).__name__}: {str(error)[:120]})") from error


def pixels_of(path: Path) -> int:
    """Return how many pixels a picture has, from its header; 0 if that cannot be read."""
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path, formats=("PNG", "JPEG")) as image:
                return image.size[0] * image.size[1]
    except Exception:  # whoever reads it says what is wrong
        return 0


def thumbnail(file: str, folder: Path, side: int) -> bytes:
    """Return a picture of a case as a .png in three channels, at most `side` pixels long.

    Args:
        file: The picture, relative to the case.
        folder: Folder of the case.
        side: Largest length of a side [pixels].

    Raises:
        AssetError: if it cannot be used.
    """
    path = picture_path(file, folder)
    stat = path.stat()
    with errors_about(f"picture file `{file}`"):
        return _thumbnail(path, side, stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=32)
def _thumbnail(path: Path, side: int, _mtime: int, _size: int) -> bytes:
    image = open_picture(path).convert("RGB")
    image.thumbnail((side, side))
    return picture_bytes(image, "PNG", compress_level=1)  # read again at once: speed matters, not size


def picture_bytes(picture: "Image", kind: str, **options: Any) -> bytes:
    """Return a picture as the content of a file.

    Args:
        picture: The picture.
        kind: Format of the file, such as `PNG`.
        options: How it is saved; see Pillow.
    """
    stream = BytesIO()
    picture.save(stream, kind, **options)
    return stream.getvalue()
