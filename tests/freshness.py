"""Generated files, compared with what is committed."""

from pathlib import Path

import pytest


def assert_fresh(file: Path, text: str, command: str) -> None:
    """Fail with the command that writes a file if it is stale: a difference of thousands of lines would hide it."""
    if file.read_text("utf-8") != text:
        pytest.fail(f"{file.name} is stale; write it: {command}", pytrace=False)
