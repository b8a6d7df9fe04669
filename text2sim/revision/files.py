"""Case files that are written anew: at once or not at all, and never something else than what was read."""

import os
from pathlib import Path

from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.text.source import Source, read_source
from text2sim.spec_schema.whole_files import write_atomically


def rewrite(file: Path, source: Source, text: str) -> None:
    """Put a text in the place of the file that `source` was read from; its mode stays.

    Args:
        file: The file.
        source: What was read from it.
        text: The new text.

    Raises:
        RunError: If the file is a symbolic link, or was changed by somebody else since it was read.
    """
    if file.is_symlink():
        raise RunError(f"{file}: a symbolic link is not written through; name the file itself")
    if read_source(file).text != source.text:
        raise RunError(f"{file}: somebody else has changed it in the meantime; nothing was written")
    mode = file.stat().st_mode
    write_atomically(file, text)
    os.chmod(file, mode)
