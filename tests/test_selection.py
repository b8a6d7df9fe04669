"""What a change is tried with."""

from pathlib import Path

import pytest
import selection

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
