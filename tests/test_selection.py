"""What a change is tried with."""

import os
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import pytest
import selection

pytest_plugins = ["pytester"]
TESTS = Path(__file__).parent
PACKAGE = TESTS.parent / "text2sim"


@pytest.mark.parametrize(
    ("changed", "folders"),
    [
        ("text2sim/templates/engine.py", {"templates", "watching", "rendering", "physics", "harness", ""}),
        ("text2sim/mcp_server/tools.py", {"mcp_server"}),
        ("tests/rendering/conftest.py", {"rendering"}),
        ("tests/conftest.py", {"physics", "harness", ""}),
        ("tests/physics/test_mass.py", set()),  # the file itself is tried, and no other
        ("docs/agents.md", set()),
    ],
)
def test_a_change_concerns_the_tests_of_what_it_touches(changed: str, folders: set[str]) -> None:
    assert set(selection.concerned(Path(changed))) == folders


def test_every_folder_that_is_named_exists() -> None:
    assert {name for name in selection.ABOUT if not (PACKAGE / name).is_dir()} == set()
    named = {folder for folders in selection.ABOUT.values() for folder in folders}
    assert {folder for folder in named if not (TESTS / folder).is_dir()} == set()


def test_what_changed_comes_first_then_what_it_concerns_then_the_share(monkeypatch: pytest.MonkeyPatch) -> None:
    told = {"diff": "text2sim/exchange/scene.py\ntests/physics/test_mass.py\n", "rev-list": "7"}
    monkeypatch.setattr(selection, "_git", lambda command, *rest: told[command])
    names = ["agents/test_loop.py", "exchange/test_gltf.py", "physics/test_mass.py", "physics/test_ropes.py"]
    items = [SimpleNamespace(path=TESTS / name, get_closest_marker=lambda name: None) for name in names]
    dropped: list[SimpleNamespace] = []
    config = SimpleNamespace(
        getoption=lambda name: "main",
        option=SimpleNamespace(share=1),
        hook=SimpleNamespace(pytest_deselected=lambda items: dropped.extend(items)),
    )
    selection.pytest_collection_modifyitems(config, items)  # type: ignore[arg-type]
    assert [item.path.name for item in items] == ["test_mass.py", "test_gltf.py", "test_loop.py", "test_ropes.py"]
    assert dropped == []


def test_a_test_that_is_about_a_folder_runs_if_something_in_it_changed(monkeypatch: pytest.MonkeyPatch) -> None:
    told = {"diff": "cases/tumbler/case.yaml\n", "rev-list": "7"}
    monkeypatch.setattr(selection, "_git", lambda command, *rest: told[command])
    abouts = [pytest.mark.about(folder).mark for folder in ("cases/curtains", "cases/tumbler", "cases/tumble")]
    items = [SimpleNamespace(path=TESTS / "cases/test_cases.py", get_closest_marker=lambda _, m=m: m) for m in abouts]
    config = SimpleNamespace(
        getoption=lambda name: "main",
        option=SimpleNamespace(share=10**9),
        hook=SimpleNamespace(pytest_deselected=lambda items: None),
    )
    selection.pytest_collection_modifyitems(config, items)  # type: ignore[arg-type]
    assert [item.get_closest_marker("about").args for item in items] == [("cases/tumbler",)]


def test_what_could_outlast_the_minutes_is_not_begun(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(selection.DEADLINE, "")
    pytester.makeini("[pytest]\ntimeout = 60")
    pytester.makepyfile(
        test_two="""
        import pytest

        def test_short(): pass

        @pytest.mark.timeout(61)
        def test_long(): pass
        """
    )
    arguments = ("-p", "selection", "-p", "no:cacheprovider", "--minutes")
    pytester.runpytest_inprocess(*arguments, "1").assert_outcomes(passed=1, skipped=1)
    pytester.runpytest_inprocess(*arguments, "0.000001").assert_outcomes(skipped=2)


def test_a_process_that_replaces_another_has_no_more_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(selection.DEADLINE, "7")

    class Config:
        workerinput: ClassVar[dict[str, str]] = {}

        def getoption(self, name: str) -> float:
            return 12.0

    selection.pytest_configure(Config())  # type: ignore[arg-type]
    assert os.environ[selection.DEADLINE] == "7"
