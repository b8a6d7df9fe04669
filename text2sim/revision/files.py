"""Atomic rewriting of case files, without overwriting changes that somebody else made."""

import os
from pathlib import Path

from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.text.source import Source, read_source
from text2sim.spec_schema.whole_files import write_atomically


def rewrite(file: Path, source: Source, text: str) -> None:
    """Replace the content of a file; its mode is kept.

    Args:
        file: The file.
        source: The content as it was read.
        text: The new text.

    Raises:
        RunError: If the file is a symbolic link, or has changed since it was read.
    """
    if file.is_symlink():
        raise RunError(f"{file}: is a symbolic link, which is not written through; name the file itself")
    if read_source(file).text != source.text:
        raise RunError(f"{file}: somebody else has changed it in the meantime; nothing was written")
    mode = file.stat().st_mode
    write_atomically(file, text)
    os.chmod(file, mode)
