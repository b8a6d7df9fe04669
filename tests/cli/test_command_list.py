"""Every command is told of in the README, and those of groups in a page."""

import re
from pathlib import Path

import pytest
from handmade import subcommands

from text2sim.cli.main import COMMANDS

README = Path(__file__).parents[2] / "README.md"
PAGES = [README, *(README.parent / "docs").glob("*.md")]


@pytest.mark.parametrize("name", COMMANDS)
def test_the_readme_tells_of_every_command(name: str) -> None:
    told = re.search(rf"(text2sim |`){name}\b", README.read_text("utf-8"))
    assert told, f"README.md: a row for `text2sim {name}` is missing"


@pytest.mark.parametrize("words", subcommands())
def test_a_page_tells_of_every_command_of_a_group(words: str) -> None:
    told = [page for page in PAGES if re.search(rf"\b{words}\b", page.read_text("utf-8"))]
    assert told, f"no page of docs/ says what `text2sim {words}` does"
