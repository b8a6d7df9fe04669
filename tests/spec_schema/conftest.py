"""A case of some size to change one thing in."""

from collections.abc import Callable

import pytest
from staged import staged

from text2sim.spec_schema.loaded import LoadedCase


@pytest.fixture
def stage() -> Callable[..., LoadedCase]:
    """Load the stage with values set at JSON Pointers; see `staged`."""
    return staged
