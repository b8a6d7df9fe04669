"""Reports of internal errors, kept where only their user can read them."""

import os
import platform
import sys
import traceback
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

from text2sim import __version__
from text2sim.spec_schema.whole_files import user_cache


def keep_details(error: BaseException) -> str:
    """Save what a maintainer needs: versions, arguments and traceback, but no environment variables.

    Returns:
        The file, in the user's cache folder, one for each error; empty if it could not be written.
    """
    text = (
        f"text2sim {__version__}, Python {platform.python_version()}, {platform.system()} {platform.machine()}\n"
        f"arguments: {sys.argv[1:]}\n\n{''.join(traceback.format_exception(error))}"
    )
    with suppress(OSError, RuntimeError):  # there may be no home at all
        home = Path.home()
        text = text.replace(str(home), "~") if len(home.parts) > 1 else text
    with suppress(OSError, RuntimeError):
        folder = user_cache() / "text2sim" / "bugs"
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        data = text.encode("utf-8", "backslashreplace")
        path = folder / f"{sha256(data).hexdigest()[:12]}.txt"
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_NOFOLLOW", 0), 0o600)
        with open(descriptor, "wb") as stream:
            stream.write(data)
        return str(path)
    return ""


def internal_error_message(error: BaseException) -> str:
    """Return the message for an internal error, with the command that prints what to send us."""
    file = keep_details(error)
    words = f"internal error, which is our bug: {type(error).__name__}: {error}"
    return f"{words}; please send us what `cat {file}` prints" if file else words
