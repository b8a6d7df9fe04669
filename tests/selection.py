"""Which of the expensive tests a change is tried with: those that it concerns, and a share of the others that rotates.

    pytest --since REVISION [--share 5] [--minutes 10]

A file of tests is concerned if it, or something in its folder that is not a test, was changed since the revision, or
something in a folder of the package that it is about. Of the other files every fifth is taken, another fifth after the
next commit. A test with the mark `about(FOLDER)` counts like a file of its own, which that folder concerns. Files that were changed come first, then what is concerned, then the share. What would begin after so many
minutes is skipped, and said so; so is a test that may take longer than the usual timeout.
"""

import os
import subprocess
import time
import zlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
DEADLINE = "TEXT2SIM_TESTS_UNTIL"
"""Environment variable with the monotonic time [s] after which no test begins."""
WHOLE_JOB = ("physics", "", "harness")
"""Folders of tests that run the whole job; the empty one is `tests` itself."""
ABOUT = {
    "spec_schema": WHOLE_JOB,
    "compiler": ("compiler", *WHOLE_JOB),
    "templates": ("templates", "watching", "rendering", *WHOLE_JOB),
    "runtime": ("agents", "cli", *WHOLE_JOB),
    "recording": ("rendering", "exchange", *WHOLE_JOB),
    "evidence": ("agents", "cli", *WHOLE_JOB),
    "harness": ("agents", "cli", *WHOLE_JOB),
    "legibility": ("rendering", "harness"),
    "asset_intake": ("assets", "agents"),
    "service": ("cli", "mcp_server"),
    "rendering": ("rendering", "replay", "agents"),
    "exchange": ("exchange", "replay"),
    "card_library": ("card_library", "agents"),
    "watching": ("watching", "physics"),
}
"""Folders of tests by folder of the package; where none is named, the one of the same name."""


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("selection")
    group.addoption("--since", metavar="REVISION", help="only tests that the change since then concerns, and a share")
    group.addoption("--share", type=int, default=5, metavar="N", help="every N-th of the other files (default 5)")
    group.addoption("--minutes", type=float, metavar="M", help="begin no test after M minutes")


def pytest_configure(config: pytest.Config) -> None:
    # In the environment, so that a process that takes the place of one that crashed has no more time than the others.
    if (minutes := config.getoption("--minutes")) and not hasattr(config, "workerinput"):
        os.environ[DEADLINE] = str(time.monotonic() + 60 * minutes)


@pytest.hookimpl(trylast=True)  # after `conftest.py`, which begins with the files that take long
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep what is concerned and this commit's share of the rest."""
    if not (since := config.getoption("--since")):
        return
    changed = [Path(line) for line in _git("diff", "--name-only", f"{since}..HEAD").splitlines()]
    turn, share = int(_git("rev-list", "--count", "HEAD")), config.option.share
    folders = {folder for path in changed for folder in concerned(path)}
    files = {ROOT / path for path in changed}
    kept, left = [], []
    for item in items:
        name, about = item.path.relative_to(ROOT).as_posix(), item.get_closest_marker("about")
        inside = item.path.parent.relative_to(ROOT / "tests")
        around = {"" if folder == Path() else folder.as_posix() for folder in (inside, *inside.parents[:-1])}
        if about is not None:
            name = about.args[0]
        if item.path in files or any(ROOT / name in path.parents for path in files):
            kept.append((0, item))
        elif around & folders:
            kept.append((1, item))
        elif (zlib.crc32(name.encode()) + turn) % share == 0:
            kept.append((2, item))
        else:
            left.append(item)
    config.hook.pytest_deselected(items=left)
    items[:] = [item for _, item in sorted(kept, key=lambda pair: pair[0])]


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Begin nothing after the time is over, and nothing that could make that time much longer."""
    if not (minutes := item.config.getoption("--minutes")):
        return
    if time.monotonic() > float(os.environ[DEADLINE]):
        pytest.skip(f"not begun: the {minutes:g} minutes are over")
    own = item.get_closest_marker("timeout")
    if own is not None and own.args[0] > float(item.config.getini("timeout")):
        pytest.skip(f"not begun: it may take {own.args[0]:g} s; `make test-all` runs it")


def concerned(path: Path) -> tuple[str, ...]:
    """Return the folders of tests that a changed file concerns, relative to `tests`; "" is `tests` itself."""
    match path.parts:
        case ("text2sim", package, _, *_):
            return ABOUT.get(package, (package,))
        case ("tests", name) if not name.startswith("test_"):
            return WHOLE_JOB
        case ("tests", *folders, name) if folders and not name.startswith("test_"):
            return ("/".join(folders),)
        case ("cases", *_) | ("pyproject.toml" | "constraints.txt",):
            return WHOLE_JOB
    return ()


def _git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout
