"""Which of the expensive tests a change is tried with: those that it concerns, and a share of the others that rotates.

    pytest --since REVISION [--share 5] [--minutes 12]

A file of tests is concerned if it, or something in its folder that is not a test, was changed since the revision, or
something in a folder of the package that it is about. Of the other files every fifth is taken, another fifth after the
next commit. What would begin after so many minutes is skipped, and said so.
"""

import subprocess
import time
import zlib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
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
    if minutes := config.getoption("--minutes"):
        config.stash[DEADLINE] = time.monotonic() + 60 * minutes


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep what is concerned and this commit's share of the rest."""
    if not (since := config.getoption("--since")):
        return
    changed = [Path(line) for line in _git("diff", "--name-only", f"{since}..HEAD").splitlines()]
    turn, share = int(_git("rev-list", "--count", "HEAD")), config.getoption("--share")
    folders = {folder for path in changed for folder in concerned(path)}
    files = {ROOT / path for path in changed}
    kept, left = [], []
    for item in items:
        name = item.path.relative_to(ROOT).as_posix()
        its_turn = (zlib.crc32(name.encode()) + turn) % share == 0
        inside = item.path.parent.relative_to(ROOT / "tests")
        around = {"" if folder == Path() else folder.as_posix() for folder in (inside, *inside.parents[:-1])}
        mine = its_turn or item.path in files or bool(around & folders)
        (kept if mine else left).append(item)
    config.hook.pytest_deselected(items=left)
    items[:] = kept


def pytest_runtest_setup(item: pytest.Item) -> None:
    deadline = item.config.stash.get(DEADLINE, None)
    if deadline is not None and time.monotonic() > deadline:
        pytest.skip(f"not begun: the {item.config.getoption('--minutes'):g} minutes are over")


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


DEADLINE = pytest.StashKey[float]()
