"""Untyped access to MuJoCo, whose stubs are incomplete."""

from importlib import import_module
from typing import Any


def mujoco() -> Any:
    """Return the module `mujoco`."""
    return import_module("mujoco")
