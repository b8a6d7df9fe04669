"""What every test may use, and the rule by which tests are split into quick and expensive ones.

A test that starts the engine, the path tracer, a browser or npm asks for the fixture of that name, by itself or through
another fixture. That marks it: `make test` leaves it out unless it is marked `smoke`, `make test-all` runs it. Without
the fixture it may not start any of them (`guard.py`).
"""

import os
import runpy
import shutil
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from warm_engine import WarmEngine

pytest_plugins = ["selection"]
ROOT = Path(__file__).resolve().parent
CASES = ROOT.parent / "cases"
EXPENSIVE = ("engine", "tracer", "browser", "npm")
GUARD = pytest.StashKey[Path]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-goldens", action="store_true", help="write the golden programs anew")


def pytest_configure(config: pytest.Config) -> None:
    """Set up the guard, in this process and for those that it begins."""
    if config.getoption("numprocesses", None) and not hasattr(config, "workerinput"):
        return  # the processes that run the tests have guards of their own
    folder = config.stash[GUARD] = Path(tempfile.mkdtemp(prefix="text2sim-guard-"))
    shutil.copy(ROOT / "guard.py", folder / "sitecustomize.py")
    (folder / "allowed").touch()
    os.environ["PYTHONPATH"] = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    runpy.run_path(str(folder / "sitecustomize.py"))


def pytest_unconfigure(config: pytest.Config) -> None:
    if GUARD in config.stash:
        shutil.rmtree(config.stash[GUARD], ignore_errors=True)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark every test by the expensive fixtures that it uses, and begin with the files that have such tests."""
    for item in items:
        for name in _expensive(item):
            item.add_marker(name)
    # Two processes share the work by files: a long one must not come last.
    long = {item.path for item in items if _expensive(item)}
    items.sort(key=lambda item: item.path not in long)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Say what the processes of a test and of its fixtures may start."""
    folder = item.config.stash[GUARD]
    (folder / "refused").unlink(missing_ok=True)
    (folder / "allowed").write_text(" ".join(_expensive(item)))
    try:
        return (yield)
    finally:
        (folder / "allowed").write_text("")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a test that started what it has no fixture for, whatever it made of the refusal."""
    try:
        return (yield)
    finally:
        refused = item.config.stash[GUARD] / "refused"
        if refused.exists():
            pytest.fail(refused.read_text(), pytrace=False)


def _expensive(item: pytest.Item) -> list[str]:
    return [name for name in EXPENSIVE if name in getattr(item, "fixturenames", ())]


@pytest.fixture(scope="session")
def engine() -> None:
    """Allow a test to start Genesis, and mark it."""


@pytest.fixture(scope="session")
def tracer() -> None:
    """Allow a test to start Mitsuba, and mark it; skip it where there is none."""
    if find_spec("mitsuba") is None:  # not imported: `renderer.mitsuba` says first where its compiler lies
        pytest.skip("the path tracer is not installed")


@pytest.fixture(scope="session")
def browser() -> None:
    """Allow a test to start a browser, and mark it."""


@pytest.fixture(scope="session")
def npm() -> None:
    """Allow a test to start Node or npm, and mark it."""


@pytest.fixture(scope="session")
def cases() -> Path:
    """The folder of the repository's cases."""
    return CASES


@pytest.fixture(scope="session")
def warm_engine(engine: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[WarmEngine]:
    """Return the engine in which the programs of all tests that only need a run are simulated."""
    warm = WarmEngine(tmp_path_factory.mktemp("warm_engine"))
    yield warm
    warm.stop()
