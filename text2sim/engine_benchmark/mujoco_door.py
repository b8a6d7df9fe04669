"""MuJoCo, behind one door: it tells type checkers nothing."""

from importlib import import_module
from typing import Any


def mujoco() -> Any:
    """Return the module."""
    return import_module("mujoco")
