"""A case of some size to change one thing in."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.text.canonical import dump_case
from text2sim.spec_schema.text.document import parse_document, parse_pointer
from text2sim.spec_schema.text.source import read_source

STAGE = Path(__file__).with_name("stage.yaml")


@pytest.fixture
def stage() -> Callable[..., LoadedCase]:
    """Load the stage with values set at JSON Pointers; None takes a value away."""

    def load(edits: dict[str, Any] | None = None) -> LoadedCase:
        data = copy.deepcopy(parse_document(read_source(STAGE)).data)
        for where, value in (edits or {}).items():
            *way, last = parse_pointer(where)
            target = data
            for step in way:
                target = target.setdefault(step, {}) if isinstance(target, dict) else target[step]
            if value is None:
                del target[last]
            else:
                target[last] = value
        return load_text(dump_case(data))

    return load
