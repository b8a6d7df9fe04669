"""Atomic writes of exported files, and conversion of their pictures."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from text2sim.spec_schema.errors import RunError

MOST_TEXELS = 4096
"""Largest side of an exported picture [pixels]; larger ones are scaled down."""


@contextmanager
def temporary_folder_beside(path: Path) -> Iterator[Path]:
    """Make a temporary folder beside a file that will be written.

    Raises:
        RunError: if nothing can be written there.
        OSError: from the body of the `with`; for files in the folder, with the path of the file to write.
    """
    try:
        folder = Path(tempfile.mkdtemp(prefix=".text2sim-", dir=path.parent))
    except (FileNotFoundError, NotADirectoryError) as error:
        raise RunError(f"{path.parent}: there is no such folder") from error
    except PermissionError as error:
        raise RunError(f"{path.parent}: cannot write there: {error.strerror}") from error
    try:
        yield folder
    except OSError as error:
        if error.filename and not str(error.filename).startswith(str(folder)):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def move_into_place(finished: Path, path: Path) -> None:
    """Move a finished file to its place atomically.

    Raises:
        RunError: if its place is a folder.
    """
    if path.is_dir():
        raise RunError(f"{path} is a folder; name a file")
    os.replace(finished, path)


def save_picture(source: Path, path: Path, largest: int = MOST_TEXELS) -> bool:
    """Write a picture of a run as a PNG of limited size; return whether parts of it are transparent.

    Args:
        source: The picture.
        path: The file to write.
        largest: Largest side [pixels].

    Raises:
        RunError: if it is not a picture, or far too large.
    """
    from PIL import Image

    try:
        with Image.open(source) as picture:
            picture.draft("RGB", (largest, largest))
            image = picture.convert("RGBA" if "A" in picture.getbands() else "RGB")
        image.thumbnail((largest, largest))
        image.save(path, format="PNG")
        return image.mode == "RGBA" and image.getchannel("A").getextrema() != (255, 255)
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise RunError(f"{source}: not a picture that can be exported ({error})") from error
