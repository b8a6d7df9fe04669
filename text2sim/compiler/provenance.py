"""Finds the line of the case behind a traceback of its program."""

import re
from pathlib import Path

SECTIONS = ("scene.py", "bodies.py", "actions.py", "render.py")
"""Modules that are written from the sections of the case."""

# The interpreter's form, and that of faulthandler, which has no comma before `in`.
_FRAME = re.compile(r'^ *File "([^"\n]+)", line (\d+)(?:, in | in |$)', re.MULTILINE)
_MARK = re.compile(r"# case\.yaml:(\d+)")
_CRASH = re.compile(r"^(?:Fatal Python error|(?:Current thread|Thread) 0x\w+ .*most recent call first)", re.MULTILINE)


def provenance(program: Path, traceback: str) -> tuple[int, str] | None:
    """Return the line of the case to blame for a traceback, and the program's line of code; None if unknown.

    From the last frame in a module that was written from the case, the search goes up to the nearest
    `# case.yaml:23`, at most to the beginning of its function.

    Args:
        program: The folder of the program.
        traceback: Text that ends with a traceback, or with what faulthandler writes when native code crashes.
    """
    files = {}
    frames = []
    for found in _FRAME.finditer(traceback):
        path = Path(found[1])
        if path.name in SECTIONS and path.parent.name == program.name:
            frames.append((path.name, int(found[2])))
    if _CRASH.search(traceback):
        frames.reverse()
    for name, number in reversed(frames):
        if name not in files:
            try:
                files[name] = (program / name).read_text("utf-8").splitlines()
            except (OSError, UnicodeDecodeError):
                files[name] = []
        lines = files[name]
        if number <= len(lines) and (line := _nearest_mark(lines, number - 1)) is not None:
            return line, lines[number - 1].strip()
    return None


def _nearest_mark(lines: list[str], index: int) -> int | None:
    for row in range(index, -1, -1):
        if found := _MARK.search(lines[row]):
            return int(found[1])
        if lines[row].startswith(("def ", "class ")):
            return _mark_above(lines, row)
    return None


def _mark_above(lines: list[str], row: int) -> int | None:
    # The comment of a function stands right above it; what is farther up belongs to another.
    while row > 0 and lines[row - 1].startswith(("#", "@")):
        row -= 1
        if found := _MARK.search(lines[row]):
            return int(found[1])
    return None
