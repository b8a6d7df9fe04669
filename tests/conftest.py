"""What every test may use."""

from pathlib import Path

import pytest

CASES = Path(__file__).resolve().parent.parent / "cases"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--update-goldens", action="store_true", help="write the golden programs anew")


@pytest.fixture(scope="session")
def cases() -> Path:
    """The folder of the repository's cases."""
    return CASES
