"""Cases for the tests of pictures."""

from pathlib import Path

import pytest

from text2sim.compiler.build import Resolution, resolve_case
from text2sim.spec_schema.load import load_text

ZOO = Path(__file__).with_name("zoo.yaml")


@pytest.fixture(scope="session")
def zoo() -> Resolution:
    """A case with a body of every kind and shape but those from files."""
    return resolve_case(load_text(ZOO.read_text(encoding="utf-8")))
