"""Tests that start something expensive without its fixture fail, whoever starts it and whatever becomes of it."""

from pathlib import Path

import pytest

pytest_plugins = ["pytester"]
TESTS_FOLDER = Path(__file__).parent
CONFTEST, GUARD = ((TESTS_FOLDER / name).read_text() for name in ("conftest.py", "guard.py"))
TESTS = """
import subprocess, sys, pytest

def test_imported():
    import mitsuba

def test_in_a_child_with_another_environment():
    import os
    code = "try:\\n import genesis\\nexcept ImportError: pass"
    subprocess.run([sys.executable, "-c", code], env={"PYTHONPATH": os.environ["PYTHONPATH"]}, check=True)

def test_browser():
    with pytest.raises(ImportError):
        subprocess.run(["/nowhere/chromium", "--headless"])

def test_looked_for_only():
    import importlib.util
    assert importlib.util.find_spec("genesis")

def test_with_its_fixture(tracer):
    import mitsuba

@pytest.mark.usefixtures("engine")
def test_marked():
    pass

def test_browser_with_its_fixture(browser):
    with pytest.raises(FileNotFoundError):
        subprocess.run(["/nowhere/chromium", "--headless"])
"""


def test_what_is_expensive_needs_its_fixture(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    # Without our own guard, which would come before that of the tests within; with what their conftest.py imports.
    pytester.makeconftest(CONFTEST)
    monkeypatch.setenv("PYTHONPATH", str(TESTS_FOLDER))
    pytester.makepyfile(guard=GUARD, test_some=TESTS)
    pytester.makeini("[pytest]\nmarkers =\n engine\n tracer\n browser\n npm\n")
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", "-q")
    result.assert_outcomes(passed=4, failed=3)
    result.stdout.fnmatch_lines([
        "*the module mitsuba was started by a test without the fixture `tracer`*",
        "*the module genesis was started by a test without the fixture `engine`*",
        "*the program chromium was started by a test without the fixture `browser`*",
    ])  # fmt: skip
    pytester.runpytest_subprocess("-q", "-m", "engine or tracer").assert_outcomes(passed=2, deselected=5)
    pytester.runpytest_subprocess("-q", "-n", "1").assert_outcomes(passed=4, failed=3)
