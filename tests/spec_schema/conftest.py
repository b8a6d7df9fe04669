"""A case of some size to change one thing in, and cases that use prefabs."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from staged import staged
from stick_prefabs import GATE, HEAD, STICK

from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase

Write = Callable[..., None]


@pytest.fixture
def stage() -> Callable[..., LoadedCase]:
    """Load the stage with values set at JSON Pointers; see `staged`."""
    return staged


@pytest.fixture
def write_prefabs(tmp_path: Path) -> Write:
    """Write prefabs into the folder of the case."""
    (tmp_path / "prefabs").mkdir()

    def files(**texts: str) -> None:
        for name, text in texts.items():
            (tmp_path / "prefabs" / f"{name}.yaml").write_text(text)

    files(stick=STICK, gate=GATE)
    return files


@pytest.fixture
def load_uses(tmp_path: Path, write_prefabs: Write) -> Callable[..., LoadedCase]:
    """Load a case with these bodies."""

    def text_of(bodies: str, top: str = "", **options: Any) -> LoadedCase:
        return load_text(
            f"{HEAD}{top}bodies:\n  other: {{kind: ragdoll, height: 1}}\n{bodies}", tmp_path / "case.yaml", **options
        )

    return text_of


@pytest.fixture
def use_problems(load_uses: Callable[..., LoadedCase]) -> Callable[..., list[Problem]]:
    """Everything that is wrong with a case with these bodies."""

    def found(bodies: str, top: str = "", **options: Any) -> list[Problem]:
        with pytest.raises(SpecError) as caught:
            load_uses(bodies, top, **options)
        return caught.value.problems

    return found
