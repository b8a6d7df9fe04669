"""What docs/editors.md tells to do can be done."""

import json
import re
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs/editors.md").read_text("utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize(("kind", "text"), BLOCKS, ids=[kind for kind, _ in BLOCKS])
def test_settings_can_be_read(kind, text):
    {"json": json.loads, "toml": tomllib.loads, "yaml": yaml.safe_load}[kind](text)


def test_the_first_line_is_the_one_of_our_cases():
    (line,) = (text.strip() for kind, text in BLOCKS if kind == "yaml")
    for path in (ROOT / "cases").glob("*/case.yaml"):
        assert path.read_text("utf-8").splitlines()[0] == line
    assert (ROOT / "cases/newton_cradle" / line.partition("$schema=")[2]).is_file()


def test_its_commands_are_there():
    import typer.main

    from text2sim.cli.main import app

    commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    for name in set(re.findall(r"text2sim ([a-z]+)\b(?! lies)", TEXT)):
        assert name in commands, name
    options = {word for parameter in commands["watch"].params for word in parameter.opts}
    named = set(re.findall(r"`(--[a-z-]+)`", TEXT))
    assert {"--timeout", "--variant", "--set"} == named
    assert named <= options


def test_what_it_says_of_time_and_size_holds():
    from text2sim.watching.session import Options

    assert f"`--timeout` ({Options.timeout:g} s)" in TEXT.replace("\n", " ")
