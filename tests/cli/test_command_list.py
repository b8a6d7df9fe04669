"""Every command is told of in the README."""

import re
from pathlib import Path

import pytest

from text2sim.cli.main import COMMANDS

README = Path(__file__).parents[2] / "README.md"


@pytest.mark.parametrize("name", COMMANDS)
def test_the_readme_tells_of_every_command(name: str) -> None:
    told = re.search(rf"(text2sim |`){name}\b", README.read_text("utf-8"))
    assert told, f"README.md: a row for `text2sim {name}` is missing"
