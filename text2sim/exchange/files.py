"""Files that come into being whole or not at all."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from text2sim.spec_schema.errors import RunError

MOST_TEXELS = 4096
"""Largest side of a picture that is passed on; larger ones are made smaller."""


@contextmanager
def workplace(path: Path) -> Iterator[Path]:
    """A folder beside a file that is to be written, on the same disk; gone afterwards.

    Raises:
        RunError: if nothing can be written there.
        OSError: From the body of the `with`; a file in the folder has the name that it would get.
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


def put(made: Path, path: Path) -> None:
    """Move a file to its place in one step.

    Raises:
        RunError: if there is a folder of this name.
    """
    if path.is_dir():
        raise RunError(f"{path} is a folder; name a file")
    os.replace(made, path)


def save_picture(source: Path, path: Path, largest: int = MOST_TEXELS) -> bool:
    """Write a picture of a run as a PNG of at most `largest` pixels on each side; return whether it has holes.

    Args:
        source: The picture.
        path: The file to write.
        largest: Largest length of a side [pixels].

    Raises:
        RunError: if it is no picture, or one that is far too large.
    """
    from PIL import Image

    try:
        with Image.open(source) as picture:
            picture.draft("RGB", (largest, largest))
            made = picture.convert("RGBA" if "A" in picture.getbands() else "RGB")
        made.thumbnail((largest, largest))
        made.save(path, format="PNG")
        return made.mode == "RGBA" and made.getchannel("A").getextrema() != (255, 255)
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise RunError(f"{source}: not a picture that can be passed on ({error})") from error
